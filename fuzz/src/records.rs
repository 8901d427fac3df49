//! Random octets as a datagram, and as the contents of a block.

#![allow(dead_code, unreachable_pub, reason = "each target uses a part of it")]

use asterix::{Block, Fault, Record, blocks, items};

/// Length of CAT and LEN, in octets.
const HEADER: usize = 3;

/// Reads the data as records of `R`. Checks that blocks and records are contiguous, that a record encodes to the octets it was
/// read from, and that a fault comes last and has its place.
pub fn exercise<R: Record<Edition: Default>>(data: &[u8]) {
    each_block(R::CATEGORY, data, records::<R>);
}

/// Like [`exercise`]; also checks that the table of the category finds the same number of records, or the same fault. Not for
/// CAT129, because the length of one of its items is known only after the whole record.
pub fn exercise_with_table<R: Record<Edition: Default>>(data: &[u8]) {
    exercise::<R>(data);
    each_block(R::CATEGORY, data, |block| {
        let read: Result<Vec<_>, Fault> =
            block.records_in::<R>(R::Edition::default()).map(|result| result.map(drop)).collect();
        assert_eq!(block.measure(R::UAP), read.map(|records| records.len()));
    });
}

/// Calls `look` with the blocks of `category` in `data`, and with `data` without its first three octets as the contents of a
/// block, so that a changed length does not always end in a bad LEN.
fn each_block(category: u8, data: &[u8], look: impl Fn(&Block<'_>)) {
    let mut end = 0;
    let mut whole = true;
    for block in blocks(data) {
        assert!(whole, "something came after a fault");
        match block {
            Ok(block) => {
                let length = block.octets.len();
                assert_eq!((block.offset, block.octets), (end, &data[end..end + length]));
                assert_eq!(
                    (block.category, block.contents()),
                    (data[end], &data[end + HEADER..end + length])
                );
                end += length;
                if block.category == category {
                    look(&block);
                }
            }
            Err(fault) => {
                assert_eq!((fault.offset, fault.item), (end, None));
                assert!(fault.to_string().ends_with(&fault.kind.to_string()));
                whole = false;
            }
        }
    }
    assert!(!whole || end == data.len(), "octets were left over");

    if let (Some(contents), Ok(length)) = (data.get(HEADER..), u16::try_from(data.len())) {
        let [high, low] = length.to_be_bytes();
        let octets = [&[category, high, low], contents].concat();
        let block = Block { category, offset: 0, octets: &octets };
        assert!(blocks(&octets).eq([Ok(block)]));
        look(&block);
    }
}

fn records<R: Record<Edition: Default>>(block: &Block<'_>) {
    let mut rest = block.contents();
    let mut encoded = Vec::new();
    let mut whole = true;
    for result in block.records_in::<R>(R::Edition::default()) {
        assert!(whole, "something came after a fault");
        let place = block.octets.len() - rest.len();
        match result {
            Ok(located) => {
                assert_eq!(located.offset, block.offset + place);
                let (octets, after) = rest.split_at(located.length);
                encoded.clear();
                located.record.encode_into(&mut encoded);
                assert_eq!(encoded, octets);
                let length: usize = items(R::UAP, octets).map(|(_, item)| item.len()).sum();
                assert_eq!(located.record.fspec().length() + length, octets.len());
                rest = after;
            }
            Err(fault) => {
                check_fault(&fault, block, place);
                whole = false;
            }
        }
    }
    assert!(!whole || rest.is_empty(), "octets were left over");
}

/// Checks a fault of a record that begins at `place` in its block.
fn check_fault(fault: &Fault, block: &Block<'_>, place: usize) {
    assert_eq!(fault.category, Some(block.category));
    assert!((place..=block.octets.len()).contains(&(fault.offset - block.offset)), "{fault}");
    assert!(fault.to_string().ends_with(&fault.kind.to_string()));
}
