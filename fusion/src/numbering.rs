//! Track numbers of transponders: who has which, since when, and when it goes back.

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::report::Identity;
use crate::slots::{Slot, SlotGrid};
use crate::time::Time;

/// The largest number: fused tracks are number · 10000 + radar track, which must fit 32 bits.
pub const LARGEST_TRANSPONDER_NUMBER: u32 = 429_496;

/// Interval at which a number's `heard` is brought up to date: what outlives a restart is at most this old.
pub const NOTED: SignedDuration = SignedDuration::from_secs(600);

/// A number goes back this long after its transponder's last point.
const KEPT: SignedDuration = SignedDuration::from_hours(24);

/// A transponder's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Numbered {
    /// The number T.
    pub number: u32,
    /// The slot it was given in: the first emitted one with a point of the transponder.
    pub since: Slot,
}

/// Who has which number: what outlives a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Given {
    /// The number T, 1 to [`LARGEST_TRANSPONDER_NUMBER`].
    pub number: u32,
    /// The transponder.
    pub identity: Identity,
    /// When it had a point last, at most [`NOTED`] before its latest; `None`: not known, which counts as now.
    pub heard: Option<Time>,
}

/// A change of a number's holder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NumberChange {
    /// It was given, or its transponder has a point for the first time in [`NOTED`].
    Heard(Given),
    /// It is free again.
    Returned(Given),
}

impl NumberChange {
    /// The number that it is about, and who has, or had, it.
    pub const fn given(&self) -> &Given {
        match self {
            Self::Heard(given) | Self::Returned(given) => given,
        }
    }
}

/// How long a transponder keeps its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Keeping {
    /// For good. When none is left, who comes next has none and is left out.
    #[default]
    ForGood,
    /// Until a day after its last point. When none is left, who comes next gets that of the transponder that was heard
    /// least recently.
    ADay,
}

/// Who has which number.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Numbers {
    grid: SlotGrid,
    keeping: Keeping,
    configured: BTreeMap<Vec<u8>, u32>,
    reserved: BTreeSet<u32>,
    held: BTreeMap<Identity, HeldNumber>,
    /// The holders, by when they were heard; ties by number.
    by_age: BTreeMap<(Time, u32), Identity>,
    taken: BTreeSet<u32>,
    /// No number below this is free for an identity without a claim; above that none for one without a serial number.
    lowest: u32,
    highest: u32,
    /// Taken over without a time, until the first slot.
    undated: Vec<Identity>,
    changes: Vec<NumberChange>,
    /// Points left out because no number was left.
    unnumbered: u64,
}

/// A number that somebody has.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct HeldNumber {
    number: u32,
    /// `None`: not since the start.
    since: Option<Slot>,
    heard: Time,
}

impl Numbers {
    /// None given yet; `configured`: trimmed serial number to number.
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

    /// From now on numbers are given for good: those that went back stay so.
    pub fn keep_for_good(&mut self) {
        self.keeping = Keeping::ForGood;
    }

    /// The number of an identity that has a point in the slot being emitted: the one it has; else its configured one if
    /// that is not taken; else its serial number if that is a number that is free; else the lowest free one; else, with
    /// [`Keeping::ADay`], that of the transponder that was heard least recently. `None` when all are used up. An identity
    /// without a serial number has the highest free one: whoever else is heard, a drone's number stays what it would be.
    pub fn of(&mut self, identity: Identity, slot: Slot) -> Option<Numbered> {
        let now = self.grid.open(slot);
        if let Some(held) = self.held.get_mut(&identity) {
            let since = *held.since.get_or_insert(slot);
            let number = held.number;
            if now - held.heard >= NOTED {
                self.by_age.remove(&(held.heard, number));
                held.heard = now;
                self.note(identity, number, now);
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
        let number = free.or_else(|| self.take_back())?;
        self.taken.insert(number);
        self.held.insert(identity, HeldNumber { number, since: Some(slot), heard: now });
        self.note(identity, number, now);
        Some(Numbered { number, since: slot })
    }

    fn note(&mut self, identity: Identity, number: u32, heard: Time) {
        self.by_age.insert((heard, number), identity);
        self.changes.push(NumberChange::Heard(Given { number, identity, heard: Some(heard) }));
    }

    /// A slot begins to be emitted: with [`Keeping::ADay`] numbers go back whose transponder has had no point for a day.
    pub fn turn(&mut self, slot: Slot) {
        let now = self.grid.open(slot);
        for identity in std::mem::take(&mut self.undated) {
            if let Some(held) = self.held.get_mut(&identity).filter(|held| held.since.is_none()) {
                self.by_age.remove(&(held.heard, held.number));
                held.heard = now;
                self.by_age.insert((now, held.number), identity);
            }
        }
        // Its last point came up to this much later than the time that is known.
        let before = now - KEPT - NOTED;
        while self.keeping == Keeping::ADay
            && let Some((&(heard, number), _)) = self.by_age.first_key_value()
            && heard <= before
        {
            self.give_back((heard, number));
        }
    }

    fn give_back(&mut self, (heard, number): (Time, u32)) {
        if let Some(identity) = self.by_age.remove(&(heard, number)) {
            self.held.remove(&identity);
            self.taken.remove(&number);
            self.lowest = self.lowest.min(number);
            self.highest = self.highest.max(number);
            self.changes.push(NumberChange::Returned(Given { number, identity, heard: Some(heard) }));
        }
    }

    /// Makes a number free although its transponder may come again; a configured one stays.
    fn take_back(&mut self) -> Option<u32> {
        if self.keeping == Keeping::ForGood {
            return None;
        }
        let &oldest = self.by_age.keys().find(|(_, number)| !self.reserved.contains(number))?;
        self.give_back(oldest);
        Some(oldest.1)
    }

    /// Takes over a number given before a restart: its identity has it again from the first slot emitted with a point of
    /// it, which is then its `since`. It stays even where the configuration has since given that number, or that serial,
    /// to someone else.
    ///
    /// `false`, and nothing is changed: the number is not 1 to [`LARGEST_TRANSPONDER_NUMBER`], or it or the identity is taken.
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
        self.held.insert(identity, HeldNumber { number, since: None, heard });
        self.by_age.insert((heard, number), identity);
        true
    }

    /// What has changed since this was asked last, in the order in which it did.
    pub fn take_changes(&mut self) -> Vec<NumberChange> {
        std::mem::take(&mut self.changes)
    }

    /// What has changed since [`Numbers::take_changes`].
    pub(super) fn changes(&self) -> &[NumberChange] {
        &self.changes
    }

    /// How many numbers are somebody's.
    pub fn used(&self) -> usize {
        self.taken.len()
    }

    /// Who has which number, by identity.
    pub fn given(&self) -> impl Iterator<Item = Given> {
        self.held.iter().map(|(&identity, held)| Given {
            number: held.number,
            identity,
            heard: Some(held.heard),
        })
    }

    /// A point is left out because no number was left.
    pub(super) fn note_unnumbered(&mut self) {
        self.unnumbered += 1;
    }

    /// Points left out because no number was left.
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
