//! The numbers T that a cell may give: unique in the region, because it is told blocks that are its own.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::territory::CellName;
use fusion::Identity;
use fusion::slots::Slot;

/// Numbers of a block.
pub const BLOCK: u32 = 64;
/// The first number of the first block: those below are for whom the configuration names.
pub const FIRST_BLOCK: u32 = 4096;
/// The first number of the last block: T · 10,000 + R fits 32 bits.
pub const LAST_BLOCK: u32 = 429_376;
/// With fewer than two blocks left another one is wanted.
const SPARE: usize = 2 * BLOCK as usize;

/// Who keeps the numbers of a region: it answers with blocks, and knows which number an identity has.
pub fn numbers_office() -> CellName {
    CellName::new("numbers").expect("a name")
}

/// The numbers of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Numbers {
    /// The first numbers of the blocks that are this cell's.
    blocks: BTreeSet<u32>,
    free: BTreeSet<u32>,
    identities: BTreeMap<Identity, u32>,
    /// Numbers of aircraft that are this cell's, or were.
    held: BTreeMap<u32, Held>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Held {
    /// Whose it is; `None`: of an aircraft that only radars see.
    identity: Option<Identity>,
    /// When it was published last.
    last: Slot,
    /// Whether it is free again here, once its aircraft has ended for a day.
    ends_here: bool,
}

impl Numbers {
    /// Takes over a block.
    pub(super) fn add_block(&mut self, first: u32) {
        if (FIRST_BLOCK..=LAST_BLOCK).contains(&first) {
            let Self { blocks, free, held, .. } = self;
            blocks.insert(first);
            free.extend((first..first + BLOCK).filter(|number| !held.contains_key(number)));
        }
    }

    /// Whether more are wanted.
    pub(super) fn are_few(&self) -> bool {
        self.free.len() < SPARE
    }

    /// The number of an identity or, of an aircraft that only radars see, a new one; and whether it was given just now. `None`:
    /// there is none left.
    pub(super) fn of(&mut self, identity: Option<Identity>, slot: Slot) -> Option<(u32, bool)> {
        let known = identity.and_then(|identity| self.identities.get(&identity).copied());
        let number = known.or_else(|| self.free.pop_first())?;
        self.take(number, identity, slot);
        Some((number, known.is_none()))
    }

    /// The number that an identity has.
    pub(super) fn known(&self, identity: Identity) -> Option<u32> {
        self.identities.get(&identity).copied()
    }

    /// A number is now that of an aircraft of this cell.
    pub(super) fn take(&mut self, number: u32, identity: Option<Identity>, slot: Slot) {
        self.free.remove(&number);
        self.held.insert(number, Held { identity, last: slot, ends_here: true });
        if let Some(identity) = identity {
            self.identities.insert(identity, number);
        }
    }

    /// Its aircraft was published.
    pub(super) fn note(&mut self, number: u32, slot: Slot) {
        if let Some(held) = self.held.get_mut(&number) {
            held.last = slot;
        }
    }

    /// Its aircraft is another cell's now: it ends there.
    pub(super) fn give(&mut self, number: u32) {
        if let Some(held) = self.held.get_mut(&number) {
            held.ends_here = false;
        }
    }

    /// The blocks that are this cell's, by their first numbers, and the identities that have a number for its aircraft.
    pub(super) fn claims(&self) -> (Vec<u32>, Vec<(Identity, u32)>) {
        let of = |(number, held): (&u32, &Held)| {
            held.identity.filter(|_| held.ends_here).map(|who| (who, *number))
        };
        (self.blocks.iter().copied().collect(), self.held.iter().filter_map(of).collect())
    }

    /// An identity has this number, as who keeps them says; for its next aircraft.
    pub(super) fn learn(&mut self, identity: Identity, number: Option<u32>) {
        match number {
            Some(number) => self.identities.insert(identity, number),
            None => self.identities.remove(&identity),
        };
    }

    /// Numbers whose aircraft ended before `before` are free again; the identities that have none any more.
    pub(super) fn turn(&mut self, before: Slot) -> Vec<Identity> {
        let Self { free, identities, held, .. } = self;
        let mut forgotten = Vec::new();
        held.retain(|&number, known| {
            if known.last >= before {
                return true;
            }
            let own = known.identity.filter(|identity| identities.get(identity) == Some(&number));
            if let Some(identity) = &own {
                identities.remove(identity);
            }
            if known.ends_here {
                free.insert(number);
                forgotten.extend(own);
            }
            false
        });
        forgotten
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_free_again_where_its_aircraft_ended() {
        let [one, other] = [1, 2].map(Identity::of_address);
        let (mut here, mut there) = (Numbers::default(), Numbers::default());
        assert_eq!(here.of(Some(one), Slot(0)), None, "there is none");
        here.add_block(FIRST_BLOCK);
        there.add_block(FIRST_BLOCK + BLOCK);
        assert_eq!(here.of(Some(one), Slot(0)), Some((FIRST_BLOCK, true)));
        assert_eq!(here.of(Some(one), Slot(1)), Some((FIRST_BLOCK, false)), "its own again");
        assert_eq!(here.of(None, Slot(1)), Some((FIRST_BLOCK + 1, true)), "of a radar's track");
        assert_eq!(here.of(Some(other), Slot(1)), Some((FIRST_BLOCK + 2, true)));
        // The first one flies on.
        here.give(FIRST_BLOCK);
        there.take(FIRST_BLOCK, Some(one), Slot(5));
        assert_eq!(here.turn(Slot(2)), [other]);
        assert_eq!(here.free.len(), BLOCK as usize - 1, "the given one is another cell's");
        assert_eq!(there.turn(Slot(5)), []);
        assert_eq!(there.turn(Slot(6)), [one]);
        assert_eq!(there.free.len(), BLOCK as usize + 1);
        assert_eq!(there.of(None, Slot(7)), Some((FIRST_BLOCK, true)));
    }

    #[test]
    fn nobody_gets_a_number_that_does_not_fit() {
        let mut numbers = Numbers::default();
        [0, FIRST_BLOCK - 1, LAST_BLOCK + 1, u32::MAX].into_iter().for_each(|first| numbers.add_block(first));
        assert!(numbers.free.is_empty());
        numbers.add_block(LAST_BLOCK);
        let most = numbers.free.last().map(|most| u64::from(*most) * 10_000 + 4095);
        assert!(most.is_some_and(|most| most <= u64::from(u32::MAX)), "{most:?}");
    }
}
