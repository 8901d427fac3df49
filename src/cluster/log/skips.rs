//! Messages of the log that are skipped because their place cannot have them: counted by place and reason, and logged once a
//! minute each.
#![expect(
    clippy::disallowed_methods,
    reason = "the pause between two log lines is timed by a monotonic clock"
)]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tracing::warn;

/// Each place and reason is logged at most this often, and is recent for as long.
const TOLD: Duration = Duration::from_secs(60);
/// Pairs of place and reason that are counted each; all further ones are counted as one.
const KINDS: usize = 64;
/// Beginnings of the messages that are read.
const KNOWN: [&[u8]; 5] = [b"UTM1", b"UTM2", b"UTO2", b"UTO3", b"UTL1"];

/// Messages that were skipped at one place for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Skipped {
    /// Subject or key of the log, without the region.
    pub place: String,
    /// Why.
    pub reason: String,
    /// How many since the process started.
    pub count: u64,
    /// Whether one came within the last minute.
    pub is_recent: bool,
}

#[derive(Debug)]
struct Counted {
    count: u64,
    last: Instant,
    told: Instant,
    untold: u64,
}

/// Counts what one process skips; clones count together.
#[derive(Clone, Debug, Default)]
pub struct Skips(Arc<Mutex<BTreeMap<(String, String), Counted>>>);

impl Skips {
    fn counts(&self) -> MutexGuard<'_, BTreeMap<(String, String), Counted>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One more.
    pub fn note(&self, place: &str, reason: &str) {
        let (now, mut counts) = (Instant::now(), self.counts());
        let mut key = (place.to_owned(), reason.to_owned());
        if counts.len() >= KINDS && !counts.contains_key(&key) {
            key = ("elsewhere".to_owned(), "many kinds of messages that cannot be read".to_owned());
        }
        let new = Counted { count: 0, last: now, told: now, untold: 0 };
        let known = counts.entry(key.clone()).or_insert(new);
        (known.count, known.last, known.untold) = (known.count + 1, now, known.untold + 1);
        if known.count == 1 || now - known.told >= TOLD {
            let messages = std::mem::take(&mut known.untold);
            known.told = now;
            let (place, reason) = key;
            warn!(place, reason, messages, "messages of the log are skipped");
        }
    }

    /// One more message that cannot be read.
    pub fn unreadable(&self, place: &str, octets: &[u8]) {
        self.note(place, &unreadable(octets));
    }

    /// All of them.
    pub fn all(&self) -> Vec<Skipped> {
        let skipped = |((place, reason), of): (&(String, String), &Counted)| Skipped {
            place: place.clone(),
            reason: reason.clone(),
            count: of.count,
            is_recent: of.last.elapsed() < TOLD,
        };
        self.counts().iter().map(skipped).collect()
    }
}

/// Why octets cannot be read: a version that this program does not know is named.
pub fn unreadable(octets: &[u8]) -> String {
    match octets.first_chunk::<4>() {
        Some(beginning) if KNOWN.contains(&&beginning[..]) => "the message is cut or damaged".to_owned(),
        Some([b'U', b'T', kind, version]) if kind.is_ascii_uppercase() && version.is_ascii_alphanumeric() => {
            format!("a message of version UT{}{}", char::from(*kind), char::from(*version))
        }
        _ => "not a message of a cluster".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skipped_messages_are_counted_and_unknown_versions_named() {
        let skips = Skips::default();
        for octets in [&b"hello"[..], b"UTO4....", b"UTO2", b"", b"UTO4", b"UTM3 of a later version"] {
            skips.unreadable("out.all", octets);
        }
        let reasons: Vec<_> = skips.all().into_iter().map(|of| (of.reason, of.count, of.is_recent)).collect();
        let expected = [
            ("a message of version UTM3", 1),
            ("a message of version UTO4", 2),
            ("not a message of a cluster", 2),
            ("the message is cut or damaged", 1),
        ];
        assert_eq!(reasons, expected.map(|(reason, count)| (reason.to_owned(), count, true)));
        (0..1000).for_each(|place| skips.note(&format!("out.{place}"), "reason"));
        assert!(skips.all().len() <= KINDS + 1 && skips.all().iter().map(|of| of.count).sum::<u64>() == 1006);
    }
}
