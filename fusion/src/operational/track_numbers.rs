//! The numbers under which targets are published.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::tuning::{FIRST_FREE_NUMBER, NUMBERS_PER_TRANSPONDER};
use crate::point::Source;
use crate::report::Identity;
use crate::slots::Slot;

/// A number, and the slot in which it was assigned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct TrackNumber {
    pub(super) number: u32,
    pub(super) since: Slot,
}

impl TrackNumber {
    /// Orders numbers by age, the oldest first.
    pub(super) fn age(self) -> (Slot, u32) {
        (self.since, self.number)
    }
}

/// Assignment of numbers to targets.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackNumbers {
    in_use: BTreeSet<u32>,
    /// Numbers of transponders' aircraft, which get them again when they return.
    of_identity: BTreeMap<Identity, TrackNumber>,
}

impl TrackNumbers {
    pub(super) fn of(&self, identity: Identity) -> Option<TrackNumber> {
        self.of_identity.get(&identity).copied()
    }

    /// Passes the number of an aircraft whose transponder has fallen silent to another identity, whose own number is
    /// released.
    pub(super) fn pass_on(&mut self, from: Identity, to: Identity) -> Option<TrackNumber> {
        let number = self.of_identity.remove(&from)?;
        if let Some(own) = self.of_identity.insert(to, number) {
            self.release(own);
        }
        Some(number)
    }

    /// Assigns a number to a target without one, based on its radar track and transponder; without both, a free one.
    pub(super) fn assign(&mut self, source: &Source, slot: Slot) -> TrackNumber {
        let transponder = source.transponder().map_or(0, |part| part.number * NUMBERS_PER_TRANSPONDER);
        let number = transponder + source.radar().map_or(0, |part| part.track.number.into());
        // A radar reuses its numbers; those of targets are unique while they exist.
        let free = |number: &u32| !self.in_use.contains(number);
        let has_number = !matches!(source, Source::Cameras);
        let number = Some(number)
            .filter(|number| has_number && free(number))
            .or_else(|| (FIRST_FREE_NUMBER..).find(free))
            .unwrap_or(number);
        self.in_use.insert(number);
        TrackNumber { number, since: slot }
    }

    /// Keeps the first number of a transponder's aircraft.
    pub(super) fn record(&mut self, identity: Identity, number: TrackNumber) {
        self.of_identity.entry(identity).or_insert(number);
    }

    /// The numbers kept for transponders' aircraft.
    pub(super) fn recorded(&self) -> impl Iterator<Item = (Identity, u32, Slot)> {
        self.of_identity.iter().map(|(&identity, known)| (identity, known.number, known.since))
    }

    /// Restores the number that a transponder's aircraft had before a restart, unless the aircraft has one or the
    /// number is in use.
    pub(super) fn remember(&mut self, identity: Identity, number: u32, since: Slot) {
        if !self.of_identity.contains_key(&identity) && self.in_use.insert(number) {
            self.of_identity.insert(identity, TrackNumber { number, since });
        }
    }

    /// Releases the number of a target that has ended.
    pub(super) fn release(&mut self, number: TrackNumber) {
        self.in_use.remove(&number.number);
    }

    /// Forgets a transponder's aircraft that does not return.
    pub(super) fn forget(&mut self, identity: Identity) {
        if let Some(number) = self.of_identity.remove(&identity) {
            self.release(number);
        }
    }
}
