//! Redundant lines bring the same datagram more than once: it is handled once.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

use crate::time::{SECOND, Time};

/// How long a handled datagram is remembered, nanoseconds.
const MEMORY_NS: i64 = 2 * SECOND;

/// The datagrams handled in the last 2 s, octet by octet: no hash stands for them, so none is lost by collision.
#[derive(Debug, Default)]
pub(crate) struct Duplicates {
    handled: HashSet<Arc<[u8]>>,
    /// By the time they were handled at, oldest first.
    order: VecDeque<(Time, Arc<[u8]>)>,
}

impl Duplicates {
    /// Whether `payload` was handled at most 2 s before `now`, which never decreases; remembers it where it was not.
    pub(crate) fn is_repeated(&mut self, payload: &[u8], now: Time) -> bool {
        while let Some((handled_at, oldest)) = self.order.front() {
            if now.nanos() - handled_at.nanos() <= MEMORY_NS {
                break;
            }
            self.handled.remove(oldest);
            self.order.pop_front();
        }
        if self.handled.contains(payload) {
            return true;
        }
        let payload: Arc<[u8]> = payload.into();
        self.handled.insert(payload.clone());
        self.order.push_back((now, payload));
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_within_two_seconds_of_the_handled_one_is_repeated() {
        let mut duplicates = Duplicates::default();
        let mut at = |second: f64| duplicates.is_repeated(&[1, 2], Time::from_nanos((second * 1e9) as i64));
        assert!(!at(10.0));
        assert!(at(11.5));
        assert!(at(12.0), "2 s after the handled one");
        assert!(!at(12.1), "copies do not prolong it");
        assert!(at(14.0));
    }
}
