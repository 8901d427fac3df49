//! Which tracks ended: readers of the stream are told.

use std::collections::HashMap;
use std::sync::Arc;

use super::piece::Piece;
use fusion::time::{SECOND, Time};

/// A track has ended when it has not been shown for this duration, ns.
const ENDED_NS: i64 = 2 * SECOND;

/// When each track was shown last.
#[derive(Clone, Debug, Default)]
pub struct Endings(HashMap<Arc<str>, Time>);

impl Endings {
    /// Notes what is shown at a time, and gives the ids that ended by then, in order.
    pub fn note<'a>(&mut self, time: Time, pieces: impl Iterator<Item = &'a Piece>) -> Vec<Arc<str>> {
        // A replay went back: what was there later is not there yet.
        self.0.retain(|_, last| *last <= time);
        for piece in pieces {
            self.0.insert(piece.id.clone(), time);
        }
        let ended = |last: &Time| time.nanos() - last.nanos() >= ENDED_NS;
        let mut ids: Vec<Arc<str>> = self.0.extract_if(|_, last| ended(last)).map(|(id, _)| id).collect();
        ids.sort();
        ids
    }

    /// Whether the track has not ended since it was shown.
    pub fn is_shown(&self, id: &str) -> bool {
        self.0.contains_key(id)
    }
}
