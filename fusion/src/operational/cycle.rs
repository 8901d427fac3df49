//! Times and settings of one run of the passes.

use super::settings::OperationalSettings;
use super::tuning::KNOWN_AHEAD_S;
use crate::slots::{Slot, SlotGrid};
use crate::time::Time;

/// A time before every report.
pub(super) const EARLIEST: Time = Time::from_nanos(i64::MIN);
/// A time after every report.
pub(super) const LATEST: Time = Time::from_nanos(i64::MAX);

/// A slot that is decided or shown, with the present settings of the sensors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle<'a> {
    pub(super) slot: Slot,
    pub(super) begin: Time,
    pub(super) centre: Time,
    pub(super) end: Time,
    /// Time up to which reports were received.
    pub(super) deadline: Time,
    /// Centre of the slot that was decided before.
    pub(super) previous: Time,
    pub(super) settings: &'a OperationalSettings,
}

impl<'a> Cycle<'a> {
    /// A slot with the reports received by `deadline`.
    pub(super) fn new(
        slot: Slot,
        deadline: Time,
        grid: SlotGrid,
        previous: Option<Time>,
        settings: &'a OperationalSettings,
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

    /// Known duration without reports since `time`, seconds.
    pub(super) fn silent_s(&self, time: Time) -> f64 {
        // Known time after the slot; negative if the slot itself is not yet complete.
        let known_ahead_s = self.deadline.seconds_since(self.end).min(KNOWN_AHEAD_S);
        known_ahead_s + self.centre.seconds_since(time)
    }
}
