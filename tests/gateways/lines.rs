//! Sensors that send text: the site and the lines of docs/INPUTS.md through the program.

use std::net::UdpSocket;
use std::process::{Command, Stdio};
use std::time::Duration;

use jiff::Timestamp;
use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::{Client, MqttOptions};
use serde_json::{Value, json};

use super::live::{Ended, broker, free_port, get, wait_for};
use super::program::{Scratch, utm_fusion};

const PAGE: &str = include_str!("../../docs/INPUTS.md");

/// The first block of this language in the page's section on sensors that send text.
fn documented(language: &str) -> String {
    let section = PAGE.split("## A sensor that sends text").nth(1).unwrap();
    let block = section.split(&format!("```{language}\n")).nth(1).unwrap();
    block.split("```").next().unwrap().to_owned()
}

/// Result of `check --lines` for the lines of a sensor: exit code and output.
fn checked(scratch: &Scratch, lines: &str, more: &[&str]) -> (Option<i32>, String) {
    let site = scratch.file("site.toml", documented("toml"));
    let file = scratch.file("lines.txt", lines);
    let output = utm_fusion("check").arg(site).arg("--lines").arg(file).args(more).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

#[test]
fn documented_lines_become_reports() {
    let scratch = Scratch::new();
    let (code, said) = checked(&scratch, &documented("json"), &["--sensor", "hill"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("line 1: plot of track 0 at 2027-01-15T12:00:00.500Z: 52.00"), "{said}");
    assert!(said.contains("no height, drone 100 %\nhill: 1 lines, 0 dropped (none), 0 refused"), "{said}");
    let (code, said) = checked(&scratch, &documented("csv"), &["--sensor", "beacons"]);
    assert_eq!(code, Some(0), "{said}");
    let report = "line 1: report of 1581F4BND23500001234 at 2027-01-15T12:00:00.500Z: 52.007000, 4.012000, height 100.6 m";
    assert!(said.contains(report), "{said}");
}

#[test]
fn line_that_is_no_report_is_named_with_its_reason() {
    let scratch = Scratch::new();
    let lines = format!("{}\n{{\"id\": 1}}\nno line\n", documented("json"));
    let (code, said) = checked(&scratch, &lines, &["--sensor", "hill"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("line 2: dropped: line_time\nline 3: dropped: line_not_an_object\n"), "{said}");
    assert!(said.contains("3 lines, 2 dropped (1 line_not_an_object, 1 line_time), 0 refused"), "{said}");
    let (code, said) = checked(&scratch, &lines, &[]);
    assert!(code != Some(0) && said.contains("name one with --sensor ID"), "{said}");
    let (code, said) = checked(&scratch, &lines, &["--sensor", "other"]);
    assert!(code != Some(0) && said.contains("no such sensor"), "{said}");
}

/// Latitude, longitude, azimuth in degrees and distance over ground in metres of a drone that flies past the radar of the page.
fn drone(seconds: f64) -> [f64; 4] {
    const METRES_A_DEGREE: f64 = 111_250.0;
    let (east_m, north_m) = (300.0 + 12.0 * seconds, 900.0);
    let latitude_deg = 52.0 + north_m / METRES_A_DEGREE;
    let longitude_deg = 4.0 + east_m / (METRES_A_DEGREE * 52_f64.to_radians().cos() * 1.0027);
    [latitude_deg, longitude_deg, f64::atan2(east_m, north_m).to_degrees(), f64::hypot(east_m, north_m)]
}

#[test]
fn text_sensors_make_a_fused_track_that_replays() {
    let scratch = Scratch::new();
    let (plots, reports, http) = (free_port(), free_port(), free_port());
    let text =
        documented("toml").replace(":15048", &format!(":{plots}")).replace(":15129", &format!(":{reports}"));
    let (state, recorded) = (scratch.path("state"), scratch.path("recorded"));
    let text = format!(
        "{text}\n[http]\nlisten = \"127.0.0.1:{http}\"\n[state]\ndir = \"{}\"\n[output.record]\ndir = \"{}\"\n",
        state.display(),
        recorded.display()
    );
    let site = scratch.file("site.toml", text);
    let log = std::fs::File::create(scratch.path("run.log")).unwrap();
    let mut run = utm_fusion("run");
    run.arg("--config").arg(&site).stdout(Stdio::null()).stderr(log);
    let mut service = Ended(run.spawn().unwrap());
    wait_for("the service answers", || get(http, "/api/v1/status").is_some());
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
    let begun = Timestamp::now();
    let mut step = 0;
    let mut fused = None;
    wait_for("the two reports of the drone are fused", || {
        let now = Timestamp::now();
        let [latitude, longitude, azimuth, distance_m] = drone(now.duration_since(begun).as_secs_f64());
        let plot = json!({
            "ts": now.as_millisecond(), "id": "a3f", "type": "uav", "pos": { "r": distance_m / 1000.0, "az": azimuth },
        });
        udp.send_to(format!("{plot}\n").as_bytes(), ("127.0.0.1", plots)).unwrap();
        if step % 2 == 0 {
            let report = format!("{now},1581F4BND23500001234,{latitude},{longitude},66\nno report\n");
            udp.send_to(report.as_bytes(), ("127.0.0.1", reports)).unwrap();
        }
        step += 1;
        std::thread::sleep(Duration::from_millis(450));
        fused =
            get(http, "/api/v1/tracks?source=fused").and_then(|answer| answer["features"].get(0).cloned());
        fused.is_some()
    });
    let fused = fused.unwrap();
    assert_eq!(fused["properties"]["uas_id"]["serial_number"], "1581F4BND23500001234", "{fused}");
    let sensors = get(http, "/api/v1/sensors").unwrap();
    let line = |id: &str| -> Value {
        let found =
            sensors["features"].as_array().unwrap().iter().find(|feature| feature["id"] == id).unwrap();
        found["properties"]["lines"][0].clone()
    };
    assert!(line("beacons")["untranslated"]["line_not_an_object"].as_u64() > Some(1), "{sensors}");
    assert_eq!(line("hill")["name"], format!("json 127.0.0.1:{plots}"), "{sensors}");
    Command::new("kill").args(["-TERM", &service.0.id().to_string()]).status().unwrap();
    assert!(
        service.0.wait().unwrap().success(),
        "{}",
        std::fs::read_to_string(scratch.path("run.log")).unwrap()
    );

    let file = |start: &str, end: &str| {
        let mut files = std::fs::read_dir(&recorded).unwrap().map(|file| file.unwrap().path());
        let named = |path: &std::path::PathBuf| {
            let name = path.file_name().unwrap().to_str().unwrap();
            name.starts_with(start) && name.ends_with(end)
        };
        files.find(named).unwrap_or_else(|| panic!("no {start}*{end}"))
    };
    let input = file("input-", ".pcap");
    let again = scratch.path("again.pcap");
    let mut replay = utm_fusion("replay");
    replay
        .arg(&input)
        .arg("--config")
        .arg(file("input-", ".site.toml"))
        .arg("--state")
        .arg(input.with_extension(""));
    let replayed = replay.args(["--output-format", "pcap", "-o"]).arg(&again).output().unwrap();
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
    let sent = std::fs::read(file("output-", ".pcap")).unwrap();
    assert!(sent == std::fs::read(again).unwrap(), "what is replayed is not what was sent");
}

#[test]
fn text_from_a_broker_becomes_plots() {
    let scratch = Scratch::new();
    let Some((port, _broker)) = broker(&scratch) else { return };
    let http = free_port();
    let at_broker = format!("address = \"mqtt://127.0.0.1:{port}\", topic = \"radars/+\"");
    let text = documented("toml").replace("address = \"127.0.0.1:15048\"", &at_broker);
    let text = text.replace(":15129", &format!(":{}", free_port()));
    let site = scratch.file("site.toml", format!("{text}\n[http]\nlisten = \"127.0.0.1:{http}\"\n"));
    let mut run = utm_fusion("run");
    run.arg("--config").arg(&site).stdout(Stdio::null()).stderr(Stdio::null());
    let _service = Ended(run.spawn().unwrap());
    wait_for("the service answers", || get(http, "/api/v1/status").is_some());
    let (client, mut connection) = Client::new(MqttOptions::new("hill", "127.0.0.1", port), 16);
    std::thread::spawn(move || connection.iter().for_each(drop));
    let mut hill = Value::Null;
    wait_for("plots are accepted", || {
        let now = Timestamp::now().as_millisecond();
        let plot = json!({ "ts": now, "id": "a3f", "pos": { "r": 1.2, "az": 45.0 } });
        client.publish("radars/hill", QoS::AtMostOnce, false, format!("{plot}\nno plot\n")).unwrap();
        std::thread::sleep(Duration::from_millis(200));
        let sensors = get(http, "/api/v1/sensors").unwrap();
        let features = sensors["features"].as_array().unwrap();
        hill = features.iter().find(|feature| feature["id"] == "hill").unwrap()["properties"].clone();
        hill["accepted"].as_u64() > Some(2)
    });
    assert_eq!(hill["lines"][0]["name"], format!("radars/+ at mqtt://127.0.0.1:{port}"), "{hill}");
    assert!(hill["lines"][0]["untranslated"]["line_not_an_object"].as_u64() > Some(0), "{hill}");
}
