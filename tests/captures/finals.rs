//! FINAL recordings.

use jiff::civil::date;
use proptest::prelude::*;
use utm_fusion::capture::{
    CaptureFormat, CapturedDatagram, Damage, MergedCaptures, PayloadKind, ReceptionKind,
};

use crate::writer::final_record;
use crate::{BLOCKS, open, open_in_steps, payloads, read};

const NOON: u32 = 4_320_000;

fn three_records() -> Vec<u8> {
    (NOON..).zip(BLOCKS).flat_map(|(time, block)| final_record(time, block)).collect()
}

fn format(octets: &[u8]) -> Option<CaptureFormat> {
    let format = open(octets).ok().map(|capture| *capture.format());
    assert_eq!(format, open_in_steps(octets, 1).ok().map(|capture| *capture.format()));
    format
}

#[test]
fn each_record_is_a_datagram_with_a_time_of_day() {
    let octets = [three_records(), final_record(8_639_999, &BLOCKS.concat())].concat();
    let mut capture = open(&octets).unwrap();
    assert_eq!(capture.format().to_string(), "FINAL recording");
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), [BLOCKS[0], BLOCKS[1], BLOCKS[2], &BLOCKS.concat()]);
    let expected =
        [43_200_000, 43_200_010, 43_200_020, 86_399_990].map(|milliseconds| Some(milliseconds * 1_000_000));
    assert_eq!(datagrams.iter().map(|datagram| datagram.since_midnight).collect::<Vec<_>>(), expected);
    assert!(datagrams.iter().all(|datagram| datagram.received.is_none() && datagram.endpoints.is_none()));
    assert_eq!(datagrams[1].origin, 20 + 8);
    assert_eq!(capture.consumed(), octets.len() as u64);
}

#[test]
fn first_record_is_of_the_given_day_midnight_begins_the_next() {
    let times = [8_639_950, 8_639_999, 0, 8_639_998, 100];
    let octets: Vec<u8> = times.into_iter().flat_map(|time| final_record(time, BLOCKS[2])).collect();
    let merged = MergedCaptures::new(vec![open(&octets).unwrap()], date(2026, 6, 20));
    let receptions: Vec<_> = merged.map(Result::unwrap).collect();
    let times: Vec<_> = receptions.iter().map(|reception| reception.received.unwrap().to_string()).collect();
    assert_eq!(
        times,
        [
            "2026-06-20T23:59:59.500Z",
            "2026-06-20T23:59:59.990Z",
            "2026-06-21T00:00:00.000Z",
            "2026-06-20T23:59:59.980Z",
            "2026-06-21T00:00:01.000Z"
        ]
    );
    assert!(receptions.iter().all(|reception| reception.kind == ReceptionKind::Datagram));
}

#[test]
fn record_of_impossible_time_has_that_of_the_one_before() {
    let block = &[48, 0, 7, 0x80, 25, 200, 0][..];
    let octets = [final_record(NOON, block), final_record(8_640_000, block)].concat();
    let (datagrams, _) = read(&octets, &mut open(&octets).unwrap());
    assert_eq!(datagrams[1].since_midnight, None);
    let merged = MergedCaptures::new(vec![open(&octets).unwrap()], date(2026, 6, 20));
    let receptions: Vec<_> = merged.map(Result::unwrap).collect();
    assert_eq!(receptions[1].kind, ReceptionKind::Record);
    assert_eq!(receptions[1].received, receptions[0].received);
}

#[test]
fn a_record_without_data_and_the_longest_are_read() {
    let longest = vec![48; 65_523];
    let octets = [three_records(), final_record(NOON, &[]), final_record(NOON, &longest)].concat();
    let (datagrams, error) = read(&octets, &mut open(&octets).unwrap());
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams[3..]), [&[][..], &longest]);
}

#[test]
fn recording_cut_anywhere_gives_whole_records_and_names_the_cut() {
    let octets = three_records();
    let ends = [20, 37, 61];
    for length in 20..=octets.len() {
        let cut = &octets[..length];
        let (datagrams, error) = read(cut, &mut open(cut).unwrap());
        let whole = ends.iter().filter(|end| **end <= length).count();
        assert_eq!(payloads(&datagrams), BLOCKS[..whole]);
        assert_eq!(error.is_some(), ends[whole - 1] != length, "{length}");
        if let Some(error) = error {
            assert_eq!(error.offset, ends[whole - 1] as u64);
            assert!(
                matches!(error.damage, Damage::Cut { present, .. } if present == length - ends[whole - 1])
            );
        }
    }
}

