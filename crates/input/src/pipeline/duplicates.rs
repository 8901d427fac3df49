//! Removal of duplicates: redundant lines bring the same datagram more than once, and it is handled once.

use std::collections::{HashMap, VecDeque};
use std::net::SocketAddr;
use std::sync::Arc;

use serde::{Deserialize, Serialize, Serializer};

use super::senders::Earlier;
use fusion::time::{SECOND, Time};

/// Time for which a datagram is remembered, in nanoseconds.
pub(super) const MEMORY_NS: i64 = 2 * SECOND;

/// Maximum number of octets remembered. Two seconds hold more only while the clock of reception stands still after a step back.
const MEMORY_OCTETS: usize = 64 << 20;
/// Approximate memory of a remembered datagram beside its payload, in octets.
const OVERHEAD: usize = 96;
/// Maximum number of senders remembered for a refused datagram.
const REFUSED: usize = 8;

/// The datagrams of the last 2 s. Their octets are compared, not hashes, so that a collision loses no datagram.
#[derive(Debug, Default, Deserialize)]
#[serde(from = "Vec<Written>")]
pub(crate) struct Duplicates {
    known: HashMap<Arc<[u8]>, Copied>,
    /// Datagrams by time of reception, oldest first.
    order: VecDeque<(Time, Arc<[u8]>)>,
    octets: usize,
}

/// An earlier copy of a datagram.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Copied {
    /// Sender, if known.
    pub(super) from: Option<SocketAddr>,
    /// Whether the copy was handled. Otherwise it was refused as a whole, and a copy from another sender may be accepted.
    pub(super) handled: bool,
    at: Time,
    /// Senders whose copies were refused, with the time.
    pub(super) refused: Vec<Earlier>,
}

/// A datagram in a checkpoint. Only its latest entry has the state of its copies.
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
    /// Whether a copy of `payload` was handled within the 2 s before `now`, which never decreases. If not, remembers `payload`.
    pub(crate) fn is_repeated(&mut self, payload: &[u8], now: Time) -> bool {
        self.note(payload, None, now).is_some_and(|earlier| earlier.handled)
    }

    /// The copy of `payload` received within the 2 s before `now`, which never decreases. If none was handled, remembers this one
    /// as handled.
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

    /// Marks a datagram that was just noted as refused as a whole, so that a copy from another sender is handled.
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
            // A copy that was refused at first may have been handled since.
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
    fn copy_within_two_seconds_is_a_duplicate() {
        let mut duplicates = Duplicates::default();
        let mut at = |second: f64| duplicates.is_repeated(&[1, 2], Time::from_nanos((second * 1e9) as i64));
        assert!(!at(10.0));
        assert!(at(11.5));
        assert!(at(12.0), "2 s after the handled one");
        assert!(!at(12.1), "copies do not prolong it");
        assert!(at(14.0));
    }

    #[test]
    fn copy_of_a_refused_datagram_is_handled() {
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
    fn stopped_clock_does_not_fill_memory() {
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
