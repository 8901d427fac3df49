//! Merging of the pictures of all cells. Sans-IO.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use crate::region::{CellPicture, PictureMerger};
use picture::Picture;
use site::territory::CellName;

/// Maximum number of slots of a cell that wait for other cells.
const MAX_WAITING_SLOTS: usize = 256;

/// A merged slot: the regular picture, and the picture of now if there is one.
pub(super) type MergedSlot = (Picture, Option<Picture>);

/// A slot of a cell.
#[derive(Debug)]
struct WaitingSlot {
    slot: Slot,
    epoch: u64,
    picture: Picture,
    now: Option<Picture>,
}

/// Merges the cells' slots in order.
///
/// A cell whose owner is lost publishes all of its slots some seconds late. The other cells wait for it: the region's picture is
/// late then, and complete. A cell that is away for longer than a takeover is left out until it is in time again.
#[derive(Debug)]
pub(super) struct SlotMerger {
    grid: SlotGrid,
    /// Time from the centre of a slot to its due time.
    due_after: SignedDuration,
    /// Time after a slot's due time for which it waits.
    patience: SignedDuration,
    cells: BTreeMap<CellName, VecDeque<WaitingSlot>>,
    away: BTreeSet<CellName>,
    /// Cells that are not shown because their owner has another configuration.
    foreign: BTreeSet<CellName>,
    /// Greatest lease number of each cell's published slots.
    epochs: BTreeMap<CellName, u64>,
    last: Option<Slot>,
    merger: PictureMerger,
    too_late: u64,
}

