//! Properties over octets: what is read is written back, and what is not whole is not read.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use asterix::cat048::ReservedExpansion;
use asterix::{Explicit, Record, blocks, cat034, cat048, cat065, cat129};
use common::strategies::{expansion_octets, record_octets};
use common::{block, encode, read};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

/// The octets are one whole record, and it encodes to the same octets.
fn comes_back<R: Record<Edition: Default>>(contents: &[u8]) {
    let (records, fault) = read::<R>(&block(R::CATEGORY, contents));
    assert_eq!((records.len(), fault), (1, None));
    assert_eq!(encode(&records[0]), contents);
}

/// A record without its last octets is a fault, and its profile finds the same fault as its reader.
fn cut_is_refused<R: Record<Edition: Default>>(contents: &[u8], cut: Index) {
    let block = block(R::CATEGORY, &contents[..cut.index(contents.len())]);
    let (records, fault) = read::<R>(&block);
    assert!(records.is_empty());
    assert_eq!(fault.is_some(), block.len() > 3);
    let measured = blocks(&block).flatten().next().map(|block| block.measure(R::UAP));
    assert_eq!(measured, Some(fault.map_or(Ok(0), Err)));
}

/// Of any octets, what is read encodes to the same octets.
fn what_is_read_comes_back<R: Record<Edition: Default>>(contents: &[u8]) {
    let (records, _) = read::<R>(&block(R::CATEGORY, contents));
    let encoded: Vec<u8> = records.iter().flat_map(encode).collect();
    assert!(contents.starts_with(&encoded));
}

proptest! {
    #[test]
    fn whole_records_of_cat034(contents in record_octets(cat034::UAP)) {
        comes_back::<cat034::Record>(&contents);
    }

    #[test]
    fn whole_records_of_cat048(contents in record_octets(cat048::UAP)) {
        comes_back::<cat048::Record>(&contents);
    }

    #[test]
    fn whole_records_of_cat065(contents in record_octets(cat065::UAP)) {
        comes_back::<cat065::Record>(&contents);
    }

    #[test]
    fn whole_records_of_cat129(contents in record_octets(cat129::UAP)) {
        comes_back::<cat129::Record>(&contents);
    }

    #[test]
    fn records_of_cat034_cut_anywhere(contents in record_octets(cat034::UAP), cut in any::<Index>()) {
        cut_is_refused::<cat034::Record>(&contents, cut);
    }

    #[test]
    fn records_of_cat048_cut_anywhere(contents in record_octets(cat048::UAP), cut in any::<Index>()) {
        cut_is_refused::<cat048::Record>(&contents, cut);
    }

    #[test]
    fn records_of_cat065_cut_anywhere(contents in record_octets(cat065::UAP), cut in any::<Index>()) {
        cut_is_refused::<cat065::Record>(&contents, cut);
    }

    #[test]
    fn expansions_come_back(octets in expansion_octets(ReservedExpansion::SUBFIELDS)) {
        let field = Explicit::new(&octets[1..]).expect("at most 254 octets");
        let read = ReservedExpansion::read(&field).expect("it is whole");
        prop_assert_eq!(read.to_field(), Some(field));
    }

    #[test]
    fn expansions_cut_anywhere(octets in expansion_octets(ReservedExpansion::SUBFIELDS), cut in any::<Index>()) {
        let field = Explicit::new(&octets[1..1 + cut.index(octets.len() - 1)]).expect("at most 254 octets");
        prop_assert_eq!(ReservedExpansion::read(&field), None);
    }

    #[test]
    fn arbitrary_octets(contents in vec(any::<u8>(), 0..200)) {
        what_is_read_comes_back::<cat034::Record>(&contents);
        what_is_read_comes_back::<cat048::Record>(&contents);
        what_is_read_comes_back::<cat065::Record>(&contents);
        what_is_read_comes_back::<cat129::Record>(&contents);
        for block in blocks(&contents).flatten() {
            prop_assert_eq!(block.octets, &contents[block.offset..block.offset + block.octets.len()]);
        }
    }

    #[test]
    fn arbitrary_expansions(contents in vec(any::<u8>(), 0..=254)) {
        let field = Explicit::new(&contents).expect("at most 254 octets");
        if let Some(read) = ReservedExpansion::read(&field) {
            prop_assert_eq!(read.to_field(), Some(field));
        }
    }
}
