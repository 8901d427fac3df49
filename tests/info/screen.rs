//! The output for people, and the same for programs.

use std::path::Path;

use serde_json::json;
use utm_fusion::commands::Outcome;
use utm_fusion::config::Config;

use super::{Temporary, arp, block, fix, info, json, octets, pcap, plot};

/// Midnight before 2026-06-21, in seconds since the epoch.
const MIDNIGHT: f64 = 1_782_000_000.0;

/// Two tracks of a radar every 4 s with a pause, a transponder, and other data.
fn mixed() -> Vec<u8> {
    let mut datagrams = Vec::new();
    for scan in (0..10).chain(16..20) {
        let time_s = 86_380.0 + f64::from(scan) * 4.0;
        let time_of_day = time_s % 86_400.0;
        let records = [plot(7, time_of_day, 1), plot(7, time_of_day + 0.25, 2)];
        datagrams.push((MIDNIGHT - 86_400.0 + time_s + 0.5, 8048, block(48, &records)));
    }
    for report in 0..3 {
        let payload = block(129, &[fix(86_381.0 + f64::from(report) * 2.0, 1)]);
        datagrams.push((MIDNIGHT - 18.0 + f64::from(report) * 2.0, 8129, payload));
    }
    datagrams.push((MIDNIGHT + 1.0, 8048, block(200, &["0102".to_owned()])));
    datagrams.push((MIDNIGHT + 1.0, 8048, octets("30 0002")));
    datagrams.sort_by(|a, b| a.0.total_cmp(&b.0));
    datagrams.insert(1, datagrams[0].clone());
    [pcap(&datagrams), arp()].concat()
}

#[test]
fn one_screen() {
    let file = Temporary::new("screen.pcap", &mixed());
    let (text, outcome) = info(&[&file.0], false, false);
    let (name, text) = text.split_once('\n').unwrap();
    assert_eq!((Path::new(name), outcome), (file.0.as_path(), Outcome::Done));
    assert_eq!(text.replace(name, "screen.pcap"), include_str!("screen.txt"));
}

#[test]
fn the_same_for_machines() {
    let file = mixed();
    let info = json("screen.json", &file);
    let bad = file.windows(3).position(|octets| octets == [0x30, 0, 2]).unwrap();
    assert_eq!(info["format"], "pcap (Ethernet, microseconds)");
    assert_eq!(
        (&info["datagrams"], &info["copies"], &info["skipped"]),
        (&json!(20), &json!(1), &json!({"not IP": 1}))
    );
    assert_eq!(
        info["span"],
        json!({
            "of": "reception", "first": "2026-06-20T23:59:40.500Z", "last": "2026-06-21T00:00:56.500Z",
            "duration_s": 76.0, "steps_back": 0,
        })
    );
    let radar = &info["sources"][0];
    assert_eq!((&radar["category"], &radar["sac"], &radar["sic"]), (&json!(48), &json!(25), &json!(7)));
    assert_eq!(radar["followed"], json!({"of": "track", "count": 2, "or_more": false}));
    assert_eq!(radar["interval"], json!({"of": "track", "median_s": 4.0}));
    assert_eq!(
        radar["silences"],
        json!({"gap_above_s": 20.0, "gaps": 1, "longest_s": 28.0, "longest_from": "2026-06-21T00:00:16.500Z"})
    );
    assert_eq!(radar["delay"], json!({"min_s": 0.25, "median_s": 0.25, "p99_s": 0.5, "max_s": 0.5}));
    assert_eq!(radar["items"], json!({"010": 30, "140": 30, "161": 30}));
    assert_eq!(
        info["errors"],
        json!([{
            "kind": "block_too_short", "category": 48, "count": 1, "first_offset": bad, "first_item": null,
            "detail": "the block's LEN is below 3, the size of its own header",
        }])
    );
    assert_eq!(info["categories"][2]["records"], json!(null));
    assert_eq!(info["damage"], json!(null));
}

#[test]
fn its_sensors_make_a_configuration() {
    for capture in ["demo", "three-radars"] {
        let capture =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata").join(capture).join("capture.pcap");
        let (text, _) = info(&[&capture], false, false);
        let (_, hint) = text.split_once("sensors of a configuration").unwrap();
        let mut sensors = String::new();
        for (number, line) in hint.lines().skip(1).enumerate() {
            let place = "latitude_deg = 53.0, longitude_deg = 10.0, height_amsl_m = 70.0, ";
            let entry = match line.split_once("  ") {
                Some(("radar", keys)) => {
                    format!("}},\n{{ id = \"s{number}\", kind = \"radar\", {place}{keys}")
                }
                Some(("transponder", keys)) => {
                    format!("}},\n{{ id = \"s{number}\", kind = \"transponder\", {keys}")
                }
                _ if line.starts_with("`utm-fusion locate ") => continue,
                _ => line.to_owned(),
            };
            sensors += &entry;
        }
        let sensors = sensors.trim_start_matches("},\n");
        let site = format!(
            "sensors = [\n{sensors} }}\n]\n[site]\nname = \"s\"\nsac = 1\nsic = 1\n[fusion]\nprofile = \"reference\"\n"
        );
        let file = Temporary::new("site.toml", site.as_bytes());
        let config = Config::load(&file.0).unwrap_or_else(|errors| panic!("{errors}\n{site}"));
        assert!(config.sensors.len() >= 2 && config.sensors.iter().all(|sensor| sensor.inputs.len() == 1));
    }
}
