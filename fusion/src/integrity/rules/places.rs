//! All places of the last half hour, to be found by their octets.
//!
//! Chains through a ring: a table has the newest report of each bucket, each report the one before it in its bucket. 24
//! octets a report and 4 MiB beside; a look costs at most [`WALK_MAX`] steps, whatever was sent.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::time::Time;

/// Reports in a block: blocks come and go whole.
const BLOCK: usize = 4096;
/// Blocks that are kept: 3.7 million reports, 2,000 transponders for half an hour at one a second.
const BLOCKS_MAX: usize = 900;
/// Buckets, a power of two.
const BUCKETS: usize = 1 << 20;
/// Steps through a bucket, which holds 3.5 reports where all are full.
const WALK_MAX: usize = 48;

/// A report's place, when, and whose.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Entry {
    key: u64,
    time: Time,
    stream: u32,
    /// The report before it in its bucket, by its number.
    before: u32,
}

/// A report at the same place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    pub(super) stream: u32,
    pub(super) time: Time,
}

/// The places, in the order in which they came.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Places {
    /// By bucket, the number of its newest report.
    buckets: Vec<u32>,
    /// All full but the last.
    blocks: VecDeque<Vec<Entry>>,
    /// Emptied blocks to fill again.
    spare: Vec<Vec<Entry>>,
    /// Number of the first report of the first block. Numbers begin again after 2³².
    first: u32,
}

impl Places {
    /// Keeps a place.
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
            block.push(Entry { key, time, stream, before });
        }
    }

    /// The reports at that place, the last to come first.
    pub(super) fn seen(&self, place: [u64; 3]) -> impl Iterator<Item = Seen> {
        let key = mixed(place);
        let end = self.first.wrapping_add(self.len());
        let mut number = self.buckets.get(bucket(key)).copied();
        // What is younger than the one before it is a number that has come again.
        let mut age = 0;
        let walk = std::iter::from_fn(move || {
            let at = end.wrapping_sub(number?);
            let entry = (at > age).then(|| self.entry(at)).flatten()?;
            (age, number) = (at, Some(entry.before));
            Some(entry)
        });
        let same = walk.take(WALK_MAX).filter(move |entry| entry.key == key);
        same.map(|entry| Seen { stream: entry.stream, time: entry.time })
    }

    /// Forgets places from before `time`, a block at a time.
    pub(super) fn forget_before(&mut self, time: Time) {
        let is_old = |block: &Vec<Entry>| block.len() == BLOCK && block[BLOCK - 1].time < time;
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

    /// The report that so many have come since, itself included.
    fn entry(&self, age: u32) -> Option<Entry> {
        let at = self.len().checked_sub(age)? as usize;
        self.blocks.get(at / BLOCK)?.get(at % BLOCK).copied()
    }
}

/// Mixes three numbers into one in which each of their bits counts (steps of Steele's SplitMix64).
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
