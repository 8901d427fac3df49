//! Classic pcap.

use std::io;

use fusion::time::Time;
use proptest::prelude::*;
use utm_fusion::capture::{Capture, Damage, OpenError, SkipReason};

use crate::writer::{MAGICS, PcapWriter, UDP, WRAPPINGS, ethernet, ipv4, ipv6, udp};
use crate::{BLOCKS, endpoints, open, open_in_steps, payloads, read};

const IPV4: [u8; 2] = [0x08, 0x00];
const IPV6: [u8; 2] = [0x86, 0xDD];

/// Three datagrams with other records between them, and the end of each record.
fn three_datagrams() -> (Vec<u8>, Vec<usize>) {
    let mut file = PcapWriter::new(false, false, 1);
    let mut ends = vec![file.octets.len()];
    for (second, block) in (1_700_000_000..).zip(BLOCKS) {
        file.record(second, 250_000, &WRAPPINGS[0].frame(4, block));
        ends.push(file.octets.len());
    }
    (file.octets, ends)
}

#[test]
fn every_magic_of_each_link_and_ip_version_is_read() {
    let mut seen = 0;
    for (big_endian, nanoseconds) in MAGICS {
        for wrapping in WRAPPINGS {
            for &version in wrapping.versions {
                let mut file = PcapWriter::new(big_endian, nanoseconds, wrapping.link);
                for (fraction, block) in (123_456..).zip(BLOCKS) {
                    file.record(1_700_000_000, fraction, &wrapping.frame(version, block));
                }
                let mut capture = open(&file.octets).unwrap();
                let unit = if nanoseconds { "nanoseconds" } else { "microseconds" };
                assert_eq!(capture.format().to_string(), format!("pcap ({}, {unit})", wrapping.shown));
                let (datagrams, error) = read(&file.octets, &mut capture);
                assert!(error.is_none() && capture.skipped().total() == 0, "{}", wrapping.shown);
                assert_eq!(payloads(&datagrams), BLOCKS);
                assert_eq!(capture.consumed(), file.octets.len() as u64);
                let scale = if nanoseconds { 1 } else { 1000 };
                let second = 1_700_000_000_000_000_000;
                for (fraction, datagram) in (123_456..).zip(&datagrams) {
                    assert_eq!(datagram.received, Some(Time::from_nanos(second + fraction * scale)));
                    assert_eq!(datagram.endpoints, endpoints(version));
                }
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 4 * 24);
}

#[test]
fn time_stamps_at_the_edges_do_not_overflow() {
    for (nanoseconds, expected) in
        [(false, 4_294_967_295_i64 * 1_000_001_000), (true, 4_294_967_295 * 1_000_000_001)]
    {
        let mut file = PcapWriter::new(true, nanoseconds, 1);
        file.record(u32::MAX, u32::MAX, &WRAPPINGS[0].frame(4, BLOCKS[0]));
        let (datagrams, _) = read(&file.octets, &mut open(&file.octets).unwrap());
        assert_eq!(datagrams[0].received, Some(Time::from_nanos(expected)));
    }
}

#[test]
fn what_is_no_datagram_is_counted_by_reason() {
    let whole = WRAPPINGS[0].frame(4, BLOCKS[0]);
    let v6 = |next, payload: &[u8]| [ethernet(&[], IPV6), ipv6(next, payload)].concat();
    let v4 = |protocol, fragment, payload: &[u8]| {
        [ethernet(&[], IPV4), ipv4(protocol, fragment, payload)].concat()
    };
    let mut long_udp = udp(BLOCKS[0]);
    long_udp[5] += 1;
    let mut short_udp = udp(BLOCKS[0]);
    short_udp[5] = 7;
    let mut wrong_version = v4(UDP, 0, &udp(BLOCKS[0]));
    wrong_version[14] = 0x55;
    let cases: Vec<(&str, Vec<u8>, SkipReason)> = vec![
        ("an empty frame", vec![], SkipReason::Truncated),
        ("half an Ethernet header", whole[..13].to_vec(), SkipReason::Truncated),
        ("half a VLAN tag", ethernet(&[0x81, 0], [0, 7]), SkipReason::Truncated),
        ("half an IP header", whole[..30].to_vec(), SkipReason::Truncated),
        ("half a UDP header", whole[..38].to_vec(), SkipReason::Truncated),
        ("half a payload", whole[..whole.len() - 3].to_vec(), SkipReason::Truncated),
        ("ARP", [ethernet(&[], [8, 6]), vec![0; 46]].concat(), SkipReason::NotIp),
        ("ARP, cut", ethernet(&[], [8, 6]), SkipReason::NotIp),
        ("spanning tree (802.3)", [ethernet(&[], [0, 38]), vec![0x42; 46]].concat(), SkipReason::NotIp),
        ("TCP", v4(6, 0, &[0x50; 20]), SkipReason::NotUdp),
        ("TCP, cut", v4(6, 0, &[0x50; 3]), SkipReason::NotUdp),
        ("IGMP", v4(2, 0, &[0x16, 0, 0, 0, 239, 0, 0, 1]), SkipReason::NotUdp),
        ("ICMPv6", v6(58, &[128, 0, 0, 0, 0, 0, 0, 0]), SkipReason::NotUdp),
        ("first fragment", v4(UDP, 0x2000, &udp(BLOCKS[0])), SkipReason::Fragment),
        ("last fragment", v4(UDP, 0x0010, &udp(BLOCKS[0])), SkipReason::Fragment),
        (
            "IPv6 fragment",
            v6(44, &[&[UDP, 0, 0, 1, 0, 0, 0, 9][..], &udp(BLOCKS[0])].concat()),
            SkipReason::Fragment,
        ),
        ("IPv6, extension header cut", v6(60, &[UDP, 0, 0]), SkipReason::Truncated),
        ("UDP longer than its packet", v4(UDP, 0, &long_udp), SkipReason::Malformed),
        ("UDP shorter than its header", v4(UDP, 0, &short_udp), SkipReason::Malformed),
        ("IP version 5", wrong_version, SkipReason::Malformed),
    ];
    let mut all = PcapWriter::new(false, false, 1);
    for (name, frame, reason) in &cases {
        let mut file = PcapWriter::new(false, false, 1);
        file.record(1, 0, frame);
        file.record(2, 0, &whole);
        all.record(1, 0, frame);
        let mut capture = open(&file.octets).unwrap();
        let (datagrams, error) = read(&file.octets, &mut capture);
        assert!(error.is_none(), "{name}");
        assert_eq!(capture.skipped().iter().collect::<Vec<_>>(), [(*reason, 1)], "{name}");
        assert_eq!(payloads(&datagrams), [BLOCKS[0]], "{name}");
    }
    let mut capture = open(&all.octets).unwrap();
    assert!(capture.next().is_none());
    assert_eq!(
        capture.skipped().to_string(),
        "3 not IP, 4 not UDP, 3 fragmented, 7 cut short by the capture, 3 malformed"
    );
    assert_eq!(capture.skipped().count(SkipReason::Fragment), 3);
}

#[test]
fn an_unfragmented_ipv6_packet_behind_extension_headers_is_read() {
    let packet = ipv6(60, &[&[UDP, 0, 1, 4, 0, 0, 0, 0][..], &udp(BLOCKS[2])].concat());
    let mut file = PcapWriter::new(false, true, 101);
    file.record(1, 0, &packet);
    let (datagrams, _) = read(&file.octets, &mut open(&file.octets).unwrap());
    assert_eq!(payloads(&datagrams), [BLOCKS[2]]);
    assert_eq!(datagrams[0].endpoints, endpoints(6));
}

#[test]
fn frame_cut_behind_its_datagram_and_empty_datagram_are_read() {
    let mut file = PcapWriter::new(false, false, 1);
    let frame = WRAPPINGS[0].frame(6, BLOCKS[1]);
    file.record_of(1, 0, &frame[..frame.len() - 2], frame.len() + 40);
    file.record(2, 0, &WRAPPINGS[0].frame(4, &[]));
    let (datagrams, error) = read(&file.octets, &mut open(&file.octets).unwrap());
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), [BLOCKS[1], &[]]);
}

