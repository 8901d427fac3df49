//! Which tracks ended: a reader that is shown slots is owed a word on those that no longer come.

use std::collections::HashMap;
use std::sync::Arc;

use serde::Serialize;

use super::gzip::Payload;
use super::piece::Piece;
use crate::picture::Rfc3339;
use fusion::time::{SECOND, Time};

/// A track that has not been shown for so long has ended, nanoseconds.
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

/// The `ended` event.
pub fn ended_event(id: &str, time: Time, ids: &[Arc<str>]) -> Payload {
    #[derive(Serialize)]
    struct Ended<'a> {
        time: Rfc3339,
        ids: Vec<&'a str>,
    }
    event(id, "ended", &Ended { time: time.into(), ids: ids.iter().map(|id| &**id).collect() })
}

/// The event `name`, which tells nothing but why it comes.
pub fn reason_event(id: &str, name: &str, reason: &str) -> Payload {
    #[derive(Serialize)]
    struct Reason<'a> {
        reason: &'a str,
    }
    event(id, name, &Reason { reason })
}

/// An event of the stream, of one line of JSON.
pub fn event(id: &str, name: &str, data: &impl Serialize) -> Payload {
    let data = serde_json::to_string(data).expect("texts, numbers and lists are written without failing");
    format!("id: {id}\nevent: {name}\ndata: {data}\n\n").into()
}
