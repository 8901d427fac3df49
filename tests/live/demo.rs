//! `demo --http` and `replay --serve` for a new user: a map, an API, and an end.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::{Running, Scratch, utm_fusion};

/// Address on which the program serves, from its log.
fn address(running: &mut Running) -> SocketAddr {
    running.says("http://");
    let log = running.log();
    let rest = log.split("http://").nth(1).unwrap();
    rest.split('/').next().unwrap().parse().unwrap()
}

/// Status and body of an answer.
fn ask(address: SocketAddr, method: &str, path: &str) -> (u16, String) {
    let mut socket = TcpStream::connect(address).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    write!(
        socket,
        "{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
}

fn json(address: SocketAddr, path: &str) -> Value {
    let (status, body) = ask(address, "GET", path);
    assert_eq!(status, 200, "{path}: {body}");
    serde_json::from_str(&body).unwrap()
}

/// Waits until a condition is met.
fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(40), "not within 40 s: {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn demo_serves_a_live_picture() {
    let scratch = Scratch::new();
    let mut command = utm_fusion("demo");
    // A port alone means this machine.
    command.args(["--http", "0", "--duration", "35s"]);
    let mut running = Running::start(&mut command, scratch.path("log"));
    let address = address(&mut running);
    let (status, page) = ask(address, "GET", "/");
    assert!(status == 200 && page.contains("app.js"), "{page}");
    let info = json(address, "/api/v1/info");
    assert_eq!(info["basemap"]["attribution"], "Invented ground of the demo, no real map", "{info}");
    let has_fused = |picture: &Value| {
        picture["features"].as_array().unwrap().iter().any(|track| track["properties"]["source"] == "fused")
    };
    until("a fused track", || has_fused(&json(address, "/api/v1/tracks")));
    let searched = |answer: &Value| answer["computed"] == true && answer["aircraft"].as_u64() >= Some(2);
    until("conflicts looked for", || searched(&json(address, "/api/v1/conflicts")));
    let (_, metrics) = ask(address, "GET", "/metrics");
    assert!(metrics.contains("\nutm_fusion_conflict_aircraft "), "{metrics}");
    assert_eq!(json(address, "/api/v1/info")["mode"], "live");
    let (status, _) = ask(address, "POST", "/api/v1/replay/pause");
    assert_eq!(status, 409, "only a replay is steered");
    let (code, log) = running.wait(Duration::from_secs(45));
    assert_eq!(code, Some(0), "{log}");
}

#[test]
fn two_demos_receive_no_data_of_each_other() {
    let scratch = Scratch::new();
    let start = |seed: &str| {
        let mut command = utm_fusion("demo");
        command.args(["--http", "127.0.0.1:0", "--seed", seed]);
        let mut running = Running::start(&mut command, scratch.path(seed));
        let address = address(&mut running);
        (running, address)
    };
    let demos = [start("1"), start("2")];
    let lines = |address: SocketAddr| -> Vec<String> {
        let sensors = json(address, "/api/v1/sensors");
        let lines = sensors["features"].as_array().unwrap().iter();
        lines
            .map(|sensor| sensor["properties"]["lines"][0]["name"].as_str().unwrap_or("").to_owned())
            .collect()
    };
    for (_, address) in &demos {
        until("tracks", || !json(*address, "/api/v1/tracks")["features"].as_array().unwrap().is_empty());
    }
    let [first, second] = [lines(demos[0].1), lines(demos[1].1)];
    assert!(
        first.len() == 2 && first.iter().all(|line| !line.is_empty() && !second.contains(line)),
        "{first:?}"
    );
    for (mut running, address) in demos {
        let said = running.log();
        assert!(said.contains("fused picture is sent to=\"239.192.129.2:"), "{said}");
        let status = json(address, "/api/v1/status")["tally"].to_string();
        assert!(!status.contains("other_sender"), "{status}");
        for sensor in json(address, "/api/v1/sensors")["features"].as_array().unwrap() {
            let properties = &sensor["properties"];
            assert_eq!(properties["state"], "operational", "{properties}");
            // The lines receive only the datagrams of the program's own flight, each once.
            assert!(properties["rate_hz"].as_f64().unwrap() > 0.0 && properties["contested"].is_null());
        }
        running.signal("-INT");
        let (code, log) = running.wait(Duration::from_secs(10));
        assert_eq!(code, Some(0), "{log}");
    }
}

