//! Recordings of receivers through the program: 1090 MHz frames with positions on the ground and GPS stamps, and MAVLink
//! logs.

use std::f64::consts::PI;
use std::path::Path;

use serde_json::Value;

use super::program::{Scratch, utm_fusion};
use super::{decode, shared};

/// Latitude and longitude, in degrees.
type Place = [f64; 2];

/// Position of an aerodrome.
const FIELD: Place = [48.3538, 11.7861];

/// Number of longitude zones at a latitude (ICAO Annex 10 volume III, compact position reporting).
fn zones(latitude_deg: f64) -> f64 {
    let cosine = (PI / 180.0 * latitude_deg).cos();
    let within = 1.0 - (1.0 - (PI / 30.0).cos()) / (cosine * cosine);
    (2.0 * PI / within.acos()).floor()
}

/// Latitude and longitude as encoded in a squitter, 17 bits each; on the ground within a quarter of the Earth.
fn compact([latitude, longitude]: Place, is_odd: bool, on_ground: bool) -> [u64; 2] {
    let (round, odd) = (if on_ground { 90.0 } else { 360.0 }, f64::from(u8::from(is_odd)));
    let steps = |zone: f64, value: f64| (131_072.0 * (value / zone).rem_euclid(1.0) + 0.5).floor();
    let zone = round / (60.0 - odd);
    let y = steps(zone, latitude);
    let sent = zone * (y / 131_072.0 + (latitude / zone).floor());
    [y, steps(round / (zones(sent) - odd).max(1.0), longitude)].map(|count| count as u64 & 0x1_ffff)
}

/// A squitter of an aircraft with these 56 bits, with its parity.
fn squitter(address: u32, message: u64) -> [u8; 14] {
    let mut octets = [0; 14];
    octets[0] = 0x8d;
    octets[1..4].copy_from_slice(&address.to_be_bytes()[1..]);
    octets[4..11].copy_from_slice(&message.to_be_bytes()[1..]);
    let parity = octets[..11].iter().fold(0_u32, |crc, octet| {
        (0..8).fold(crc ^ u32::from(*octet) << 16, |crc, _| {
            (crc << 1 ^ if crc & 0x80_0000 == 0 { 0 } else { 0xff_f409 }) & 0xff_ffff
        })
    });
    octets[11..].copy_from_slice(&parity.to_be_bytes()[1..]);
    octets
}

fn position(place: Place, is_odd: bool, on_ground: bool) -> [u8; 14] {
    let [y, x] = compact(place, is_odd, on_ground);
    // On the ground type 7; in the air type 11 at 1000 ft.
    let kind = if on_ground { 7 << 51 } else { 11 << 51 | 0x0b0 << 36 };
    squitter(0x3c_6444, kind | u64::from(is_odd) << 34 | y << 17 | x)
}

/// A Beast frame.
fn beast(stamp: u64, message: &[u8]) -> Vec<u8> {
    let body = [&stamp.to_be_bytes()[2..], &[0x80], message].concat();
    let escaped = body.iter().flat_map(|octet| std::iter::repeat_n(*octet, 1 + usize::from(*octet == 0x1a)));
    [0x1a, b'3'].into_iter().chain(escaped).collect()
}

/// Alternating even and odd positions, with these stamps.
fn flight(stamps: impl IntoIterator<Item = u64>, on_ground: bool) -> Vec<u8> {
    let frame = |(count, stamp)| beast(stamp, &position(FIELD, count % 2 == 1, on_ground));
    stamps.into_iter().enumerate().flat_map(frame).collect()
}

/// A site with an ADS-B receiver at a place, and the lines `more`.
fn site([latitude, longitude]: Place, more: &str) -> String {
    format!(
        "[site]\nname = \"field\"\nsac = 25\nsic = 1\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n\
         height_amsl_m = 450.0\n[[sensors]]\nkind = \"adsb\"\nid = \"roof\"\nsac = 25\nsic = 21\n{more}"
    )
}

/// Tracks that `replay` makes from a recording, its summary and its exit code.
fn replayed(scratch: &Scratch, site: &str, recording: &Path, options: &[&str]) -> (Vec<Value>, String, i32) {
    let (site, out) = (scratch.file("site.toml", site), scratch.path("out.ndjson"));
    let mut command = utm_fusion("replay");
    command.arg(recording).arg("--config").arg(site).arg("-o").arg(&out).args(options);
    let output = command.output().unwrap();
    let text = std::fs::read_to_string(&out).unwrap_or_default();
    let tracks = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let said = [output.stdout, output.stderr].concat();
    (tracks, String::from_utf8(said).unwrap(), output.status.code().unwrap())
}

/// Stamps of a 12 MHz counter, one each half second.
fn counted(count: u64) -> impl Iterator<Item = u64> {
    (0..count).map(|number| 500_000_000_000 + 6_000_000 * number)
}

