//! Numbers T that a cell may assign. They are unique in the region because each cell has its own blocks.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use fusion::Identity;
use fusion::slots::Slot;
use site::territory::CellName;

/// Count of numbers in a block.
pub const BLOCK: u32 = 64;
/// First number of the first block. Lower numbers are for transponders named in the configuration.
pub const FIRST_BLOCK: u32 = 4096;
/// First number of the last block, so that T · 10,000 + R fits into 32 bits.
pub const LAST_BLOCK: u32 = 429_376;
/// Number of free numbers below which another block is requested.
const MIN_FREE: usize = 2 * BLOCK as usize;

/// Recipient name for requests to the region's table of numbers.
pub fn number_table() -> CellName {
    CellName::new("numbers").expect("a name")
}

/// The numbers of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct CellNumbers {
    /// First numbers of this cell's blocks.
    blocks: BTreeSet<u32>,
    free: BTreeSet<u32>,
    identities: BTreeMap<Identity, u32>,
    /// Numbers of current and former aircraft of this cell.
    held: BTreeMap<u32, HeldNumber>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct HeldNumber {
    /// Identity that has the number; `None` for an aircraft that only radars see.
    identity: Option<Identity>,
    /// Slot of the last publication.
    last: Slot,
    /// Whether the number becomes free here once its aircraft has ended for a day.
    ends_here: bool,
}

impl CellNumbers {
    /// Adds a block.
    pub(super) fn add_block(&mut self, first: u32) {
        if (FIRST_BLOCK..=LAST_BLOCK).contains(&first) {
            let Self { blocks, free, held, .. } = self;
            blocks.insert(first);
            free.extend((first..first + BLOCK).filter(|number| !held.contains_key(number)));
        }
    }

    /// Whether another block is needed.
    pub(super) fn needs_block(&self) -> bool {
        self.free.len() < MIN_FREE
    }

    /// Number of an identity, or a new number for an aircraft that only radars see; and whether it was newly assigned. `None` if
    /// none is free.
    pub(super) fn number_for(&mut self, identity: Option<Identity>, slot: Slot) -> Option<(u32, bool)> {
        let known = identity.and_then(|identity| self.identities.get(&identity).copied());
        let number = known.or_else(|| self.free.pop_first())?;
        self.assign(number, identity, slot);
        Some((number, known.is_none()))
    }

    /// Number of an identity.
    pub(super) fn known(&self, identity: Identity) -> Option<u32> {
        self.identities.get(&identity).copied()
    }

    /// Assigns a number to an aircraft of this cell.
    pub(super) fn assign(&mut self, number: u32, identity: Option<Identity>, slot: Slot) {
        self.free.remove(&number);
        self.held.insert(number, HeldNumber { identity, last: slot, ends_here: true });
        if let Some(identity) = identity {
            self.identities.insert(identity, number);
        }
    }

    /// Notes that the aircraft with this number was published.
    pub(super) fn note(&mut self, number: u32, slot: Slot) {
        if let Some(held) = self.held.get_mut(&number) {
            held.last = slot;
        }
    }

    /// Notes that another cell has taken over the aircraft with this number, and will release it.
    pub(super) fn hand_over(&mut self, number: u32) {
        if let Some(held) = self.held.get_mut(&number) {
            held.ends_here = false;
        }
    }

    /// First numbers of this cell's blocks, and the identities with a number that this cell will release.
    pub(super) fn claims(&self) -> (Vec<u32>, Vec<(Identity, u32)>) {
        let of = |(number, held): (&u32, &HeldNumber)| {
            held.identity.filter(|_| held.ends_here).map(|who| (who, *number))
        };
        (self.blocks.iter().copied().collect(), self.held.iter().filter_map(of).collect())
    }

    /// Notes the number of an identity, as stated by the table of numbers, for its next aircraft.
    pub(super) fn set_number(&mut self, identity: Identity, number: Option<u32>) {
        match number {
            Some(number) => self.identities.insert(identity, number),
            None => self.identities.remove(&identity),
        };
    }

    /// Releases numbers whose aircraft ended before `before`. Returns the identities that have lost their number.
    pub(super) fn release_expired(&mut self, before: Slot) -> Vec<Identity> {
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
    fn number_is_released_where_its_aircraft_ended() {
        let [one, other] = [1, 2].map(Identity::of_address);
        let (mut here, mut there) = (CellNumbers::default(), CellNumbers::default());
        assert_eq!(here.number_for(Some(one), Slot(0)), None, "there is none");
        here.add_block(FIRST_BLOCK);
        there.add_block(FIRST_BLOCK + BLOCK);
        assert_eq!(here.number_for(Some(one), Slot(0)), Some((FIRST_BLOCK, true)));
        assert_eq!(here.number_for(Some(one), Slot(1)), Some((FIRST_BLOCK, false)), "its own again");
        assert_eq!(here.number_for(None, Slot(1)), Some((FIRST_BLOCK + 1, true)), "of a radar's track");
        assert_eq!(here.number_for(Some(other), Slot(1)), Some((FIRST_BLOCK + 2, true)));
        // The first aircraft is handed over.
        here.hand_over(FIRST_BLOCK);
        there.assign(FIRST_BLOCK, Some(one), Slot(5));
        assert_eq!(here.release_expired(Slot(2)), [other]);
        assert_eq!(here.free.len(), BLOCK as usize - 1, "the given one is another cell's");
        assert_eq!(there.release_expired(Slot(5)), []);
        assert_eq!(there.release_expired(Slot(6)), [one]);
        assert_eq!(there.free.len(), BLOCK as usize + 1);
        assert_eq!(there.number_for(None, Slot(7)), Some((FIRST_BLOCK, true)));
    }

    #[test]
    fn block_outside_the_range_is_rejected() {
        let mut numbers = CellNumbers::default();
        [0, FIRST_BLOCK - 1, LAST_BLOCK + 1, u32::MAX].into_iter().for_each(|first| numbers.add_block(first));
        assert!(numbers.free.is_empty());
        numbers.add_block(LAST_BLOCK);
        let most = numbers.free.last().map(|most| u64::from(*most) * 10_000 + 4095);
        assert!(most.is_some_and(|most| most <= u64::from(u32::MAX)), "{most:?}");
    }
}
