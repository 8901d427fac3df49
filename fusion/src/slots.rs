//! Slots of time, and sets of slots.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::time::Time;

/// Slot number k: covers [k·slot, (k+1)·slot) since the Unix epoch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Slot(pub i64);

impl Slot {
    /// The slot `by` later (earlier where negative).
    pub const fn plus(self, by: i64) -> Self {
        Self(self.0 + by)
    }
}

/// Division of time into slots of equal length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlotGrid {
    slot_ns: i64,
}

/// Slots of 0.25 s.
impl Default for SlotGrid {
    fn default() -> Self {
        Self { slot_ns: 250_000_000 }
    }
}

impl SlotGrid {
    /// Creates slots of this length.
    ///
    /// # Panics
    /// If the length is not above zero, is above 292 years, or is an odd number of nanoseconds: a slot's centre is a
    /// whole nanosecond.
    pub const fn new(slot: SignedDuration) -> Self {
        let slot_ns = slot.as_nanos();
        assert!(slot_ns > 0 && slot_ns <= i64::MAX as i128 && slot_ns % 2 == 0);
        Self { slot_ns: slot_ns as i64 }
    }

    /// The slot that contains an instant.
    pub const fn of(self, time: Time) -> Slot {
        Slot(time.nanos().div_euclid(self.slot_ns))
    }

    /// Start of a slot.
    pub const fn open(self, slot: Slot) -> Time {
        Time::from_nanos(slot.0 * self.slot_ns)
    }

    /// Centre of a slot, its nominal time.
    pub const fn centre(self, slot: Slot) -> Time {
        Time::from_nanos(slot.0 * self.slot_ns + self.slot_ns / 2)
    }

    /// Length of a slot, seconds.
    pub fn slot_s(self) -> f64 {
        self.slot_ns as f64 * 1e-9
    }

    /// Length of a slot.
    pub const fn slot(self) -> SignedDuration {
        SignedDuration::from_nanos(self.slot_ns)
    }
}

/// Number of slots in the ring: the window and the reports that wait ahead of it must fit.
pub(crate) const RING: usize = 128;

/// A set of slots, all less than [`RING`] apart: one bit for each, at the slot's index in the ring. A slot that has
/// left the window must be removed before the ring wraps around to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(crate) struct SlotSet(u128);

impl SlotSet {
    /// The empty set.
    pub(crate) const EMPTY: Self = Self(0);

    /// All slots from `first` to `last`, both included; empty if `last` is before `first`.
    pub(crate) fn span(first: Slot, last: Slot) -> Self {
        let count = last.0 - first.0 + 1;
        debug_assert!(count <= RING as i64, "{count} slots do not fit the ring");
        match count {
            ..=0 => Self::EMPTY,
            1..128 => Self(((1_u128 << count) - 1).rotate_left(ring_place(first) as u32)),
            _ => Self(u128::MAX),
        }
    }

    /// The set of one slot.
    pub(crate) fn only(slot: Slot) -> Self {
        Self(1 << ring_place(slot))
    }

    /// Whether the set is empty.
    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether the set contains `slot`.
    pub(crate) fn contains(self, slot: Slot) -> bool {
        self.0 & Self::only(slot).0 != 0
    }

    /// Adds or removes `slot`.
    pub(crate) fn set(&mut self, slot: Slot, member: bool) {
        let bit = Self::only(slot).0;
        if member { self.0 |= bit } else { self.0 &= !bit }
    }

    /// Number of slots.
    pub(crate) fn count(self) -> u32 {
        self.0.count_ones()
    }

    /// Union of both sets.
    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Intersection of both sets.
    pub(crate) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Slots of this set that are not in `other`.
    pub(crate) fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The slots in order, if all of them lie within [`RING`] slots from `first`.
    pub(crate) fn slots_from(self, first: Slot) -> impl Iterator<Item = Slot> {
        let mut bits = self.0.rotate_right(ring_place(first) as u32);
        std::iter::from_fn(move || {
            (bits != 0).then(|| {
                let place = bits.trailing_zeros();
                bits &= bits - 1;
                first.plus(place.into())
            })
        })
    }
}

/// Index of a slot in a ring of [`RING`] slots.
pub(crate) const fn ring_place(slot: Slot) -> usize {
    slot.0.rem_euclid(RING as i64) as usize
}

/// The slots that are used to emit one slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// The oldest slot (k-75).
    pub(crate) first: Slot,
    /// The slot being emitted (k).
    pub(crate) emitted: Slot,
    /// The last slot at which an association can still change the output (k+16).
    pub(crate) horizon: Slot,
    /// The newest slot (k+24). Knots lie between `first` and this slot.
    pub(crate) last: Slot,
}

impl Window {
    /// Slots from `first` to `horizon`, in which points are evaluated and compared.
    pub(crate) fn evaluated(&self) -> SlotSet {
        SlotSet::span(self.first, self.horizon)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_boundary_belongs_to_the_later_slot() {
        let grid = SlotGrid::default();
        assert_eq!(grid.of(Time::from_nanos(249_999_999)), Slot(0));
        assert_eq!(grid.of(Time::from_nanos(250_000_000)), Slot(1));
        assert_eq!(grid.of(Time::from_nanos(-1)), Slot(-1));
        assert_eq!(grid.centre(Slot(1)).nanos(), 375_000_000);
    }

    proptest! {
        #[test]
        fn a_slot_set_is_a_set(
            first in -1000..1000_i64, members in prop::collection::btree_set(0..128_i64, 0..40),
            from in 0..128_i64, to in 0..128_i64,
        ) {
            let members: BTreeSet<Slot> = members.into_iter().map(|slot| Slot(first + slot)).collect();
            let mut set = SlotSet::EMPTY;
            for &slot in &members {
                set.set(slot, true);
            }
            prop_assert_eq!(set.slots_from(Slot(first)).collect::<BTreeSet<_>>(), members.clone());
            prop_assert_eq!(set.count() as usize, members.len());
            let (from, to) = (Slot(first + from), Slot(first + to));
            let within = set.and(SlotSet::span(from, to));
            let expected = members.iter().filter(|slot| (from..=to).contains(slot)).count();
            prop_assert_eq!(within.count() as usize, expected);
            prop_assert_eq!(set.without(within).count() as usize, members.len() - expected);
        }
    }
}
