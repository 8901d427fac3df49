//! Octets lost, added or zeroed in the middle of a file: everything else is read.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

use std::fs;
use std::path::Path;

use asterix::{blocks, profile};
use utm_fusion::capture::{Capture, CapturedDatagram, PayloadKind};

use crate::writer::final_record;
use crate::{open, open_in_steps, read};

/// Number of damages per file.
const DAMAGES: u64 = 100;

/// The valid blocks of a capture of the project in order.
fn sound_blocks(name: &str) -> Vec<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata").join(name).join("capture.pcap");
    let datagrams: Vec<CapturedDatagram> = Capture::open(&path).unwrap().map(Result::unwrap).collect();
    let all = datagrams.iter().flat_map(|datagram| blocks(&datagram.payload).filter_map(Result::ok));
    let is_sound =
        |block: &asterix::Block<'_>| profile(block.category).is_some_and(|uap| block.measure(uap).is_ok());
    all.filter(is_sound).map(|block| block.octets.to_vec()).collect()
}

/// An hour of a real radar, if `UTM_FUSION_SHARED_DATA` names the folder.
fn real_hour() -> Option<Vec<u8>> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA");
    if folder.is_none() {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    }
    Some(fs::read(Path::new(&folder?).join("cat048-barcelona/capture.ast")).unwrap())
}

/// Pseudo-random numbers, the same in every run (SplitMix64).
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) % limit as u64) as usize
    }
}

/// A file with 1 to 16 octets lost, added or zeroed at a random position.
struct Damaged {
    octets: Vec<u8>,
    /// Octets of the original file that are changed.
    touched: std::ops::Range<usize>,
    /// Shift of the octets after the damage.
    moved: isize,
}

fn damage(sound: &[u8], seed: u64) -> Damaged {
    let mut chance = Chance(seed);
    let count = 1 + chance.below(16);
    let at = chance.below(sound.len() - count);
    let mut octets = sound.to_vec();
    match seed % 3 {
        0 => {
            octets.drain(at..at + count);
            Damaged { octets, touched: at..at + count, moved: -(count as isize) }
        }
        1 => {
            octets.splice(at..at, (0..count).map(|_| chance.below(256) as u8));
            Damaged { octets, touched: at..at, moved: count as isize }
        }
        _ => {
            octets[at..at + count].fill(0);
            Damaged { octets, touched: at..at + count, moved: 0 }
        }
    }
}

/// Number of undamaged blocks among those at these positions of the original file, and number of these that are not read.
fn unread(sound: &[std::ops::Range<usize>], damaged: &Damaged, read: &[(usize, usize)]) -> (usize, usize) {
    let Damaged { touched, moved, .. } = damaged;
    let is_untouched =
        |block: &&std::ops::Range<usize>| block.end <= touched.start || block.start >= touched.end;
    let untouched: Vec<_> = sound.iter().filter(is_untouched).collect();
    let is_unread = |block: &&&std::ops::Range<usize>| {
        let at = block.start.wrapping_add_signed(if block.start >= touched.end { *moved } else { 0 });
        read.binary_search(&(at, block.len())).is_err()
    };
    (untouched.len(), untouched.iter().filter(is_unread).count())
}

/// Positions and lengths of the complete blocks read.
fn places(datagrams: &[CapturedDatagram]) -> Vec<(usize, usize)> {
    let framed = datagrams.iter().filter(|datagram| datagram.contents == PayloadKind::Blocks);
    let places = framed.flat_map(|datagram| {
        let whole = blocks(&datagram.payload).flatten();
        whole.map(|block| (datagram.origin as usize + block.offset, block.octets.len()))
    });
    places.collect()
}

