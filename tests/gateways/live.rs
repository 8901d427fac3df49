//! Connections of a running service: receivers over TCP, MAVLink over UDP, a broker. Received data is translated, counted,
//! shown and recorded; a connection that ends is opened again.

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::{Client, MqttOptions};
use serde_json::Value;

use super::decode;
use super::program::{Scratch, utm_fusion};

/// Timeout of all waits in these tests.
const PATIENCE: Duration = Duration::from_secs(60);

pub(super) fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < until, "{what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// An even and an odd position of one aircraft, at 52.2572 N, 3.9194 E, from the Mode S book (mode-s.org/1090mhz).
const PAIR: [&str; 2] = ["8D40621D58C382D690C8AC2863A7", "8D40621D58C386435CC412692AD6"];

fn octets(digits: &str) -> Vec<u8> {
    (0..digits.len()).step_by(2).map(|at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap()).collect()
}

fn beast(digits: &str) -> Vec<u8> {
    let message = octets(digits);
    assert!(!message.contains(&0x1a));
    [&[0x1a, b'3', 0, 0, 0, 0, 0, 0, 0x80], &message[..]].concat()
}

/// A receiver that serves one connection after the other: it sends this stream and closes.
fn receiver(stream: Vec<u8>) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for connection in listener.incoming() {
            let mut connection = connection.unwrap();
            let _ = connection.write_all(&stream);
            std::thread::sleep(Duration::from_millis(300));
        }
    });
    port
}

/// A MAVLink frame of version 2.
fn framed(number: u32, seed: u8, contents: &[u8]) -> Vec<u8> {
    let [low, middle, high, _] = number.to_le_bytes();
    let mut frame = vec![0xfd, contents.len() as u8, 0, 0, 0, 9, 1, low, middle, high];
    frame.extend(contents);
    let checksum = mavlink_core::calculate_crc(&frame[1..], seed);
    frame.extend(checksum.to_le_bytes());
    frame
}

/// ADSB_VEHICLE of ICAO address 4B1A2C at 52.3 N, 3.95 E.
fn vehicle() -> Vec<u8> {
    let mut contents = [0; 38];
    contents[..4].copy_from_slice(&0x4b_1a2c_u32.to_le_bytes());
    contents[4..8].copy_from_slice(&523_000_000_i32.to_le_bytes());
    contents[8..12].copy_from_slice(&39_500_000_i32.to_le_bytes());
    contents[22] = 1;
    framed(246, 184, &contents)
}

/// OPEN_DRONE_ID_BASIC_ID with a serial number.
fn open_drone_id() -> Vec<u8> {
    let contents = [&[0; 22][..], &[1, 2], b"1581F4FKD2291000A4B2"].concat();
    framed(12_900, 114, &contents)
}

fn mavlink(system: u8) -> Vec<u8> {
    let mut frame = vec![0xfd, 28, 0, 0, 1, system, 1, 33, 0, 0, 9, 9, 0, 0];
    for value in [522_500_000_i32, 39_000_000, 120_000, 50_000] {
        frame.extend(value.to_le_bytes());
    }
    frame.extend([100, 0, 0, 0, 0, 0, 10, 0]);
    let checksum = mavlink_core::calculate_crc(&frame[1..], 104);
    frame.extend(checksum.to_le_bytes());
    frame
}

pub(super) struct Ended(pub(super) Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

pub(super) fn get(port: u16, path: &str) -> Option<Value> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n").ok()?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).ok()?;
    let (_, body) = answer.split_once("\r\n\r\n")?;
    // A body may be chunked.
    serde_json::from_str(&body[body.find('{')?..=body.rfind('}')?]).ok()
}

pub(super) fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

