//! Conflicts in the output of `replay`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{Scratch, ran, utm_fusion};

/// Six drones that fly to and fro through one point.
const SCENARIO: &str = "name = \"meeting\"\nduration_s = 90\n[airspace]\nradius_m = 500\nheight_agl_m = [90, 110]\n\
                        [drones]\nmultirotors = 6\nequipped = 6\npattern = \"crossing\"\nseparation_m = 0\n";

fn lines(path: &Path) -> Vec<Value> {
    let text = String::from_utf8(fs::read(path).unwrap()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn fly(scratch: &Scratch) {
    simulate(scratch, SCENARIO);
}

fn simulate(scratch: &Scratch, text: &str) {
    let scenario = scratch.path("meeting.toml");
    fs::write(&scenario, text).unwrap();
    let flown = ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(scratch.path("flight")));
    assert_eq!(flown.code, 0, "{}", flown.stderr);
}

/// Conflicts and alerts of a replay with these environment variables.
fn replayed(scratch: &Scratch, variables: &[(&str, &str)]) -> [Vec<u8>; 2] {
    let [conflicts, alerts] = ["conflicts.ndjson", "alerts.ndjson"].map(|name| scratch.path(name));
    let mut replay = utm_fusion("replay");
    replay.arg(scratch.path("flight/capture.pcap")).arg("--config").arg(scratch.path("flight/site.toml"));
    replay.arg("--conflicts").arg(&conflicts).arg("--alerts").arg(&alerts);
    variables.iter().for_each(|(name, value)| _ = replay.env(name, value));
    let ran = ran(&mut replay);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    [conflicts, alerts].map(|path| fs::read(path).unwrap())
}

#[test]
fn every_pair_has_a_line_per_second_deterministically() {
    let scratch = Scratch::new();
    fly(&scratch);
    let enabled = [("UTM_FUSION__CONFLICTS__ENABLED", "true")];
    let first = replayed(&scratch, &enabled);
    assert_eq!(first, replayed(&scratch, &enabled), "to the octet");
    let conflicts = lines(&scratch.path("conflicts.ndjson"));
    let mut seconds = BTreeMap::<(String, String, String), u32>::new();
    for line in &conflicts {
        let name = |key: &str| line[key].as_str().unwrap().to_owned();
        *seconds.entry((name("a"), name("b"), name("time"))).or_default() += 1;
        let relative = &line["relative"];
        let [east, north] = [0, 1].map(|axis| relative["position_m"][axis].as_f64().unwrap());
        assert!((east.hypot(north) - line["d_now_h_m"].as_f64().unwrap()).abs() < 0.01, "{line}");
        assert!(line.get("seen").is_none_or(|seen| seen.as_str() < line["time"].as_str()), "{line}");
        assert!((0.0..=60.0).contains(&line["t_cpa_s"].as_f64().unwrap()), "{line}");
        let is_worth = line["probability"].as_f64() >= Some(0.01) || line["level"] != "none";
        assert!(is_worth, "{line}");
        assert_eq!(relative["covariance"].as_array().unwrap().len(), 4);
    }
    assert!(seconds.len() > 20 && seconds.values().all(|&count| count == 1), "one line each");
    let violations = conflicts.iter().filter(|line| line["level"] == "violation").count();
    assert!(violations > 0, "six drones in 20 m of height through one point, and nobody met");

    // Each warning raises an alert, which ends with the warning.
    let alerts = lines(&scratch.path("alerts.ndjson"));
    let alerts: Vec<&Value> = alerts.iter().filter(|alert| alert["kind"] == "conflict").collect();
    assert!(alerts.iter().any(|alert| alert["severity"] == "critical"), "{alerts:?}");
    for alert in &alerts {
        let begun = alerts.iter().filter(|other| other["id"] == alert["id"] && other.get("until").is_none());
        assert!(begun.count() >= 1, "{alert}");
        let mentioned = conflicts.iter().any(|line| line["id"] == alert["conflict"]);
        assert!(mentioned, "{alert}");
    }
}

/// No volume and no serial number is configured: ADS-B identifies the crewed aircraft.
#[test]
fn a_helicopter_that_meets_a_drone_is_in_conflict_with_it() {
    let scratch = Scratch::new();
    simulate(&scratch, &SCENARIO.replace("duration_s = 90", "duration_s = 120\n[crewed]\nconflicts = 1"));
    let [found, _] = replayed(&scratch, &[("UTM_FUSION__CONFLICTS__ENABLED", "true")]);
    assert!(!found.is_empty());
    let crewed: Vec<Value> = lines(&scratch.path("conflicts.ndjson"));
    let crewed: Vec<&Value> = crewed.iter().filter(|line| line["volume"] == "crewed").collect();
    assert!(crewed.iter().any(|line| line["level"] == "violation"), "{crewed:?}");
    // The helicopter is one of both, each time.
    let sides = |line: &Value| ["a", "b"].map(|side| line[side].as_str().unwrap().to_owned());
    let helicopter =
        sides(crewed[0]).into_iter().find(|id| crewed.iter().all(|line| sides(line).contains(id)));
    assert!(helicopter.is_some(), "{crewed:?}");
}

/// Conflicts are enabled on the command line, their alerts in the configuration.
#[test]
fn without_the_configuration_there_are_lines_and_no_alerts() {
    let scratch = Scratch::new();
    fly(&scratch);
    let [conflicts, alerts] = replayed(&scratch, &[]);
    let alerts = String::from_utf8(alerts).unwrap();
    assert!(!conflicts.is_empty() && !alerts.contains("\"conflict\""), "{alerts}");
}

#[test]
fn contradictory_options_are_refused() {
    let scratch = Scratch::new();
    fly(&scratch);
    let refused = |code: i32, arguments: &[&str], variables: &[(&str, &str)], word: &str| {
        let mut replay = utm_fusion("replay");
        replay.arg(scratch.path("flight/capture.pcap")).arg("--config").arg(scratch.path("flight/site.toml"));
        replay.args(arguments);
        variables.iter().for_each(|(name, value)| _ = replay.env(name, value));
        let ran = ran(&mut replay);
        assert_eq!(ran.code, code, "{arguments:?} {variables:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(word), "{}", ran.stderr);
    };
    let out = scratch.path("c.ndjson");
    let out = out.to_str().unwrap();
    refused(2, &["--conflicts", out, "--profile", "reference"], &[], "reference");
    refused(2, &["--conflicts", out], &[("UTM_FUSION__FUSION__NOW", "false")], "fusion.now");
    refused(2, &["--conflicts", out, "--alerts", out], &[], "same file");
    refused(2, &["--conflicts", "-"], &[], "--conflicts");
    let on = ("UTM_FUSION__CONFLICTS__ENABLED", "true");
    refused(3, &[], &[on, ("UTM_FUSION__FUSION__NOW", "false")], "picture");
    refused(3, &[], &[on, ("UTM_FUSION__CONFLICTS__HORIZON_S", "301")], "300");
    refused(3, &[], &[on, ("UTM_FUSION__CONFLICTS__WARNING", "{ probability = 0.05 }")], "advisory");
}
