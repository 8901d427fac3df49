//! The recordings of the project, where `UTM_FUSION_SHARED_DATA` says they are.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use serde_json::Value;
use utm_fusion::commands::decode;

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA");
    if folder.is_none() {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    }
    folder.map(PathBuf::from)
}

/// The captures in a folder and below.
fn captures(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            captures(&path, found);
        } else if path.extension().is_some_and(|end| ["pcap", "ast", "raw", "bin"].iter().any(|e| end == *e))
        {
            found.push(path);
        }
    }
}

fn decoded(path: &Path) -> Vec<Value> {
    let args = decode::Args { inputs: vec![path.to_owned()], ..decode::Args::default() };
    let mut out = Vec::new();
    decode::run(&args, &mut out).unwrap();
    out.split(|&octet| octet == b'\n')
        .filter(|line| !line.is_empty())
        .map(|line| serde_json::from_slice(line).unwrap())
        .collect()
}

/// Lines by category, errors apart.
fn count(lines: &[Value]) -> (BTreeMap<u64, usize>, usize) {
    let mut records = BTreeMap::new();
    let mut errors = 0;
    for line in lines {
        if line.get("error").is_some() {
            errors += 1;
        } else {
            *records.entry(line["cat"].as_u64().unwrap()).or_default() += 1;
        }
    }
    (records, errors)
}

#[test]
fn every_recording_decodes() {
    let Some(folder) = folder() else { return };
    let mut paths = Vec::new();
    captures(&folder, &mut paths);
    assert!(paths.len() > 10, "{paths:?}");
    for path in paths {
        let (records, errors) = count(&decoded(&path));
        println!("{}: {records:?}, {errors} errors", path.display());
        let is_hostile = path.to_string_lossy().contains("hostile");
        assert_eq!(errors > 0, is_hostile, "{}", path.display());
    }
    let (records, _) = count(&decoded(&folder.join("cat048-barcelona/capture.ast")));
    assert_eq!(records, BTreeMap::from([(48, 44_085)]));
    let (records, _) = count(&decoded(&folder.join("cat048-croatia/capture.pcap")));
    assert_eq!(records[&48], 128);
}

/// A number of the other decoder is what was printed: to half of our last decimal.
fn is_near(printed: &Value, theirs: f64, decimals: i32) -> bool {
    printed.as_f64().is_some_and(|ours| (ours - theirs).abs() <= 0.500_001 * 10_f64.powi(-decimals))
}

/// The parts of an extended item, its first octet.
fn same_bits(ours: &Value, theirs: &Value) -> bool {
    let theirs = theirs["_groups"][0].as_object().unwrap();
    theirs.iter().all(|(name, value)| ours[name.to_lowercase()] == *value) && theirs.len() == 5
}

/// Whether an item says the same; `true` for the items that the codec does not type.
fn agrees(item: &str, ours: &Value, theirs: &Value) -> bool {
    const NAUTICAL_MILE_M: f64 = 1852.0;
    let number = |name: &str| theirs[name].as_f64().unwrap();
    match item {
        "010" => ours["sac"] == theirs["SAC"] && ours["sic"] == theirs["SIC"],
        "140" => ours == theirs,
        "020" | "170" => same_bits(ours, theirs),
        "040" => {
            is_near(&ours["rho_m"], number("RHO") * NAUTICAL_MILE_M, 1)
                && is_near(&ours["theta_deg"], number("THETA"), 3)
        }
        "070" => {
            ["v", "g", "l"].iter().all(|bit| ours[*bit] == theirs[bit.to_uppercase()])
                && ours["mode_3a"] == theirs["MODE3A"]
        }
        "090" => {
            ["v", "g"].iter().all(|bit| ours[*bit] == theirs[bit.to_uppercase()])
                && ours["flight_level"] == theirs["FL"]
        }
        "161" => ours["track_number"] == theirs["TRN"],
        "200" => {
            is_near(&ours["speed_m_s"], number("GSP") * NAUTICAL_MILE_M, 2)
                && is_near(&ours["heading_deg"], number("HDG"), 3)
        }
        "220" => u64::from_str_radix(ours.as_str().unwrap(), 16).ok() == theirs.as_u64(),
        "240" => ours == theirs,
        _ => ours.is_string() || item == "030",
    }
}

#[test]
fn another_decoder_says_the_same_of_a_real_hour() {
    let Some(folder) = folder() else { return };
    let folder = folder.join("cat048-barcelona");
    let lines = decoded(&folder.join("capture.ast"));
    let packed = fs::read(folder.join("decoded.ndjson.gz")).unwrap();
    let theirs = BufReader::new(GzDecoder::new(packed.as_slice()));
    let mut compared = 0;
    for (ours, theirs) in lines.iter().zip(theirs.lines()) {
        let theirs: Value = serde_json::from_str(&theirs.unwrap()).unwrap();
        let (items, their_items) = (ours["items"].as_object().unwrap(), theirs["items"].as_object().unwrap());
        assert_eq!(ours["block"], theirs["off"]);
        assert!(items.keys().eq(their_items.keys()), "{ours} {theirs}");
        for ((item, ours), theirs) in items.iter().zip(their_items.values()) {
            assert!(agrees(item, ours, theirs), "{item}: {ours} {theirs}");
        }
        compared += 1;
    }
    assert_eq!((lines.len(), compared), (44_085, 44_085));
}
