//! Whether a radar track is a drone: the log-odds that its plots add up to.

use super::settings::Radar;
use crate::normalise::Plot;

/// A probability of this says nothing; above it speaks for a drone.
const NEUTRAL: f64 = 0.45;
/// A second of plots with a probability that is higher by 1 would add this.
const SLOPE: f64 = 8.0;
/// What one second of plots adds at most, and takes away.
const MOST: f64 = 1.5;
/// What a second of plots of a radar that does not say adds.
const UNKNOWN: f64 = -0.2;
/// A track is put out from here on.
pub(super) const CONFIRMED: f64 = 3.0;
/// The sum is held between these, so that it can change its mind.
const LIMITS: (f64, f64) = (-8.0, 8.0);

/// The log-odds with these plots. Successive plots say much the same: what counts is how long they come.
pub(super) fn with<'a>(sum: f64, plots: impl Iterator<Item = &'a Plot>, radar: &Radar) -> f64 {
    plots.fold(sum, |sum, plot| {
        let evidence = plot.uav_probability.map_or(UNKNOWN, |probability| SLOPE * (probability - NEUTRAL));
        let period_s = radar.period_s.min(1.0);
        (sum + evidence.clamp(-MOST, MOST) * period_s).clamp(LIMITS.0, LIMITS.1)
    })
}
