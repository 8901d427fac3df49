//! Counts skipped messages of the log: messages that are invalid where they were written. They are counted by place and reason,
//! and each pair is logged once a minute.
#![expect(
    clippy::disallowed_methods,
    reason = "the pause between two log lines is timed by a monotonic clock"
)]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tracing::warn;

/// Minimum interval of the log lines for a place and reason, and time for which a skipped message is recent.
const LOG_INTERVAL: Duration = Duration::from_secs(60);
/// Maximum number of pairs of place and reason counted separately; further ones are counted together.
const MAX_KINDS: usize = 64;
/// Beginnings of known message versions.
const KNOWN_VERSIONS: [&[u8]; 5] = [b"UTM1", b"UTM2", b"UTO2", b"UTO3", b"UTL1"];

/// Messages skipped at one place for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Skipped {
    /// Subject or key of the log, without the region.
    pub place: String,
    /// Reason.
    pub reason: String,
    /// Number of messages since the process started.
    pub count: u64,
    /// Whether one was skipped within the last minute.
    pub is_recent: bool,
}

#[derive(Debug)]
struct SkipCount {
    count: u64,
    last: Instant,
    logged: Instant,
    unlogged: u64,
}

/// Counts what one process skips. Clones share their counts.
#[derive(Clone, Debug, Default)]
pub struct Skips(Arc<Mutex<BTreeMap<(String, String), SkipCount>>>);

impl Skips {
    fn counts(&self) -> MutexGuard<'_, BTreeMap<(String, String), SkipCount>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a skipped message.
    pub fn note(&self, place: &str, reason: &str) {
        let (now, mut counts) = (Instant::now(), self.counts());
        let mut key = (place.to_owned(), reason.to_owned());
        if counts.len() >= MAX_KINDS && !counts.contains_key(&key) {
            key = ("elsewhere".to_owned(), "many kinds of messages that cannot be read".to_owned());
        }
        let new = SkipCount { count: 0, last: now, logged: now, unlogged: 0 };
        let known = counts.entry(key.clone()).or_insert(new);
        (known.count, known.last, known.unlogged) = (known.count + 1, now, known.unlogged + 1);
        if known.count == 1 || now - known.logged >= LOG_INTERVAL {
            let messages = std::mem::take(&mut known.unlogged);
            known.logged = now;
            let (place, reason) = key;
            warn!(place, reason, messages, "messages of the log are skipped");
        }
    }

    /// Counts a skipped message that cannot be read.
    pub fn unreadable(&self, place: &str, octets: &[u8]) {
        self.note(place, &unreadable(octets));
    }

    /// All counts.
    pub fn all(&self) -> Vec<Skipped> {
        let skipped = |((place, reason), of): (&(String, String), &SkipCount)| Skipped {
            place: place.clone(),
            reason: reason.clone(),
            count: of.count,
            is_recent: of.last.elapsed() < LOG_INTERVAL,
        };
        self.counts().iter().map(skipped).collect()
    }
}

/// Reason why octets cannot be read. An unknown message version is named.
pub fn unreadable(octets: &[u8]) -> String {
    match octets.first_chunk::<4>() {
        Some(beginning) if KNOWN_VERSIONS.contains(&&beginning[..]) => {
            "the message is cut or damaged".to_owned()
        }
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
        assert!(
            skips.all().len() <= MAX_KINDS + 1 && skips.all().iter().map(|of| of.count).sum::<u64>() == 1006
        );
    }
}
