//! The numbers under which targets are published.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::tuning::{FIRST_FREE_NUMBER, NUMBERS_PER_TRANSPONDER};
use crate::point::Source;
use crate::report::Identity;
use crate::slots::Slot;

/// A number, and the slot in which it was given.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct TrackNumber {
    pub(super) number: u32,
    pub(super) since: Slot,
}

/// Who has which number.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackNumbers {
    in_use: BTreeSet<u32>,
    /// Of each transponder's aircraft, which has it again when it comes back.
    of_identity: BTreeMap<Identity, TrackNumber>,
}

impl TrackNumbers {
    pub(super) fn of(&self, identity: Identity) -> Option<TrackNumber> {
        self.of_identity.get(&identity).copied()
    }

    /// The number of a target that has none, by what it is published as.
    pub(super) fn give(&mut self, source: &Source, slot: Slot) -> TrackNumber {
        let transponder = source.transponder().map_or(0, |part| part.number * NUMBERS_PER_TRANSPONDER);
        let number = transponder + source.radar().map_or(0, |part| part.track.number.into());
        // A radar's numbers come again; those of targets do not while they last.
        let free = |number: &u32| !self.in_use.contains(number);
        let number = Some(number).filter(free).or_else(|| (FIRST_FREE_NUMBER..).find(free)).unwrap_or(number);
        self.in_use.insert(number);
        TrackNumber { number, since: slot }
    }

    /// A transponder's aircraft keeps the first number that it had.
    pub(super) fn keep(&mut self, identity: Identity, number: TrackNumber) {
        self.of_identity.entry(identity).or_insert(number);
    }

    /// The numbers that transponders' aircraft keep.
    pub(super) fn kept(&self) -> impl Iterator<Item = (Identity, u32, Slot)> {
        self.of_identity.iter().map(|(&identity, known)| (identity, known.number, known.since))
    }

    /// Takes over a number that a transponder's aircraft had before a restart, unless it or the number has another one.
    pub(super) fn remember(&mut self, identity: Identity, number: u32, since: Slot) {
        if !self.of_identity.contains_key(&identity) && self.in_use.insert(number) {
            self.of_identity.insert(identity, TrackNumber { number, since });
        }
    }

    /// A number whose target has ended.
    pub(super) fn release(&mut self, number: TrackNumber) {
        self.in_use.remove(&number.number);
    }

    /// A transponder's aircraft that does not come back.
    pub(super) fn forget(&mut self, identity: Identity) {
        if let Some(number) = self.of_identity.remove(&identity) {
            self.release(number);
        }
    }
}
