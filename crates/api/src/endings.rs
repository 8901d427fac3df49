//! Detection of ended tracks, for readers of the stream.

use std::collections::HashMap;
use std::sync::Arc;

use super::track_slice::TrackSlice;
use fusion::time::{SECOND, Time};

/// Time without a point after which a track has ended, in nanoseconds.
const ENDED_NS: i64 = 2 * SECOND;

/// Time of the last point of each track.
#[derive(Clone, Debug, Default)]
pub struct Endings(HashMap<Arc<str>, Time>);

impl Endings {
    /// Records the tracks shown at `time`. Returns the ids of the tracks that have ended by then, in order.
    pub fn note<'a>(&mut self, time: Time, slices: impl Iterator<Item = &'a TrackSlice>) -> Vec<Arc<str>> {
        // After a replay jumped back, later tracks do not exist yet.
        self.0.retain(|_, last| *last <= time);
        for slice in slices {
            self.0.insert(slice.id.clone(), time);
        }
        let ended = |last: &Time| time.nanos() - last.nanos() >= ENDED_NS;
        let mut ids: Vec<Arc<str>> = self.0.extract_if(|_, last| ended(last)).map(|(id, _)| id).collect();
        ids.sort();
        ids
    }

    /// Whether the track has not ended since its last point.
    pub fn is_shown(&self, id: &str) -> bool {
        self.0.contains_key(id)
    }
}
