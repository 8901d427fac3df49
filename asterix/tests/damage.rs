//! Damaged octets cause no panic and yield no incomplete record.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{VECTORS, block, encode, hex, read};
use utm_asterix::cat048::ReservedExpansion;
use utm_asterix::{Explicit, Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129};

/// Decodes everything; a block without a fault must encode to the same octets.
fn survey(datagram: &[u8]) -> usize {
    fn records<R: Record<Edition: Default>>(block: &utm_asterix::Block<'_>) -> usize {
        let (records, fault) = common::read_block::<R>(block);
        let encoded: Vec<u8> = records.iter().flat_map(encode).collect();
        assert!(block.contents().starts_with(&encoded));
        assert_eq!(fault.is_none(), encoded.len() == block.contents().len());
        // Profile and decoder agree on complete records, except that only the decoder knows the length of I129/120.
        if R::CATEGORY != cat129::Record::CATEGORY {
            assert_eq!(block.measure(R::UAP), fault.map_or(Ok(records.len()), Err));
        }
        if let Some(fault) = fault {
            assert_eq!(fault.category, Some(R::CATEGORY));
            let end = block.offset + block.octets.len();
            assert!((block.offset + 3 + encoded.len()..=end).contains(&fault.offset), "{fault}");
        }
        records.len()
    }
    blocks(datagram)
        .flatten()
        .map(|block| match block.category {
            15 => records::<cat015::Record>(&block),
            21 => records::<cat021::Record>(&block),
            34 => records::<cat034::Record>(&block),
            48 => records::<cat048::Record>(&block),
            62 => records::<cat062::Record>(&block),
            63 => records::<cat063::Record>(&block),
            65 => records::<cat065::Record>(&block),
            129 => records::<cat129::Record>(&block),
            _ => 0,
        })
        .sum()
}

#[test]
fn datagram_cut_at_every_length() {
    for vector in VECTORS.map(hex) {
        assert_eq!(survey(&vector), 1);
        for length in 0..vector.len() {
            assert_eq!(survey(&vector[..length]), 0, "a block cut to {length} octets");
            assert!(blocks(&vector[..length]).all(|block| block.is_err()));
        }
    }
}

#[test]
fn record_cut_at_every_length() {
    for vector in VECTORS.map(hex) {
        for length in 1..vector.len() - 3 {
            // LEN is the actual length, so the block is valid and its record is not.
            assert_eq!(
                survey(&block(vector[0], &vector[3..3 + length])),
                0,
                "a record cut to {length} octets"
            );
        }
    }
}

#[test]
fn second_record_cut_at_every_length() {
    for vector in VECTORS.map(hex) {
        let contents = &vector[3..];
        for length in 0..contents.len() {
            let both = block(vector[0], &[contents, &contents[..length]].concat());
            assert_eq!(survey(&both), 1);
        }
    }
}

#[test]
fn every_octet_set_to_every_value() {
    for mut vector in VECTORS.map(hex) {
        for index in 0..vector.len() {
            let original = vector[index];
            for value in 0..=u8::MAX {
                vector[index] = value;
                survey(&vector);
            }
            vector[index] = original;
        }
    }
}

#[test]
fn every_octet_removed_or_doubled() {
    for vector in VECTORS.map(hex) {
        let contents = &vector[3..];
        for index in 0..contents.len() {
            survey(&block(vector[0], &[&contents[..index], &contents[index + 1..]].concat()));
            survey(&block(vector[0], &[&contents[..=index], &contents[index..]].concat()));
        }
    }
}

/// A complete reserved expansion field is decoded and restores its octets.
#[test]
fn expansion_with_every_octet_set_to_every_value() {
    let vector = hex(common::EXPANSION);
    let mut contents = vector[3 + 4 + 2 + 1..].to_vec();
    for length in 0..contents.len() {
        assert_eq!(ReservedExpansion::read(&Explicit::new(&contents[..length]).unwrap()), None);
    }
    for index in 0..contents.len() {
        let original = contents[index];
        for value in 0..=u8::MAX {
            contents[index] = value;
            let field = Explicit::new(&contents).unwrap();
            if let Some(read) = ReservedExpansion::read(&field) {
                assert_eq!(read.to_field(), Some(field));
            }
        }
        contents[index] = original;
    }
}

#[test]
fn faults_name_the_item() {
    // Truncated within I048/240 of the record with every item.
    let vector = hex(common::EVERY_ITEM);
    let (_, fault) = read::<cat048::Record>(&block(48, &vector[3..36]));
    let fault = fault.unwrap();
    assert_eq!((fault.item, fault.offset), (Some("240"), 3 + 30));
    assert_eq!(fault.kind.name(), "item_past_end");
    assert_eq!(fault.to_string(), "CAT048 item 240 at octet 33: the item runs past the end of its block");
}
