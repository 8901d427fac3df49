//! The captures of the project, and recordings from the folder that `UTM_FUSION_SHARED_DATA` names.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};
use utm_fusion::commands::decode;

use super::info;
use super::shared::{captures, recordings};

fn told(path: &Path) -> Value {
    serde_json::from_str(&info(&[path], true, false).0).unwrap()
}

/// Number of records by category, SAC and SIC, and number of errors.
type Counts = (BTreeMap<(u64, Option<u64>, Option<u64>), u64>, u64);

/// The result of `decode` in the edition of CAT021 that `info` reports.
fn of_decode(path: &Path, told: &Value) -> Counts {
    let mut out = Vec::new();
    let fit = told["editions"].get(0).filter(|fit| fit["or_later"] == false);
    let edition = fit.map(|fit| fit["edition"].as_str().unwrap().parse().unwrap()).into_iter().collect();
    let args = decode::Args { inputs: vec![path.to_owned()], edition, ..decode::Args::default() };
    decode::run(&args, &mut out).unwrap();
    let mut counts = Counts::default();
    for line in out.split(|&octet| octet == b'\n').filter(|line| !line.is_empty()) {
        let line: Value = serde_json::from_slice(line).unwrap();
        if line.get("error").is_some() {
            counts.1 += 1;
        } else if line.get("items").is_some() {
            let key = (line["cat"].as_u64().unwrap(), line["sac"].as_u64(), line["sic"].as_u64());
            *counts.0.entry(key).or_default() += 1;
        }
    }
    counts
}

fn of_info(told: &Value) -> Counts {
    let records = told["sources"].as_array().unwrap().iter().map(|source| {
        let category = source["category"].as_u64().unwrap();
        let key = (category, source["sac"].as_u64(), source["sic"].as_u64());
        (key, source["records"].as_u64().unwrap())
    });
    let errors = told["errors"].as_array().unwrap().iter();
    (records.collect(), errors.map(|error| error["count"].as_u64().unwrap()).sum())
}

fn all_as_decode(folder: &Path, least: usize) {
    let paths = captures(folder);
    assert!(paths.len() >= least, "{paths:?}");
    for path in paths {
        let told = told(&path);
        assert_eq!(of_info(&told), of_decode(&path, &told), "{}", path.display());
    }
}

#[test]
fn the_captures_of_the_project_hold_what_decode_prints() {
    all_as_decode(&Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata"), 5);
}

#[test]
fn recordings_hold_what_decode_prints() {
    let Some(folder) = recordings() else { return };
    all_as_decode(&folder, 11);
}

#[test]
fn a_real_hour() {
    let Some(folder) = recordings() else { return };
    let told = told(&folder.join("cat048-barcelona/capture.ast"));
    let radar = &told["sources"][0];
    assert_eq!((&radar["records"], &radar["sac"], &radar["sic"]), (&json!(44_085), &json!(20), &json!(129)));
    assert_eq!(radar["followed"], json!({"of": "track", "count": 333, "or_more": false}));
    // The antenna turns in 4 s.
    assert!((radar["interval"]["median_s"].as_f64().unwrap() - 4.0).abs() < 0.05, "{radar}");
    assert_eq!((&radar["silences"]["gaps"], &told["errors"]), (&json!(0), &json!([])));
    assert_eq!(told["span"]["duration_s"].as_f64().unwrap().round(), 3599.0);
}

#[test]
fn redundant_lines_of_a_real_network() {
    let Some(folder) = recordings() else { return };
    let told = told(&folder.join("cat048-croatia/capture.pcap"));
    assert_eq!((&told["datagrams"], &told["copies"]), (&json!(100), &json!(50)));
    assert_eq!(told["streams"].as_array().unwrap().len(), 14);
    let lines =
        told["sensors"].as_array().unwrap().iter().map(|sensor| sensor["inputs"].as_array().unwrap().len());
    assert_eq!(lines.collect::<Vec<_>>(), [2; 7]);
}
