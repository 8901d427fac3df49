//! All formats of `replay` give the same score. Raw captures take their day from the truth, also across midnight.

use std::fs;
use std::path::{Path, PathBuf};

use asterix::cat129;
use asterix::{Record, blocks, encode_block};
use serde_json::Value;
use utm_fusion::capture::Capture;

use super::common::{Scratch, evaluate, number, ran, utm_fusion};

fn testdata(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata/demo").join(name)
}

/// `replay -o` of the demonstration flight.
fn replayed(scratch: &Scratch, extension: &str) -> PathBuf {
    let file = scratch.path(format!("out.{extension}"));
    let mut command = utm_fusion("replay");
    command.arg(testdata("capture.pcap")).arg("--config").arg(testdata("site.toml")).arg("-o").arg(&file);
    let told = ran(&mut command);
    assert_eq!(told.code, 0, "{}", told.stderr);
    file
}

fn scored(output: &Path, capture: &Path) -> Value {
    let mut command = evaluate(&testdata("truth.csv"), output);
    command.arg("--labels").arg(testdata("labels.csv")).arg("--json");
    ran(command.arg("--capture").arg(capture).arg("--config").arg(testdata("site.toml"))).json()
}

/// Checks that counts and shares are equal, and lengths equal to `within_m`.
fn assert_same(name: &str, told: &Value, expected: &Value, within_m: f64) {
    match (told, expected) {
        (Value::Object(told), Value::Object(expected)) => {
            let names = |object: &serde_json::Map<String, Value>| object.keys().cloned().collect::<Vec<_>>();
            assert_eq!(names(told), names(expected), "{name}");
            for (key, value) in expected {
                assert_same(&format!("{name}.{key}"), &told[key], value, within_m);
            }
        }
        (Value::Array(told), Value::Array(expected)) => {
            assert_eq!(told.len(), expected.len(), "{name}");
            told.iter()
                .zip(expected)
                .for_each(|(told, expected)| assert_same(name, told, expected, within_m));
        }
        (Value::Number(told), Value::Number(expected)) => {
            let bound = if name.ends_with("_m") { within_m } else { 0.0 };
            let (told, expected) = (told.as_f64().unwrap(), expected.as_f64().unwrap());
            assert!((told - expected).abs() <= bound, "{name}: {told} is not {expected}");
        }
        _ => assert_eq!(told, expected, "{name}"),
    }
}

#[test]
fn every_format_gives_the_same_score() {
    let scratch = Scratch::new();
    let expected = scored(&testdata("expected.csv"), &testdata("capture.pcap"));
    assert!(number(&expected, "fused.all.pu_percent") > 70.0, "{expected}");
    assert!(number(&expected, "fused.all.epos.mean_m") < 10.0, "{expected}");
    // The resolution of CAT129 is 180/2^31 degrees, and about half a metre in height.
    for (extension, within_m) in
        [("csv", 0.002), ("ndjson", 0.002), ("geojson", 0.002), ("ast", 0.15), ("pcap", 0.15)]
    {
        let told = scored(&replayed(&scratch, extension), &testdata("capture.pcap"));
        assert_same(extension, &told, &expected, within_m);
        // Formats are recognised by content, not by file name.
        let renamed = scratch.file("renamed", fs::read(scratch.path(format!("out.{extension}"))).unwrap());
        assert_eq!(scored(&renamed, &testdata("capture.pcap")), told, "{extension}");
    }
}

#[test]
fn raw_asterix_takes_the_day_of_the_truth_unless_given() {
    let scratch = Scratch::new();
    let out = replayed(&scratch, "ast");
    let mut command = evaluate(&testdata("truth.csv"), &out);
    let given = ran(command.args(["--json", "--date", "2026-06-20"])).json();
    assert_eq!(ran(evaluate(&testdata("truth.csv"), &out).arg("--json")).json(), given);
    assert!(number(&given, "fused.all.pu_percent") > 70.0, "{given}");

    let mut command = evaluate(&testdata("truth.csv"), &out);
    let wrong = ran(command.args(["--json", "--date", "2026-06-19"]));
    assert_eq!(number(&wrong.json(), "fused.all.pu_percent"), 0.0);
    assert!(wrong.stderr.contains("no point counts"), "{}", wrong.stderr);
}

#[test]
fn a_raw_capture_is_on_the_day_of_the_truth() {
    let scratch = Scratch::new();
    let datagrams = Capture::open(&testdata("capture.pcap")).unwrap();
    // Whole blocks only: a broken block would end a raw file.
    let octets: Vec<u8> = datagrams
        .flat_map(|datagram| {
            let payload = datagram.unwrap().payload;
            let whole = blocks(&payload).map_while(Result::ok).map(|block| block.octets.to_vec());
            whole.collect::<Vec<_>>().concat()
        })
        .collect();
    let raw = scored(&testdata("expected.csv"), &scratch.file("capture.ast", octets));
    let pcap = scored(&testdata("expected.csv"), &testdata("capture.pcap"));
    let pu = |json| number(json, "radar.all.pu_percent");
    assert!((pu(&raw) - pu(&pcap)).abs() < 2.0, "{} and {}", pu(&raw), pu(&pcap));
    assert!(number(&raw, "transponder.equipped.pu_percent") > 50.0);
}

#[test]
fn cat129_of_another_tracker_belongs_to_the_nearest_drone() {
    let scratch = Scratch::new();
    let mut plain = Vec::new();
    for block in blocks(&fs::read(replayed(&scratch, "ast")).unwrap()) {
        for located in block.unwrap().records::<cat129::Record>() {
            let record = cat129::Record { special_purpose: None, ..located.unwrap().record };
            encode_block(&[record], &mut plain).unwrap();
        }
    }
    assert_eq!(cat129::Record::CATEGORY, 129);
    let plain = scratch.file("plain.ast", plain);
    let mut command = evaluate(&testdata("truth.csv"), &plain);
    let told = ran(command.arg("--labels").arg(testdata("labels.csv")).arg("--json"));
    assert!(told.stderr.contains("do not say what they are made of"), "{}", told.stderr);
    let expected = ran(evaluate(&testdata("truth.csv"), &scratch.path("out.ast")).arg("--json")).json();
    for way in ["fused.all.pu_percent", "fused.all.epos.mean_m", "drones.0.fused.eposh.mean_m"] {
        assert_eq!(number(&told.json(), way), number(&expected, way), "{way}");
    }
    assert!(told.json()["fused"]["all"].get("precision").is_none());
}