/// Stamps of a Radarcape, one each half second from 23:59:55.25 on.
fn over_midnight() -> impl Iterator<Item = u64> {
    (0..20).map(|number: u64| {
        let ns = 250_000_000 + 500_000_000 * number;
        let seconds = (86_395 + ns / 1_000_000_000) % 86_400;
        (seconds << 30) | (ns % 1_000_000_000)
    })
}

/// `run` translates the same octets with the site's place; so does the replay of a recording.
#[test]
fn replay_resolves_surface_positions_near_the_site() {
    let scratch = Scratch::new();
    let recording = scratch.file("field-20250413T120000Z.beast", flight(counted(40), true));
    let (tracks, said, code) = replayed(&scratch, &site([48.0, 11.5], ""), &recording, &[]);
    assert_eq!(code, 0, "{said}");
    assert!(tracks.len() > 20, "{said}");
    for track in &tracks {
        let [latitude, longitude] = ["lat", "lng"].map(|name| track[name].as_f64().unwrap());
        assert!((latitude - FIELD[0]).abs() < 1e-3 && (longitude - FIELD[1]).abs() < 1e-3, "{track}");
    }
    // The nearest of the possible places is used.
    let (tracks, said, _) = replayed(&scratch, &site([48.0, 101.5], ""), &recording, &[]);
    assert!((tracks[0]["lng"].as_f64().unwrap() - FIELD[1] - 90.0).abs() < 1e-3, "{said}");
}

#[test]
fn gps_stamps_are_recognised_and_keep_the_day_over_midnight() {
    let scratch = Scratch::new();
    // The name has the start time of the recorder.
    let recording = scratch.file("rc-20220622T235955Z.beast", flight(over_midnight(), false));
    let times: Vec<String> =
        decode(&recording).iter().map(|record| record["time"].as_str().unwrap().to_owned()).collect();
    assert_eq!(times.len(), 19, "the first one is half a position");
    assert_eq!(
        (times[0].as_str(), times[18].as_str()),
        ("2022-06-22T23:59:55.750Z", "2022-06-23T00:00:04.750Z")
    );
}

#[test]
fn stamps_option_overrides_recognition() {
    let scratch = Scratch::new();
    // Too few frames to recognise the kind of stamps.
    let recording = scratch.file("rc-20220622T235955Z.beast", flight(over_midnight().take(6), false));
    let count = |stamps: &str| {
        let mut command = utm_fusion("decode");
        let output = command.arg(&recording).args(["--stamps", stamps]).output().unwrap();
        String::from_utf8(output.stdout).unwrap().lines().count()
    };
    assert_eq!([count("gps"), count("auto"), count("12mhz")], [5, 0, 0]);
    let (tracks, said, code) = replayed(&scratch, &site(FIELD, ""), &recording, &["--stamps", "gps"]);
    assert_eq!((code, tracks.is_empty()), (0, false), "{said}");
}

/// Folder of a case found in the field.
fn case(name: &str) -> Option<std::path::PathBuf> {
    shared::recordings().map(|data| data.join("field-cases").join(name))
}

#[test]
fn field_case_surface_pairs_are_replayed() {
    let Some(folder) = case("07-pymodes-surface-pairs") else { return };
    let cases = [
        ("lfbo-20250413T120000Z.beast", [43.6, 1.4], Some([43.6265, 1.3747])),
        ("saopaulo-20190812T154423Z.beast", [-23.4, -46.5], None),
    ];
    for (name, place, expected) in cases {
        let scratch = Scratch::new();
        let (tracks, said, code) = replayed(&scratch, &site(place, ""), &folder.join(name), &[]);
        assert_eq!((code, tracks.is_empty()), (0, false), "{said}");
        for (axis, value) in ["lat", "lng"].into_iter().zip(expected.into_iter().flatten()) {
            // The two frames were sent some seconds apart, and alternate.
            assert!((tracks[0][axis].as_f64().unwrap() - value).abs() < 2e-3, "{}", tracks[0]);
        }
    }
}

#[test]
fn field_case_radarcape_has_its_positions_over_midnight() {
    let Some(folder) = case("10-traffic213-radarcape-midnight") else { return };
    let records = decode(&folder.join("rc-20220622T235955Z.beast"));
    // Two alternating frames, of which the first one alone gives no position.
    assert_eq!(records.len(), 19);
    let time = |record: &Value| record["time"].as_str().unwrap().to_owned();
    assert!(time(&records[0]).starts_with("2022-06-22T23:59:55."), "{}", records[0]);
    assert!(time(&records[18]).starts_with("2022-06-23T00:00:04."), "{}", records[18]);
}

