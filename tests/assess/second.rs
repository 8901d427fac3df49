//! The figures against those of `check.py`, which is written from the documentation.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::{Scratch, utm_fusion};
use crate::{Flight, assess, demo, simulated};

/// Fails if a printed digit differs. Returns the last line of the script.
fn compare(scratch: &Scratch, flight: &Flight, with_truth: bool) -> Option<String> {
    let report = assess(flight, with_truth, &[]);
    assert!(report.status.success(), "{}", String::from_utf8_lossy(&report.stderr));
    let report = scratch.file("report.json", report.stdout);
    let decoded = utm_fusion("decode").arg(&flight.capture).output().unwrap();
    let decoded = scratch.file("decoded.ndjson", decoded.stdout);
    let picture = scratch.path("picture.ndjson");
    let mut replay = utm_fusion("replay");
    replay.arg(&flight.capture).arg("--config").arg(&flight.site).arg("-o").arg(&picture);
    assert!(replay.output().unwrap().status.success());
    let mut python = Command::new("python3");
    python
        .arg("tests/assess/check.py")
        .arg(report)
        .arg(&flight.capture)
        .arg(&flight.site)
        .arg(decoded)
        .arg(picture);
    if with_truth {
        python.arg(&flight.truth);
    }
    let Ok(checked) = python.output() else {
        println!("skipped: python3 is not installed");
        return None;
    };
    let text = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(checked.status.success(), "{text}{}", String::from_utf8_lossy(&checked.stderr));
    let last = text.lines().last().unwrap().to_owned();
    println!("{}: {last}", flight.capture.display());
    Some(last)
}

#[test]
fn second_implementation_agrees_on_the_demo() {
    let scratch = Scratch::new();
    for with_truth in [true, false] {
        compare(&scratch, &demo(), with_truth);
    }
}

#[test]
fn second_implementation_agrees_on_a_simulation() {
    let scratch = Scratch::new();
    let flight = simulated(&scratch, "1001");
    for with_truth in [true, false] {
        compare(&scratch, &flight, with_truth);
    }
}

#[test]
fn second_implementation_finds_a_wrong_digit() {
    let scratch = Scratch::new();
    let flight = demo();
    let Some(last) = compare(&scratch, &flight, true) else { return };
    assert!(last.starts_with("0 differences, ") && !last.contains(", 0 printed"), "{last}");
    let path = scratch.path("report.json");
    let text = fs::read_to_string(&path).unwrap();
    let place = text.find("\"key\": \"picture.accuracy.horizontal.rms\"").unwrap();
    let value = place + text[place..].find("\"value\": ").unwrap() + "\"value\": ".len();
    let changed = format!("{}9{}", &text[..value], &text[value..]);
    fs::write(&path, changed).unwrap();
    let again = Command::new("python3")
        .arg("tests/assess/check.py")
        .args([&path, &flight.capture, &flight.site])
        .args([scratch.path("decoded.ndjson"), scratch.path("picture.ndjson")])
        .arg(&flight.truth)
        .output()
        .unwrap();
    assert_eq!(again.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&again.stdout).starts_with("picture.accuracy.horizontal.rms: value"));
}

#[test]
fn second_implementation_agrees_on_real_flights() {
    let Some(shared) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let folder = Path::new(&shared).join("drone-trial/2_1");
    let file = |name: &str| folder.join(name);
    let flight = Flight { capture: file("capture.pcap"), site: file("site.toml"), truth: file("truth.csv") };
    let scratch = Scratch::new();
    for with_truth in [true, false] {
        compare(&scratch, &flight, with_truth);
    }
}
