//! A well-behaved client.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::Running;

/// Address on which the program serves, from its log.
pub(crate) fn address(running: &mut Running) -> SocketAddr {
    running.says("url=http://");
    let log = running.log();
    log.split("url=http://").nth(1).unwrap().split('/').next().unwrap().parse().unwrap()
}

/// Status and body of an answer.
pub(crate) fn get(address: SocketAddr, path: &str) -> (u16, String) {
    let mut socket = TcpStream::connect(address).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    write!(socket, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
}

pub(crate) fn json(address: SocketAddr, path: &str) -> Value {
    let (_, body) = get(address, path);
    serde_json::from_str(&body).unwrap_or_else(|error| panic!("{path}: {error}: {body}"))
}

/// Sum of a metric's samples whose labels contain `label`.
pub(crate) fn metric(address: SocketAddr, name: &str, label: &str) -> f64 {
    let (_, text) = get(address, "/metrics");
    let values = text.lines().filter_map(|line| {
        let (sample, value) = line.rsplit_once(' ')?;
        let (of, labels) = sample.split_once('{').unwrap_or((sample, ""));
        (of == name && labels.contains(label)).then(|| value.parse::<f64>().unwrap())
    });
    values.sum()
}

/// States of the sensors; empty before they are available.
pub(crate) fn lights(address: SocketAddr) -> Vec<String> {
    let sensors = json(address, "/api/v1/sensors");
    let state = |sensor: &Value| sensor["properties"]["state"].as_str().unwrap_or("").to_owned();
    sensors["features"].as_array().unwrap().iter().map(state).collect()
}

/// Parts of the service with faults.
pub(crate) fn troubled(address: SocketAddr) -> Vec<String> {
    let alerts = json(address, "/api/v1/alerts");
    let of_service = alerts["alerts"].as_array().unwrap().iter().filter(|alert| alert["kind"] == "service");
    let mut parts: Vec<String> = of_service.map(|alert| alert["part"].as_str().unwrap().to_owned()).collect();
    // Either of two may be the first to find the disk full.
    parts.sort();
    parts
}

/// Waits until a condition is met; returns the time that this took.
pub(crate) fn until(what: &str, at_most: Duration, mut is_so: impl FnMut() -> bool) -> Duration {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < at_most, "not within {at_most:?}: {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
    start.elapsed()
}

/// Reads the stream to its end.
pub(crate) struct Stream(Arc<Mutex<Vec<(u64, Instant)>>>);

impl Stream {
    pub(crate) fn open(address: SocketAddr) -> Self {
        let mut socket = TcpStream::connect(address).unwrap();
        socket.write_all(b"GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let slots = Arc::new(Mutex::new(Vec::new()));
        let read = slots.clone();
        std::thread::spawn(move || {
            let mut is_slot = false;
            for line in BufReader::new(socket).lines().map_while(Result::ok) {
                if let Some(event) = line.strip_prefix("event: ") {
                    assert_ne!(event, "resync", "a slot was missed");
                    is_slot = event == "tracks";
                } else if let Some(data) = line.strip_prefix("data: ").filter(|_| is_slot) {
                    let data: Value = serde_json::from_str(data).unwrap();
                    read.lock().unwrap().push((data["seq"].as_u64().unwrap(), Instant::now()));
                }
            }
        });
        Self(slots)
    }

    /// Checks that no slot is missing, and that no pause exceeds `at_most`; returns the number of slots.
    pub(crate) fn is_unbroken(&self, at_most: Duration) -> usize {
        let slots = self.0.lock().unwrap();
        for pair in slots.windows(2) {
            assert_eq!(pair[1].0, pair[0].0 + 1, "a slot is missing");
            let pause = pair[1].1 - pair[0].1;
            assert!(pause < at_most, "no slot for {pause:?} before {}", pair[1].0);
        }
        slots.len()
    }
}
