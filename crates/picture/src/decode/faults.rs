//! Counts of octets and frames that cannot be read.

use std::collections::BTreeMap;
use std::fmt;

use input::capture::{Capture, Gaps, SkipReason};
use input::json::Place;

/// Number of errors in captures, by reason. `Display`: `3 errors in the input: 2 item-past-end, 1 skipped`.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    counts: BTreeMap<String, u64>,
    /// Unreadable octets of the capture that is being read.
    octets: Gaps,
}

/// Number of frames that could not be read and may have held records, by reason.
pub fn lost_frames(capture: &Capture) -> impl Iterator<Item = (SkipReason, u64)> {
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
    /// Counts an error with its octets.
    pub fn note(&mut self, reason: &str, place: Place<'_>, octets: &[u8]) {
        *self.counts.entry(reason.to_owned()).or_default() += 1;
        self.octets.add(place.offset, octets.len());
    }

    /// Ends a capture: counts its unreadable frames that may have held records, which are reported in no other way. Returns the
    /// octets of the capture that could not be read.
    pub fn end(&mut self, capture: &Capture) -> Gaps {
        for (reason, times) in lost_frames(capture) {
            *self.counts.entry(format!("{reason} frame")).or_default() += times;
        }
        std::mem::take(&mut self.octets)
    }

    /// Whether there are no errors.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Number of errors by reason.
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
