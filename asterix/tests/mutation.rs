//! Randomly damaged blocks: the crate and a strict hand-written parser agree on every record.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;
#[path = "common/damage.rs"]
mod damaging;
#[path = "../benches/slice/mod.rs"]
mod slice;

use std::path::Path;

use common::recordings::datagrams;
use common::{DRONE_PLOT, EVERY_ITEM, VECTORS, block, hex};
use damaging::{Random, damage};
use slice::Malformed;
use utm_asterix::{Record, blocks, cat048};

/// Number of blocks to damage.
const BLOCKS: usize = 100_000;

/// Valid CAT048 blocks: hand-made ones and, if available, those of real radars.
fn sound_blocks() -> Vec<Vec<u8>> {
    let mut sound: Vec<Vec<u8>> = [DRONE_PLOT, EVERY_ITEM].map(hex).to_vec();
    sound.push(block(48, &[&sound[0][3..], &sound[1][3..], &sound[0][3..]].concat()));
    let Some(folder) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        eprintln!(
            "UTM_FUSION_SHARED_DATA names no folder of recordings: only blocks written by hand are damaged"
        );
        return sound;
    };
    let mut keep = |octets: &[u8]| {
        let radar = blocks(octets).flatten().filter(|block| block.category == 48);
        sound.extend(radar.map(|block| block.octets.to_vec()));
    };
    let read = |file: &str| std::fs::read(Path::new(&folder).join(file)).unwrap();
    for file in [
        "cat048-barcelona/capture.ast",
        "cat048-small/croatia_cat048.raw",
        "cat048-small/goasterix_sample.ast",
        "cat048-small/jasterix_cat048ed1.23.bin",
        "cat048-small/psr3d_nonminimal_fspec.raw",
        "drone-trial/1_1/radar.ast",
    ] {
        keep(&read(file));
    }
    for file in ["cat048-croatia/capture.pcap", "conformance/hostile/capture.pcap"] {
        datagrams(&read(file)).into_iter().for_each(|(_, datagram)| keep(datagram));
    }
    sound
}

/// Compares the values that both decoders name. The others are compared by encoding.
fn assert_same(record: &cat048::Record, by_hand: &slice::Record<'_>) {
    assert_eq!(record.data_source.map(|at| (at.sac, at.sic)), by_hand.i010.map(|at| (at.sac, at.sic)));
    assert_eq!(record.time_of_day.map(utm_asterix::TimeOfDay::count), by_hand.i140);
    assert_eq!(record.target_report.as_ref().map(|report| report.chain().octets()), by_hand.i020);
    let two_words = |first: u16, second: u16| [first.to_be_bytes(), second.to_be_bytes()].concat();
    assert_eq!(
        record.polar_position.map(|at| at.octets().to_vec()),
        by_hand.i040.map(|at| two_words(at.rho, at.theta))
    );
    assert_eq!(
        record.mode_3a.map(|it| (!it.is_validated(), it.is_garbled(), it.is_not_extracted(), it.code())),
        by_hand.i070.map(|it| (it.v, it.g, it.l, it.code))
    );
    assert_eq!(
        record.flight_level.map(|it| (!it.is_validated(), it.is_garbled(), it.flight_level())),
        by_hand.i090.map(|it| (it.v, it.g, f64::from(it.fl) / 4.0))
    );
    assert_eq!(record.aircraft_address.map(cat048::AircraftAddress::address), by_hand.i220);
    assert_eq!(
        record.aircraft_identification.map(cat048::AircraftIdentification::octets),
        by_hand.i240.map(|word| *word.to_be_bytes().last_chunk().unwrap())
    );
    assert_eq!(record.track_number.map(cat048::TrackNumber::number), by_hand.i161);
    assert_eq!(
        record.track_velocity.map(|it| it.octets().to_vec()),
        by_hand.i200.map(|it| two_words(it.gsp, it.hdg))
    );
    assert_eq!(record.track_status.as_ref().map(|status| status.chain().octets()), by_hand.i170);
    assert_eq!(record.warnings.as_ref().map(cat048::Warnings::octets), by_hand.i030);
    assert_eq!(
        record.height_3d.map(cat048::Height3D::height_ft),
        by_hand.i110.map(|count| f64::from(count) * 25.0)
    );
    assert_eq!(record.special_purpose.as_ref().map(utm_asterix::Explicit::octets), by_hand.sp);
}

/// Decodes a block in both ways. Returns the number of records, and whether the last one was refused.
fn compare(block: &utm_asterix::Block<'_>) -> (usize, bool) {
    let mut rest = block.contents();
    let mut records = block.records::<cat048::Record>();
    let mut count = 0;
    let mut again = Vec::new();
    while !rest.is_empty() {
        match (records.next(), slice::Record::parse(rest)) {
            (Some(Ok(located)), Ok((by_hand, length))) => {
                assert_eq!(located.length, length);
                assert_eq!(located.offset, block.offset + block.octets.len() - rest.len());
                again.clear();
                located.record.encode_into(&mut again);
                assert_eq!(again, rest[..length]);
                assert_same(&located.record, &by_hand);
                rest = &rest[length..];
                count += 1;
            }
            (Some(Err(_)), Err(Malformed)) => {
                assert!(records.next().is_none());
                return (count, true);
            }
            (ours, by_hand) => panic!("{ours:?}, but by hand {by_hand:?}, of {rest:02x?}"),
        }
    }
    assert!(records.next().is_none());
    (count, false)
}