#[test]
fn recording_is_served_paused_and_moved_in_time() {
    let scratch = Scratch::new();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo");
    let mut command = utm_fusion("replay");
    command.arg(demo.join("capture.pcap")).arg("--config").arg(demo.join("site.toml"));
    command.args(["--serve", "--http", "127.0.0.1:0", "--speed", "20"]);
    let mut running = Running::start(&mut command, scratch.path("log"));
    let address = address(&mut running);
    until("a track", || !json(address, "/api/v1/tracks")["features"].as_array().unwrap().is_empty());
    let (status, _) = ask(address, "POST", "/api/v1/replay/pause");
    assert_eq!(status, 200);
    let (status, _) = ask(address, "POST", "/api/v1/replay/seek?time=2026-06-21T00:00:10Z");
    assert_eq!(status, 200);
    let time = || json(address, "/api/v1/tracks")["time"].as_str().unwrap_or("").to_owned();
    until("the time asked for", || time().starts_with("2026-06-21T00:00:10"));
    let stood = time();
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(time(), stood, "it is paused");
    // The recording lasts from 23:59:30 to 00:00:45, so each time of day is unique.
    for (clock, at) in [("23:59:50", "2026-06-20T23:59:50"), ("00:00:10", "2026-06-21T00:00:10")] {
        until("its length", || json(address, "/api/v1/info")["replay"]["end"].is_string());
        let (status, told) = ask(address, "POST", &format!("/api/v1/replay/seek?time={clock}"));
        assert_eq!(status, 200, "{told}");
        until("the time of day asked for", || time().starts_with(at));
    }
    let (status, told) = ask(address, "POST", "/api/v1/replay/seek?time=12:00:00");
    let span =
        "the recording is from 2026-06-20T23:59:30.279Z to 2026-06-21T00:00:45.052Z: it has no 12:00:00";
    assert!(status == 400 && told.contains(span), "{told}");
    let (status, told) = ask(address, "POST", "/api/v1/replay/seek?time=noon");
    let form = "write the time as RFC 3339 has it, 2026-06-20T23:59:30Z, or as a time of day, 23:59:30";
    assert!(status == 400 && told.contains(form), "{told}");
    let info = json(address, "/api/v1/info");
    assert_eq!((&info["mode"], &info["replay"]["playing"]), (&"replay".into(), &false.into()));
    let (status, problem) = ask(address, "POST", "/api/v1/replay/speed?speed=0");
    assert!(status == 400 && problem.contains("0.01 to 1000"), "{problem}");
    ask(address, "POST", "/api/v1/replay/play");
    until("the time goes on", || time() > stood);
    ask(address, "POST", "/api/v1/replay/pause");
    ask(address, "POST", "/api/v1/replay/seek?time=2026-06-20T23:59:50Z");
    until("a time that is past", || time().starts_with("2026-06-20T23:59:50"));
    running.signal("-INT");
    let (code, log) = running.wait(Duration::from_secs(5));
    assert_eq!(code, Some(0), "{log}");
}

#[test]
fn looped_replay_repeats_the_flight() {
    let scratch = Scratch::new();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo");
    let mut command = utm_fusion("replay");
    command.arg(demo.join("capture.pcap")).arg("--config").arg(demo.join("site.toml"));
    command.args(["--serve", "--loop", "--http", "127.0.0.1:0", "--speed", "60"]);
    let mut running = Running::start(&mut command, scratch.path("log"));
    let address = address(&mut running);
    let time = || json(address, "/api/v1/tracks")["time"].as_str().unwrap_or("").to_owned();
    for _ in 0..3 {
        until("the end", || time().as_str() > "2026-06-21T00:00:10");
        until("the beginning", || time().starts_with("2026-06-20T23:59"));
    }
    running.signal("-INT");
    let (code, log) = running.wait(Duration::from_secs(5));
    assert_eq!(code, Some(0), "{log}");
}