pub(super) fn broker(scratch: &Scratch) -> Option<(u16, Ended)> {
    let program = ["/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "/usr/bin/mosquitto"];
    let Some(program) = program.iter().find(|path| std::path::Path::new(path).exists()) else {
        println!("skipped in part: mosquitto is not installed");
        return None;
    };
    let port = free_port();
    let text = format!("listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\n");
    let config = scratch.file("mosquitto.conf", text);
    let mut command = Command::new(program);
    command.arg("-c").arg(config).stdout(Stdio::null()).stderr(Stdio::null());
    Some((port, Ended(command.spawn().unwrap())))
}

#[test]
fn connections_are_translated_counted_shown_and_recorded() {
    let scratch = Scratch::new();
    let mut damaged = beast(PAIR[0]);
    damaged[15] ^= 1;
    let binary = [&b"garbage"[..], &damaged, &beast(PAIR[0]), &beast(PAIR[1])].concat();
    let text = format!("*{};\n*5D40;\n*5D4;\n*{};\n", PAIR[0], PAIR[1]);
    let (binary, text) = (receiver(binary), receiver(text.into_bytes()));
    // Two consecutive blocks of CAT129.
    let item = |serial: &str| [&[0x88, 70, 25][..], serial.as_bytes()].concat();
    let block = |serial: &str| {
        let record = item(serial);
        [&[129, 0, record.len() as u8 + 3][..], &record].concat()
    };
    let blocks = receiver([block("RELAY-000001"), block("RELAY-000002")].concat());
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
    let (mavlink_port, http) = (free_port(), free_port());
    let broker = broker(&scratch);
    let mut site = format!(
        r#"
[site]
name = "test"
sac = 70
sic = 1
latitude_deg = 52.2
longitude_deg = 3.9
height_amsl_m = 0.0
[[sensors]]
kind = "adsb"
id = "roof"
sac = 70
sic = 21
connections = [{{ format = "beast", address = "127.0.0.1:{binary}" }}]
[[sensors]]
kind = "adsb"
id = "mast"
sac = 70
sic = 22
connections = [{{ format = "avr", address = "127.0.0.1:{text}" }}]
[[sensors]]
kind = "transponder"
id = "range"
sac = 70
sic = 23
connections = [{{ format = "mavlink", address = "127.0.0.1:{mavlink_port}", systems = [{{ system_id = 7, serial_number = "TEST-7", country = "NL" }}] }}]
[[sensors]]
kind = "adsb"
id = "uplink"
sac = 70
sic = 26
connections = [{{ format = "mavlink", address = "127.0.0.1:{mavlink_port}" }}]
[[sensors]]
kind = "remote-id"
id = "fleet"
sac = 70
sic = 27
connections = [{{ format = "mavlink", address = "127.0.0.1:{mavlink_port}" }}]
[[sensors]]
kind = "transponder"
id = "relay"
sac = 70
sic = 25
connections = [{{ format = "asterix", address = "127.0.0.1:{blocks}" }}]
[http]
listen = "127.0.0.1:{http}"
[state]
dir = "{}"
[output.record]
dir = "{}"
"#,
        scratch.path("state").display(),
        scratch.path("recorded").display(),
    );
    if let Some((port, _)) = &broker {
        site += &format!(
            "[[sensors]]\nkind = \"remote-id\"\nid = \"gateways\"\nsac = 70\nsic = 24\n\
             connections = [{{ format = \"mqtt\", address = \"mqtt://127.0.0.1:{port}\", topic = \"rid/+\" }}]\n",
        );
    }
    let site = scratch.file("site.toml", site);
    let log = std::fs::File::create(scratch.path("run.log")).unwrap();
    let mut run = utm_fusion("run");
    run.arg("--config").arg(&site).stdout(Stdio::null()).stderr(log);
    let mut service = Ended(run.spawn().unwrap());
    let line = |sensor: &str| -> Option<Value> {
        let sensors = get(http, "/api/v1/sensors")?;
        let found = sensors["features"].as_array()?.iter().find(|feature| feature["id"] == sensor)?;
        Some(found["properties"]["lines"][0].clone())
    };
    let received = |sensor: &str| line(sensor).and_then(|line| line["received"].as_u64()).unwrap_or(0);
    let shown = || std::fs::read_to_string(scratch.path("run.log")).unwrap();
    // Two connections each: state of the aircraft is kept between them.
    wait_for(&format!("positions come over TCP\n{}", shown()), || {
        received("roof") >= 3 && received("mast") >= 3 && received("relay") >= 3
    });
    wait_for("positions come by MAVLink", || {
        for octets in [mavlink(7), mavlink(8), mavlink(7)[..20].to_vec(), vehicle(), open_drone_id()] {
            udp.send_to(&octets, ("127.0.0.1", mavlink_port)).unwrap();
        }
        received("range") >= 3
    });
    if let Some((port, _)) = &broker {
        let (client, mut connection) = Client::new(MqttOptions::new("gateway", "127.0.0.1", *port), 16);
        std::thread::spawn(move || connection.iter().for_each(drop));
        let serial = "41".repeat(23);
        let good = format!(r#"{{"transmitter":"90:3a:e6:5b:c8:a8","message":"0212{serial}"}}"#);
        wait_for("lines come from the broker", || {
            client.publish("rid/a", QoS::AtMostOnce, false, format!("{good}\nnonsense\n\n{good}")).unwrap();
            client.publish("other", QoS::AtMostOnce, false, good.clone()).unwrap();
            received("gateways") >= 2
        });
        assert!(line("gateways").unwrap()["untranslated"]["line_not_an_object"].as_u64() >= Some(1));
    }
    let roof = line("roof").unwrap();
    assert!(roof["name"].as_str().unwrap().starts_with("beast 127.0.0.1:"), "{roof}");
    let reasons = |line: &Value| -> BTreeSet<String> {
        line["untranslated"].as_object().unwrap().keys().cloned().collect()
    };
    assert!(reasons(&roof).contains("damaged"), "{roof}");
    assert!(
        reasons(&line("mast").unwrap())
            .is_superset(&BTreeSet::from(["malformed".to_owned(), "mode_ac".to_owned()]))
    );
    let range = line("range").unwrap();
    assert_eq!(reasons(&range), BTreeSet::from(["cut".to_owned(), "unknown_system".to_owned()]), "{range}");

    Command::new("kill").args(["-TERM", &service.0.id().to_string()]).status().unwrap();
    assert!(service.0.wait().unwrap().success(), "{}", shown());
    let mut recorded = Vec::new();
    for file in std::fs::read_dir(scratch.path("recorded")).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_some_and(|end| end == "pcap") {
            recorded.extend(decode(&path));
        }
    }
    let of = |sic: u8| recorded.iter().filter(move |line| line["sic"] == sic);
    for sic in [21, 22] {
        let positions: Vec<&Value> = of(sic).collect();
        assert!(positions.len() >= 3);
        for record in positions {
            assert_eq!((&record["cat"], &record["items"]["080"]), (&21.into(), &"40621D".into()));
            let at = |name: &str| record["items"]["131"][name].as_f64().unwrap();
            assert!(
                (at("latitude_deg") - 52.26).abs() < 0.01 && (at("longitude_deg") - 3.93).abs() < 0.02,
                "{record}"
            );
        }
    }
    assert!(of(26).all(|record| record["items"]["080"] == "4B1A2C") && of(26).count() > 0);
    let is_fleet = |line: &&Value| line["transmitter"] == "mavlink-9-1";
    let fleet: Vec<_> = recorded.iter().filter(is_fleet).collect();
    assert!(!fleet.is_empty() && fleet.iter().all(|line| line.to_string().contains("1581F4FKD2291000A4B2")));
    let relayed: BTreeSet<&str> = of(25).filter_map(|record| record["items"]["040"].as_str()).collect();
    assert_eq!(relayed, BTreeSet::from(["RELAY-000001", "RELAY-000002"]));
    let drone = of(23).next().unwrap();
    assert_eq!((&drone["cat"], &drone["items"]["040"]), (&129.into(), &"TEST-7      ".into()));
    if broker.is_some() {
        assert!(
            recorded
                .iter()
                .any(|line| line["transmitter"] == "90:3a:e6:5b:c8:a8" && line["message"] == "basic_id")
        );
    }
}
