//! Silence: what is not heard for longer than its reports are usually apart.

use jiff::SignedDuration;

use super::history::History;
use super::stream::Stream;
use crate::time::Time;

/// Silence of any transponder, seconds;
const SILENT_S: f64 = 10.0;
/// of one that reports rarely, in its median period.
const SILENT_PERIODS: f64 = 3.0;
/// Silence that is longer than those a single transponder falls into, by judgement: its gaps last up to 20 s.
const LONG: SignedDuration = SignedDuration::from_secs(20);
/// Reports without which nothing is usual.
const REPORTS: usize = 3;

/// After how long one with this period is silent.
pub(super) fn after(period_s: Option<f64>) -> SignedDuration {
    let after_s = (SILENT_PERIODS * period_s.unwrap_or_default()).max(SILENT_S);
    SignedDuration::from_millis((after_s * 1e3) as i64)
}

/// Whether a receiver has not heard an identity for so long.
pub(super) fn is_over(history: &History, deadline: Time) -> bool {
    history.newest().is_none_or(|newest| deadline - newest.time > after(history.period_s()))
}

/// Whether no receiver hears an identity any longer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Silence {
    /// Whether it was heard often enough to be missed.
    pub(super) is_known: bool,
    pub(super) is_silent: bool,
    /// The deadline at which it had been silent for longer than single ones usually are.
    pub(super) long_since: Option<Time>,
}

impl Silence {
    /// Looks at an identity whose last report is `newest`.
    pub(super) fn look(&mut self, streams: &[Stream], newest: Time, deadline: Time) {
        self.is_known = self.is_known || streams.iter().any(|stream| stream.history.len() >= REPORTS);
        let silent = deadline - newest;
        self.is_silent = self.is_known && silent > after(None) && silent > after(period_s(streams));
        let is_long = self.is_silent && silent > LONG && silent > after(period_s(streams)) * 2;
        self.long_since = is_long.then(|| self.long_since.unwrap_or(deadline));
    }
}

/// The median period at the receiver that hears it most often, seconds.
fn period_s(streams: &[Stream]) -> Option<f64> {
    streams.iter().filter_map(|stream| stream.history.period_s()).min_by(f64::total_cmp)
}
