//! Track numbers of transponders: their assignment and release.

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::report::Identity;
use crate::slots::{Slot, SlotGrid};
use crate::time::Time;

/// The largest number: a fused track has number · 10000 + radar track, which must fit 32 bits.
pub const LARGEST_TRANSPONDER_NUMBER: u32 = 429_496;

/// Interval at which the `heard` of a number is updated: a value saved for a restart is at most this old.
pub const NOTED: SignedDuration = SignedDuration::from_secs(600);

/// Time after a transponder's last point at which its number is released.
const KEPT: SignedDuration = SignedDuration::from_hours(24);

/// A transponder's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Numbered {
    /// The number T.
    pub number: u32,
    /// The slot in which it was assigned: the first emitted one with a point of the transponder.
    pub since: Slot,
}

/// Assignment of a number to a transponder, as it is saved for a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Given {
    /// The number T, 1 to [`LARGEST_TRANSPONDER_NUMBER`].
    pub number: u32,
    /// The transponder.
    pub identity: Identity,
    /// Time of the transponder's last point, or up to [`NOTED`] earlier. `None`: not known, and replaced by the current
    /// time.
    pub heard: Option<Time>,
}

/// A change in the assignment of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NumberChange {
    /// The number was assigned, or its transponder has a point for the first time in [`NOTED`].
    Heard(Given),
    /// The number was released.
    Returned(Given),
}

impl NumberChange {
    /// The number and its present or former transponder.
    pub const fn given(&self) -> &Given {
        match self {
            Self::Heard(given) | Self::Returned(given) => given,
        }
    }
}

/// How long a transponder keeps its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Keeping {
    /// Permanently. If no number is left, a new transponder gets none and is omitted.
    #[default]
    ForGood,
    /// Until a day after its last point. If no number is left, a new transponder gets the number of the transponder
    /// whose last point is oldest.
    ADay,
}

/// Assignment of numbers to transponders.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Numbers {
    grid: SlotGrid,
    keeping: Keeping,
    configured: BTreeMap<Vec<u8>, u32>,
    reserved: BTreeSet<u32>,
    held: BTreeMap<Identity, NumberInUse>,
    /// The numbers in use, by the time of the transponder's last noted point, then by number.
    by_age: BTreeMap<(Time, u32), Identity>,
    taken: BTreeSet<u32>,
    /// No number below `lowest` is free for an identity without a claim; no number above `highest` is free for one
    /// without a serial number.
    lowest: u32,
    highest: u32,
    /// Restored without a time, until the first slot.
    undated: Vec<Identity>,
    changes: Vec<NumberChange>,
    /// Number of points omitted because no number was left.
    unnumbered: u64,
}

/// A number in use.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct NumberInUse {
    number: u32,
    /// `None`: no point since the start.
    since: Option<Slot>,
    heard: Time,
}

impl Numbers {
    /// Creates an empty assignment; `configured` maps trimmed serial numbers to numbers.
    pub fn new(grid: SlotGrid, keeping: Keeping, configured: BTreeMap<Vec<u8>, u32>) -> Self {
        let reserved = configured.values().copied().collect();
        Self {
            grid,
            keeping,
            configured,
            reserved,
            held: BTreeMap::new(),
            by_age: BTreeMap::new(),
            taken: BTreeSet::new(),
            lowest: 1,
            highest: LARGEST_TRANSPONDER_NUMBER,
            undated: Vec::new(),
            changes: Vec::new(),
            unnumbered: 0,
        }
    }

    /// Makes numbers permanent from now on; numbers that were released before stay released.
    pub fn keep_for_good(&mut self) {
        self.keeping = Keeping::ForGood;
    }

    /// The number of an identity that has a point in the slot being emitted. The first available of: the number it has;
    /// its configured number; its serial number, if that is a valid number; the lowest free number; with
    /// [`Keeping::ADay`], the number of the transponder whose last point is oldest. `None` if all are in use. An
    /// identity without a serial number gets the highest free number, so that it does not change the numbers of drones.
    pub fn of(&mut self, identity: Identity, slot: Slot) -> Option<Numbered> {
        let now = self.grid.open(slot);
        if let Some(held) = self.held.get_mut(&identity) {
            let since = *held.since.get_or_insert(slot);
            let number = held.number;
            if now - held.heard >= NOTED {
                self.by_age.remove(&(held.heard, number));
                held.heard = now;
                self.record(identity, number, now);
            }
            return Some(Numbered { number, since });
        }
        let free = match identity.serial() {
            Some(serial) => {
                let configured = self.configured.get(serial).copied();
                configured
                    .filter(|number| !self.taken.contains(number))
                    .or_else(|| decimal(serial).filter(|&number| self.is_free(number)))
                    .or_else(|| self.lowest_free())
            }
            None => self.highest_free(),
        };
        let number = free.or_else(|| self.evict_oldest())?;
        self.taken.insert(number);
        self.held.insert(identity, NumberInUse { number, since: Some(slot), heard: now });
        self.record(identity, number, now);
        Some(Numbered { number, since: slot })
    }

