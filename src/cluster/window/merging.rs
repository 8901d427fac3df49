//! The pictures of all cells on their way to one. Sans-IO.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use crate::cluster::region::{Merger, Part};
use crate::picture::Picture;
use crate::territory::CellName;

/// Most slots of a cell that wait for those of others.
const WAITING: usize = 256;

/// A slot of all cells that publish: the usual picture, and that of now where it is made.
pub(super) type Merged = (Picture, Option<Picture>);

/// A slot of a cell.
#[derive(Debug)]
struct Waiting {
    slot: Slot,
    epoch: u64,
    picture: Picture,
    now: Option<Picture>,
}

/// Puts the cells' slots together, in order.
///
/// Of a cell whose owner is lost all slots come, a few seconds late, so the others wait for it: the region's picture is then as late,
/// and nothing is missing. A cell that stays away for longer than a take-over takes is left out until it is in time again.
#[derive(Debug)]
pub(super) struct Merging {
    grid: SlotGrid,
    /// From the centre of a slot until it is due.
    due_after: SignedDuration,
    /// How long after a slot was due it is waited for.
    patience: SignedDuration,
    cells: BTreeMap<CellName, VecDeque<Waiting>>,
    away: BTreeSet<CellName>,
    /// Cells whose owner has another configuration: nothing of them is shown.
    foreign: BTreeSet<CellName>,
    /// The greatest lease of each cell under which a slot was published.
    epochs: BTreeMap<CellName, u64>,
    last: Option<Slot>,
    merger: Merger,
    too_late: u64,
}

impl Merging {
    pub(super) fn new(
        cells: &[CellName],
        grid: SlotGrid,
        due_after: SignedDuration,
        patience: SignedDuration,
    ) -> Self {
        Self {
            grid,
            due_after,
            patience,
            cells: cells.iter().map(|cell| (cell.clone(), VecDeque::new())).collect(),
            away: BTreeSet::new(),
            foreign: BTreeSet::new(),
            epochs: BTreeMap::new(),
            last: None,
            merger: Merger::default(),
            too_late: 0,
        }
    }

    /// Whether there is such a cell.
    pub(super) fn has(&self, cell: &CellName) -> bool {
        self.cells.contains_key(cell)
    }

    /// Shows nothing of a cell from now on, because its owner has another configuration, or shows it again.
    pub(super) fn leave_out(&mut self, cell: &CellName, is_foreign: bool) {
        if !is_foreign {
            self.foreign.remove(cell);
        } else if self.foreign.insert(cell.clone()) {
            self.cells.get_mut(cell).into_iter().for_each(VecDeque::clear);
        }
    }

    /// The greatest lease under which something of a cell was published; 0: nothing was.
    pub(super) fn epoch(&self, cell: &CellName) -> u64 {
        self.epochs.get(cell).copied().unwrap_or_default()
    }

    /// When a slot is due.
    pub(super) fn due(&self, slot: Slot) -> Time {
        self.grid.centre(slot) + self.due_after
    }

    /// A slot of a cell; whether there is such a cell.
    pub(super) fn take(&mut self, cell: &CellName, epoch: u64, (picture, now): Merged) -> bool {
        let slot = picture.slot;
        let Some(waiting) = self.cells.get_mut(cell) else { return false };
        if self.foreign.contains(cell) {
            return true;
        }
        let newest = self.epochs.entry(cell.clone()).or_insert(epoch);
        *newest = epoch.max(*newest);
        if self.last.is_some_and(|last| slot <= last)
            || waiting.back().is_some_and(|newest| slot <= newest.slot)
        {
            self.too_late += 1;
        } else {
            self.away.remove(cell);
            waiting.push_back(Waiting { slot, epoch, picture, now });
            if waiting.len() > WAITING {
                waiting.pop_front();
            }
        }
        true
    }

    /// The next slot that is whole, or has been waited for, at `now`.
    pub(super) fn next(&mut self, now: Time) -> Option<Merged> {
        let slot = self.cells.values().filter_map(|waiting| waiting.front()).map(|first| first.slot).min()?;
        let is_whole = |(cell, waiting): (&CellName, &VecDeque<Waiting>)| {
            // Who has a later one has begun since.
            self.away.contains(cell) || !waiting.is_empty()
        };
        if !self.cells.iter().all(is_whole) {
            if now < self.grid.centre(slot) + self.due_after + self.patience {
                return None;
            }
            let missing = self.cells.iter().filter(|(_, waiting)| waiting.is_empty());
            self.away.extend(missing.map(|(cell, _)| cell.clone()));
        }
        self.last = Some(slot);
        let (mut parts, mut parts_of_now) = (Vec::new(), Vec::new());
        for (cell, waiting) in &mut self.cells {
            if waiting.front().is_some_and(|first| first.slot == slot)
                && let Some(Waiting { epoch, picture, now, .. }) = waiting.pop_front()
            {
                let part = |picture| Part { cell: cell.clone(), epoch, picture };
                parts_of_now.extend(now.map(part));
                parts.push(part(picture));
            }
        }
        let merged = self.merger.merge(slot, &parts)?;
        // What is left out of the one picture is left out of the other, and counted once.
        let slot_of_now = parts_of_now.iter().map(|part| part.picture.slot).max();
        let now = slot_of_now.and_then(|slot| Merger::default().merge(slot, &parts_of_now));
        Some((merged, now))
    }

