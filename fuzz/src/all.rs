//! Random octets as a block of any category and edition, read by its definition.

#![allow(dead_code, unreachable_pub, reason = "the target and the tests use a part of it each")]

use std::sync::LazyLock;

use asterix::all::{Category, Definition, categories};
use asterix::{Block, Fspec};

/// Length of CAT and LEN, in octets.
const HEADER: usize = 3;

/// Every edition, with the newest reserved expansion field.
static DEFINITIONS: LazyLock<Vec<&'static Definition>> = LazyLock::new(|| {
    let editions =
        |of: &'static Category| of.editions().iter().filter_map(|edition| of.edition(edition).ok());
    categories().flat_map(editions).collect()
});

/// The first octet selects the edition; the rest is read. Checks that records and their items are contiguous, and that a fault
/// comes last and has its place.
pub fn exercise(data: &[u8]) {
    let Some((chosen, contents)) = data.split_first() else { return };
    let definition = DEFINITIONS[usize::from(*chosen) % DEFINITIONS.len()];
    let octets = [&[definition.category(), 0, 0], contents].concat();
    let block = Block { category: definition.category(), offset: 0, octets: &octets };
    let (mut next, mut whole) = (HEADER, true);
    for located in definition.records(block) {
        assert!(whole, "something came after a fault");
        match located {
            Ok(located) => {
                let record = located.record;
                assert_eq!((located.offset, located.length), (next, record.octets().len()));
                assert_eq!(record.octets(), &octets[next..next + located.length]);
                next += located.length;
                let fspec = Fspec::read(record.octets()).expect("a record begins with one");
                let of_items: usize = record.items().map(|(_, octets)| octets.len()).sum();
                assert_eq!(fspec.length() + of_items, located.length);
                let _ = (record.data_source(), record.time_of_day());
            }
            Err(fault) => {
                assert_eq!(fault.category, Some(definition.category()));
                assert!((next..=octets.len()).contains(&fault.offset), "{fault}");
                whole = false;
            }
        }
    }
    assert!(!whole || next == octets.len(), "octets were left over");
}
