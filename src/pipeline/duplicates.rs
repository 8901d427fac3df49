//! Redundant lines bring the same datagram more than once: it is handled once.

use std::collections::{HashMap, VecDeque};
use std::net::SocketAddr;
use std::sync::Arc;

use serde::{Deserialize, Serialize, Serializer};

use super::senders::Earlier;
use fusion::time::{SECOND, Time};

/// Time for which a datagram is remembered, nanoseconds.
pub(super) const MEMORY_NS: i64 = 2 * SECOND;

/// Most octets that are remembered: more come in 2 s only where the clock of reception waits to be caught up.
const MEMORY_OCTETS: usize = 64 << 20;
/// Cost of remembering a datagram besides its octets, about.
const OVERHEAD: usize = 96;
/// Most senders that are remembered of a datagram that was refused.
const REFUSED: usize = 8;

/// The datagrams of the last 2 s, octet by octet, not as hashes: none is lost by a collision.
#[derive(Debug, Default, Deserialize)]
#[serde(from = "Vec<Written>")]
pub(crate) struct Duplicates {
    known: HashMap<Arc<[u8]>, Copied>,
    /// By the time they came at, oldest first.
    order: VecDeque<(Time, Arc<[u8]>)>,
    octets: usize,
}

/// An earlier copy of a datagram.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Copied {
    /// Its sender, where that is known.
    pub(super) from: Option<SocketAddr>,
    /// Whether it was handled; otherwise all of it was refused, and a copy from another sender may count.
    pub(super) handled: bool,
    at: Time,
    /// Senders from which it was refused, and when.
    pub(super) refused: Vec<Earlier>,
}

/// A datagram in a checkpoint, with what is known of it where it is the one that was handled last.
type Written = (Time, Vec<u8>, Option<Copied>);

impl Serialize for Duplicates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.order.iter().map(|(at, payload)| {
            let known = self.known.get(payload).filter(|known| known.at == *at);
            (at, &payload[..], known)
        }))
    }
}

impl From<Vec<Written>> for Duplicates {
    fn from(written: Vec<Written>) -> Self {
        let mut duplicates = Self::default();
        for (at, payload, known) in written {
            let payload: Arc<[u8]> = payload.into();
            duplicates.octets += OVERHEAD + payload.len();
            known.into_iter().for_each(|known| _ = duplicates.known.insert(payload.clone(), known));
            duplicates.order.push_back((at, payload));
        }
        duplicates
    }
}

impl Duplicates {
    /// Whether `payload` was handled at most 2 s before `now`, which never decreases; remembers it where it was not.
    pub(crate) fn is_repeated(&mut self, payload: &[u8], now: Time) -> bool {
        self.note(payload, None, now).is_some_and(|earlier| earlier.handled)
    }

    /// The copy of `payload` that came at most 2 s before `now`, which never decreases. Where none was handled, this one is
    /// remembered as handled.
    pub(super) fn note(&mut self, payload: &[u8], from: Option<SocketAddr>, now: Time) -> Option<Copied> {
        self.forget(now);
        let earlier = self.known.get(payload).cloned();
        if earlier.as_ref().is_none_or(|earlier| !earlier.handled) {
            self.octets += OVERHEAD + payload.len();
            let payload: Arc<[u8]> = payload.into();
            let refused = earlier.as_ref().map(|earlier| earlier.refused.clone()).unwrap_or_default();
            self.known.insert(payload.clone(), Copied { from, handled: true, at: now, refused });
            self.order.push_back((now, payload));
        }
        earlier
    }

    /// Nothing of this datagram, which was noted just now, was taken: a copy from another sender is to be handled.
    pub(super) fn was_refused(&mut self, payload: &[u8]) {
        if let Some(known) = self.known.get_mut(payload) {
            known.handled = false;
            if known.refused.len() < REFUSED {
                known.refused.extend(known.from.map(|from| (from, known.at)));
            }
        }
    }

    fn forget(&mut self, now: Time) {
        while let Some((at, oldest)) = self.order.front() {
            if now.nanos() - at.nanos() <= MEMORY_NS && self.octets <= MEMORY_OCTETS {
                break;
            }
            self.octets -= OVERHEAD + oldest.len();
            // One that was refused at first may have been handled since.
            if self.known.get(oldest).is_some_and(|known| known.at <= *at) {
                self.known.remove(oldest);
            }
            self.order.pop_front();
        }
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
    fn a_refused_datagram_is_handled_when_its_copy_comes() {
        let mut duplicates = Duplicates::default();
        let at = |second: f64| Time::from_nanos((second * 1e9) as i64);
        assert_eq!(duplicates.note(&[1], None, at(10.0)), None);
        duplicates.was_refused(&[1]);
        let earlier = duplicates.note(&[1], None, at(11.5)).unwrap();
        assert!(!earlier.handled);
        assert!(duplicates.is_repeated(&[1], at(13.0)), "1.5 s after the handled one");
        assert!(!duplicates.is_repeated(&[1], at(13.6)));
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
        assert_eq!(duplicates.known.len(), duplicates.order.len());
    }
}