#[test]
fn file_cut_anywhere_gives_whole_datagrams_and_names_the_cut() {
    let (octets, ends) = three_datagrams();
    for length in 0..=octets.len() {
        let cut = &octets[..length];
        let mut capture = match open(cut) {
            Ok(capture) => capture,
            Err(OpenError::Empty { .. }) => {
                assert_eq!(length, 0);
                continue;
            }
            Err(OpenError::Foreign { .. }) => {
                assert!(length < 4);
                continue;
            }
            Err(error) => {
                assert!(
                    matches!(error, OpenError::HeaderCut { octets, .. } if octets == length && length < 24)
                );
                continue;
            }
        };
        let (datagrams, error) = read(cut, &mut capture);
        let whole = ends.iter().filter(|end| **end <= length).count() - 1;
        assert_eq!(payloads(&datagrams), BLOCKS[..whole]);
        assert_eq!(capture.consumed(), ends[whole] as u64);
        assert_eq!(error.is_some(), ends[whole] != length, "{length}");
        if let Some(error) = error {
            assert_eq!(error.offset, ends[whole] as u64);
            assert!(matches!(error.damage, Damage::Cut { present, .. } if present == length - ends[whole]));
        }
    }
}

#[test]
fn any_octet_may_be_wrong() {
    let (octets, _) = three_datagrams();
    for place in 0..octets.len() {
        for flip in [0x01, 0x80, 0xFF] {
            let mut wrong = octets.clone();
            wrong[place] ^= flip;
            if let Ok(mut capture) = open(&wrong) {
                let (datagrams, _) = read(&wrong, &mut capture);
                assert!(datagrams.len() <= 3);
            }
        }
    }
}

