//! Reports of one identity at each receiver, and the state of the rules for it.

use serde::{Deserialize, Serialize};

use super::duplicate::Duplicate;
use super::history::{ReportHistory, TimedReport};
use super::silence::Silence;
use super::stream::ReportStream;
use super::swapped::Swap;
use crate::report::SensorIndex;
use crate::time::Time;

/// Height above the lowest one up to which an aircraft may have landed, metres.
const LANDED_HEIGHT_M: f64 = 5.0;

/// Minimum descent to a landing, metres. The first report must be at most this much higher than the landing.
const LANDED_DESCENT_M: f64 = 10.0;

/// Maximum speed after a landing, m/s, and apparent motion of the receiver at rest, metres.
const LANDED_SPEED_M_S: f64 = 0.5;

const LANDED_WANDER_M: f64 = 2.0;

/// State of an identity.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct IdentityLedger {
    /// Streams by receiver, in the order of their first reports.
    pub(super) streams: Vec<ReportStream>,
    /// Numbers of the streams.
    pub(super) numbers: Vec<u32>,
    pub(super) duplicate: Duplicate,
    pub(super) swap: Option<Swap>,
    /// Time stamp of its newest report.
    pub(super) newest: Time,
    pub(super) silence: Silence,
    pub(super) heights: Option<ReportedHeights>,
}

/// Reported heights of an identity, metres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct ReportedHeights {
    first_m: f64,
    lowest_m: f64,
    highest_m: f64,
}

impl ReportedHeights {
    pub(super) fn update(heights: &mut Option<Self>, height_m: f64) {
        let first = Self { first_m: height_m, lowest_m: height_m, highest_m: height_m };
        let heights = heights.get_or_insert(first);
        heights.lowest_m = heights.lowest_m.min(height_m);
        heights.highest_m = heights.highest_m.max(height_m);
    }

    /// Whether this is the height of the ground from which it took off.
    fn is_ground(&self, height_m: f64) -> bool {
        height_m <= self.lowest_m + LANDED_HEIGHT_M
            && height_m <= self.highest_m - LANDED_DESCENT_M
            && self.first_m <= height_m + LANDED_DESCENT_M
    }
}

impl IdentityLedger {
    /// Index of the stream of a receiver; adds a stream if necessary.
    pub(super) fn at(&mut self, sensor: SensorIndex, numbers: &mut u32) -> usize {
        let known = self.streams.iter().position(|stream| stream.sensor == sensor);
        known.unwrap_or_else(|| {
            self.streams.push(ReportStream::new(sensor, *numbers));
            self.numbers.push(*numbers);
            *numbers = numbers.wrapping_add(1);
            self.streams.len() - 1
        })
    }

    /// The stream with the newest report.
    pub(super) fn latest(&self) -> Option<&ReportHistory> {
        let histories = self.streams.iter().map(|stream| &stream.history);
        histories.max_by_key(|history| history.newest().map(TimedReport::order))
    }

    /// Whether more than one aircraft sends this identity, so that its motion has no meaning.
    pub(super) fn is_several(&self, deadline: Time) -> bool {
        self.duplicate.is_active(deadline) || self.streams.iter().any(ReportStream::is_replay)
    }

    /// Whether the last reports look like a landing: slow, and back on the ground.
    pub(super) fn has_landed(&self) -> bool {
        let Some(history) = self.latest() else { return false };
        let mut last = history.before(history.len());
        let (Some(newest), Some(before)) = (last.next(), last.next()) else { return false };
        let rest_m = LANDED_WANDER_M + LANDED_SPEED_M_S * newest.apart_s(before);
        let is_low = self.heights.is_some_and(|heights| heights.is_ground(newest.position.z));
        is_low && newest.distance_m(before) <= rest_m
    }
}
