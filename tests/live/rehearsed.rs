//! `replay --to-inputs`: a recording is the input of a live service, which then has the same tracks as a replay.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use serde_json::Value;
use utm_fusion::config::Config;
use utm_fusion::simulate::{Simulation, write};

use crate::common::{Running, Scratch, ask, flight, on_own_ports, utm_fusion};

const SCENARIO: &str = "name = \"rehearsed\"\nduration_s = 24\n[drones]\nmultirotors = 3\nequipped = 2\n";

/// A recording made at other addresses than the site's.
fn recording(scratch: &Scratch, port: u16) -> (PathBuf, Config, Simulation) {
    let flight = flight(SCENARIO, 5, None);
    write(&flight, "", &scratch.path("flight")).unwrap();
    let config = on_own_ports(&flight.config, port, scratch, None);
    (scratch.path("flight/capture.pcap"), config, flight)
}

fn replay(capture: &Path, site: &Path, options: &[&str]) -> Output {
    utm_fusion("replay").arg(capture).arg("--config").arg(site).args(options).output().unwrap()
}

fn texts(output: &Output) -> (Option<i32>, String, String) {
    let text = |octets: &[u8]| String::from_utf8(octets.to_vec()).unwrap();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// Value of a field in a log line, as a time.
fn stamp(log: &str, field: &str) -> i128 {
    let rest = log.split(&format!("{field}=")).nth(1).unwrap_or_else(|| panic!("no {field}: {log}"));
    let text = rest.split_whitespace().next().unwrap().trim_matches('"');
    text.parse::<jiff::Timestamp>().unwrap_or_else(|error| panic!("{text}: {error}")).as_nanosecond()
}

/// Time and position of a track: nanoseconds, degrees.
fn position(track: &Value) -> (i128, f64, f64) {
    let time = track["time"].as_str().unwrap().parse::<jiff::Timestamp>().unwrap();
    (time.as_nanosecond(), track["lng"].as_f64().unwrap(), track["lat"].as_f64().unwrap())
}

fn metres((_, lng, lat): (i128, f64, f64), (_, other_lng, other_lat): (i128, f64, f64)) -> f64 {
    let degree_m = 111_200.0;
    f64::hypot((lat - other_lat) * degree_m, (lng - other_lng) * degree_m * lat.to_radians().cos())
}

#[test]
fn run_and_replay_show_the_same_tracks() {
    let scratch = Scratch::new();
    let (capture, config, _) = recording(&scratch, 26_200);
    let site = scratch.file("site.toml", config.to_string());
    let lines = scratch.path("x.ndjson");
    let (code, _, log) = texts(&replay(&capture, &site, &["-o", lines.to_str().unwrap()]));
    assert_eq!(code, Some(0), "{log}");
    let mut run = utm_fusion("run");
    let mut service = Running::start(run.arg(&site), scratch.path("run.log"));
    service.says("running");
    let mut sender = utm_fusion("replay");
    sender.arg(&capture).arg("--config").arg(&site).arg("--to-inputs");
    let mut sender = Running::start(&mut sender, scratch.path("replay.log"));
    let (code, log) = sender.wait(Duration::from_secs(60));
    assert_eq!(code, Some(0), "{log}");
    // The picture is 6.25 s old, and therefore still within the flight.
    let (status, tracks) = ask(service.http_port(), "GET", "/api/v1/tracks");
    assert_eq!(status, 200, "{tracks}");
    let moved = stamp(&log, "now") - stamp(&log, "recorded");
    let live: Vec<_> =
        tracks["features"].as_array().unwrap().iter().map(|one| position(&one["properties"])).collect();
    let at = tracks["time"].as_str().unwrap().parse::<jiff::Timestamp>().unwrap().as_nanosecond() - moved;
    let lines = std::fs::read_to_string(&lines).unwrap();
    let all: Vec<_> = lines.lines().map(|line| position(&serde_json::from_str(line).unwrap())).collect();
    let recorded: Vec<_> = all.into_iter().filter(|(time, ..)| *time == at).collect();
    assert!(live.len() >= 3 && live.len() == recorded.len(), "{live:?} and {recorded:?}");
    for track in live {
        let nearest = recorded.iter().map(|other| metres(track, *other)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 3.0, "{nearest} m: {track:?} and {recorded:?}");
    }
    let (_, status) = ask(service.http_port(), "GET", "/api/v1/status");
    assert_eq!(status["tally"]["unknown_sources"], 0, "{status}");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}

#[test]
fn datagrams_without_an_input_are_counted_by_content() {
    let scratch = Scratch::new();
    let (capture, mut config, flight) = recording(&scratch, 26_220);
    config.sensors.retain(|sensor| sensor.kind.radar().is_some());
    let site = scratch.file("site.toml", config.to_string());
    let (code, said, log) = texts(&replay(&capture, &site, &["--to-inputs", "--speed", "100"]));
    assert_eq!(code, Some(0), "{log}");
    let count =
        |is_of: &dyn Fn(u8) -> bool| flight.datagrams.iter().filter(|one| is_of(one.payload[0])).count();
    let (others, radar) = (count(&|category| category == 129), count(&|category| category != 129));
    assert!(said.contains(&format!("sent       {radar} datagrams to 239.192.")), "{said}");
    assert!(said.contains(&format!("not sent   {others} datagrams: CAT129 of ")), "{said}");
    config.sensors.iter_mut().for_each(|sensor| (sensor.sac, sensor.sic) = (9, 9));
    let site = scratch.file("other.toml", config.to_string());
    let (code, said, log) = texts(&replay(&capture, &site, &["--to-inputs", "--speed", "1000"]));
    assert_eq!(code, Some(1), "{said}{log}");
    assert!(log.contains("no datagram of the recording is for an input of"), "{log}");
}

#[test]
fn signal_ends_a_rehearsal() {
    let scratch = Scratch::new();
    let (capture, config, _) = recording(&scratch, 26_240);
    let site = scratch.file("site.toml", config.to_string());
    let mut sender = utm_fusion("replay");
    sender.arg(&capture).arg("--config").arg(&site).args(["--to-inputs", "--loop", "--speed", "0.1"]);
    let mut sender = Running::start(&mut sender, scratch.path("replay.log"));
    sender.says("sending to the site's inputs");
    let (code, log) = sender.stop();
    assert_eq!(code, Some(0), "{log}");
}

#[test]
fn unreachable_inputs_are_named() {
    let scratch = Scratch::new();
    let (capture, config, _) = recording(&scratch, 26_260);
    for (input, problem) in [
        ("source = \"192.0.2.7\", group", "takes datagrams from 192.0.2.7 alone"),
        ("address = \"192.0.2.8\", unused", "nothing can be sent to its input 192.0.2.8"),
    ] {
        let text = config.to_string().replacen("group = \"239", &format!("{input} = \"239"), 1);
        let text = match input.split_once(", unused") {
            Some((address, _)) => {
                let (before, rest) = text.split_once(input).unwrap();
                let rest =
                    rest.split_once(", port").unwrap().1.replacen(", interface = \"127.0.0.1\"", "", 1);
                format!("{before}{address}, port{rest}")
            }
            None => text,
        };
        let site = scratch.file("site.toml", text);
        let (code, said, log) = texts(&replay(&capture, &site, &["--to-inputs"]));
        assert_eq!(code, Some(1), "{said}{log}");
        assert!(log.contains(problem), "{log}");
    }
}
