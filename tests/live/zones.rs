//! A zone that an operator activates: it raises alerts at once, stays over a reload and a restart, and ends when it is revoked.

use std::fs;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::common::{Running, ask, ask_with};
use crate::stage::Stage;

const SCENARIO: &str = "name = \"live\"\nduration_s = 75\n[drones]\nmultirotors = 1\nequipped = 1\n";

/// A polygon over the whole site.
fn zone(ceiling_m: f64) -> String {
    let ring = "[[[-20,30],[20,30],[20,70],[-20,70],[-20,30]]]";
    format!(
        "{{\"type\":\"Feature\",\"properties\":{{\"ceiling_m\":{ceiling_m}}},\
         \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":{ring}}}}}"
    )
}

/// The active alerts about areas.
fn lasting(port: u16) -> Vec<Value> {
    let (_, answer) = ask(port, "GET", "/api/v1/alerts?kind=area");
    answer["alerts"].as_array().unwrap().clone()
}

/// Sends the flight in steps until `is_done`; returns the second that it has reached.
fn fly_until(stage: &Stage, from_s: u32, what: &str, is_done: impl Fn() -> bool) -> u32 {
    for second in from_s..from_s + 25 {
        stage.send(f64::from(second), f64::from(second + 1));
        if is_done() {
            return second + 1;
        }
    }
    panic!("not within 25 s: {what}");
}

fn wait_until(what: &str, is_done: impl Fn() -> bool) {
    let until = Instant::now() + Duration::from_secs(20);
    while !is_done() {
        assert!(Instant::now() < until, "{what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn end(service: Running) -> String {
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    log
}

#[test]
fn activated_zone_raises_alerts_until_it_is_revoked() {
    let stage = Stage::new(SCENARIO, 23_200, |_, _| {});
    let service = stage.run("first.log");
    let port = service.http_port();
    let at_s = fly_until(&stage, 0, "a track", || {
        ask(port, "GET", "/api/v1/tracks").1["features"].as_array().is_some_and(|tracks| !tracks.is_empty())
    });
    assert_eq!(lasting(port), [Value::Null; 0]);

    // A zone below the drone raises nothing; its replacement does.
    for (ceiling_m, alerts) in [(-400.0, 0), (5_000.0, 1)] {
        let (status, answer) = ask_with(port, "POST", "/api/v1/zones/Fair%201?by=tower", &zone(ceiling_m));
        assert_eq!(status, 200, "{answer}");
        let areas = ask(port, "GET", "/api/v1/areas").1;
        let shown = areas["features"].as_array().unwrap();
        assert_eq!((shown.len(), &shown[0]["properties"]["ceiling_m"]), (1, &json!(ceiling_m)), "{areas}");
        assert_eq!(shown[0]["properties"]["activated_by"], "tower");
        if alerts == 0 {
            stage.send(f64::from(at_s), f64::from(at_s + 2));
            assert_eq!(lasting(port), [Value::Null; 0]);
        }
    }
    let at_s = fly_until(&stage, at_s + 2, "an alert", || !lasting(port).is_empty());
    let [alert] = &lasting(port)[..] else { panic!("one drone") };
    assert_eq!(
        (&alert["area"]["name"], &alert["severity"]),
        (&json!("Fair 1"), &json!("warning")),
        "{alert}"
    );

    // A reload of the configuration keeps the zone.
    service.signal("-HUP");
    wait_until("no reload", || service.log().contains("SIGHUP is done"));
    stage.send(f64::from(at_s), f64::from(at_s + 4));
    assert_eq!((lasting(port).len(), &lasting(port)[0]["id"]), (1, &alert["id"]), "the alert goes on");
    let log = end(service);
    assert!(log.contains("zone activated name=\"Fair 1\" by=\"tower\""), "{log}");
    let file = stage.config.state.dir.join("zones/Fair%201.geojson");
    let kept: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let properties = &kept["features"][0]["properties"];
    assert_eq!((&properties["activated_by"], &properties["name"]), (&json!("tower"), &json!("Fair 1")));
    assert!(properties["activated_at"].is_string());

    // After a restart, with a damaged file beside it.
    fs::write(file.with_file_name("other.geojson"), "{").unwrap();
    let service = stage.run("second.log");
    let port = service.http_port();
    let zones = ask(port, "GET", "/api/v1/zones").1;
    assert_eq!((zones["zones"].as_array().unwrap().len(), &zones["zones"][0]["name"]), (1, &json!("Fair 1")));
    let at_s = fly_until(&stage, at_s + 4, "an alert after the restart", || !lasting(port).is_empty());
    let reported = ask(port, "GET", "/api/v1/alerts?kind=service").1.to_string();
    assert!(reported.contains("other.geojson.damaged-"), "{reported}");

    assert_eq!(ask(port, "POST", "/api/v1/zones/fair%201/revoke").0, 404);
    let (status, answer) = ask(port, "POST", "/api/v1/zones/Fair%201/revoke?by=chief");
    assert_eq!((status, &answer["activated_by"]), (200, &json!("tower")), "{answer}");
    fly_until(&stage, at_s, "the alert lasts", || lasting(port).is_empty());
    assert_eq!(ask(port, "GET", "/api/v1/areas").1["features"], json!([]));
    let log = end(service);
    assert!(log.contains("zones of operators stay active zones=1"), "{log}");
    assert!(log.contains("zone revoked name=\"Fair 1\" by=\"chief\""), "{log}");
    assert!(!file.exists());
}
