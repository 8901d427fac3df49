//! Intended trajectory of the aircraft: I021/110.

use crate::Repeated;
use crate::aircraft::{IntentStatus, TrajectoryPoint};
use crate::item::items;

items! {
    /// I021/110, trajectory intent.
    compound pub struct TrajectoryIntent {
        /// TIS, status.
        "tis" status: IntentStatus,
        /// TID, the points.
        "tid" points: Repeated<TrajectoryPoint>,
        _,
        _,
        _,
        _,
        _,
    }
}
