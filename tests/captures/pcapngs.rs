//! pcapng.

use fusion::time::Time;
use utm_fusion::capture::{CaptureFormat, CapturedDatagram, MergedCaptures, ReceptionKind, SkipReason};

use crate::writer::{PcapngWriter, WRAPPINGS};
use crate::{BLOCKS, endpoints, open, payloads, read};

const RESOLUTION: u16 = 9;
const OFFSET: u16 = 14;
const SECOND: i64 = 1_000_000_000;

/// Reads a file that must be valid.
fn sound(file: &PcapngWriter) -> Vec<CapturedDatagram> {
    let (datagrams, error) = read(&file.octets, &mut open(&file.octets).expect("a capture"));
    assert!(error.is_none(), "{error:?}");
    datagrams
}

fn frame(block: &[u8]) -> Vec<u8> {
    WRAPPINGS[0].frame(4, block)
}

#[test]
fn both_byte_orders_of_each_link_and_ip_version_are_read() {
    for big_endian in [false, true] {
        let mut all = PcapngWriter::new(big_endian);
        let mut interfaces = 0;
        for wrapping in WRAPPINGS {
            for &version in wrapping.versions {
                all.interface(wrapping.link as u16, 65_535, &[(2, b"eth0")]);
                for (time, block) in (1_700_000_000_123_456..).zip(BLOCKS) {
                    all.packet(interfaces, time, &wrapping.frame(version, block));
                }
                interfaces += 1;
            }
        }
        let mut capture = open(&all.octets).unwrap();
        assert_eq!(
            (*capture.format(), capture.format().to_string().as_str()),
            (CaptureFormat::Pcapng, "pcapng")
        );
        let (datagrams, error) = read(&all.octets, &mut capture);
        assert!(error.is_none() && capture.skipped().total() == 0);
        assert_eq!(capture.consumed(), all.octets.len() as u64);
        let versions = WRAPPINGS.iter().flat_map(|wrapping| wrapping.versions);
        assert_eq!(datagrams.len(), 3 * versions.clone().count());
        for (three, version) in datagrams.chunks(3).zip(versions) {
            assert_eq!(payloads(three), BLOCKS);
            for (micros, datagram) in (1_700_000_000_123_456..).zip(three) {
                assert_eq!(datagram.received, Some(Time::from_nanos(micros * 1000)));
                assert_eq!(datagram.endpoints, endpoints(*version));
            }
        }
    }
}

#[test]
fn times_have_the_unit_and_the_offset_of_their_interface() {
    let cases: [(&[u8], i64, u64, Option<i64>); 18] = [
        (&[], 0, 1_000_001, Some(1_000_001_000)),
        (&[0], 0, 7, Some(7 * SECOND)),
        (&[3], 0, 1001, Some(1_001_000_000)),
        (&[6], 5, 1, Some(5 * SECOND + 1000)),
        (&[6], -5, 0, Some(-5 * SECOND)),
        (&[9], 0, 1_700_000_000_123_456_789, Some(1_700_000_000_123_456_789)),
        // Rounded down to the nanosecond.
        (&[12], 0, 1_999, Some(1)),
        (&[19], 0, u64::MAX, Some(1_844_674_407)),
        (&[38], 0, u64::MAX, Some(0)),
        (&[127], 0, u64::MAX, Some(0)),
        (&[0x80], 0, 3, Some(3 * SECOND)),
        (&[0x81], 0, 3, Some(1_500_000_000)),
        // 1/128 s, the unit of ASTERIX, exact to the nanosecond.
        (&[0x87], 0, 1, Some(7_812_500)),
        (&[0xA0], 1_700_000_000, 1 << 31, Some(1_700_000_000 * SECOND + SECOND / 2)),
        (&[0xFF], 0, u64::MAX, Some(0)),
        // A time out of range.
        (&[0], 0, u64::MAX, None),
        (&[6], i64::MAX, 0, None),
        // An option of another length has no meaning.
        (&[9, 9], 0, 1_000_001, Some(1_000_001_000)),
    ];
    for big_endian in [false, true] {
        let mut file = PcapngWriter::new(big_endian);
        for (interface, (resolution, offset, time, _)) in (0..).zip(&cases) {
            let offset = if big_endian { offset.to_be_bytes() } else { offset.to_le_bytes() };
            let options: [(u16, &[u8]); 3] = [(OFFSET, &offset), (RESOLUTION, resolution), (0, &[])];
            file.interface(1, 0, if resolution.is_empty() { &[] } else { &options });
            file.packet(interface, *time, &frame(BLOCKS[0]));
        }
        for (datagram, (resolution, .., expected)) in sound(&file).iter().zip(&cases) {
            assert_eq!(datagram.received, expected.map(Time::from_nanos), "{resolution:?}");
        }
    }
}

