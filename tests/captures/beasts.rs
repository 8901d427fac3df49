//! Recordings of a 1090 MHz receiver as files.

use std::io::{Cursor, Read};

use utm_fusion::capture::{Capture, CaptureFormat, OpenError, PayloadKind, SkipReason};

use crate::Trickle;

/// Start and number of the octets outside of any frame.
fn unframed(reader: Box<dyn Read + Send>) -> Vec<(u64, usize)> {
    let capture =
        Capture::from_reader("x.beast".to_owned(), reader, None).expect("it begins with four frames");
    let datagrams = capture.map(Result::unwrap).filter(|datagram| datagram.contents == PayloadKind::Unframed);
    datagrams.map(|datagram| (datagram.origin, datagram.payload.len())).collect()
}

#[test]
fn octets_between_frames_split_anywhere_are_the_same() {
    let frame = |stamp| [0x1a, b'1', 0, 0, 0, 0, 0, stamp, 0x80, 1, 2];
    let mut octets: Vec<u8> = (1..=4).flat_map(frame).collect();
    octets.extend([7; 5000]);
    octets.extend(frame(5));
    // The first of two escapes belongs to no frame.
    octets.push(0x1a);
    octets.extend(frame(6));
    octets.extend([7; 10]);
    let pieces = vec![(44, 4096), (4140, 904), (5055, 1), (5067, 10)];
    assert_eq!(unframed(Box::new(Cursor::new(octets.clone()))), pieces);
    let in_parts = Trickle { octets: Cursor::new(octets), step: 1, calls: 0 };
    assert_eq!(unframed(Box::new(in_parts)), pieces);
}

fn open(name: &str, octets: &[u8]) -> Result<Capture, OpenError> {
    Capture::from_reader(name.to_owned(), Box::new(Cursor::new(octets.to_vec())), None)
}

#[test]
fn receiver_ids_are_skipped_and_counted() {
    let frame = |stamp| [0x1a, b'1', 0, 0, 0, 0, 0, stamp, 0x80, 1, 2];
    let id = [0x1a, 0xe3, 42, 208, 62, 0x1a, 0x1a, 98, 67, 150, 9];
    let uuid = [&[0x1a, 0xe4], &b"38366a5c-c54f-4256-bd0a-1557961f5ad0"[..]].concat();
    let each: Vec<u8> = (1..=6).flat_map(|stamp| [id, frame(stamp)].concat()).collect();
    let once = [uuid, (1..=6).flat_map(frame).collect()].concat();
    for (octets, ids) in [(each, 6), (once, 1)] {
        let mut capture = open("x.beast", &octets).unwrap();
        assert_eq!(capture.format(), &CaptureFormat::Beast);
        assert!(capture.by_ref().next().is_none(), "no octet belongs to no frame");
        let count = |reason| capture.skipped().count(reason);
        assert_eq!(
            [SkipReason::ReceiverId, SkipReason::NotAdsb, SkipReason::Malformed].map(count),
            [ids, 6, 0]
        );
    }
}

/// An even and an odd position message of one aircraft, from the Mode S book (mode-s.org/1090mhz).
const PAIR: [&str; 2] = ["8D40621D58C382D690C8AC2863A7", "8D40621D58C386435CC412692AD6"];

/// Lines of AVR, one every five seconds of a 12 MHz counter.
fn avr(mark: char, count: u64) -> String {
    let line = |number: u64| {
        let stamp = if mark == '*' { String::new() } else { format!("{:012X}", 60_000_000 * (number + 1)) };
        let level = if mark == '<' { "80" } else { "" };
        format!("{mark}{stamp}{level}{};\r\n", PAIR[number as usize % 2])
    };
    (0..count).map(line).collect()
}

#[test]
fn avr_lines_with_stamps_are_read_from_a_file() {
    for mark in ['@', '<'] {
        let text = avr(mark, 6);
        let mut capture = open("in-20160213T120000Z.avr", text.as_bytes()).unwrap();
        assert_eq!((capture.format(), capture.is_dated()), (&CaptureFormat::Avr, true));
        let positions: Vec<_> = capture.by_ref().map(Result::unwrap).collect();
        let times: Vec<_> = positions.iter().map(|position| position.received.unwrap().to_string()).collect();
        assert_eq!(times.len(), 5, "the first one is half a position");
        assert_eq!(
            (times[0].as_str(), times[4].as_str()),
            ("2016-02-13T12:00:05.000Z", "2016-02-13T12:00:25.000Z")
        );
        assert!(positions.iter().all(|position| text.as_bytes()[position.origin as usize] == mark as u8));
    }
    let text = avr('@', 6);
    let in_parts = Trickle { octets: Cursor::new(text.into_bytes()), step: 1, calls: 0 };
    let capture = Capture::from_reader("in.avr".to_owned(), Box::new(in_parts), None).unwrap();
    assert_eq!(capture.map(Result::unwrap).filter(|position| position.since_midnight.is_some()).count(), 5);
}

#[test]
fn avr_damage_is_counted_at_its_place() {
    let mut text = avr('@', 4);
    let noise_at = text.len() as u64;
    text += "noise";
    text += &avr('@', 6).lines().skip(4).map(|line| format!("{line}\n")).collect::<String>();
    // A line interrupted by another one.
    text += "@0000";
    text += &avr('@', 7).lines().skip(6).collect::<String>();
    let mut capture = open("in.avr", text.as_bytes()).unwrap();
    let all: Vec<_> = capture.by_ref().map(Result::unwrap).collect();
    let (gaps, positions): (Vec<_>, Vec<_>) =
        all.iter().partition(|datagram| datagram.contents == PayloadKind::Unframed);
    assert_eq!((gaps.len(), gaps[0].origin, gaps[0].payload.as_slice()), (1, noise_at, &b"noise"[..]));
    assert_eq!(positions.len(), 6);
    assert!(text.as_bytes()[positions[5].origin as usize..].starts_with(b"@0000"));
    assert_eq!(positions[5].origin as usize, text.len() - 42);
    assert_eq!(capture.skipped().count(SkipReason::Truncated), 1);
}

#[test]
fn avr_without_stamps_is_refused_with_advice() {
    let error = open("in.avr", avr('*', 6).as_bytes()).unwrap_err().to_string();
    assert!(error.contains("AVR without time stamps") && error.contains("lines begin with @"), "{error}");
}