#[test]
fn a_record_of_absurd_length_ends_the_capture() {
    let (mut octets, ends) = three_datagrams();
    octets[ends[1] + 10] = 0x10; // captured length of the second record: about 1 MB
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert_eq!(payloads(&datagrams), [BLOCKS[0]]);
    let message = error.unwrap().to_string();
    assert!(
        message.starts_with(&format!("test: at offset {}: a pcap record claims 1048", ends[1])),
        "{message}"
    );
}

#[test]
fn a_link_type_that_is_not_read_is_named() {
    let message = |link| open(&PcapWriter::new(true, true, link).octets).unwrap_err().to_string();
    assert!(message(119).starts_with("test: is a pcap of link type 119 (IEEE 802.11 with Prism header)"));
    assert!(message(9999).contains("9999 (unknown)"));
}

#[test]
fn an_error_of_the_system_comes_after_what_was_read() {
    struct Broken;
    impl io::Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("bad sector"))
        }
    }
    let (octets, ends) = three_datagrams();
    let reader = io::Read::chain(io::Cursor::new(octets[..ends[1] + 5].to_vec()), Broken);
    let mut capture = Capture::from_reader("disk".to_owned(), Box::new(reader), None).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert_eq!(payloads(&datagrams), [BLOCKS[0]]);
    let message = error.unwrap().to_string();
    assert!(
        message.starts_with(&format!("disk: at offset {}: cannot be read further: bad sector;", ends[1]))
    );
    let nothing = Capture::from_reader("disk".to_owned(), Box::new(Broken), None);
    assert_eq!(nothing.unwrap_err().to_string(), "disk: cannot be read: bad sector");
}

#[test]
fn frame_of_any_size_up_to_the_limit_passes_the_window() {
    let mut file = PcapWriter::new(false, true, 1);
    let mut expected = Vec::new();
    for (second, size) in (0_u32..).zip([65_507, 1, 262_144, 40_000, 65_000, 262_144, 30_000, 0, 65_507]) {
        let payload: Vec<u8> =
            (0..size.min(65_507)).map(|place| (place * 7 + second as usize) as u8).collect();
        let mut frame = WRAPPINGS[0].frame(4, &payload);
        frame.resize(size.max(frame.len()), 0);
        file.record(second, 0, &frame);
        expected.push(payload);
    }
    for step in [0, 1000, 65_536] {
        let (datagrams, error) = read(&file.octets, &mut open_in_steps(&file.octets, step).unwrap());
        assert!(error.is_none());
        assert_eq!(payloads(&datagrams), expected);
    }
}

proptest! {
    #[test]
    fn how_the_octets_arrive_changes_nothing(
        step in 0_usize..80,
        frames in prop::collection::vec((0..WRAPPINGS.len(), prop::collection::vec(any::<u8>(), 0..60), 0_usize..9), 0..12),
        cut in 0_usize..40,
    ) {
        let mut file = PcapWriter::new(false, true, 1);
        for (wrapping, payload, lost) in frames {
            // Frames of other link types are noise in this one.
            let frame = WRAPPINGS[wrapping].frame(WRAPPINGS[wrapping].versions[0], &payload);
            file.record(7, 8, &frame[..frame.len() - lost]);
        }
        let octets = &file.octets[..file.octets.len().saturating_sub(cut).max(24)];
        let (mut at_once, mut in_steps) = (open(octets).unwrap(), open_in_steps(octets, step).unwrap());
        let (expected, damage) = read(octets, &mut at_once);
        let (datagrams, same_damage) = read(octets, &mut in_steps);
        prop_assert_eq!(datagrams, expected);
        prop_assert_eq!(damage.map(|error| error.to_string()), same_damage.map(|error| error.to_string()));
        prop_assert_eq!(at_once.skipped(), in_steps.skipped());
        prop_assert_eq!(at_once.consumed(), in_steps.consumed());
    }

    #[test]
    fn frames_of_noise_never_panic(
        link in prop::sample::select(vec![0_u32, 1, 12, 101, 108, 113, 276]),
        header in prop::collection::vec(any::<u8>(), 0..24),
        noise in prop::collection::vec(any::<u8>(), 0..80),
        version in prop::sample::select(vec![0x45_u8, 0x4F, 0x60]),
    ) {
        let mut file = PcapWriter::new(false, true, link);
        let known = WRAPPINGS.iter().find(|wrapping| wrapping.link == link).unwrap();
        let inner = [vec![version], noise.clone()].concat();
        for frame in [[header, noise].concat(), [(known.header)(4), inner.clone()].concat(), [(known.header)(6), inner].concat()] {
            file.record(1, 1, &frame);
        }
        let mut capture = open(&file.octets).unwrap();
        let (datagrams, error) = read(&file.octets, &mut capture);
        prop_assert!(error.is_none());
        prop_assert_eq!(datagrams.len() as u64 + capture.skipped().total(), 3);
    }
}
