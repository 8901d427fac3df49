//! What could not be read, counted.

use std::collections::BTreeMap;
use std::fmt;

use crate::capture::{Capture, Gaps, SkipReason};
use crate::json::Place;

/// How much of captures could not be read, by reason. `Display`: `3 errors in the input: 2 item-past-end, 1 skipped`.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    counts: BTreeMap<String, u64>,
    /// Octets of the capture that is being read.
    octets: Gaps,
}

/// The frames that may have held records and could not be read, by reason.
pub(crate) fn lost_frames(capture: &Capture) -> impl Iterator<Item = (SkipReason, u64)> {
    let lost = [
        SkipReason::Fragment,
        SkipReason::Truncated,
        SkipReason::Malformed,
        SkipReason::TooDeep,
        SkipReason::LinkType,
        SkipReason::UnknownInterface,
    ];
    capture.skipped().iter().filter(move |(reason, _)| lost.contains(reason))
}

impl Faults {
    /// Counts these octets, which stand there.
    pub fn note(&mut self, reason: &str, place: Place<'_>, octets: &[u8]) {
        *self.counts.entry(reason.to_owned()).or_default() += 1;
        self.octets.add(place.offset, octets.len());
    }

    /// The capture has come to its end: counts the unreadable frames that may have held records, which nothing else tells of.
    /// What remains are the octets that could not be read of it.
    pub fn end(&mut self, capture: &Capture) -> Gaps {
        for (reason, times) in lost_frames(capture) {
            *self.counts.entry(format!("{reason} frame")).or_default() += times;
        }
        std::mem::take(&mut self.octets)
    }

    /// Whether all could be read.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// How many there are of each.
    pub fn counts(&self) -> &BTreeMap<String, u64> {
        &self.counts
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total: u64 = self.counts.values().sum();
        let counts: Vec<_> = self.counts.iter().map(|(reason, times)| format!("{times} {reason}")).collect();
        let plural = if total == 1 { "" } else { "s" };
        write!(f, "{total} error{plural} in the input: {}", counts.join(", "))
    }
}