#[test]
fn field_case_receiver_ids_and_avr_are_read() {
    let (Some(ids), Some(avr)) = (case("11-readsb-e3"), case("13-mlatclient12-avr")) else { return };
    for (name, positions) in [("e3", 11), ("e4", 11), ("mixed", 13)] {
        let records = decode(&ids.join(format!("{name}-20240916T120618Z.beast")));
        assert_eq!(records.len(), positions, "{name}");
        assert!(records.iter().all(|record| record.get("error").is_none()), "{name}");
    }
    let records = decode(&avr.join("in-20160213T120000Z.avr"));
    assert_eq!(records.len(), 5);
    assert!(records[0]["time"].as_str().unwrap().starts_with("2016-02-13T12:00:"), "{}", records[0]);
}

#[test]
fn field_case_mavlink_log_is_replayed() {
    let Some(folder) = case("mavlink-tlog") else { return };
    let own = "[[sensors]]\nkind = \"transponder\"\nid = \"range\"\nsac = 25\nsic = 23\nconnections = [{ format = \"mavlink\", \
               address = \"127.0.0.1:14550\", systems = [{ system_id = 1, serial_number = \"OWN-1\", country = \"NL\" }] }]\n";
    let log = folder.join("own-drone.tlog");
    let records = decode(&log);
    assert!(records.len() > 100 && records.iter().all(|record| record["cat"] == 129), "{}", records.len());
    let place = &records[0]["items"]["080"];
    let place = ["latitude_deg", "longitude_deg"].map(|axis| place[axis].as_f64().unwrap());
    let scratch = Scratch::new();
    let (tracks, said, code) = replayed(&scratch, &site(place, own), &log, &[]);
    assert_eq!(code, 0, "{said}");
    assert!(tracks.iter().any(|track| track.to_string().contains("OWN-1")), "{said}");
}

/// A record of a MAVLink log with a frame of version 2.
fn logged(time_us: u64, number: u32, seed: u8, contents: &[u8]) -> Vec<u8> {
    let [low, middle, high, _] = number.to_le_bytes();
    let mut frame = vec![0xfd, contents.len() as u8, 0, 0, 0, 9, 1, low, middle, high];
    frame.extend(contents);
    frame.extend(mavlink_core::calculate_crc(&frame[1..], seed).to_le_bytes());
    [&time_us.to_be_bytes()[..], &frame].concat()
}

/// Twenty seconds of a drone with Remote ID by MAVLink, once a second: OPEN_DRONE_ID_BASIC_ID and OPEN_DRONE_ID_LOCATION.
fn remote_id_log(serial: &[u8; 20]) -> Vec<u8> {
    let second = |second: u64| {
        // 2026-11-20T10:00:00Z and later.
        let time_us = (1_795_168_800 + second) * 1_000_000;
        let id = [&[0; 22][..], &[1, 2], serial].concat();
        let place = [480_000_000 + 900 * second as i32, 115_000_000].map(i32::to_le_bytes).concat();
        let metres = [-1000.0_f32, 520.0, -1000.0, second as f32].map(f32::to_le_bytes).concat();
        let motion = [0_u16, 1000, 0].map(u16::to_le_bytes).concat();
        let location = [&place[..], &metres, &motion, &[0; 22], &[2, 0, 10, 4, 0, 3, 1]].concat();
        [logged(time_us, 12_900, 114, &id), logged(time_us + 100_000, 12_901, 254, &location)].concat()
    };
    (0..20).flat_map(second).collect()
}

#[test]
fn whole_serial_number_reaches_a_second_service() {
    let scratch = Scratch::new();
    let log = scratch.file("fleet.tlog", remote_id_log(b"1581F4FKD2291000A4B2"));
    let fleet = "[[sensors]]\nkind = \"remote-id\"\nid = \"fleet\"\nsac = 25\nsic = 22\n\
                 connections = [{ format = \"mavlink\", address = \"127.0.0.1:14550\" }]\n";
    let first = scratch.file("first.toml", site([48.0, 11.5], fleet));
    let published = scratch.path("published.pcap");
    let mut replay = utm_fusion("replay");
    let output = replay.arg(&log).arg("--config").arg(first).arg("-o").arg(&published).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let records: Vec<_> = decode(&published).into_iter().filter(|record| record["cat"] == 129).collect();
    assert!(records.len() > 20, "{}", records.len());
    for record in &records {
        let items = &record["items"];
        assert_eq!(
            (&items["040"], &items["SP"]["uf"]["serial_number"]),
            (&"D2291000A4B2".into(), &"1581F4FKD2291000A4B2".into())
        );
        assert!(items["SP"]["uf"]["track_number"].is_u64());
    }
    let second = "[[sensors]]\nkind = \"transponder\"\nid = \"neighbour\"\nsac = 25\nsic = 1\n";
    // The first site publishes 6.25 s late.
    let second =
        site([48.0, 11.5], second).replacen("sac = 25", "sac = 26", 1) + "[fusion]\nlatency_s = 13.0\n";
    let (tracks, said, code) = replayed(&scratch, &second, &published, &[]);
    assert_eq!((code, tracks.is_empty()), (0, false), "{said}");
    for track in &tracks {
        assert!(track.to_string().contains("\"1581F4FKD2291000A4B2\""), "{track}");
    }
}
