//! One run of the passes.

use super::settings::Settings;
use crate::slots::{Slot, SlotGrid};
use crate::time::Time;

/// Earlier than every report.
pub(super) const EARLIEST: Time = Time::from_nanos(i64::MIN);
/// Later than every report.
pub(super) const LATEST: Time = Time::from_nanos(i64::MAX);

/// The slot that is published, and the sensors as they are known now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle<'a> {
    pub(super) slot: Slot,
    pub(super) begin: Time,
    pub(super) centre: Time,
    pub(super) end: Time,
    /// What was received by then is known.
    pub(super) deadline: Time,
    /// Centre of the slot that was published before.
    pub(super) previous: Time,
    pub(super) settings: &'a Settings,
}

impl<'a> Cycle<'a> {
    pub(super) fn new(slot: Slot, grid: SlotGrid, previous: Option<Time>, settings: &'a Settings) -> Self {
        Self {
            slot,
            begin: grid.open(slot),
            centre: grid.centre(slot),
            end: grid.open(slot.plus(1)),
            deadline: grid.open(slot) + settings.latency,
            previous: previous.unwrap_or(grid.centre(slot.plus(-1))),
            settings,
        }
    }
}