    fn record(&mut self, identity: Identity, number: u32, heard: Time) {
        self.by_age.insert((heard, number), identity);
        self.changes.push(NumberChange::Heard(Given { number, identity, heard: Some(heard) }));
    }

    /// Starts a slot: with [`Keeping::ADay`], releases the numbers of transponders without a point for a day.
    pub fn begin_slot(&mut self, slot: Slot) {
        let now = self.grid.open(slot);
        for identity in std::mem::take(&mut self.undated) {
            if let Some(held) = self.held.get_mut(&identity).filter(|held| held.since.is_none()) {
                self.by_age.remove(&(held.heard, held.number));
                held.heard = now;
                self.by_age.insert((now, held.number), identity);
            }
        }
        // The last point may be up to `NOTED` later than the noted time.
        let before = now - KEPT - NOTED;
        while self.keeping == Keeping::ADay
            && let Some((&(heard, number), _)) = self.by_age.first_key_value()
            && heard <= before
        {
            self.release((heard, number));
        }
    }

    fn release(&mut self, (heard, number): (Time, u32)) {
        if let Some(identity) = self.by_age.remove(&(heard, number)) {
            self.held.remove(&identity);
            self.taken.remove(&number);
            self.lowest = self.lowest.min(number);
            self.highest = self.highest.max(number);
            self.changes.push(NumberChange::Returned(Given { number, identity, heard: Some(heard) }));
        }
    }

    /// Releases the number of the transponder whose last point is oldest; configured numbers are kept.
    fn evict_oldest(&mut self) -> Option<u32> {
        if self.keeping == Keeping::ForGood {
            return None;
        }
        let &oldest = self.by_age.keys().find(|(_, number)| !self.reserved.contains(number))?;
        self.release(oldest);
        Some(oldest.1)
    }

    /// Restores a number that was assigned before a restart. Its identity gets it again in the first slot emitted with
    /// a point of it, which becomes its `since`. The number is kept even if the configuration now assigns that number
    /// to another transponder, or another number to that serial number.
    ///
    /// Returns `false` and changes nothing if the number is not 1 to [`LARGEST_TRANSPONDER_NUMBER`], or if it or the
    /// identity is already in use.
    pub fn remember(&mut self, given: Given) -> bool {
        let Given { number, identity, heard } = given;
        let has_one = self.held.contains_key(&identity);
        if !(1..=LARGEST_TRANSPONDER_NUMBER).contains(&number) || has_one || !self.taken.insert(number) {
            return false;
        }
        if heard.is_none() {
            self.undated.push(identity);
        }
        let heard = heard.unwrap_or_default();
        self.held.insert(identity, NumberInUse { number, since: None, heard });
        self.by_age.insert((heard, number), identity);
        true
    }

    /// Returns the changes since the last call, in order.
    pub fn take_changes(&mut self) -> Vec<NumberChange> {
        std::mem::take(&mut self.changes)
    }

    /// The changes since the last [`Numbers::take_changes`].
    pub(super) fn changes(&self) -> &[NumberChange] {
        &self.changes
    }

    /// Number of numbers in use.
    pub fn used(&self) -> usize {
        self.taken.len()
    }

    /// All assignments, by identity.
    pub fn given(&self) -> impl Iterator<Item = Given> {
        self.held.iter().map(|(&identity, held)| Given {
            number: held.number,
            identity,
            heard: Some(held.heard),
        })
    }

    /// Counts a point that is omitted because no number was left.
    pub(super) fn note_unnumbered(&mut self) {
        self.unnumbered += 1;
    }

    /// Number of points omitted because no number was left.
    pub fn unnumbered(&self) -> u64 {
        self.unnumbered
    }

    fn is_free(&self, number: u32) -> bool {
        !self.taken.contains(&number) && !self.reserved.contains(&number)
    }

    fn lowest_free(&mut self) -> Option<u32> {
        while self.lowest <= LARGEST_TRANSPONDER_NUMBER && !self.is_free(self.lowest) {
            self.lowest += 1;
        }
        (self.lowest <= LARGEST_TRANSPONDER_NUMBER).then_some(self.lowest)
    }

    fn highest_free(&mut self) -> Option<u32> {
        while self.highest > 0 && !self.is_free(self.highest) {
            self.highest -= 1;
        }
        (self.highest > 0).then_some(self.highest)
    }
}

/// A serial number that is a decimal integer from 1 to [`LARGEST_TRANSPONDER_NUMBER`]; leading zeros are allowed.
fn decimal(serial: &[u8]) -> Option<u32> {
    if serial.is_empty() || !serial.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let number = serial.iter().fold(0_u64, |number, digit| number * 10 + u64::from(digit - b'0'));
    u32::try_from(number).ok().filter(|number| (1..=LARGEST_TRANSPONDER_NUMBER).contains(number))
}

#[cfg(test)]
mod tests;