#[test]
fn each_section_has_its_byte_order_and_its_interfaces() {
    let mut file = PcapngWriter::new(false);
    file.interface(1, 0, &[]);
    file.interface(101, 0, &[(RESOLUTION, &[9])]);
    file.packet(1, 1, &WRAPPINGS[6].frame(6, BLOCKS[0]));
    file.section(true);
    file.packet(0, 2, &frame(BLOCKS[1]));
    file.interface(1, 0, &[(RESOLUTION, &[9])]);
    file.packet(0, 3, &frame(BLOCKS[1]));
    file.packet(1, 4, &frame(BLOCKS[1]));
    file.section(false);
    file.section(false);
    file.interface(113, 0, &[(RESOLUTION, &[9])]);
    file.packet(0, 5, &WRAPPINGS[4].frame(4, BLOCKS[2]));
    let mut capture = open(&file.octets).unwrap();
    let (datagrams, error) = read(&file.octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), BLOCKS);
    let times: Vec<_> = datagrams.iter().map(|datagram| datagram.received.unwrap().nanos()).collect();
    assert_eq!(times, [1, 3, 5]);
    assert_eq!(capture.skipped().to_string(), "2 on an interface that the file does not describe");
}

#[test]
fn simple_and_obsolete_packets_are_read() {
    for big_endian in [false, true] {
        let mut file = PcapngWriter::new(big_endian);
        let kept = frame(BLOCKS[1]).len() - 2;
        file.interface(1, kept as u32, &[]);
        file.interface(101, 0, &[]);
        // The 2 octets of padding of the second frame were not captured.
        file.simple_packet(kept - 3, &frame(BLOCKS[1])[..kept - 3]);
        file.simple_packet(kept + 2, &frame(BLOCKS[1])[..kept]);
        file.obsolete_packet(1, 7, &WRAPPINGS[6].frame(6, BLOCKS[2]));
        let mut capture = open(&file.octets).unwrap();
        let (datagrams, error) = read(&file.octets, &mut capture);
        assert!(error.is_none());
        assert_eq!(payloads(&datagrams), [BLOCKS[1], BLOCKS[2]]);
        assert_eq!((datagrams[0].received, datagrams[0].endpoints), (None, endpoints(4)));
        assert_eq!(datagrams[1].received, Some(Time::from_nanos(7000)));
        assert_eq!(capture.skipped().to_string(), "1 cut short by the capture");
    }
}

#[test]
fn records_of_simple_packets_have_the_time_of_what_came_before() {
    let mut file = PcapngWriter::new(false);
    file.interface(1, 0, &[]);
    let first = frame(&[48, 0, 7, 0x80, 25, 200, 0]);
    file.simple_packet(first.len(), &first);
    file.packet(0, 1_700_000_000_000_000, &frame(BLOCKS[2]));
    file.simple_packet(first.len(), &first);
    let receptions: Vec<_> =
        MergedCaptures::new(vec![open(&file.octets).unwrap()], jiff::civil::date(2026, 1, 1))
            .map(|reception| reception.map(|reception| (reception.kind, reception.received)).unwrap())
            .collect();
    let time = Some(Time::from_nanos(1_700_000_000 * SECOND));
    let records = receptions.iter().filter(|(kind, _)| *kind == ReceptionKind::Record).count();
    assert_eq!((receptions[0].1, records), (None, receptions.len() - 1));
    assert_eq!(receptions.last(), Some(&(ReceptionKind::Record, time)));
}

#[test]
fn what_is_of_no_interest_is_passed_over() {
    for length in [0, 1, 65_535, 131_060, 131_064, 200_000, 3_000_000] {
        let mut file = PcapngWriter::new(true);
        file.block(4, &vec![7; length]); // names
        file.interface(1, 0, &[(1, b"a comment"), (11, b"\0udp")]);
        file.block(0x0BAD, &vec![0xA5; length]); // a private block
        file.packet_of(
            0,
            1,
            &frame(BLOCKS[0]),
            frame(BLOCKS[0]).len(),
            &[(1, &[b'x'; 60_000]), (2, &[0; 4])],
        );
        file.block(5, &vec![0; length]); // statistics
        file.block(0x8000_0001, &vec![0x0A; length]);
        assert_eq!(payloads(&sound(&file)), [BLOCKS[0]]);
    }
}

#[test]
fn what_is_no_datagram_is_counted_by_reason() {
    let mut file = PcapngWriter::new(false);
    file.interface(119, 0, &[]);
    file.interface(1, 0, &[]);
    file.block(1, &[1, 0]); // a truncated interface block is still the third interface
    file.packet(0, 1, &frame(BLOCKS[0]));
    file.packet(2, 1, &frame(BLOCKS[0]));
    file.packet(3, 1, &frame(BLOCKS[0]));
    file.packet(u32::MAX, 1, &frame(BLOCKS[0]));
    file.packet_of(1, 1, &frame(BLOCKS[0]), 100, &[]);
    file.packet_of(1, 1, &frame(BLOCKS[0]), u32::MAX as usize, &[]);
    file.packet_of(1, 1, &frame(BLOCKS[0]), 30, &[]);
    file.packet(1, 1, &[0; 60]);
    file.block(2, &[0; 16]);
    file.block(3, &[]);
    file.block(6, &[0; 4]);
    file.packet(1, 1, &frame(BLOCKS[0]));
    let mut capture = open(&file.octets).unwrap();
    let (datagrams, error) = read(&file.octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), [BLOCKS[0]]);
    assert_eq!(
        capture.skipped().to_string(),
        "1 not IP, 1 cut short by the capture, 5 malformed, 2 of a link type that cannot be read, \
         2 on an interface that the file does not describe"
    );
    assert_eq!(capture.skipped().count(SkipReason::LinkType), 2);
}
