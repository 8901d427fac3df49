//! Transponders that are not to be trusted, in what `replay` writes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{Scratch, ran, utm_fusion};

/// A flight of two drones, and an operator who distrusts one of them from the beginning.
const SCENARIO: &str = "name = \"distrust\"\nduration_s = 40\n[drones]\nmultirotors = 2\nequipped = 2\n";

/// The serial number of the drone that is not trusted.
fn distrust(scratch: &Scratch) -> String {
    let scenario = scratch.path("distrust.toml");
    fs::write(&scenario, SCENARIO).unwrap();
    let flown = ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(scratch.path("flight")));
    assert_eq!(flown.code, 0, "{}", flown.stderr);
    let labels = fs::read_to_string(scratch.path("flight/labels.csv")).unwrap();
    let report = labels.lines().find(|line| line.contains(",drone-it,")).unwrap();
    // The simulator's serial numbers count from 1.
    let serial = format!("{:0>12}", report.split(',').nth(2).unwrap());
    let line =
        format!("{{\"slot\":0,\"serial\":\"{serial}\",\"country\":\"GB\",\"verdict\":\"distrusted\"}}\n");
    fs::write(scratch.path("kept.decisions.jsonl"), line).unwrap();
    fs::write(scratch.path("kept.numbers.json"), "{\"version\":1,\"numbers\":[]}\n").unwrap();
    serial
}

/// What a replay writes as `out.EXTENSION`, and its alerts.
fn replayed(scratch: &Scratch, extension: &str, change: &[&str]) -> (String, String, String) {
    let (out, alerts) = (scratch.path(format!("out.{extension}")), scratch.path("alerts.ndjson"));
    let mut replay = utm_fusion("replay");
    replay.arg(scratch.path("flight/capture.pcap")).arg("--config").arg(scratch.path("flight/site.toml"));
    replay.arg("--state").arg(scratch.path("kept")).arg("-o").arg(&out).arg("--alerts").arg(&alerts);
    for variable in change.chunks_exact(2) {
        replay.env(variable[0], variable[1]);
    }
    let ran = ran(&mut replay);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let read = |path: &Path| fs::read_to_string(path).unwrap();
    (read(&out), read(&alerts), ran.text().to_owned())
}

#[test]
fn who_is_not_to_be_trusted_is_flagged_in_every_format_and_in_the_alerts() {
    let scratch = Scratch::new();
    let serial = distrust(&scratch);
    let (text, alerts, summary) = replayed(&scratch, "ndjson", &[]);
    let mut states = BTreeMap::<(bool, String), u32>::new();
    for line in text.lines() {
        let track: Value = serde_json::from_str(line).unwrap();
        let is_it = track["uas_id"]["serial_number"] == *serial;
        if track.get("uas_id").is_some() {
            *states.entry((is_it, track["integrity"].as_str().unwrap().to_owned())).or_default() += 1;
        } else {
            assert!(track.get("integrity").is_none(), "{track}");
        }
    }
    assert!(states.contains_key(&(true, "failed".to_owned())), "{states:?}");
    assert!(!states.contains_key(&(false, "failed".to_owned())), "{states:?}");
    assert!(summary.contains(&format!("flagged    {serial}")), "{summary}");

    let raised: Vec<Value> = alerts.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let its: Vec<&Value> = raised.iter().filter(|alert| alert["identity"] == *serial).collect();
    let [alert, ..] = its[..] else { panic!("{alerts}") };
    assert_eq!((&alert["kind"], &alert["severity"]), (&"integrity".into(), &"critical".into()), "{alerts}");
    assert!(alert["text"].as_str().unwrap().contains("an operator distrusts it"), "{alert}");

    let (table, again, _) = replayed(&scratch, "csv", &[]);
    assert_eq!(again, alerts);
    let columns = ",integrity,integrity_index,protection_level_m,offset_m,reasons,linked,uncooperative";
    assert!(table.lines().next().unwrap().ends_with(columns), "{table}");
    assert!(table.lines().any(|line| line.contains(",failed,")));
}

#[test]
fn where_nothing_is_judged_nothing_is_said() {
    let scratch = Scratch::new();
    distrust(&scratch);
    for change in [["UTM_FUSION__INTEGRITY__ACTION", "off"], ["UTM_FUSION__FUSION__PROFILE", "reference"]] {
        let (text, alerts, summary) = replayed(&scratch, "ndjson", &change);
        assert!(!text.is_empty() && !text.contains("integrity") && !text.contains("uncooperative"));
        assert!(alerts.is_empty() && !summary.contains("flagged"), "{alerts}{summary}");
        let (table, ..) = replayed(&scratch, "csv", &change);
        assert!(table.lines().next().unwrap().ends_with(",alt_msl,flags"), "{table}");
    }
}

#[test]
fn alerts_go_into_a_file_of_their_own() {
    let scratch = Scratch::new();
    distrust(&scratch);
    let capture = scratch.path("flight/capture.pcap");
    let usage = |arguments: &[&str]| {
        let mut replay = utm_fusion("replay");
        replay.arg(&capture).arg("--config").arg(scratch.path("flight/site.toml")).args(arguments);
        let ran = ran(&mut replay);
        assert_eq!(ran.code, 2, "{arguments:?}: {}", ran.stderr);
        ran.stderr
    };
    assert!(usage(&["--alerts", "-"]).contains("--alerts needs a file"));
    assert!(usage(&["--alerts", capture.to_str().unwrap()]).contains("is also an input"));
    assert!(usage(&["--alerts", "x.ndjson", "-o", "x.ndjson"]).contains("the same file"));
    assert!(usage(&["--alerts", "x.ndjson", "--udp", "--loop"]).contains("grow without end"));
}
