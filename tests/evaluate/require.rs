//! `--require`: requirements that are met, missed or not available.

use std::path::PathBuf;

use super::common::{Ran, Scratch, evaluate, ran, utm_fusion};

fn testdata(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata/demo").join(name)
}

fn required(conditions: &[&str], whole: bool) -> Ran {
    let mut command = evaluate(&testdata("truth.csv"), &testdata("expected.csv"));
    if whole {
        command.arg("--labels").arg(testdata("labels.csv"));
        command.arg("--capture").arg(testdata("capture.pcap")).arg("--config").arg(testdata("site.toml"));
    }
    ran(command.args(conditions.iter().flat_map(|condition| ["--require", condition])))
}

#[test]
fn met_requirements_exit_with_success() {
    let told =
        required(&["pu>=10", "radar.unequipped.eposh<1000", "transponder.gospa <= 60", "recall>0"], true);
    assert_eq!(told.code, 0, "{}", told.stderr);
    assert!(told.stdout.contains("met: pu>=10 ("), "{}", told.stdout);
}

#[test]
fn missed_requirement_is_reported_with_its_value() {
    let told = required(&["pu>=101", "epos<1000", "false_track<0"], true);
    assert_eq!(told.code, 5, "{}", told.stderr);
    for word in ["--require 'pu>=101' is missed: it is ", "--require 'false_track<0' is missed: it is "] {
        assert!(told.stderr.contains(word), "{word} is not in {}", told.stderr);
    }
    assert!(!told.stderr.contains("epos<1000"), "{}", told.stderr);
}

#[test]
fn unavailable_metric_misses_its_requirement() {
    let told = required(&["radar.pu>=1", "precision>=0", "epos_gap<100", "equipped.pu>0"], false);
    assert_eq!(told.code, 5, "{}", told.stderr);
    for (condition, reason) in [
        ("radar.pu>=1", "it needs --capture and --config"),
        ("precision>=0", "it needs --labels"),
        ("epos_gap<100", "it needs --capture and --config"),
        ("equipped.pu>0", "it needs --labels or --capture"),
    ] {
        let line = format!("--require '{condition}' is missed: {reason}");
        assert!(told.stderr.contains(&line), "{line} is not in {}", told.stderr);
    }
}

#[test]
fn wrong_usage_exits_with_code_2() {
    let told = required(&["speed>=1"], false);
    assert_eq!(told.code, 2);
    assert!(
        told.stderr.contains("\"speed\" is no metric")
            && told.stderr.contains("id_changes two_numbers ghosts false_track gospa")
    );
    for (args, word) in [
        (&["out.csv"][..], "--truth"),
        (&["--truth", "truth.csv", "out.csv", "--capture", "capture.pcap"], "--config"),
        (&["--truth", "truth.csv"], "OUTPUT"),
        (&["--truth", "truth.csv", "out.csv", "--date", "today"], "write a day as 2026-11-20"),
    ] {
        let told = ran(utm_fusion("evaluate").args(args));
        assert_eq!(told.code, 2, "{args:?}");
        assert!(told.stderr.contains(word), "{args:?}: {}", told.stderr);
    }
}

#[test]
fn json_has_the_requirements_and_every_column() {
    let scratch = Scratch::new();
    let mut command = evaluate(&testdata("truth.csv"), &testdata("expected.csv"));
    command.arg("--labels").arg(testdata("labels.csv"));
    command.arg("--capture").arg(testdata("capture.pcap")).arg("--config").arg(testdata("site.toml"));
    let told = ran(command.args(["--json", "--require", "pu>=101", "--require", "gospa<1000"]));
    assert_eq!(told.code, 5, "{}", told.stderr);
    let json: serde_json::Value = serde_json::from_str(&told.stdout).unwrap();
    drop(scratch);
    for stream in ["fused", "radar", "transponder"] {
        for group in ["all", "equipped", "unequipped"] {
            assert!(json[stream][group].is_object(), "{stream} {group}");
        }
        assert!(json["drones"][2][stream].is_object(), "{stream}");
    }
    for metric in [
        "pu_percent",
        "epos",
        "eposh",
        "eposv",
        "epos_covered",
        "epos_gap",
        "precision",
        "recall",
        "gap_within_50_m_percent",
        "id_changes",
        "two_numbers_percent",
        "ghosts_s",
        "false_track_s",
        "gospa_m",
        "gospa_parts",
    ] {
        assert!(json["fused"]["all"].get(metric).is_some(), "{metric}");
    }
    assert_eq!(
        (&json["labels"], &json["capture"], &json["reference_hz"]),
        (&true.into(), &true.into(), &4.0.into())
    );
    assert_eq!(json["requirements"][0]["met"], false);
    assert!(json["requirements"][1]["met"] == true && json["requirements"][1]["value"].is_f64());
    let ids: Vec<_> =
        json["drones"].as_array().unwrap().iter().map(|drone| drone["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["ALPHA", "BRAVO", "CHARLIE"]);
    assert_eq!(json["drones"][2]["equipped"], false);
}
