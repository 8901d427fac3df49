//! Every value of every item of one to three octets: what is complete is decoded and comes back, anything else is refused.
//!
//! `cargo test --workspace --features full --test exhaustive -- --ignored` tries all values, in four minutes. The usual run tries
//! one of 16 beginnings of three octets.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

use utm_asterix::cat021::Edition;
use utm_asterix::{
    Fspec, Layout, Record, UapItem, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129,
    octets_of,
};

/// Number of octets up to which all values are tried.
const OCTETS: usize = 3;

/// A record with one item, in a block.
struct Trial<R: Record> {
    edition: R::Edition,
    item: &'static UapItem,
    /// The block; its length is adapted to the octets of the item.
    block: Vec<u8>,
    /// Index of the first octet of the item in the block.
    start: usize,
    encoded: Vec<u8>,
    /// A third octet completes one beginning of two octets in this number.
    step: usize,
    /// Number of complete values.
    accepted: u64,
}

impl<R: Record<Edition: Copy>> Trial<R> {
    fn new(edition: R::Edition, item: &'static UapItem, step: usize) -> Self {
        let mut present = [false; 7 * Fspec::MAX_OCTETS];
        present[usize::from(item.frn) - 1] = true;
        let mut block = vec![R::CATEGORY, 0, 0];
        Fspec::of(present, 0).encode_into(&mut block);
        let start = block.len();
        Self { edition, item, block, start, encoded: Vec::new(), step, accepted: 0 }
    }

    /// Tries these octets and, while they are too few, all that begin with them.
    fn explore(&mut self, octets: &mut Vec<u8>) {
        match self.item.layout.measure(octets) {
            Ok(length) if length == octets.len() => {
                self.comes_back(octets);
                self.accepted += 1;
            }
            // The rest would be another record.
            Ok(_) => {}
            Err(_) => {
                self.is_refused(octets);
                if self.goes_on(octets) {
                    for next in 0..=u8::MAX {
                        octets.push(next);
                        self.explore(octets);
                        octets.pop();
                    }
                }
            }
        }
    }

    /// Whether further octets are tried after these.
    fn goes_on(&self, octets: &[u8]) -> bool {
        match (self.item.layout, octets) {
            (Layout::Fields(fields), _) if octets_of(fields) > OCTETS => false,
            (_, &[first, second]) => (usize::from(first) * 17 + usize::from(second)) % self.step == 0,
            _ => octets.len() < OCTETS,
        }
    }

    fn put(&mut self, octets: &[u8]) {
        self.block.truncate(self.start);
        self.block.extend_from_slice(octets);
        self.block[2] = self.block.len() as u8;
    }

    fn comes_back(&mut self, octets: &[u8]) {
        self.put(octets);
        let block = blocks(&self.block).next().unwrap().unwrap();
        let mut records = block.records_in::<R>(self.edition);
        let record = records
            .next()
            .unwrap()
            .unwrap_or_else(|fault| panic!("{}: {octets:02x?}: {fault}", self.place()));
        assert!(records.next().is_none(), "{}: {octets:02x?}", self.place());
        self.encoded.clear();
        record.record.encode_into(&mut self.encoded);
        assert_eq!(self.encoded, self.block[3..], "{}", self.place());
    }

    fn is_refused(&mut self, octets: &[u8]) {
        self.put(octets);
        let block = blocks(&self.block).next().unwrap().unwrap();
        let first = block.records_in::<R>(self.edition).next().unwrap();
        assert!(first.is_err(), "{}: {octets:02x?}", self.place());
    }

    fn place(&self) -> String {
        format!("I{:03}/{}", R::CATEGORY, self.item.item)
    }
}

/// Tries all items of a category. Returns the number of complete values.
fn complete_values<R: Record<Edition: Copy>>(edition: R::Edition, step: usize) -> u64 {
    let of_items = R::profile(edition).iter().map(|item| {
        let mut trial = Trial::<R>::new(edition, item, step);
        trial.explore(&mut Vec::new());
        trial.accepted
    });
    of_items.sum()
}

fn of_all_categories(step: usize) -> u64 {
    [
        complete_values::<cat015::Record>((), step),
        complete_values::<cat021::Record>(Edition::V2_1, step),
        complete_values::<cat021::Record>(Edition::V2_7, step),
        complete_values::<cat034::Record>((), step),
        complete_values::<cat048::Record>((), step),
        complete_values::<cat062::Record>((), step),
        complete_values::<cat063::Record>((), step),
        complete_values::<cat065::Record>((), step),
        complete_values::<cat129::Record>((), step),
    ]
    .iter()
    .sum()
}

#[test]
fn short_items_come_back_or_are_refused() {
    let count = of_all_categories(16);
    assert!(count > 25_000_000, "{count} values");
}

#[test]
#[ignore = "takes four minutes"]
fn all_short_items_come_back_or_are_refused() {
    let count = of_all_categories(1);
    println!("{count} values");
    assert!(count > 400_000_000, "{count} values");
}