#[test]
fn a_hundred_thousand_damaged_blocks() {
    let sound = sound_blocks();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut read, mut refused, mut no_blocks) = (0, 0, 0);
    for _ in 0..BLOCKS {
        let mut octets = sound[random.below(sound.len())].clone();
        let other = &sound[random.below(sound.len())];
        for _ in 0..=random.below(4) {
            damage(&mut octets, other, &mut random);
        }
        // LEN is corrected in most cases, so that the damage reaches the records.
        if octets.len() >= 3 && random.below(8) > 0 {
            octets = block(48, &octets[3..]);
        }
        for block in blocks(&octets) {
            match block {
                Ok(block) if block.category == 48 => {
                    let (records, ends_badly) = compare(&block);
                    read += records;
                    refused += usize::from(ends_badly);
                }
                Ok(_) => {}
                Err(_) => no_blocks += 1,
            }
        }
    }
    eprintln!("{read} records read, {refused} refused; {no_blocks} times no block");
    assert!(read > BLOCKS / 4 && refused > BLOCKS / 4 && no_blocks > BLOCKS / 100);
}

#[test]
fn undamaged_blocks() {
    for octets in sound_blocks() {
        let block = blocks(&octets).next().unwrap().unwrap();
        compare(&block);
    }
}

#[test]
fn octets_of_other_categories() {
    for vector in VECTORS.map(hex) {
        for start in 0..vector.len() {
            let octets = block(48, &vector[start..]);
            compare(&blocks(&octets).next().unwrap().unwrap());
        }
    }
}

/// The hand-written parser on the record with every item.
#[test]
fn the_parser_by_hand_reads_every_item() {
    let octets = hex(EVERY_ITEM);
    let (record, length) = slice::Record::parse(&octets[3..]).unwrap();
    assert_eq!(length, octets.len() - 3);
    let registers = hex("0011223344556640 0011223344556650");
    let code = |code| Some(slice::Code { v: false, g: false, l: false, code });
    let expected = slice::Record {
        i010: Some(slice::Source { sac: 20, sic: 129 }),
        i140: Some(28_800 * 128 + 64),
        i020: Some(&[0xe1, 0x80]),
        i040: Some(slice::Polar { rho: 0x30a6, theta: 0xba34 }),
        i070: Some(slice::Code { v: true, g: true, l: true, code: 0o4004 }),
        i090: Some(slice::Level { v: true, g: true, fl: -5 }),
        i130: Some(slice::Plot {
            srl: Some(0x18),
            srr: Some(4),
            sam: Some(-55),
            prl: Some(7),
            pam: Some(42),
            rpd: Some(10),
            apd: Some(-4),
        }),
        i220: Some(0x4a_08eb),
        i240: Some(0x48f5_34c7_5820),
        i250: Some(&registers),
        i161: Some(1923),
        i042: Some(slice::Cartesian { x: 256, y: -256 }),
        i200: Some(slice::Velocity { gsp: 16384, hdg: 32768 }),
        i170: Some(&[0xa7, 0x40]),
        i210: Some(slice::Quality { sigx: 1, sigy: 2, sigv: 3, sigh: 4 }),
        i030: Some(&[0x27, 0x01, 0xfe]),
        i080: Some(0x0fff),
        i100: Some(slice::ModeC { v: false, g: false, code: 0x123, confidence: 0x456 }),
        i110: Some(-2),
        i120: Some(slice::Doppler { cal: Some((true, -5)), rds: Some(&[0, 10, 0, 20, 11, 0xb8]) }),
        i230: Some(0x2cf5),
        i260: Some(&[0x30, 0, 0, 0, 0, 0, 0]),
        i055: code(0x1f),
        i050: code(0xabc),
        i065: Some(0x1f),
        i060: Some(0x0fff),
        sp: Some(&[3, 0x80, 0x7f]),
        re: Some(&[4, 1, 2, 3]),
    };
    assert_eq!(record, expected);
}

#[test]
fn the_parser_by_hand_is_strict() {
    for refused in [
        "",                                       // no FSPEC
        "ff",                                     // a FSPEC that goes on
        "010101010101010100",                     // a FSPEC of nine octets
        "0101010180",                             // FRN 29
        "0101010101010102",                       // FRN 56
        "80 01",                                  // 010 cut
        "0120",                                   // 250 without its count
        "0120 01 00112233445566",                 // 250 cut
        "02 81 01",                               // 130 extended
        "02 c0 01",                               // 130 cut
        "010104 41 00",                           // 120 extended
        "010104 20",                              // 120 with an undefined subfield
        "010104 02 00 00",                        // another
        "010104 40",                              // 120 without its count
        "20 01010101010101010101010101010101 00", // 020 of 17 octets
        "01010104 00",                            // SP of length 0
        "01010102 03 00",                         // RE cut
    ] {
        assert_eq!(slice::Record::parse(&hex(refused)), Err(Malformed), "{refused}");
    }
    for (read, length) in [
        ("00 ff", 1),
        ("0101010101010100 ff", 8),
        ("0120 00 ff", 3),
        ("010104 00 ff", 4),
        ("20 010101010101010101010101010101 00 ff", 17),
        ("01010104 01 ff", 5),
    ] {
        assert_eq!(slice::Record::parse(&hex(read)).unwrap().1, length, "{read}");
    }
}
