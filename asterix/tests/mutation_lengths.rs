//! Randomly damaged blocks of CAT015, CAT021, CAT062 and CAT063: the crate and a strict hand-written parser find the same
//! records, and decoded records are restored. `UTM_FUSION_MUTATIONS` is the number of blocks of each category.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;
#[path = "common/damage.rs"]
mod damaging;
#[path = "common/lengths.rs"]
#[rustfmt::skip]
mod lengths;

use common::recordings::shared_data;
use common::strategies::record_octets;
use common::{block, encode};
use damaging::{Random, damage};
use lengths::{CAT015, CAT021, CAT062, CAT063, Length, SURFACE_2_1};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use utm_asterix::cat021::Edition;
use utm_asterix::{Block, Record, blocks, cat015, cat021, cat062, cat063};

/// Valid blocks: of random records, and real ones if available.
fn sound_blocks<R: Record>(edition: R::Edition) -> Vec<Vec<u8>> {
    let strategy = record_octets(R::profile(edition));
    let mut runner = TestRunner::deterministic();
    let mut record = || strategy.new_tree(&mut runner).unwrap().current();
    let mut sound: Vec<Vec<u8>> =
        (0..200).map(|_| block(R::CATEGORY, &[record(), record()].concat())).collect();
    let real = ["cat021-barcelona/capture.ast", "cat062-system-track/capture.ast"];
    for octets in
        shared_data().iter().flat_map(|folder| real.map(|file| std::fs::read(folder.join(file)).unwrap()))
    {
        let of_category = blocks(&octets).flatten().filter(|block| block.category == R::CATEGORY);
        sound.extend(of_category.take(500).map(|block| block.octets.to_vec()));
    }
    sound
}

/// Decodes a block in both ways. Returns the number of records, and whether the last one is refused.
fn compare<R: Record>(block: &Block<'_>, edition: R::Edition, items: &[Length]) -> (usize, bool) {
    let mut rest = block.contents();
    let mut records = block.records_in::<R>(edition);
    let mut count = 0;
    while !rest.is_empty() {
        match (records.next(), lengths::record(items, rest)) {
            (Some(Ok(located)), Some(length)) => {
                assert_eq!(located.length, length);
                assert_eq!(encode(&located.record), rest[..length]);
                rest = &rest[length..];
                count += 1;
            }
            (Some(Err(_)), None) => {
                assert!(records.next().is_none());
                return (count, true);
            }
            (ours, by_hand) => {
                panic!("{:?}, but by hand {by_hand:?}, of {rest:02x?}", ours.map(|ours| ours.map(drop)))
            }
        }
    }
    assert!(records.next().is_none());
    (count, false)
}

fn damaged_blocks<R: Record>(edition: R::Edition, items: &[Length]) {
    let wanted = std::env::var("UTM_FUSION_MUTATIONS").map_or(20_000, |count| count.parse().unwrap());
    let sound = sound_blocks::<R>(edition);
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut read, mut refused) = (0, 0);
    for _ in 0..wanted {
        let mut octets = sound[random.below(sound.len())].clone();
        let other = &sound[random.below(sound.len())];
        for _ in 0..=random.below(4) {
            damage(&mut octets, other, &mut random);
        }
        let octets = block(R::CATEGORY, octets.get(3..).unwrap_or_default());
        let (records, ends_badly) = compare::<R>(&blocks(&octets).next().unwrap().unwrap(), edition, items);
        read += records;
        refused += usize::from(ends_badly);
    }
    eprintln!("CAT{:03}: {wanted} blocks, {read} records read, {refused} refused", R::CATEGORY);
    assert!(read > wanted / 8 && refused > wanted / 8);
}

#[test]
fn cat015() {
    damaged_blocks::<cat015::Record>((), &CAT015);
}

#[test]
fn cat021() {
    damaged_blocks::<cat021::Record>(Edition::V2_7, &CAT021);
}

#[test]
fn cat021_in_edition_2_1() {
    let mut items = CAT021;
    items[36] = SURFACE_2_1;
    damaged_blocks::<cat021::Record>(Edition::V2_1, &items);
}

#[test]
fn cat062() {
    damaged_blocks::<cat062::Record>((), &CAT062);
}

#[test]
fn cat063() {
    damaged_blocks::<cat063::Record>((), &CAT063);
}
