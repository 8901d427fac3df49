//! Blocks of any category with types are decoded like blocks of a known category.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;
#[path = "common/any.rs"]
mod either;

use std::fmt::Debug;

use common::strategies::record_octets;
use common::{block, hex};
use proptest::prelude::*;
use utm_asterix::cat021::Edition;
use utm_asterix::{
    AnyRecord, FaultKind, Record, UapItem, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065,
    cat129, profile,
};

#[test]
fn every_category_with_a_profile_is_one_and_no_other() {
    let known: Vec<u8> = (0..=u8::MAX).filter(|&category| profile(category).is_some()).collect();
    assert_eq!(AnyRecord::CATEGORIES, known);
    for category in 0..=u8::MAX {
        let octets = [category, 0, 3];
        let block = blocks(&octets).next().unwrap().unwrap();
        let records = block.any_records(Edition::V2_7);
        assert_eq!(records.map(Iterator::count), known.contains(&category).then_some(0));
    }
}

/// The record is so large that a program which needs one category should use that category's type.
#[test]
fn any_record_is_as_large_as_the_largest() {
    let (any, largest) = (size_of::<AnyRecord>(), size_of::<cat062::Record>());
    println!("octets in memory: any {any}, CAT062 {largest}, CAT048 {}", size_of::<cat048::Record>());
    assert!((largest..=largest + size_of::<usize>()).contains(&any));
}

/// I021/271 with two octets, the second of which has an FX bit from edition 2.2 on.
#[test]
fn cat021_is_read_in_the_edition_that_is_given() {
    let octets = block(21, &hex("01 01 01 01 01 40  01 01"));
    let block = blocks(&octets).next().unwrap().unwrap();
    let read = |edition| block.any_records(edition).unwrap().map(|located| located.map(drop)).next().unwrap();
    assert_eq!(read(Edition::V2_1), Ok(()));
    assert_eq!(
        read(Edition::V2_2).map_err(|fault| (fault.item, fault.kind)),
        Err((Some("271"), FaultKind::ItemPastEnd))
    );
}

/// Complete records of a profile, and truncated ones.
fn any_of<R>(edition: R::Edition, cat021: Edition, uap: &'static [UapItem])
where
    R: Record + Into<AnyRecord> + Debug,
{
    let contents = (record_octets(uap), any::<prop::sample::Index>());
    let mut runner = proptest::test_runner::TestRunner::default();
    let run = runner.run(&contents, |(contents, cut)| {
        let whole = block(R::CATEGORY, &contents);
        let short = block(R::CATEGORY, &contents[..cut.index(contents.len())]);
        let compare =
            |octets: &[u8]| either::compare::<R>(&blocks(octets).next().unwrap().unwrap(), edition, cat021);
        prop_assert_eq!(compare(&whole), 1);
        compare(&short);
        Ok(())
    });
    run.unwrap();
}

#[test]
fn records_are_those_of_their_category() {
    fn of<R: Record<Edition = ()> + Into<AnyRecord> + Debug>() {
        any_of::<R>((), Edition::default(), R::UAP);
    }
    of::<cat015::Record>();
    of::<cat034::Record>();
    of::<cat048::Record>();
    of::<cat062::Record>();
    of::<cat063::Record>();
    of::<cat065::Record>();
    of::<cat129::Record>();
    for edition in Edition::ALL {
        any_of::<cat021::Record>(edition, edition, edition.profile());
    }
}
