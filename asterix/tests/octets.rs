//! Properties of octets: decoded records are restored, and incomplete ones are not decoded.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::strategies::{expansion_octets, record_octets};
use common::{block, encode, read_in};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use utm_asterix::cat021::Edition;
use utm_asterix::{Explicit, Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129};

/// The octets are one complete record, which encodes to the same octets.
fn comes_back<R: Record>(edition: R::Edition, contents: &[u8]) {
    let (records, fault) = read_in::<R>(edition, &block(R::CATEGORY, contents));
    assert_eq!((records.len(), fault), (1, None));
    assert_eq!(encode(&records[0]), contents);
}

/// A record without its last octets is a fault, and its profile finds the same fault as its decoder.
fn cut_is_refused<R: Record>(edition: R::Edition, contents: &[u8], cut: Index) {
    let block = block(R::CATEGORY, &contents[..cut.index(contents.len())]);
    let (records, fault) = read_in::<R>(edition, &block);
    assert!(records.is_empty());
    assert_eq!(fault.is_some(), block.len() > 3);
    let measured = blocks(&block).flatten().next().map(|block| block.measure(R::profile(edition)));
    assert_eq!(measured, Some(fault.map_or(Ok(0), Err)));
}

/// Records decoded from any octets encode to the same octets.
fn what_is_read_comes_back<R: Record>(edition: R::Edition, contents: &[u8]) {
    let (records, _) = read_in::<R>(edition, &block(R::CATEGORY, contents));
    let encoded: Vec<u8> = records.iter().flat_map(encode).collect();
    assert!(contents.starts_with(&encoded));
}

/// Complete and truncated records of a category in an edition.
macro_rules! records {
    ($($whole:ident $cut:ident $category:ident $edition:expr;)*) => {
        proptest! {$(
            #[test]
            fn $whole(contents in record_octets($category::Record::profile($edition))) {
                comes_back::<$category::Record>($edition, &contents);
            }

            #[test]
            fn $cut(contents in record_octets($category::Record::profile($edition)), cut in any::<Index>()) {
                cut_is_refused::<$category::Record>($edition, &contents, cut);
            }
        )*}
    };
}

records! {
    whole_records_of_cat015 records_of_cat015_cut_anywhere cat015 ();
    whole_records_of_cat021 records_of_cat021_cut_anywhere cat021 Edition::V2_7;
    whole_records_of_cat021_2_1 records_of_cat021_2_1_cut_anywhere cat021 Edition::V2_1;
    whole_records_of_cat034 records_of_cat034_cut_anywhere cat034 ();
    whole_records_of_cat048 records_of_cat048_cut_anywhere cat048 ();
    whole_records_of_cat062 records_of_cat062_cut_anywhere cat062 ();
    whole_records_of_cat063 records_of_cat063_cut_anywhere cat063 ();
    whole_records_of_cat065 records_of_cat065_cut_anywhere cat065 ();
}

/// Complete, truncated and random reserved expansion fields.
macro_rules! expansions {
    ($($whole:ident $cut:ident $any:ident $category:ident;)*) => {
        proptest! {$(
            #[test]
            fn $whole(octets in expansion_octets($category::ReservedExpansion::SUBFIELDS)) {
                let field = Explicit::new(&octets[1..]).expect("at most 254 octets");
                let read = $category::ReservedExpansion::read(&field).expect("it is whole");
                prop_assert_eq!(read.to_field(), Some(field));
            }

            #[test]
            fn $cut(octets in expansion_octets($category::ReservedExpansion::SUBFIELDS), cut in any::<Index>()) {
                let octets = &octets[1..1 + cut.index(octets.len() - 1)];
                let field = Explicit::new(octets).expect("at most 254 octets");
                prop_assert_eq!($category::ReservedExpansion::read(&field), None);
            }

            #[test]
            fn $any(contents in vec(any::<u8>(), 0..=254)) {
                let field = Explicit::new(&contents).expect("at most 254 octets");
                if let Some(read) = $category::ReservedExpansion::read(&field) {
                    prop_assert_eq!(read.to_field(), Some(field));
                }
            }
        )*}
    };
}

expansions! {
    expansions_of_cat021 expansions_of_cat021_cut_anywhere any_expansions_of_cat021 cat021;
    expansions_of_cat048 expansions_of_cat048_cut_anywhere any_expansions_of_cat048 cat048;
    expansions_of_cat062 expansions_of_cat062_cut_anywhere any_expansions_of_cat062 cat062;
}

proptest! {
    #[test]
    fn whole_records_of_cat129(contents in record_octets(cat129::UAP)) {
        comes_back::<cat129::Record>((), &contents);
    }

    #[test]
    fn arbitrary_octets(contents in vec(any::<u8>(), 0..200)) {
        what_is_read_comes_back::<cat015::Record>((), &contents);
        what_is_read_comes_back::<cat021::Record>(Edition::V2_1, &contents);
        what_is_read_comes_back::<cat021::Record>(Edition::V2_7, &contents);
        what_is_read_comes_back::<cat034::Record>((), &contents);
        what_is_read_comes_back::<cat048::Record>((), &contents);
        what_is_read_comes_back::<cat062::Record>((), &contents);
        what_is_read_comes_back::<cat063::Record>((), &contents);
        what_is_read_comes_back::<cat065::Record>((), &contents);
        what_is_read_comes_back::<cat129::Record>((), &contents);
        for block in blocks(&contents).flatten() {
            prop_assert_eq!(block.octets, &contents[block.offset..block.offset + block.octets.len()]);
        }
    }
}
