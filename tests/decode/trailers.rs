//! Octets that a sender appends to the blocks of each datagram.

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;
use utm_fusion::capture::Capture;

use super::lossless::there_and_back;
use super::{Temporary, block, pcap};

/// A datagram of a radar: two records, then a counter and a time; the counter may resemble a block.
fn datagram(count: u32) -> Vec<u8> {
    let counter = if count == 7 { [48, 0, 8, 0x80] } else { count.to_be_bytes() };
    [&block(48, &["80 1907", "80 1908"])[..], &counter, &(1_000_000 * count).to_be_bytes()].concat()
}

fn run(args: &[&str], file: &Temporary) -> (Output, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_utm-fusion")).args(args).arg(&file.0).output().unwrap();
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    (output, text)
}

#[test]
fn a_trailer_of_constant_length_is_told_once_and_kept() {
    let datagrams: Vec<_> = (0..50).map(datagram).collect();
    let (capture, origins) =
        pcap(&datagrams.iter().map(|payload| (0, payload.as_slice())).collect::<Vec<_>>());
    let file = Temporary::new("trailer", &capture);
    let (output, text) = run(&["decode", "--strict"], &file);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{told}");
    let words =
        "a trailer of 8 octets follows the blocks of each datagram from 10.0.0.1 to 239.192.48.1:8048\n";
    assert!(told.ends_with(words) && told.lines().count() == 1, "{told}");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3 * 50);
    assert!(lines.iter().all(|line| line.get("error").is_none()));
    let at = origins[1] + 9;
    let second = format!(r#"{{"trailer":8,"offset":{at},"block":{at},"hex":"00000001000f4240"}}"#);
    assert_eq!(text.lines().nth(5).unwrap(), second);
    // All octets are present.
    assert!(there_and_back(&file.0) == datagrams.concat());

    let (output, text) = run(&["info", "--strict"], &file);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains(&format!("trailer    {}: 50 datagrams\n", words.trim_end())), "{text}");
    assert!(text.contains("\nno errors\n"), "{text}");
    let (_, text) = run(&["info", "--json"], &file);
    let info: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(info["trailers"][0]["octets"], 8);
    assert_eq!((&info["octets"], &info["errors"]), (&(17 * 50).into(), &Value::Array(Vec::new())));
}

/// A FINAL recording, which does not state the sender, is supported, too. Three datagrams are too few.
#[test]
fn a_recording_has_trailers_too_and_few_datagrams_have_faults() {
    let record = |payload: Vec<u8>| {
        let length = (payload.len() as u16 + 12).to_be_bytes();
        [&length[..], &[0, 0, 0, 0x41, 0xEB, 0], &payload, &[0xA5; 4]].concat()
    };
    for (count, code, lines) in [(3, 4, 9), (4, 0, 12), (20, 0, 60)] {
        let recording: Vec<u8> = (0..count).flat_map(|count| record(datagram(count))).collect();
        let (output, text) = run(&["decode"], &Temporary::new("final", &recording));
        assert_eq!((output.status.code(), text.lines().count()), (Some(code), lines));
        assert_eq!(text.contains("error"), code == 4, "{text}");
    }
}

/// Datagrams of other senders between them have no influence, and truncated octets remain a fault.
#[test]
fn datagrams_come_in_their_order_and_cut_blocks_are_faults() {
    let cut = |count: u32| [&block(48, &["80 1907"])[..], &[48, 0, 7, 0x80, count as u8]].concat();
    let datagrams: Vec<_> = (0..40).map(cut).collect();
    let (capture, _) = pcap(&datagrams.iter().map(|payload| (0, payload.as_slice())).collect::<Vec<_>>());
    let file = Temporary::new("cut", &capture);
    let (output, text) = run(&["decode", "--strict"], &file);
    assert_eq!((output.status.code(), text.lines().count()), (Some(4), 80));
    assert_eq!(text.matches("block_past_end").count(), 40);
    // Two streams, of which the second has no trailers.
    let mixed: Vec<_> =
        (0..60).map(|count| if count % 3 == 0 { datagram(count) } else { block(48, &["80 1907"]) }).collect();
    let (mut capture, origins) =
        pcap(&mixed.iter().map(|payload| (0, payload.as_slice())).collect::<Vec<_>>());
    for origin in origins.iter().skip(1).step_by(3).chain(origins.iter().skip(2).step_by(3)) {
        capture[origin - 13] = 2; // from 10.0.0.2
    }
    let file = Temporary::new("mixed", &capture);
    fs::write(&file.0, &capture).unwrap();
    let read: Vec<_> = Capture::open(&file.0).unwrap().map(Result::unwrap).collect();
    assert!(read.iter().map(|datagram| datagram.origin as usize).eq(origins));
    assert!(
        read.iter()
            .zip(0..)
            .all(|(datagram, place)| datagram.trailer.len() == if place % 3 == 0 { 8 } else { 0 })
    );
}
