//! Remote ID posted by gateways over HTTP to a running service.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::{Value, json};
use utm_fusion::config::{Config, Connection, ConnectionFormat};
use utm_fusion::live::now;

use crate::common::{Scratch, ask, ask_with, datagrams, only, replayed, utm_fusion};
use crate::stage::Stage;

const SCENARIO: &str = "name = \"posted\"\nduration_s = 20\n[drones]\nmultirotors = 2\nequipped = 0\n[birds]\ncount = 2\n\
                        [remote_id]\ndrones = 2\n";
const PATH: &str = "/api/v1/remote-id";

/// Configures the Remote ID receiver for posted lines.
fn posted(config: &mut Config, _: &Scratch) {
    let sensor = config.sensors.iter_mut().find(|sensor| sensor.kind.name() == "remote-id").unwrap();
    sensor.inputs.clear();
    sensor.connections = vec![Connection { format: ConnectionFormat::Http, ..Connection::default() }];
}

/// State of the sensor, as soon as it is available.
fn gateway(port: u16) -> Value {
    for _ in 0..200 {
        let sensors = ask(port, "GET", "/api/v1/sensors").1;
        let is_it = |sensor: &&Value| sensor["properties"]["lines"][0]["name"] == format!("POST {PATH}");
        if let Some(found) = sensors["features"].as_array().unwrap().iter().find(is_it) {
            return found["properties"].clone();
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("no sensor has such a line");
}

/// Sends an incomplete request; there is no answer.
fn break_off(port: u16, text: &str) {
    let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
    socket.write_all(text.as_bytes()).unwrap();
}

/// Sends a whole request as given, and returns its status.
fn raw(port: u16, request: &[u8]) -> u16 {
    let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
    socket.write_all(request).unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    answer.split(' ').nth(1).unwrap().parse().unwrap()
}

#[test]
fn posted_lines_are_shown_recorded_and_replayed() {
    let stage = Stage::new(SCENARIO, 21_900, posted);
    let service = stage.run("run.log");
    let port = service.http_port();
    let before = gateway(port);
    assert_eq!(
        (&before["state"], &before["lines"][0]["joined"]),
        (&json!("degraded"), &json!(true)),
        "it is open, and nothing has come: {before}"
    );

    let socket = stage.sender();
    let mut batch: Vec<&[u8]> = Vec::new();
    let (mut began, mut sent, mut bad) = (now(), 0, 0);
    let mut post = |batch: &mut Vec<&[u8]>| {
        // A damaged line between two others affects neither of them.
        let text = batch.join(&b"\n{\"transmitter\":\"\xff\n"[..]);
        let expected = batch.len() as u64;
        let damaged = expected.saturating_sub(1);
        let head = format!(
            "POST {PATH} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/x-ndjson\r\n\
             Content-Length: {}\r\n\r\n",
            text.len()
        );
        let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
        socket.write_all(&[head.as_bytes(), &text].concat()).unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        assert!(head.starts_with("HTTP/1.1 200"), "{answer}");
        let body: Value = serde_json::from_str(body).unwrap();
        assert_eq!((&body["lines"], &body["taken"]), (&json!(expected + damaged), &json!(expected)));
        (sent, bad) = (sent + expected, bad + damaged);
        batch.clear();
    };
    for datagram in &stage.simulation.datagrams {
        if let Ok(early) = Duration::try_from(datagram.received - now()) {
            std::thread::sleep(early);
        }
        if datagram.payload[0] == b'{' {
            batch.push(&datagram.payload);
        } else {
            socket.send_to(&datagram.payload, stage.to(0)).unwrap();
        }
        if now().seconds_since(began) > 0.4 && !batch.is_empty() {
            began = now();
            post(&mut batch);
        }
    }
    post(&mut batch);
    assert!(sent > 40 && bad > 10, "{sent} lines, {bad} damaged");

    // Requests that are incomplete, too large, or of another kind post nothing.
    let line = std::str::from_utf8(
        stage
            .simulation
            .datagrams
            .iter()
            .find(|datagram| datagram.payload[0] == b'{')
            .unwrap()
            .payload
            .as_slice(),
    )
    .unwrap();
    break_off(
        port,
        &format!("POST {PATH} HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5000\r\n\r\n{line}\n{line}"),
    );
    break_off(
        port,
        &format!(
            "POST {PATH} HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nfff\r\n{line}\n"
        ),
    );
    for (headers, body, status) in [
        ("Content-Length: 70000", String::new(), 413),
        ("Transfer-Encoding: chunked", format!("{:x}\r\n{}\r\n0\r\n\r\n", 70_000, " ".repeat(70_000)), 413),
        ("Content-Type: text/plain\r\nContent-Length: 3", "abc".to_owned(), 415),
        ("Content-Encoding: gzip\r\nContent-Length: 3", "abc".to_owned(), 415),
        ("Origin: https://elsewhere.example\r\nContent-Length: 3", "abc".to_owned(), 403),
    ] {
        let request = format!(
            "POST {PATH} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}\r\n\r\n{body}"
        );
        assert_eq!(raw(port, request.as_bytes()), status, "{headers}");
    }
    let (status, answer) = ask_with(port, "POST", PATH, "nonsense\n[]\n{}");
    assert_eq!((status, answer["refused"]["line_not_an_object"].as_u64()), (200, Some(3)), "{answer}");

    std::thread::sleep(Duration::from_millis(1_200));
    let after = gateway(port);
    let line = &after["lines"][0];
    assert_eq!((&after["state"], &after["reasons"]), (&json!("operational"), &json!([])), "{after}");
    assert_eq!((line["received"].as_u64(), line["queue_full"].as_u64()), (Some(sent), Some(0)), "{line}");
    assert_eq!(line["untranslated"], json!({ "line_not_an_object": bad + 3 }));
    assert!(after["accepted"].as_u64() > Some(20), "{after}");
    let tracks = ask(port, "GET", "/api/v1/tracks").1;
    let drones = tracks["features"].as_array().unwrap().iter();
    assert!(drones.filter(|track| track["properties"]["uas_id"].is_object()).count() == 2, "{tracks}");

    std::thread::sleep(Duration::from_millis(7_000));
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    let directory = stage.scratch.path("recordings");
    let (input, output) = (only(&directory, "input-", ".pcap"), only(&directory, "output-", ".pcap"));
    assert!(datagrams(&output).len() > 40);
    assert!(fs::read(&output).unwrap() == replayed(&input));
    let of_drones = |payload: &[u8]| payload[0] == b'{';
    let recorded: Vec<Vec<u8>> = datagrams(&input)
        .into_iter()
        .map(|(_, payload)| payload)
        .filter(|payload| of_drones(payload))
        .collect();
    let simulated = stage.simulation.datagrams.iter().map(|datagram| &datagram.payload);
    assert!(simulated.filter(|payload| of_drones(payload)).eq(&recorded));
}

#[test]
fn check_and_record_describe_a_posted_line() {
    let stage = Stage::new(SCENARIO, 21_950, posted);
    let check = utm_fusion("check").arg("--network").arg("--config").arg(&stage.site).output().unwrap();
    let text = String::from_utf8(check.stdout).unwrap();
    assert!(
        check.status.success() && text.contains("POST /api/v1/remote-id (remote-id): ok while"),
        "{text}"
    );
    let record = utm_fusion("record")
        .arg("--config")
        .arg(&stage.site)
        .arg("--dir")
        .arg(stage.scratch.path("recorded"))
        .args(["--duration", "1s"])
        .output()
        .unwrap();
    let log = String::from_utf8(record.stderr).unwrap();
    assert!(record.status.success() && log.contains("only a running service is posted to"), "{log}");
}