/// Data are read if they begin with a block; the other octets up to the next record are passed on unchanged.
#[test]
fn behind_damage_the_next_record_is_read() {
    let sound = three_records();
    let with = |place: usize, octet: u8| {
        let mut octets = sound.clone();
        octets[place] = octet;
        octets
    };
    let cases = [
        // The trailer, and three wrong lengths: too long by one, below the minimum, beyond the end.
        (with(36, 0), 20..37),
        (with(21, 18), 20..37),
        (with(21, 11), 20..37),
        (with(20, 1), 20..37),
        // One octet lost, one octet added.
        ([&sound[..30], &sound[31..]].concat(), 20..36),
        ([&sound[..30], &[7], &sound[30..]].concat(), 20..38),
        ([sound.clone(), vec![0; 40]].concat(), 61..101),
    ];
    for (octets, damaged) in cases {
        let mut capture = open(&octets).unwrap();
        let (datagrams, error) = read(&octets, &mut capture);
        assert!(error.is_none(), "{error:?}");
        let sound: Vec<_> =
            datagrams.iter().filter(|datagram| datagram.since_midnight.is_some()).cloned().collect();
        let expected = if damaged.start == 20 { vec![BLOCKS[0], BLOCKS[2]] } else { BLOCKS.to_vec() };
        assert_eq!(payloads(&sound), expected);
        let rest: Vec<u8> = datagrams
            .iter()
            .filter(|datagram| datagram.since_midnight.is_none())
            .flat_map(|datagram| datagram.payload.clone())
            .collect();
        assert_eq!(rest, octets[damaged.clone()]);
        let is_gap = |datagram: &&CapturedDatagram| datagram.contents == PayloadKind::Unframed;
        let gaps: usize = datagrams.iter().filter(is_gap).map(|datagram| datagram.payload.len()).sum();
        assert_eq!(
            (capture.gaps().octets, capture.gaps().first_offset),
            (gaps as u64, Some(damaged.start as u64))
        );
    }
    // A record in which only the length is wrong.
    let block = &[48, 0, 7, 0x80, 25, 200, 0xFF][..6];
    let block = [&[48, 0, 6][..], &block[3..]].concat();
    let mut octets =
        [final_record(NOON, &block), final_record(NOON, &block), final_record(NOON, &block)].concat();
    octets[19] = 77;
    let (datagrams, error) = read(&octets, &mut open(&octets).unwrap());
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), [&block[..], &octets[18..26], &block, &[0xA5; 4], &block]);
    assert_eq!(datagrams[2].contents, PayloadKind::Blocks);
}

#[test]
fn recording_followed_by_a_longer_one_is_cut() {
    let octets = [three_records(), BLOCKS.concat()].concat();
    let (datagrams, error) = read(&octets, &mut open(&octets).unwrap());
    assert_eq!(datagrams.len(), 3);
    let message = error.unwrap().to_string();
    assert!(
        message.starts_with("test: at offset 61: ") && message.contains("(25 of 12288 octets)"),
        "{message}"
    );
}

#[test]
fn recordings_are_told_from_raw_files_by_their_trailer() {
    // Blocks that could also begin a raw file: a record of 257 octets resembles category 1 with 257 octets.
    let mut block = vec![0x81; 245];
    block[..3].copy_from_slice(&[48, 0, 245]);
    let lookalike = final_record(NOON, &block);
    assert_eq!(lookalike[..3], [1, 1, 1]);
    for octets in [three_records(), lookalike.clone(), lookalike.repeat(2)] {
        assert_eq!(format(&octets), Some(CaptureFormat::Final));
    }
    // Without its trailer it is what it resembles.
    let mut octets = lookalike.repeat(2);
    octets[256] = 0xA4;
    assert_eq!(format(&octets), Some(CaptureFormat::Raw));
    // Octets a5 in a raw file are no trailer, and a time must be within a day.
    let filled = [&[48, 1, 0][..], &[0xA5; 253]].concat().repeat(200);
    assert_eq!(format(&filled), Some(CaptureFormat::Raw));
    assert_eq!(format(&[0xA5; 50_000]), Some(CaptureFormat::Raw));
    assert_eq!(format(&final_record(8_640_000, BLOCKS[0])), None);
    // Data that do not begin with a block, or begin with one longer than the data.
    assert_eq!(format(&final_record(NOON, &[0; 20])), None);
    assert_eq!(format(&final_record(NOON, &[48, 0, 99, 1, 2])), None);
    assert_eq!(format(&final_record(NOON, &[])), None);
    // A trailer by chance at the end of the first record, and none thereafter.
    let mut chance = BLOCKS[0].repeat(2000);
    chance[..12].copy_from_slice(&[48, 0, 12, 0x80, 0, 0, 0, 0, 48, 0, 8, 0x80]);
    chance[12..16].copy_from_slice(&[48, 0, 4, 0x80]);
    let length = 48 * 256;
    chance[length - 8..length].copy_from_slice(&[48, 0, 8, 0xFF, 0xA5, 0xA5, 0xA5, 0xA5]);
    assert_eq!(format(&chance), Some(CaptureFormat::Raw));
}

proptest! {
    #[test]
    fn mutations_split_anywhere_never_panic_and_change_nothing(
        step in 0_usize..80,
        noise in prop::collection::vec(any::<u8>(), 0..100),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..3),
    ) {
        let mut octets = [three_records(), noise].concat();
        for (place, octet) in changes {
            let place = 20 + place.index(octets.len() - 20);
            octets[place] = octet;
        }
        let (mut at_once, mut in_steps) = (open(&octets).unwrap(), open_in_steps(&octets, step).unwrap());
        let (expected, damage) = read(&octets, &mut at_once);
        let (datagrams, same_damage) = read(&octets, &mut in_steps);
        prop_assert_eq!(datagrams, expected);
        prop_assert_eq!(damage.map(|error| error.to_string()), same_damage.map(|error| error.to_string()));
        prop_assert_eq!(at_once.consumed(), in_steps.consumed());
    }
}
