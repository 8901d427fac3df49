//! Names of tracklets and targets inside the engine: in the order in which they began, never used again. They say what began
//! and when, not how many there were before: engines that see a thing begin call it the same, whatever else they see.

use serde::{Deserialize, Serialize};

use crate::report::{Identity, RadarTrackKey};
use crate::slots::Slot;
use crate::time::Time;

/// Tells tracklets apart, also those that had one radar track number after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct TrackletId {
    /// The slot with which it came,
    pub(super) slot: Slot,
    /// its first plot then,
    pub(super) time: Time,
    pub(super) track: RadarTrackKey,
    /// and which of those with one number and time.
    pub(super) nth: u16,
}

/// Tells targets apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct TargetId {
    /// The slot with which it came.
    pub(super) slot: Slot,
    pub(super) begun: Begun,
}

/// What a target was first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) enum Begun {
    /// A transponder, with this report.
    Transponder(Time, Identity),
    /// A radar track that was nobody's.
    Track(TrackletId),
}

impl TrackletId {
    /// Tells it apart from others of its radar: when it began, and its number.
    pub(super) const fn of_radar(&self) -> (Time, u16) {
        (self.time, self.track.number)
    }
}

#[cfg(test)]
impl TargetId {
    /// The so many-th.
    pub(super) fn nth(nth: u64) -> Self {
        Self { slot: Slot(nth as i64), begun: Begun::Transponder(Time::default(), Identity::of_address(1)) }
    }
}
