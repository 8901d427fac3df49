//! The recordings of the project, from the folder that `UTM_FUSION_SHARED_DATA` names.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;

use flate2::read::GzDecoder;
use serde_json::Value;
use utm_fusion::capture::Capture;
use utm_fusion::commands::decode;

use super::lossless::there_and_back;
use super::shared::{captures, recordings};

fn decoded(path: &Path) -> Vec<Value> {
    let args = decode::Args { inputs: vec![path.to_owned()], ..decode::Args::default() };
    let mut out = Vec::new();
    decode::run(&args, &mut out).unwrap();
    out.split(|&octet| octet == b'\n')
        .filter(|line| !line.is_empty())
        .map(|line| serde_json::from_slice(line).unwrap())
        .collect()
}

/// Number of lines by category, and number of errors.
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
    let Some(folder) = recordings() else { return };
    let paths = captures(&folder);
    assert!(paths.len() > 10, "{paths:?}");
    for path in paths {
        let (records, errors) = count(&decoded(&path));
        println!("{}: {records:?}, {errors} errors", path.display());
        // The first is hostile on purpose. The second is older than any edition. The third is in edition 2.1 and read in another
        // one. The last has CAT032, which is not defined.
        let has_errors = ["hostile", "croatia_cat062_100datagrams", "cat021-barcelona", "goasterix_sample"]
            .map(|name| path.to_string_lossy().contains(name));
        assert_eq!(errors > 0, has_errors.contains(&true), "{}", path.display());
    }
    let (records, _) = count(&decoded(&folder.join("cat048-barcelona/capture.ast")));
    assert_eq!(records, BTreeMap::from([(48, 44_085)]));
    let (records, _) = count(&decoded(&folder.join("cat048-croatia/capture.pcap")));
    assert_eq!(records[&48], 128);
}

/// Whether the printed number equals that of the other decoder, to half of our last decimal.
fn is_near(printed: &Value, theirs: f64, decimals: i32) -> bool {
    printed.as_f64().is_some_and(|ours| (ours - theirs).abs() <= 0.500_001 * 10_f64.powi(-decimals))
}

/// Whether the fields of an item agree; the other decoder's units are NM, NM/s and degrees.
///
/// `fields`: our name, theirs, the factor to our unit, our decimals.
fn same(ours: &Value, theirs: &Value, fields: &[(&str, &str, f64, i32)]) -> bool {
    let known = |name: &&String| fields.iter().any(|(_, theirs, ..)| theirs == name);
    let theirs = theirs.as_object().unwrap();
    theirs.keys().all(|name| known(&name))
        && ours.as_object().unwrap().len() == theirs.len()
        && fields.iter().filter(|(_, name, ..)| theirs.contains_key(*name)).all(
            |(ours_name, name, factor, decimals)| {
                let (ours, theirs) = (&ours[*ours_name], &theirs[*name]);
                match theirs {
                    Value::String(_) => ours == theirs,
                    _ => is_near(ours, theirs.as_f64().unwrap() * factor, *decimals),
                }
            },
        )
}

/// Whether integers of the same name agree; our names are in lower case.
fn same_codes(ours: &Value, theirs: &Value) -> bool {
    let theirs = theirs.as_object().unwrap();
    ours.as_object().unwrap().len() == theirs.len()
        && theirs.iter().all(|(name, value)| ours[name.to_lowercase()] == *value)
}

/// Whether an item agrees.
fn agrees(item: &str, ours: &Value, theirs: &Value) -> bool {
    const NM: f64 = 1852.0;
    match item {
        "010" => same_codes(ours, theirs),
        "140" | "240" | "030" => ours == theirs,
        "020" | "170" => {
            let groups = theirs["_groups"].as_array().unwrap();
            let all: serde_json::Map<_, _> =
                groups.iter().flat_map(|group| group.as_object().unwrap().clone()).collect();
            same_codes(ours, &Value::Object(all))
        }
        "040" => same(ours, theirs, &[("rho_m", "RHO", NM, 1), ("theta_deg", "THETA", 1.0, 3)]),
        "042" => same(ours, theirs, &[("x_m", "X", NM, 1), ("y_m", "Y", NM, 1)]),
        "070" => same(
            ours,
            theirs,
            &[("v", "V", 1.0, 0), ("g", "G", 1.0, 0), ("l", "L", 1.0, 0), ("mode_3a", "MODE3A", 1.0, 0)],
        ),
        "080" => {
            // The other decoder's pulses from A4 to D1 are the bits of our number.
            let pulses = theirs.as_object().unwrap().values();
            let bits = pulses.fold(0, |bits, pulse| bits << 1 | pulse.as_u64().unwrap());
            ours["low_quality"] == format!("{bits:04o}")
        }
        "090" => {
            same(ours, theirs, &[("v", "V", 1.0, 0), ("g", "G", 1.0, 0), ("flight_level", "FL", 1.0, 2)])
        }
        "130" => same(
            ours,
            theirs,
            &[
                ("srl_deg", "SRL", 1.0, 2),
                ("srr", "SRR", 1.0, 0),
                ("sam_dbm", "SAM", 1.0, 0),
                ("prl_deg", "PRL", 1.0, 2),
                ("pam_dbm", "PAM", 1.0, 0),
                ("rpd_m", "RPD", NM, 1),
                ("apd_deg", "APD", 1.0, 3),
            ],
        ),
        "161" => ours["track_number"] == theirs["TRN"],
        "200" => same(ours, theirs, &[("speed_m_s", "GSP", NM, 2), ("heading_deg", "HDG", 1.0, 3)]),
        "220" => u64::from_str_radix(ours.as_str().unwrap(), 16).ok() == theirs.as_u64(),
        "230" => same_codes(ours, theirs),
        "250" => {
            let (ours, theirs) = (ours.as_array().unwrap(), theirs.as_array().unwrap());
            ours.len() == theirs.len()
                && ours.iter().zip(theirs).all(|(ours, theirs)| {
                    u64::from_str_radix(ours["data"].as_str().unwrap(), 16).ok() == theirs["MBDATA"].as_u64()
                        && (&ours["bds1"], &ours["bds2"]) == (&theirs["BDS1"], &theirs["BDS2"])
                })
        }
        _ => panic!("I048/{item} is not compared: {ours} {theirs}"),
    }
}

/// The data blocks of a capture, unchanged.
fn payloads(path: &Path) -> Vec<u8> {
    Capture::open(path).unwrap().flat_map(|datagram| datagram.unwrap().payload).collect()
}

#[test]
fn every_recording_comes_back() {
    let Some(folder) = recordings() else { return };
    let paths = captures(&folder);
    for path in paths {
        assert!(there_and_back(&path) == payloads(&path), "{}", path.display());
    }
    let hour = folder.join("cat048-barcelona/capture.ast");
    assert!(there_and_back(&hour) == fs::read(&hour).unwrap());
}

#[test]
fn another_decoder_says_the_same_of_a_real_hour() {
    let Some(folder) = recordings() else { return };
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
