//! Records of any category compared with records of a known category.

use std::fmt::Debug;

use utm_asterix::cat021::Edition;
use utm_asterix::{AnyRecord, Block, Located, Record};

/// Decodes a block of `R` in both ways: records, fault and places must agree, and encoding must restore the octets. Returns the
/// number of records.
pub fn compare<R>(block: &Block<'_>, edition: R::Edition, cat021: Edition) -> usize
where
    R: Record + Into<AnyRecord> + Debug,
{
    let mut any = block.any_records(cat021).expect("the category has types");
    let (mut count, mut octets) = (0, Vec::new());
    for typed in block.records_in::<R>(edition) {
        let read = any.next().expect("as many records");
        let (typed, read) = match (typed, read) {
            (Ok(typed), Ok(read)) => (typed, read),
            (typed, read) => {
                assert_eq!(read.map(drop), typed.map(drop));
                continue;
            }
        };
        count += 1;
        let record = &read.record;
        assert_eq!((read.offset, read.length), (typed.offset, typed.length));
        assert_eq!(record.category(), block.category);
        assert_eq!(record.data_source(), typed.record.data_source());
        assert_eq!(record.time_of_day(), typed.record.time_of_day());
        assert_eq!(record.fspec(), typed.record.fspec());
        octets.clear();
        record.encode_into(&mut octets);
        let Located { offset, length, record: typed } = typed;
        assert_eq!(octets, block.octets[offset - block.offset..][..length]);
        assert_eq!(read.record, typed.into());
    }
    assert!(any.next().is_none());
    count
}