/// Damages a file a hundred times. All its octets must be passed on, and of its undamaged blocks 999 in 1,000 must be read.
fn each_damage_costs_only_what_it_touches(name: &str, sound: &[u8], is_raw: bool) {
    let (datagrams, error) = read(sound, &mut open(sound).unwrap());
    assert!(error.is_none() && datagrams.iter().all(|datagram| datagram.contents == PayloadKind::Blocks));
    let blocks: Vec<_> = places(&datagrams).into_iter().map(|(at, length)| at..at + length).collect();
    let mut lost = 0;
    for seed in 0..DAMAGES {
        let damaged = damage(sound, seed);
        let mut capture =
            open(&damaged.octets).unwrap_or_else(|error| panic!("{name}, seed {seed}: {error}"));
        let (datagrams, error) = read(&damaged.octets, &mut capture);
        assert!(error.is_none() || !is_raw, "{name}, seed {seed}: {error:?}");
        if is_raw {
            let octets: Vec<u8> = datagrams.iter().flat_map(|datagram| datagram.payload.clone()).collect();
            assert!(octets == damaged.octets, "{name}, seed {seed}: an octet is missing");
        }
        let gaps = datagrams.iter().filter(|datagram| datagram.contents == PayloadKind::Unframed);
        let gaps: u64 = gaps.map(|datagram| datagram.payload.len() as u64).sum();
        assert_eq!(capture.gaps().octets, gaps);
        let (untouched, unread) = unread(&blocks, &damaged, &places(&datagrams));
        assert!(
            unread * 1000 <= untouched,
            "{name}, seed {seed}: {unread} of {untouched} blocks are not read"
        );
        lost += unread;
    }
    println!("{name}: of {} blocks {lost} untouched ones were not read in {DAMAGES} files", blocks.len());
}

#[test]
fn raw_files() {
    for name in ["conformance/bias", "conformance/crossing"] {
        each_damage_costs_only_what_it_touches(name, &sound_blocks(name).concat(), true);
    }
    if let Some(hour) = real_hour() {
        each_damage_costs_only_what_it_touches("a real hour", &hour, true);
    }
}

#[test]
fn final_recordings() {
    for name in ["conformance/bias", "conformance/crossing"] {
        let blocks = sound_blocks(name);
        let record =
            |(index, blocks): (usize, &[Vec<u8>])| final_record(4_320_000 + index as u32, &blocks.concat());
        let recording: Vec<u8> = blocks.chunks(2).enumerate().flat_map(record).collect();
        each_damage_costs_only_what_it_touches(name, &recording, false);
    }
}

/// Several damages in one file, read in pieces of any size with the same result.
#[test]
fn a_file_that_is_damaged_in_many_places() {
    let sound = sound_blocks("demo").concat();
    let count = blocks(&sound).count();
    let mut octets = sound.clone();
    for seed in 0..30 {
        octets = damage(&octets, seed).octets;
    }
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    // A damage affects at most two blocks of the original file, and its 16 octets may resemble another one.
    assert!(places(&datagrams).len() + 3 * 30 >= count, "{} of {count}", places(&datagrams).len());
    assert!(capture.gaps().places > 10, "{}", capture.gaps());
    assert_eq!(read(&octets, &mut open_in_steps(&octets, 1).unwrap()).0, datagrams);
}

/// A category that occurs late, blocks longer than any before, and blocks of one octet: LEN is followed.
#[test]
fn a_sound_file_is_read_as_it_is_whatever_is_in_it() {
    let block = |category: u8, length: usize, fill: u8| {
        let mut block = vec![fill; length];
        block[0] = category;
        block[1..3].copy_from_slice(&(length as u16).to_be_bytes());
        block
    };
    let mut expected = vec![block(48, 40, 0xFF); 50];
    for (category, fill) in (1..=255).zip((0..=255).cycle().step_by(7)) {
        expected.push(block(category, 4 + usize::from(category), fill));
        expected.push(block(48, 40, 0xFF));
        expected.push(block(category, 10 * (4 + usize::from(category)), fill));
        expected.push(block(category, 3, 0));
    }
    expected.extend([block(240, 65_535, 48), block(240, 3, 0), block(7, 65_535, 0)]);
    let octets = expected.concat();
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none() && capture.gaps().is_empty(), "{}", capture.gaps());
    assert!(datagrams.iter().map(|datagram| &datagram.payload).eq(&expected));
}

#[test]
fn a_long_stretch_without_blocks_is_handed_out_in_parts() {
    let sound = sound_blocks("demo");
    let hole = vec![0; 300_000];
    let octets = [&sound[..100].concat(), &hole, &sound[100..].concat()].map(Vec::as_slice).concat();
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(places(&datagrams).len(), sound.len());
    assert_eq!(
        capture.gaps().to_string(),
        format!("300000 octets in 1 place (at offset {})", sound[..100].concat().len())
    );
    assert!(datagrams.iter().all(|datagram| datagram.payload.len() <= 65_535));
}
