//! Operators' decisions about alerts: all readers see them, they survive a restart, and the recording replays them.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::thread::JoinHandle;
use std::time::Duration;

use serde_json::{Value, json};
use utm_fusion::config::{AlertArea, Area, AreaKind, ConflictVolume};

use crate::common::{Running, ask, ask_with, beside, only, utm_fusion};
use crate::stage::Stage;

/// Two drones that are close to each other by the volume below.
const SCENARIO: &str = "name = \"live\"\nduration_s = 55\n[drones]\nmultirotors = 2\nequipped = 2\n";

/// A zone over the whole site, from which the first drone is exempt.
fn stage() -> Stage {
    Stage::new(SCENARIO, 23_000, |config, scratch| {
        let polygon = r#"{"type":"Polygon","coordinates":[[[-180,-80],[0,-80],[180,-80],[180,80],[0,80],[-180,80],[-180,-80]]]}"#;
        let allow = vec!["000000000001".to_owned()];
        let kind = AreaKind::Alert(AlertArea { allow, ..AlertArea::default() });
        config.areas = vec![Area { kind, file: scratch.file("closed.geojson", polygon) }];
        config.conflicts.enabled = true;
        config.conflicts.volumes = vec![ConflictVolume {
            name: Some("wide".to_owned()),
            horizontal_m: Some(15_000.0),
            vertical_m: Some(5_000.0),
            ..ConflictVolume::default()
        }];
    })
}

/// Reads the alerts and the conflicts of a stream, until the service closes it.
fn overhear(port: u16) -> JoinHandle<[Vec<Value>; 2]> {
    let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    socket.write_all(b"GET /api/v1/stream?source=radar HTTP/1.0\r\nHost: localhost\r\n\r\n").unwrap();
    std::thread::spawn(move || {
        let mut events = [Vec::new(), Vec::new()];
        let mut event = None;
        for line in BufReader::new(socket).lines().map_while(Result::ok) {
            match line.split_once(": ") {
                Some(("event", name)) => {
                    event = ["alert", "conflict"].iter().position(|wanted| name == *wanted);
                }
                Some(("data", data)) => {
                    if let Some(event) = event {
                        events[event].push(serde_json::from_str(data).unwrap());
                    }
                }
                _ => {}
            }
        }
        events
    })
}

/// The active alert of a kind.
fn lasting(port: u16, kind: &str) -> Option<Value> {
    let (_, answer) = ask(port, "GET", &format!("/api/v1/alerts?kind={kind}"));
    answer["alerts"].as_array().unwrap().first().cloned()
}

/// Changes of the alerts of each kind that a recording contains, without the ids, which count from another start.
fn by_kind(alerts: Vec<Value>) -> BTreeMap<String, Vec<Value>> {
    let mut kinds = BTreeMap::<_, Vec<Value>>::new();
    for mut alert in alerts {
        let kind = alert["kind"].as_str().unwrap().to_owned();
        if !["sensor", "service", "registration"].contains(&&*kind) {
            alert.as_object_mut().unwrap().remove("id");
            kinds.entry(kind).or_default().push(alert);
        }
    }
    // The stream also has each wording of an alert whose figures change by the second.
    kinds.values_mut().for_each(|alerts| alerts.dedup_by_key(|alert| without_figures(alert)));
    kinds
}

fn without_figures(alert: &Value) -> Value {
    let mut alert = alert.clone();
    for member in ["text", "closest", "time_to_entry_s", "earliest_s"] {
        alert.as_object_mut().unwrap().remove(member);
    }
    alert
}

/// Sends the flight in steps until both alerts are active.
fn fly(stage: &Stage, port: u16, from_s: u32) -> u32 {
    for second in from_s..from_s + 20 {
        stage.send(f64::from(second), f64::from(second + 1));
        if lasting(port, "area").is_some() && lasting(port, "conflict").is_some() {
            return second + 1;
        }
    }
    panic!("no alerts: {}", ask(port, "GET", "/api/v1/alerts").1);
}

#[test]
fn acknowledgement_and_shelving_survive_restart_and_replay() {
    let stage = stage();
    let service = stage.run("first.log");
    let port = service.http_port();
    let stream = overhear(port);
    let at_s = fly(&stage, port, 0);

    let areas = ask(port, "GET", "/api/v1/alerts?kind=area").1;
    let [area] = &areas["alerts"].as_array().unwrap()[..] else {
        panic!("who may be there raises none: {areas}")
    };
    let decide = |alert: &Value, act: &str, body: Value| {
        let path = format!("/api/v1/alerts/{}/{act}", alert["id"].as_str().unwrap());
        let (status, answer) = ask_with(port, "POST", &path, &body.to_string());
        assert_eq!(status, 200, "{answer}");
        answer
    };
    let seen = decide(area, "acknowledge", json!({ "by": "tower", "note": "called the pilot" }));
    assert_eq!(seen["acknowledged"]["by"], "tower");
    let conflict = lasting(port, "conflict").unwrap();
    decide(&conflict, "shelve", json!({ "minutes": 10, "by": "tower" }));
    stage.send(f64::from(at_s), f64::from(at_s + 4));
    let log = end(service);
    for line in ["alert acknowledged", "alert shelved", "by=\"tower\"", "note=\"called the pilot\""] {
        assert!(log.contains(line), "{line}\n{log}");
    }

    // The replay of the recording.
    let input = only(&stage.scratch.path("recordings"), "input-", ".pcap");
    let [file, conflict_file] = ["alerts.ndjson", "conflicts.ndjson"].map(|name| stage.scratch.path(name));
    let mut replay = utm_fusion("replay");
    replay.arg(&input).arg("--config").arg(beside(&input, "site.toml"));
    replay.arg("--state").arg(input.with_extension("")).arg("--alerts").arg(&file);
    let ran = replay.arg("--conflicts").arg(&conflict_file).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let lines = |path| -> Vec<Value> {
        fs::read_to_string(path).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let (again, conflicts_again) = (by_kind(lines(file)), lines(conflict_file));
    let [alerts, conflicts] = stream.join().unwrap();
    let heard = by_kind(alerts);
    assert!(heard["area"].iter().any(|alert| alert["acknowledged"]["note"] == "called the pilot"));
    assert!(heard["conflict"].iter().any(|alert| alert["shelved"]["by"] == "tower"));
    for (kind, heard) in &heard {
        // The stream ends before the last slots, which the service publishes at once when it stops.
        let again = again.get(kind).map_or(&[][..], |again| &again[..heard.len().min(again.len())]);
        assert_eq!(heard, again, "{kind}");
    }

    assert!(conflicts.len() > 3, "{conflicts:?}");
    for heard in &conflicts {
        let is_same = |again: &&Value| again["time"] == heard["time"] && again["volume"] == heard["volume"];
        let mut again = conflicts_again.iter().find(is_same).expect("not replayed").clone();
        again.as_object_mut().unwrap().remove("relative");
        assert_eq!(heard, &again);
    }

    // After a restart.
    let service = stage.run("second.log");
    let port = service.http_port();
    fly(&stage, port, at_s + 5);
    let conflict = lasting(port, "conflict").unwrap();
    assert_eq!(
        (&conflict["shelved"]["by"], conflict["shelved"]["until"].is_string()),
        (&json!("tower"), true)
    );
    assert!(lasting(port, "area").unwrap().get("acknowledged").is_none(), "a new alert");
    end(service);
}

fn end(service: Running) -> String {
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    log
}
