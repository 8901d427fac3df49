//! Silence: an identity is not received for longer than the usual interval of its reports.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::history::{ReportHistory, TimedReport};
use super::stream::ReportStream;
use crate::time::Time;

/// Minimum silence of any transponder, seconds, and of a slow one, in median periods.
const SILENT: (f64, f64) = (10.0, 3.0);
/// Minimum of a long silence, likewise. Gaps of a single transponder last up to 20 s plus its period.
const LONG: (f64, f64) = (27.0, 6.0);
/// Maximum delay of a report for the start of a silence: a later report counts as this late, because with a wrong clock
/// all reports are late.
const LATE: SignedDuration = SignedDuration::from_secs(5);
/// Minimum number of reports from which a silence counts.
const REPORTS: usize = 3;

fn longer_of(least_s: f64, periods: f64, period_s: Option<f64>) -> SignedDuration {
    let longer_s = (periods * period_s.unwrap_or_default()).max(least_s);
    SignedDuration::from_millis((longer_s * 1e3) as i64)
}

fn is_past(
    silent: SignedDuration,
    (least_s, periods): (f64, f64),
    period_s: impl Fn() -> Option<f64>,
) -> bool {
    silent > longer_of(least_s, periods, None) && silent > longer_of(least_s, periods, period_s())
}

/// Whether a receiver has not received an identity for longer than usual.
pub(super) fn is_over(history: &ReportHistory, deadline: Time) -> bool {
    let is_silent = |newest: &TimedReport| is_past(deadline - newest.time, SILENT, || history.period_s());
    history.newest().is_none_or(is_silent)
}

/// Whether no receiver receives an identity any more.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Silence {
    /// Whether there were enough reports for a silence to count.
    pub(super) is_known: bool,
    pub(super) is_silent: bool,
    /// Deadline at which the silence became longer than usual gaps.
    pub(super) long_since: Option<Time>,
    /// Time stamp of the newest report at the last evaluation.
    newest: Option<Time>,
    /// Start of the silence: that time stamp, or later if the report was late.
    heard: Option<Time>,
}

impl Silence {
    /// Resets the silence until the identity is received again: the engine restarted, and the time before does not
    /// count.
    pub(super) fn restart(&mut self) {
        *self = Self { newest: self.newest, heard: self.heard, ..Self::default() };
    }

    /// Start of the silence.
    pub(super) fn since(&self) -> Option<Time> {
        self.heard
    }

    /// Evaluates an identity whose last report is `newest`.
    pub(super) fn evaluate(&mut self, streams: &[ReportStream], newest: Time, deadline: Time) {
        if self.newest.is_none_or(|known| newest > known) {
            (self.newest, self.heard) = (Some(newest), Some(newest.max(deadline - LATE)));
            self.is_known = self.is_known || streams.iter().any(|stream| stream.history.len() >= REPORTS);
        }
        let silent = deadline - self.heard.unwrap_or(newest);
        let period_s = || period_s(streams);
        self.is_silent = self.is_known && is_past(silent, SILENT, period_s);
        let is_long = self.is_silent && is_past(silent, LONG, period_s);
        self.long_since = is_long.then(|| self.long_since.unwrap_or(deadline));
    }
}

/// Median period at the receiver that receives it most often, seconds.
fn period_s(streams: &[ReportStream]) -> Option<f64> {
    streams.iter().filter_map(|stream| stream.history.period_s()).min_by(f64::total_cmp)
}
