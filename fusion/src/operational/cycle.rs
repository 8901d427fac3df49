//! One run of the passes, and the pictures that it yields.

use super::settings::Settings;
use super::tuning::KNOWN_AHEAD_S;
use crate::slots::{Slot, SlotGrid};
use crate::time::Time;

/// Earlier than every report.
pub(super) const EARLIEST: Time = Time::from_nanos(i64::MIN);
/// Later than every report.
pub(super) const LATEST: Time = Time::from_nanos(i64::MAX);

/// A slot that is decided or shown, and the sensors as they are known now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle<'a> {
    pub(super) slot: Slot,
    pub(super) begin: Time,
    pub(super) centre: Time,
    pub(super) end: Time,
    /// What was received by then is known.
    pub(super) deadline: Time,
    /// Centre of the slot that was decided before.
    pub(super) previous: Time,
    pub(super) settings: &'a Settings,
}

impl<'a> Cycle<'a> {
    /// A slot with what was received by `deadline`.
    pub(super) fn new(
        slot: Slot,
        deadline: Time,
        grid: SlotGrid,
        previous: Option<Time>,
        settings: &'a Settings,
    ) -> Self {
        Self {
            slot,
            begin: grid.open(slot),
            centre: grid.centre(slot),
            end: grid.open(slot.plus(1)),
            deadline,
            previous: previous.unwrap_or(grid.centre(slot.plus(-1))),
            settings,
        }
    }

    /// For how long nothing has come since `time`, as far as is known, seconds.
    pub(super) fn silent_s(&self, time: Time) -> f64 {
        // Of what comes after the slot; less than nothing where not even all of the slot is known.
        let known_ahead_s = self.deadline.seconds_since(self.end).min(KNOWN_AHEAD_S);
        known_ahead_s + self.centre.seconds_since(time)
    }
}
