//! Zones of `[[areas]]` in a replay: alerts for drones inside, and for predicted entries.

use std::collections::BTreeMap;
use std::fs;

use serde_json::{Value, json};

use super::common::{Scratch, demo, ran, utm_fusion};

/// A circle of 150 m that a drone of the demo passes through after half of its flight.
fn zone(more: &Value) -> String {
    let mut zone = json!({ "type": "Feature",
        "properties": { "identifier": "EDR1", "name": "Moon", "type": "PROHIBITED" },
        "geometry": { "type": "Point", "coordinates": [10.33, 53.0877],
            "extent": { "subType": "Circle", "radius": 150 },
            "layer": { "lower": 0, "lowerReference": "AGL", "upper": 300, "upperReference": "AGL" } } });
    for (name, value) in more.as_object().unwrap() {
        zone["properties"][name] = value.clone();
    }
    zone.to_string()
}

/// Area alerts in a replay of the demo with such a zone and these keys of its area.
fn alerts(more: &Value, keys: &str, options: &[&str]) -> Vec<Value> {
    let flight = demo();
    let scratch = Scratch::new();
    scratch.file("moon.json", zone(more).as_bytes());
    let area = format!("\n[[areas]]\nkind = \"alert\"\nfile = \"moon.json\"\nground_m = 70.0\n{keys}\n");
    let site = scratch.file("site.toml", [fs::read(flight.site()).unwrap(), area.into()].concat());
    let told = scratch.path("alerts.ndjson");
    let mut command = utm_fusion("replay");
    command.arg(flight.capture()).arg("--config").arg(site).arg("--alerts").arg(&told).args(options);
    let ran = ran(&mut command);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let text = String::from_utf8(fs::read(told).unwrap()).unwrap();
    let alerts = text.lines().map(|line| serde_json::from_str(line).unwrap());
    alerts.filter(|alert: &Value| alert["kind"].as_str().unwrap().starts_with("area")).collect()
}

#[test]
fn zone_entry_raises_a_warning_then_an_alert() {
    let operational = ["--profile", "operational"];
    let told = alerts(&json!({}), "", &operational);
    let mut inside = BTreeMap::new();
    for alert in told.iter().filter(|alert| alert["kind"] == "area") {
        assert_eq!((&alert["severity"], &alert["area"]["identifier"]), (&json!("critical"), &json!("EDR1")));
        inside.entry(alert["track"].as_str().unwrap()).or_insert(alert["since"].as_str().unwrap());
    }
    assert!(!inside.is_empty(), "nobody is inside");
    let began = |alert: &&Value| alert["kind"] == "area-predicted" && alert.get("until").is_none();
    let warned = told.iter().filter(began).filter(|alert| {
        inside
            .get(alert["track"].as_str().unwrap())
            .is_some_and(|since| alert["since"].as_str().unwrap() < *since)
    });
    assert!(warned.count() > 0, "nobody was warned of: {told:#?}");
    // Predictions end, also if no entry follows.
    let ended = |alert: &&Value| alert["kind"] == "area-predicted" && alert.get("until").is_some();
    assert!(told.iter().filter(ended).count() > 0);
    assert_eq!(told, alerts(&json!({}), "", &operational), "the same again");

    // Permitted drones raise no alert; a drone without a transponder cannot be permitted.
    let serials = |told: &[Value]| {
        // A text begins with the end of the serial number, or with R and the number of a radar track.
        let serial = |alert: &Value| {
            let name = alert["text"].as_str()?.split(' ').next()?;
            name.starts_with(|c: char| c.is_ascii_digit()).then(|| format!("{name:0>12}"))
        };
        told.iter().filter_map(serial).collect::<std::collections::BTreeSet<_>>()
    };
    let known = serials(&told);
    assert!(!known.is_empty());
    let allow = format!("allow = {known:?}").replace(['{', '}'], "|").replacen('|', "[", 1).replace('|', "]");
    assert_eq!(serials(&alerts(&json!({}), &allow, &operational)), Default::default());

    assert!(alerts(&json!({}), "predict_s = 0", &operational).iter().all(|alert| alert["kind"] == "area"));
    assert_eq!(alerts(&json!({ "type": "NO_RESTRICTION" }), "", &operational), [] as [Value; 0]);
    let over = json!({ "limitedApplicability": [{ "endDateTime": "2001-01-01T00:00:00Z" }] });
    assert_eq!(alerts(&over, "", &operational), [] as [Value; 0]);
    // Keys for heights apply only to files without heights.
    assert_eq!(
        alerts(&json!({ "verticalLayer": null }), "floor_m = 0", &operational),
        told,
        "the file's own heights count"
    );
}

/// The reference profile has no velocities.
#[test]
fn reference_profile_predicts_no_entries() {
    let told = alerts(&json!({}), "", &["--profile", "reference"]);
    assert!(!told.is_empty() && told.iter().all(|alert| alert["kind"] == "area"), "{told:#?}");
}
