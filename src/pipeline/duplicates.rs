//! Redundant lines bring the same datagram more than once: it is handled once.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

use crate::time::{SECOND, Time};

/// How long a handled datagram is remembered, nanoseconds.
const MEMORY_NS: i64 = 2 * SECOND;

/// Octets that are remembered at most: more do not come in 2 s, unless the clock of reception waits to be caught up.
const MEMORY_OCTETS: usize = 64 << 20;
/// What remembering a datagram takes besides its octets, about.
const OVERHEAD: usize = 64;

/// The datagrams handled in the last 2 s, octet by octet: no hash stands for them, so none is lost by collision.
#[derive(Debug, Default)]
pub(crate) struct Duplicates {
    handled: HashSet<Arc<[u8]>>,
    /// By the time they were handled at, oldest first.
    order: VecDeque<(Time, Arc<[u8]>)>,
    octets: usize,
}

impl Duplicates {
    /// Whether `payload` was handled at most 2 s before `now`, which never decreases; remembers it where it was not.
    pub(crate) fn is_repeated(&mut self, payload: &[u8], now: Time) -> bool {
        while let Some((handled_at, oldest)) = self.order.front() {
            if now.nanos() - handled_at.nanos() <= MEMORY_NS && self.octets <= MEMORY_OCTETS {
                break;
            }
            self.octets -= OVERHEAD + oldest.len();
            self.handled.remove(oldest);
            self.order.pop_front();
        }
        if self.handled.contains(payload) {
            return true;
        }
        self.octets += OVERHEAD + payload.len();
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
    #[test]
    fn a_clock_that_stands_does_not_fill_the_memory() {
        let mut duplicates = Duplicates::default();
        let now = Time::from_nanos(0);
        for count in 0..3_000_u32 {
            let mut payload = vec![0; 60_000];
            payload[..4].copy_from_slice(&count.to_le_bytes());
            assert!(!duplicates.is_repeated(&payload, now));
        }
        assert!(duplicates.octets <= MEMORY_OCTETS + 2 * 60_000, "{}", duplicates.octets);
        assert_eq!(duplicates.handled.len(), duplicates.order.len());
    }
}
