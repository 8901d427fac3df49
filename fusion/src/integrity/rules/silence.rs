//! Silence: what is not heard for longer than its reports are usually apart.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::history::{Heard, History};
use super::stream::Stream;
use crate::time::Time;

/// Silence of any transponder, seconds, and of one that reports rarely, in its median period.
const SILENT: (f64, f64) = (10.0, 3.0);
/// Silence that is longer than a single transponder's gaps, which last up to 20 s, and its period beside: likewise.
const LONG: (f64, f64) = (27.0, 6.0);
/// A report later than this counts for the silence as if it were that late, seconds: where a clock is wrong, all are late.
const LATE: SignedDuration = SignedDuration::from_secs(5);
/// Reports without which nothing is usual.
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

/// Whether a receiver has not heard an identity for so long.
pub(super) fn is_over(history: &History, deadline: Time) -> bool {
    let is_silent = |newest: &Heard| is_past(deadline - newest.time, SILENT, || history.period_s());
    history.newest().is_none_or(is_silent)
}

/// Whether no receiver hears an identity any longer.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Silence {
    /// Whether it was heard often enough to be missed.
    pub(super) is_known: bool,
    pub(super) is_silent: bool,
    /// The deadline at which it had been silent for longer than single ones usually are.
    pub(super) long_since: Option<Time>,
    /// Time stamp of its newest report at the last look.
    newest: Option<Time>,
    /// From when on it is silent: that time stamp, or later where the report came late.
    heard: Option<Time>,
}

impl Silence {
    /// Is not silent until it was heard again: the engine started afresh, and what came before says nothing.
    pub(super) fn start_afresh(&mut self) {
        *self = Self { newest: self.newest, heard: self.heard, ..Self::default() };
    }

    /// From when on it is silent.
    pub(super) fn heard(&self) -> Option<Time> {
        self.heard
    }

    /// Looks at an identity whose last report is `newest`.
    pub(super) fn look(&mut self, streams: &[Stream], newest: Time, deadline: Time) {
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

/// The median period at the receiver that hears it most often, seconds.
fn period_s(streams: &[Stream]) -> Option<f64> {
    streams.iter().filter_map(|stream| stream.history.period_s()).min_by(f64::total_cmp)
}
