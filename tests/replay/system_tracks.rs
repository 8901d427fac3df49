//! CAT062 files contain the same picture as every other format.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use asterix::{blocks, cat062};
use serde_json::Value;

use super::common::{Flight, Scratch, bundled, datagrams, demo, ran, three_radars};

/// Output of `replay … --output-format FORMAT`.
fn written(flight: &Flight, profile: &str, format: &str) -> Vec<u8> {
    let mut replay = flight.replay(&[&flight.capture()]);
    let ran = ran(replay.args(["--profile", profile, "-o", "-", "--output-format", format]));
    assert_eq!(ran.code, 0, "{}: {}", flight.name, ran.stderr);
    ran.stdout
}

fn records(octets: &[u8]) -> Vec<cat062::Record> {
    let blocks = blocks(octets).map(Result::unwrap);
    blocks
        .flat_map(|block| block.records::<cat062::Record>().map(|located| located.unwrap().record))
        .collect()
}

#[test]
fn cat062_file_has_every_point_and_an_end_of_each_track() {
    for flight in bundled().into_iter().chain([three_radars()]) {
        for profile in ["reference", "operational"] {
            let records = records(&written(&flight, profile, "cat062"));
            let json = String::from_utf8(written(&flight, profile, "ndjson")).unwrap();
            let mut lines = json.lines();
            // Ids of the current tracks, by number.
            let mut alive: BTreeMap<u16, String> = BTreeMap::new();
            let mut seconds: BTreeSet<(u32, u16)> = BTreeSet::new();
            for record in &records {
                let (status, track_number) =
                    (record.track_status.unwrap(), record.track_number.unwrap().number());
                if status.is_last() {
                    assert!(alive.remove(&track_number).is_some() && record.position.is_none());
                    continue;
                }
                let line = lines.next().unwrap();
                let track: Value = serde_json::from_str(line).unwrap();
                let number = |key: &str| track[key].as_f64();
                let time: jiff::Timestamp = track["time"].as_str().unwrap().parse().unwrap();
                let count = (time.as_millisecond() % 86_400_000 * 128 / 1000) as u32;
                assert_eq!(record.time_of_day.unwrap().count(), count, "{line}");
                assert!(seconds.insert((count, track_number)), "twice in a picture: {line}");
                let id = track["id"].as_str().unwrap().to_owned();
                let before = alive.insert(track_number, id.clone());
                assert_eq!(before, (!status.is_first()).then_some(id), "{line}");

                let position = record.position.unwrap();
                assert!((position.latitude_deg() - number("lat").unwrap()).abs() < 2.8e-6, "{line}");
                assert!((position.longitude_deg() - number("lng").unwrap()).abs() < 2.8e-6, "{line}");
                let height = record.geometric_altitude.map(cat062::GeometricHeight::height_m);
                assert_eq!(height.is_some(), number("alt").is_some(), "{line}");
                let off = |said: Option<f64>, key: &str| {
                    said.zip(number(key)).map_or(0.0, |(said, known)| (said - known).abs())
                };
                assert!(off(height, "alt") < 0.96, "{line}");
                let velocity = record.velocity;
                assert_eq!(velocity.is_some(), profile == "operational", "{line}");
                let speed = velocity.map(|velocity| velocity.east_m_s().hypot(velocity.north_m_s()));
                assert!(off(speed, "speed") < 0.25, "{line}");
                assert_eq!(status.is_monosensor(), track["source"] != "fused", "{line}");
            }
            assert_eq!(lines.next(), None);
        }
    }
}

#[test]
fn cat062_is_sent_with_cat129() {
    let flight = demo();
    let scratch = Scratch::new();
    let [system, usual] = ["cat062-pcap", "pcap"]
        .map(|format| datagrams(&scratch.file(format, written(&flight, "operational", format))));
    let payloads: Vec<u8> = system.iter().flat_map(|datagram| datagram.payload.clone()).collect();
    assert!(payloads == written(&flight, "operational", "cat062"));
    let times = |datagrams: &[utm_fusion::capture::CapturedDatagram]| -> BTreeSet<_> {
        datagrams.iter().map(|datagram| datagram.received.unwrap().nanos()).collect()
    };
    assert!(system.iter().all(|datagram| datagram.payload.len() <= 1400));
    // Only end-of-track messages are sent in slots without tracks.
    assert!(times(&usual).is_subset(&times(&system)));
}

/// A CAT062 destination does not change the output to other destinations, with either profile.
#[test]
fn cat129_is_the_same_with_other_receivers() {
    let flight = three_radars();
    let scratch = Scratch::new();
    let site = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap();
    let output = "[output]\nasterix = [{ address = \"127.0.0.1\", port = 8131, category = 62 }, \
                  { address = \"127.0.0.1\", port = 8130 }]\n";
    assert!(!site.contains("[output]"), "{site}");
    let both = scratch.file("both.toml", site.clone() + output);
    let one = scratch.file("one.toml", site + &output.replace(", category = 62", "").replace("8131", "8130"));
    for profile in ["reference", "operational"] {
        for format in ["asterix", "pcap"] {
            let [both, one] = [&both, &one].map(|site| {
                let mut replay = super::common::utm_fusion("replay");
                replay.arg(flight.capture()).arg("--config").arg(site);
                let ran = ran(replay.args(["--profile", profile, "-o", "-", "--output-format", format]));
                assert_eq!(ran.code, 0, "{}", ran.stderr);
                ran.stdout
            });
            assert!(one.len() > 10_000 && both == one, "{profile} {format}");
        }
    }
}
