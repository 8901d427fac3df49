//! Index of all positions of the last half hour by their octets.
//!
//! Hash chains through a ring: a table has the newest report of each bucket, and each report links to the previous one
//! in its bucket. It takes 24 octets a report and 4 MiB for the table. A lookup takes at most [`WALK_MAX`] steps for
//! any input.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::time::Time;

/// Reports in a block; blocks are added and removed as a whole.
const BLOCK: usize = 4096;
/// Maximum number of blocks: 3.7 million reports, which are 2,000 transponders for half an hour at one report a second.
const BLOCKS_MAX: usize = 900;
/// Number of buckets, a power of two.
const BUCKETS: usize = 1 << 20;
/// Maximum number of steps through a bucket, which contains 3.5 reports if all blocks are full.
const WALK_MAX: usize = 48;

/// Position (hash), time and stream of a report.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct PlaceEntry {
    key: u64,
    time: Time,
    stream: u32,
    /// Number of the previous report in its bucket.
    before: u32,
}

/// A report at the same position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EarlierReport {
    pub(super) stream: u32,
    pub(super) time: Time,
}

/// The positions, in order of insertion.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct ReportPlaces {
    /// Number of the newest report, by bucket.
    buckets: Vec<u32>,
    /// All blocks are full except the last.
    blocks: VecDeque<Vec<PlaceEntry>>,
    /// Empty blocks for reuse.
    spare: Vec<Vec<PlaceEntry>>,
    /// Number of the first report of the first block. Numbers wrap around after 2³².
    first: u32,
}

impl ReportPlaces {
    /// Adds a position.
    pub(super) fn insert(&mut self, place: [u64; 3], stream: u32, time: Time) {
        let key = mixed(place);
        if self.buckets.is_empty() {
            self.buckets = vec![0; BUCKETS];
        }
        if self.blocks.back().is_none_or(|block| block.len() == BLOCK) {
            if self.blocks.len() == BLOCKS_MAX {
                self.drop_block();
            }
            let block = self.spare.pop().unwrap_or_else(|| Vec::with_capacity(BLOCK));
            self.blocks.push_back(block);
        }
        let number = self.first.wrapping_add(self.len());
        let before = std::mem::replace(&mut self.buckets[bucket(key)], number);
        if let Some(block) = self.blocks.back_mut() {
            block.push(PlaceEntry { key, time, stream, before });
        }
    }

    /// The reports at that position, the last inserted first.
    pub(super) fn reports_at(&self, place: [u64; 3]) -> impl Iterator<Item = EarlierReport> {
        let key = mixed(place);
        let end = self.first.wrapping_add(self.len());
        let mut number = self.buckets.get(bucket(key)).copied();
        // A number that is younger than its successor has wrapped around.
        let mut age = 0;
        let walk = std::iter::from_fn(move || {
            let at = end.wrapping_sub(number?);
            let entry = (at > age).then(|| self.entry(at)).flatten()?;
            (age, number) = (at, Some(entry.before));
            Some(entry)
        });
        let same = walk.take(WALK_MAX).filter(move |entry| entry.key == key);
        same.map(|entry| EarlierReport { stream: entry.stream, time: entry.time })
    }

    /// Removes positions from before `time`, in whole blocks.
    pub(super) fn forget_before(&mut self, time: Time) {
        let is_old = |block: &Vec<PlaceEntry>| block.len() == BLOCK && block[BLOCK - 1].time < time;
        while self.blocks.front().is_some_and(is_old) {
            self.drop_block();
        }
    }

    fn drop_block(&mut self) {
        if let Some(mut block) = self.blocks.pop_front() {
            self.first = self.first.wrapping_add(block.len() as u32);
            block.clear();
            self.spare.push(block);
        }
    }

    fn len(&self) -> u32 {
        let full = self.blocks.len().saturating_sub(1) * BLOCK;
        (full + self.blocks.back().map_or(0, Vec::len)) as u32
    }

    /// The report after which `age` - 1 others were inserted.
    fn entry(&self, age: u32) -> Option<PlaceEntry> {
        let at = self.len().checked_sub(age)? as usize;
        self.blocks.get(at / BLOCK)?.get(at % BLOCK).copied()
    }
}

/// Hashes three numbers so that each bit counts (steps of Steele's SplitMix64).
fn mixed(place: [u64; 3]) -> u64 {
    place.into_iter().fold(0, |mixed: u64, part| {
        let mut z = (mixed ^ part).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}

fn bucket(key: u64) -> usize {
    key as usize & (BUCKETS - 1)
}
