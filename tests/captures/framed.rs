//! Recordings with the framings of ORADIS and GPS recorders, and datagrams with the former.

use jiff::civil::date;
use utm_fusion::capture::{CaptureFormat, Damage, MergedCaptures, PayloadKind};

use crate::writer::{PcapWriter, WRAPPINGS};
use crate::{endpoints, open, open_in_steps, payloads, read};

/// CAT048 with I048/010 only, from these systems.
fn block(systems: &[u8]) -> Vec<u8> {
    let records: Vec<u8> = systems.iter().flat_map(|sic| [0x80, 25, *sic]).collect();
    [&[48, 0, 3 + records.len() as u8], &records[..]].concat()
}

const NOON_MS: u32 = 43_200_000;

/// An ORADIS record, received this number of milliseconds after midnight.
fn oradis(milliseconds: u32, data: &[u8]) -> Vec<u8> {
    let length = (6 + data.len() as u16).to_be_bytes();
    [&length[..], &milliseconds.to_be_bytes(), data].concat()
}

/// A block followed by the ten octets of a GPS recorder.
fn gps(count: u8, data: &[u8]) -> Vec<u8> {
    [data, &[0x11, 0xd2, 0x8f, 0x0a, 0, 0, 0, 1, count, 0]].concat()
}

#[test]
fn oradis_record_is_a_datagram_with_a_time_of_day() {
    let blocks = [block(&[1, 2]), [block(&[3]), block(&[4])].concat(), block(&[5])];
    let octets: Vec<u8> =
        blocks.iter().zip(NOON_MS..).flat_map(|(block, time)| oradis(time, block)).collect();
    for step in [0, 1] {
        let mut capture = open_in_steps(&octets, step).unwrap();
        assert_eq!((capture.format(), capture.is_dated()), (&CaptureFormat::Oradis, false));
        let (datagrams, error) = read(&octets, &mut capture);
        assert!(error.is_none() && capture.gaps().is_empty());
        assert_eq!(payloads(&datagrams), blocks);
        let times: Vec<_> = datagrams.iter().map(|datagram| datagram.since_midnight.unwrap()).collect();
        assert_eq!(times, [0, 1, 2].map(|ms| (i64::from(NOON_MS) + ms) * 1_000_000));
    }
    let merged = MergedCaptures::new(vec![open(&octets).unwrap()], date(2026, 6, 20));
    let last = merged.map(Result::unwrap).last().unwrap();
    assert_eq!(last.received.unwrap().to_string(), "2026-06-20T12:00:00.002Z");
}

#[test]
fn oradis_record_behind_damage_is_found() {
    let records: Vec<Vec<u8>> = (0..6).map(|count| oradis(NOON_MS, &block(&[count]))).collect();
    // The length of the fourth record is wrong.
    let mut octets = records.concat();
    let fourth = 3 * records[0].len();
    octets[fourth + 1] += 3;
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    let read = |contents| datagrams.iter().filter(move |datagram| datagram.contents == contents);
    assert_eq!(read(PayloadKind::Blocks).count(), 5);
    let gap = read(PayloadKind::Unframed).next().unwrap();
    assert_eq!((gap.origin as usize, gap.payload.len()), (fourth, records[3].len()));
    assert_eq!(capture.gaps().octets as usize, records[2].len());
}

#[test]
fn oradis_file_that_ends_within_a_record_says_so() {
    let octets: Vec<u8> = (0..4).flat_map(|count| oradis(NOON_MS, &block(&[count]))).collect();
    let (datagrams, error) = read(&octets, &mut open(&octets[..octets.len() - 2]).unwrap());
    assert_eq!(datagrams.len(), 3);
    assert!(matches!(error.unwrap().damage, Damage::Cut { present: 10, needed: 12, .. }));
}

#[test]
fn oradis_datagram_gives_a_datagram_for_each_record() {
    let blocks = [block(&[1]), block(&[2, 3])];
    let payload: Vec<u8> = blocks.iter().flat_map(|block| oradis(NOON_MS, block)).collect();
    // The record claims more octets than are present, so the datagram remains as it is.
    let cut = &payload[..payload.len() - 1];
    let mut file = PcapWriter::new(false, false, 1);
    file.record(1_700_000_000, 0, &WRAPPINGS[0].frame(4, &payload));
    file.record(1_700_000_001, 0, &WRAPPINGS[0].frame(4, cut));
    let (datagrams, error) = read(&file.octets, &mut open(&file.octets).unwrap());
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), [&blocks[0], &blocks[1], cut]);
    assert!(datagrams.iter().all(|datagram| datagram.endpoints == endpoints(4)));
    assert_eq!(datagrams[0].received, datagrams[1].received);
}

#[test]
fn gps_framing_is_read_with_and_without_its_header() {
    let blocks = [block(&[1]), block(&[2, 3]), block(&[4]), block(&[5])];
    let body: Vec<u8> = blocks.iter().zip(1..).flat_map(|(block, count)| gps(count, block)).collect();
    for header in [vec![], vec![0xcd; 2200], vec![0; 2200]] {
        let octets = [&header[..], &body].concat();
        for step in [0, 1] {
            let mut capture = open_in_steps(&octets, step).unwrap();
            assert_eq!(capture.format(), &CaptureFormat::Gps, "{} octets of header", header.len());
            let (datagrams, error) = read(&octets, &mut capture);
            assert!(error.is_none() && capture.gaps().is_empty());
            assert_eq!(payloads(&datagrams), blocks);
            assert_eq!(datagrams[1].origin as usize, header.len() + blocks[0].len() + 10);
            assert_eq!(capture.consumed() as usize, octets.len());
        }
    }
}

#[test]
fn gps_block_behind_damage_is_found() {
    let mut octets: Vec<u8> = (0..8).flat_map(|count| gps(count, &block(&[count]))).collect();
    let length = octets.len() / 8;
    // LEN of the fourth record is wrong, and the sixth has lost an octet.
    octets[3 * length + 2] += 4;
    octets.remove(5 * length + 9);
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    let found: Vec<u8> = datagrams
        .iter()
        .filter(|datagram| datagram.contents == PayloadKind::Blocks && datagram.payload.len() == 6)
        .map(|datagram| datagram.payload[5])
        .collect();
    assert_eq!(found, [0, 1, 2, 4, 5, 6, 7]);
    // The fourth record with its trailer, and nine octets after the sixth.
    assert_eq!(capture.gaps().octets as usize, length + 10 + 9, "{}", capture.gaps());
}

#[test]
fn raw_blocks_stay_raw() {
    let raw: Vec<u8> = (0..20).flat_map(|count| block(&[count])).collect();
    assert_eq!(open(&raw).unwrap().format(), &CaptureFormat::Raw);
    // A single block followed by other octets is no framing.
    assert!(open(&[&raw[..6], &[0x11; 10]].concat()).is_err());
}
