//! Identifiers of tracklets and targets inside the engine: ordered by their start, never reused. They state what began
//! and when, not a count of earlier ones. So engines that observe the same start use the same identifier, whatever else
//! they observe.

use serde::{Deserialize, Serialize};

use crate::report::{CameraTrackKey, Identity, RadarTrackKey};
use crate::slots::Slot;
use crate::time::Time;

/// Identifies a tracklet, even among those with the same radar track number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct TrackletId {
    /// The slot in which it was created.
    pub(super) slot: Slot,
    /// Time of its first plot then.
    pub(super) time: Time,
    pub(super) track: RadarTrackKey,
    /// Index among tracklets with the same number and time.
    pub(super) nth: u16,
}

/// Identifies a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct TargetId {
    /// The slot in which it was created.
    pub(super) slot: Slot,
    pub(super) begun: Begun,
}

/// Origin of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) enum Begun {
    /// A transponder, with the time of this report.
    Transponder(Time, Identity),
    /// An unassigned radar track.
    Track(TrackletId),
    /// Tracks of two cameras, in order, with the time of the first look at which their lines cross.
    Cameras(Time, CameraTrackKey, CameraTrackKey),
}

impl TrackletId {
    /// Identifies it among the tracks of its radar: time of its start, and its number.
    pub(super) const fn of_radar(&self) -> (Time, u16) {
        (self.time, self.track.number)
    }
}

#[cfg(test)]
impl TargetId {
    /// Identifier of the target with this index.
    pub(super) fn nth(nth: u64) -> Self {
        Self { slot: Slot(nth as i64), begun: Begun::Transponder(Time::default(), Identity::of_address(1)) }
    }
}
