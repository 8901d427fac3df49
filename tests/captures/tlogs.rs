//! MAVLink telemetry logs.

use asterix::{blocks, cat129};
use utm_fusion::capture::{CaptureFormat, PayloadKind, SkipReason};

use crate::{open, open_in_steps};

/// Microseconds of 2026-11-20T10:00:00Z.
const START_US: u64 = 1_795_168_800_000_000;

/// The MAVLink checksum (X.25) of these octets and the seed of the message.
fn checksum(octets: &[u8], seed: u8) -> [u8; 2] {
    let crc = octets.iter().chain([&seed]).fold(0xffff_u16, |crc, octet| {
        let octet = octet ^ (crc as u8);
        let octet = octet ^ (octet << 4);
        (crc >> 8) ^ (u16::from(octet) << 8) ^ (u16::from(octet) << 3) ^ (u16::from(octet) >> 4)
    });
    crc.to_le_bytes()
}

/// A frame of MAVLink version 2.
fn frame(system: u8, message: u8, seed: u8, contents: &[u8]) -> Vec<u8> {
    let mut frame = vec![0xfd, contents.len() as u8, 0, 0, 0, system, 1, message, 0, 0];
    frame.extend(contents);
    let checksum = checksum(&frame[1..], seed);
    frame.extend(checksum);
    frame
}

/// GLOBAL_POSITION_INT at 52.5 degrees north; `longitude` is west, in 1e-7 degrees.
fn position(system: u8, longitude: i32) -> Vec<u8> {
    let mut contents = 5000_u32.to_le_bytes().to_vec();
    for value in [525_000_000, -longitude, 150_000, 50_000] {
        contents.extend(value.to_le_bytes());
    }
    contents.extend([0; 6]);
    contents.extend(u16::MAX.to_le_bytes());
    frame(system, 33, 104, &contents)
}

/// Frames of pymavlink: ADSB_VEHICLE, OPEN_DRONE_ID_BASIC_ID and OPEN_DRONE_ID_LOCATION. The tests of `gateways::mavlink` show
/// the calls that created them.
const HEARD: [&str; 3] = [
    "fd2600000009ecf600001d624000e0d0251f900d560260ac1100282370176aff9f00b004004b4c4d31303233000005010234",
    "fd2c00000009ec643200000000000000000000000000000000000000000000000102313538314634464b44323239313030304134423213ca",
    "fd3b00000009ec653200c8d4251f781156020000bf420000f0420000f4410010e144aa69e2046aff0000000000000000000000000000000000000000000002010b04030305f64d",
];

fn octets(digits: &str) -> Vec<u8> {
    (0..digits.len())
        .step_by(2)
        .map(|at| u8::from_str_radix(&digits[at..at + 2], 16).expect("digits"))
        .collect()
}

fn heartbeat(system: u8) -> Vec<u8> {
    frame(system, 0, 50, &[0, 0, 0, 0, 2, 3, 81, 4, 3])
}

fn record(milliseconds: u64, frame: &[u8]) -> Vec<u8> {
    [&(START_US + 1000 * milliseconds).to_be_bytes()[..], frame].concat()
}

/// Ten seconds of a drone and its ground station, once a second.
fn log() -> Vec<Vec<u8>> {
    let second = |second: u64| {
        let at = 1000 * second;
        let position = position(1, 5_880_000 + second as i32);
        [record(at, &heartbeat(255)), record(at, &heartbeat(1)), record(at + 250, &position)].concat()
    };
    (0..10).map(second).collect()
}

#[test]
fn log_gives_a_position_as_cat129_with_the_time_of_the_log() {
    let octets = log().concat();
    for step in [0, 1] {
        let mut capture = open_in_steps(&octets, step).unwrap();
        assert_eq!((capture.format(), capture.is_dated()), (&CaptureFormat::Tlog, true));
        let datagrams: Vec<_> = capture.by_ref().map(Result::unwrap).collect();
        assert_eq!(datagrams.len(), 10);
        assert_eq!(capture.skipped().count(SkipReason::NotPosition), 20);
        let last = datagrams.last().unwrap();
        assert_eq!(last.contents, PayloadKind::Translated);
        assert_eq!(last.received.unwrap().to_string(), "2026-11-20T10:00:09.250Z");
        assert!(octets[last.origin as usize..].starts_with(&(START_US + 9_250_000).to_be_bytes()));
        let block = blocks(&last.payload).next().unwrap().unwrap();
        let record = block.records::<cat129::Record>().next().unwrap().unwrap().record;
        assert_eq!(record.serial_number, Some(*b"SYSTEM-1    "));
        assert!((record.position.unwrap().latitude_deg() - 52.5).abs() < 1e-6);
    }
}

#[test]
fn log_goes_on_behind_damage() {
    let mut seconds = log();
    // The length of a position's frame, and therefore its checksum, is wrong.
    let length = seconds[4].len();
    seconds[4][length - 39] ^= 0x40;
    let octets = seconds.concat();
    let mut capture = open(&octets).unwrap();
    let datagrams: Vec<_> = capture.by_ref().map(Result::unwrap).collect();
    let positions = datagrams.iter().filter(|datagram| datagram.contents == PayloadKind::Translated);
    assert_eq!(positions.count(), 9);
    let lost = capture.gaps().octets + capture.skipped().count(SkipReason::Checksum);
    assert!(lost > 0, "the damage is counted");
}

#[test]
fn log_gives_aircraft_and_remote_id_that_were_heard() {
    let heard: Vec<u8> = HEARD.iter().zip(0..).flat_map(|(frame, at)| record(at, &octets(frame))).collect();
    let log = [log().concat(), heard].concat();
    let mut capture = open(&log).unwrap();
    let datagrams: Vec<_> = capture.by_ref().map(Result::unwrap).collect();
    let [vehicle, id, location] = &datagrams[10..] else { panic!("{}", datagrams.len()) };
    assert_eq!((vehicle.payload[0], vehicle.contents), (21, PayloadKind::Translated));
    for line in [id, location] {
        let text = std::str::from_utf8(&line.payload).unwrap();
        assert!(text.contains("\"transmitter\":\"mavlink-9-236\"") && !text.contains("receiver"), "{text}");
        assert!(text.contains("\"time\":\"2026-11-20T10:00:00.00"), "{text}");
    }
}