impl SlotMerger {
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
            merger: PictureMerger::default(),
            too_late: 0,
        }
    }

    /// Whether there is a cell with this name.
    pub(super) fn has(&self, cell: &CellName) -> bool {
        self.cells.contains_key(cell)
    }

    /// Hides a cell because its owner has another configuration, or shows it again.
    pub(super) fn set_hidden(&mut self, cell: &CellName, is_foreign: bool) {
        if !is_foreign {
            self.foreign.remove(cell);
        } else if self.foreign.insert(cell.clone()) {
            self.cells.get_mut(cell).into_iter().for_each(VecDeque::clear);
        }
    }

    /// Greatest lease number of a cell's published slots; 0 if there are none.
    pub(super) fn epoch(&self, cell: &CellName) -> u64 {
        self.epochs.get(cell).copied().unwrap_or_default()
    }

    /// Time at which a slot is due.
    pub(super) fn due(&self, slot: Slot) -> Time {
        self.grid.centre(slot) + self.due_after
    }

    /// Adds a slot of a cell. Returns whether the cell exists.
    pub(super) fn add_slot(&mut self, cell: &CellName, epoch: u64, (picture, now): MergedSlot) -> bool {
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
            waiting.push_back(WaitingSlot { slot, epoch, picture, now });
            if waiting.len() > MAX_WAITING_SLOTS {
                waiting.pop_front();
            }
        }
        true
    }

    /// The next slot that is complete or has waited long enough at `now`.
    pub(super) fn next(&mut self, now: Time) -> Option<MergedSlot> {
        let slot = self.cells.values().filter_map(|waiting| waiting.front()).map(|first| first.slot).min()?;
        let is_whole = |(cell, waiting): (&CellName, &VecDeque<WaitingSlot>)| {
            // A cell with a later slot has started since.
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
                && let Some(WaitingSlot { epoch, picture, now, .. }) = waiting.pop_front()
            {
                let part = |picture| CellPicture { cell: cell.clone(), epoch, picture };
                parts_of_now.extend(now.map(part));
                parts.push(part(picture));
            }
        }
        let merged = self.merger.merge(slot, &parts)?;
        // Tracks left out are the same in both pictures, and are counted once.
        let slot_of_now = parts_of_now.iter().map(|part| part.picture.slot).max();
        let now = slot_of_now.and_then(|slot| PictureMerger::default().merge(slot, &parts_of_now));
        Some((merged, now))
    }

    /// Time until which the next slot waits; `None` if no slot is queued.
    pub(super) fn waits_until(&self) -> Option<Time> {
        let slot = self.cells.values().filter_map(|waiting| waiting.front()).map(|first| first.slot).min()?;
        Some(self.grid.centre(slot) + self.due_after + self.patience)
    }

    /// Discards all slots, for example after the streams were lost.
    pub(super) fn discard_all(&mut self) {
        self.epochs.clear();
        self.cells.values_mut().for_each(VecDeque::clear);
    }

    /// Cells without which the picture continues.
    pub(super) const fn away(&self) -> &BTreeSet<CellName> {
        &self.away
    }

    /// Number of aircraft left out because another cell published them, too.
    pub(super) const fn duplicates(&self) -> u64 {
        self.merger.doubled
    }

    /// Number of cells' slots that arrived after the region's slot was shown without them.
    pub(super) const fn late_slots(&self) -> u64 {
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

    fn merger() -> SlotMerger {
        let due_after = SignedDuration::from_millis(6125);
        SlotMerger::new(&cells(), SlotGrid::default(), due_after, SignedDuration::from_secs(PATIENCE_S))
    }

    fn picture(slot: i64) -> MergedSlot {
        let slot = Slot(slot);
        let time = SlotGrid::default().centre(slot);
        (Picture { slot, time, tracks: Vec::new(), concerns: Vec::new(), resolved: Vec::new() }, None)
    }

    fn due(slot: i64) -> Time {
        SlotGrid::default().centre(Slot(slot)) + SignedDuration::from_millis(6125)
    }

    fn slots(merger: &mut SlotMerger, now: Time) -> Vec<i64> {
        std::iter::from_fn(|| merger.next(now)).map(|(picture, _)| picture.slot.0).collect()
    }

    #[test]
    fn missing_cell_is_waited_for_during_a_takeover() {
        let [east, north, west] = &cells()[..] else { unreachable!("three") };
        let mut merger = merger();
        for slot in 100..104 {
            [east, north, west].into_iter().for_each(|cell| assert!(merger.add_slot(cell, 1, picture(slot))));
        }
        assert_eq!(slots(&mut merger, due(103)), [100, 101, 102, 103]);
        // The owner of one cell is lost; the new owner publishes all slots.
        for slot in 104..116 {
            [east, north].into_iter().for_each(|cell| _ = merger.add_slot(cell, 1, picture(slot)));
        }
        assert!(slots(&mut merger, due(116)).is_empty() && merger.away().is_empty());
        (104..117).for_each(|slot| _ = merger.add_slot(west, 2, picture(slot)));
        assert_eq!(slots(&mut merger, due(116)), (104..116).collect::<Vec<_>>());
        // The cell does not come back.
        for slot in 116..150 {
            [east, north].into_iter().for_each(|cell| _ = merger.add_slot(cell, 1, picture(slot)));
        }
        let shown = slots(&mut merger, due(149));
        assert_eq!(shown, (116..150).collect::<Vec<_>>(), "nobody waits for it any more");
        assert_eq!(merger.away().iter().collect::<Vec<_>>(), [west]);
        // A slot that is too late is counted; then the cell takes part again.
        assert!(merger.add_slot(west, 3, picture(149)) && merger.late_slots() == 1);
        assert!(merger.add_slot(west, 3, picture(150)) && merger.away().is_empty());
        assert!(slots(&mut merger, due(150)).is_empty(), "the others are waited for");
        assert!(!merger.add_slot(&CellName::new("south").unwrap(), 1, picture(150)));
    }

    proptest! {
        /// In any order of arrival slots are shown in order and once each, and none is left out that all cells have published in
        /// time.
        #[test]
        fn slots_are_merged_once_and_in_order(late in prop::collection::vec((0_usize..3, 0_i64..20), 1..60)) {
            let mut merger = merger();
            let mut shown = Vec::new();
            let mut next = [100_i64; 3];
            let cells = cells();
            for (cell, slots_more) in late {
                for _ in 0..slots_more {
                    merger.add_slot(&cells[cell], 1, picture(next[cell]));
                    next[cell] += 1;
                }
                shown.extend(slots(&mut merger, due(*next.iter().max().unwrap())));
            }
            prop_assert!(shown.windows(2).all(|pair| pair[1] == pair[0] + 1), "{shown:?}");
            let all = *next.iter().min().unwrap();
            prop_assert!(shown.last().map_or(100, |last| last + 1) >= all);
        }
    }
}
