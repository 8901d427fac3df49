//! The last reports of one identity at one receiver, by time.

use std::collections::VecDeque;

use jiff::SignedDuration;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::report::Fix;
use crate::time::Time;

/// Time for which reports are kept: the longest rule evaluates 20 s, and a report may be 6 s late.
const KEPT: SignedDuration = SignedDuration::from_secs(32);
/// Number of reports kept longer, to determine the period of slow transponders.
const KEPT_REPORTS: usize = 12;
/// Maximum number of reports: 32 s at five reports a second.
const REPORTS_MAX: usize = 160;

/// A report, as received.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TimedReport {
    pub(super) time: Time,
    /// Position in the site's frame, metres; equal octets give equal bits.
    pub(super) position: Vector3<f64>,
    /// Reported velocity, m/s, east and north.
    pub(super) velocity: Option<Vector2<f64>>,
}

/// Sort key: time, then content, so that the order does not depend on the order of reception.
pub(super) type ReportOrder = (Time, [u64; 6]);

impl TimedReport {
    pub(super) fn new(fix: &Fix) -> Self {
        Self { time: fix.time, position: fix.position.0, velocity: fix.velocity }
    }

    pub(super) fn order(&self) -> ReportOrder {
        let [east, north, up] = self.place();
        let (said, [x, y]) = match self.velocity {
            Some(velocity) => (1, [velocity.x, velocity.y].map(f64::to_bits)),
            None => (0, [0; 2]),
        };
        (self.time, [east, north, up, said, x, y])
    }

    /// The bits of the position.
    pub(super) fn place(&self) -> [u64; 3] {
        [self.position.x, self.position.y, self.position.z].map(f64::to_bits)
    }

    /// Distance over ground, metres.
    pub(super) fn distance_m(&self, other: &Self) -> f64 {
        (self.position - other.position).xy().norm()
    }

    /// Absolute time difference to `other`, seconds.
    pub(super) fn apart_s(&self, other: &Self) -> f64 {
        self.time.seconds_since(other.time).abs()
    }
}

/// Reports by [`TimedReport::order`].
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct ReportHistory(VecDeque<TimedReport>);

impl ReportHistory {
    /// Inserts a report and returns its index; `None` if it is a duplicate, or older than all reports kept.
    pub(super) fn insert(&mut self, heard: TimedReport) -> Option<usize> {
        let reports = &mut self.0;
        let at = reports.partition_point(|known| known.order() < heard.order());
        let doubled = |known: &TimedReport| known.time == heard.time && known.place() == heard.place();
        let is_known =
            reports.get(at).is_some_and(doubled) || at.checked_sub(1).is_some_and(|at| doubled(&reports[at]));
        if is_known || at == 0 && reports.len() >= KEPT_REPORTS {
            return None;
        }
        reports.insert(at, heard);
        let mut dropped = 0;
        let since = reports[reports.len() - 1].time - KEPT;
        while reports.len() > REPORTS_MAX || reports.len() > KEPT_REPORTS && reports[0].time < since {
            reports.pop_front();
            dropped += 1;
        }
        at.checked_sub(dropped)
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn get(&self, at: usize) -> Option<&TimedReport> {
        self.0.get(at)
    }

    pub(super) fn newest(&self) -> Option<&TimedReport> {
        self.0.back()
    }

    /// Index of the first report after `time`.
    pub(super) fn after(&self, time: Time) -> usize {
        self.0.partition_point(|heard| heard.time <= time)
    }

    /// Median time between the last reports, seconds.
    pub(super) fn period_s(&self) -> Option<f64> {
        let mut periods_s = [0.0; KEPT_REPORTS - 1];
        let mut known = 0;
        for (later, earlier) in self.iter().rev().zip(self.iter().rev().skip(1)).take(periods_s.len()) {
            periods_s[known] = later.apart_s(earlier);
            known += 1;
        }
        let periods_s = &mut periods_s[..known];
        (known > 0).then(|| *periods_s.select_nth_unstable_by(known / 2, f64::total_cmp).1)
    }

    /// The reports from index `at` on.
    pub(super) fn from(&self, at: usize) -> impl Iterator<Item = &TimedReport> {
        self.0.range(at.min(self.0.len())..)
    }

    /// The reports before index `at`, the latest first.
    pub(super) fn before(&self, at: usize) -> impl Iterator<Item = &TimedReport> {
        self.0.range(..at.min(self.0.len())).rev()
    }

    /// All reports, by time.
    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = &TimedReport> {
        self.0.iter()
    }
}