    /// When the next slot has been waited for, where one waits.
    pub(super) fn waits_until(&self) -> Option<Time> {
        let slot = self.cells.values().filter_map(|waiting| waiting.front()).map(|first| first.slot).min()?;
        Some(self.grid.centre(slot) + self.due_after + self.patience)
    }

    /// Begins anew with what comes; as where the streams were lost.
    pub(super) fn forget(&mut self) {
        self.epochs.clear();
        self.cells.values_mut().for_each(VecDeque::clear);
    }

    /// Cells that the picture is without.
    pub(super) const fn away(&self) -> &BTreeSet<CellName> {
        &self.away
    }

    /// Aircraft that were left out because another cell published them, too.
    pub(super) const fn twice(&self) -> u64 {
        self.merger.doubled
    }

    /// Slots of cells that came when they had been shown without.
    pub(super) const fn too_late(&self) -> u64 {
        self.too_late
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PATIENCE_S: i64 = 5;

    fn cells() -> Vec<CellName> {
        ["east", "north", "west"].map(|name| CellName::new(name).unwrap()).to_vec()
    }

    fn merging() -> Merging {
        let due_after = SignedDuration::from_millis(6125);
        Merging::new(&cells(), SlotGrid::default(), due_after, SignedDuration::from_secs(PATIENCE_S))
    }

    fn picture(slot: i64) -> Merged {
        let slot = Slot(slot);
        let time = SlotGrid::default().centre(slot);
        (Picture { slot, time, tracks: Vec::new(), concerns: Vec::new(), resolved: Vec::new() }, None)
    }

    fn due(slot: i64) -> Time {
        SlotGrid::default().centre(Slot(slot)) + SignedDuration::from_millis(6125)
    }

    fn slots(merging: &mut Merging, now: Time) -> Vec<i64> {
        std::iter::from_fn(|| merging.next(now)).map(|(picture, _)| picture.slot.0).collect()
    }

    #[test]
    fn a_cell_is_waited_for_as_long_as_a_take_over_takes() {
        let [east, north, west] = &cells()[..] else { unreachable!("three") };
        let mut merging = merging();
        for slot in 100..104 {
            [east, north, west].into_iter().for_each(|cell| assert!(merging.take(cell, 1, picture(slot))));
        }
        assert_eq!(slots(&mut merging, due(103)), [100, 101, 102, 103]);
        // The owner of one is lost; whoever takes over has all slots.
        for slot in 104..116 {
            [east, north].into_iter().for_each(|cell| _ = merging.take(cell, 1, picture(slot)));
        }
        assert!(slots(&mut merging, due(116)).is_empty() && merging.away().is_empty());
        (104..117).for_each(|slot| _ = merging.take(west, 2, picture(slot)));
        assert_eq!(slots(&mut merging, due(116)), (104..116).collect::<Vec<_>>());
        // It does not come back.
        for slot in 116..150 {
            [east, north].into_iter().for_each(|cell| _ = merging.take(cell, 1, picture(slot)));
        }
        let shown = slots(&mut merging, due(149));
        assert_eq!(shown, (116..150).collect::<Vec<_>>(), "nobody waits for it any more");
        assert_eq!(merging.away().iter().collect::<Vec<_>>(), [west]);
        // What comes too late is counted; then it is one of them again.
        assert!(merging.take(west, 3, picture(149)) && merging.too_late() == 1);
        assert!(merging.take(west, 3, picture(150)) && merging.away().is_empty());
        assert!(slots(&mut merging, due(150)).is_empty(), "the others are waited for");
        assert!(!merging.take(&CellName::new("south").unwrap(), 1, picture(150)));
    }

    proptest! {
        /// Whatever comes when: slots are shown in order, once each, and none is left out that all have published in time.
        #[test]
        fn slots_are_shown_once_and_in_order(late in prop::collection::vec((0_usize..3, 0_i64..20), 1..60)) {
            let mut merging = merging();
            let mut shown = Vec::new();
            let mut next = [100_i64; 3];
            let cells = cells();
            for (cell, slots_more) in late {
                for _ in 0..slots_more {
                    merging.take(&cells[cell], 1, picture(next[cell]));
                    next[cell] += 1;
                }
                shown.extend(slots(&mut merging, due(*next.iter().max().unwrap())));
            }
            prop_assert!(shown.windows(2).all(|pair| pair[1] == pair[0] + 1), "{shown:?}");
            let all = *next.iter().min().unwrap();
            prop_assert!(shown.last().map_or(100, |last| last + 1) >= all);
        }
    }
}
