//! A transponder's reports: the knots of the window and the curve through them.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::frames::Enu;
use crate::interpolation::{self, Knot};
use crate::report::Fix;
use crate::slots::{RING, Slot, SlotGrid, SlotSet, Window, ring_place};
use crate::time::Time;

/// The curve of one identity over the window.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct IdentityCurve {
    /// Knots by time. Those ahead of the window are at the end and do not take part yet.
    knots: Vec<Knot>,
    /// Times of knots that were added or changed since the last emission, or that wait ahead of the window.
    fresh: Vec<Time>,
    /// Slots with a point.
    present: SlotSet,
    /// Points by index in the ring; empty until the first point, because a flood of invented identities has one report
    /// each.
    points: Vec<Enu>,
}

impl IdentityCurve {
    pub(super) fn new() -> Self {
        Self { knots: Vec::new(), fresh: Vec::new(), present: SlotSet::EMPTY, points: Vec::new() }
    }

    /// Adds a report; of two with one time, the last received counts.
    pub(super) fn insert(&mut self, fix: &Fix) {
        let knot = Knot { time: fix.time, position: fix.position.0 };
        let index = self.knots.partition_point(|earlier| earlier.time < knot.time);
        match self.knots.get_mut(index) {
            Some(same) if same.time == knot.time => *same = knot,
            _ => self.knots.insert(index, knot),
        }
        self.fresh.push(knot.time);
    }

    /// Whether there are neither knots nor waiting reports.
    pub(super) fn is_empty(&self) -> bool {
        self.knots.is_empty()
    }

    /// Slots with a point.
    pub(super) fn present(&self) -> SlotSet {
        self.present
    }

    /// The point of a slot that has one.
    pub(super) fn point(&self, slot: Slot) -> Enu {
        debug_assert!(self.present.contains(slot));
        self.points[ring_place(slot)]
    }

    /// Updates the curve to `window`; returns the slots whose point changed, appeared or vanished.
    ///
    /// A knot's slope depends on the adjacent knots, at an end on the next two. So a knot that is added or changed
    /// moves the curve over two pieces on either side of it, and a knot that is removed moves the piece after the new
    /// first one.
    pub(super) fn update(&mut self, window: &Window, grid: SlotGrid, max_gap: SignedDuration) -> SlotSet {
        let evaluated = window.evaluated();
        self.present = self.present.and(evaluated);
        let leaving = self.knots.partition_point(|knot| grid.of(knot.time) < window.first);
        self.knots.drain(..leaving);
        let active = self.knots.partition_point(|knot| grid.of(knot.time) <= window.last);
        let knots = &self.knots[..active];

        let mut moved = SlotSet::only(window.horizon);
        if leaving > 0 {
            let until = knots.get(1).map_or(window.horizon, |knot| grid.of(knot.time));
            moved = moved.or(SlotSet::span(window.first, until.min(window.horizon)));
        }
        self.fresh.retain(|&time| {
            let index = knots.partition_point(|knot| knot.time < time);
            if let Some(last) = active.checked_sub(1).filter(|&last| index <= last) {
                let from = grid.of(knots[index.saturating_sub(2)].time);
                let until = grid.of(knots[(index + 2).min(last)].time).min(window.horizon);
                moved = moved.or(SlotSet::span(from, until));
            }
            index >= active
        });

        let mut changed = SlotSet::EMPTY;
        for slot in moved.and(evaluated).slots_from(window.first) {
            let point = evaluate(knots, grid.centre(slot), max_gap);
            match point {
                Some(point) if !self.present.contains(slot) || self.points[ring_place(slot)] != point => {
                    self.points.resize(RING, point);
                    self.points[ring_place(slot)] = point;
                    self.present.set(slot, true);
                    changed.set(slot, true);
                }
                None if self.present.contains(slot) => {
                    self.present.set(slot, false);
                    changed.set(slot, true);
                }
                _ => {}
            }
        }
        changed
    }
}

/// Position of the curve at `time`; `None` inside a gap longer than `max_gap`.
pub(super) fn evaluate(knots: &[Knot], time: Time, max_gap: SignedDuration) -> Option<Enu> {
    let after = knots.partition_point(|knot| knot.time < time);
    if let (Some(before), Some(next)) = (after.checked_sub(1), knots.get(after))
        && next.time != time
        && next.time - knots[before].time > max_gap
    {
        return None;
    }
    interpolation::evaluate(knots, time).map(Enu::from)
}
