//! Compares a radar's velocities with its own plots along the line of sight, where transponders give too little
//! evidence.

use serde::{Deserialize, Serialize};

use super::model::change_variance;
use crate::filter::RadarErrors;
use crate::time::Time;

/// Minimum period for a range rate, seconds.
const SPAN_S: f64 = 2.0;
/// Minimum number of plots for a range rate.
const PLOTS: usize = 4;
/// Maximum period, seconds: after a longer one the drone may have turned.
const LONGEST_S: f64 = 6.0;

/// The plots of a radar track since its last comparison.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct RangeRate(Vec<RatePlot>);

/// A plot.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct RatePlot {
    pub(crate) time: Time,
    /// Distance over ground, metres.
    pub(crate) range_m: f64,
    /// Range rate of the radar's reported velocity, m/s.
    pub(crate) reported_m_s: f64,
}

/// Error of the reported range rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RangeRateError {
    pub(super) time: Time,
    pub(super) off_m_s: f64,
    /// Variance of the range rate computed from plots, m²/s².
    pub(super) variance: f64,
}

impl RangeRate {
    /// Adds a plot, later than those before, of a radar with these errors.
    pub(crate) fn add(&mut self, seen: RatePlot, errors: &RadarErrors) -> Option<RangeRateError> {
        let Self(plots) = self;
        plots.push(seen);
        let span_s = seen.time.seconds_since(plots[0].time);
        if span_s > LONGEST_S {
            plots.clear();
        }
        if plots.len() < PLOTS || span_s < SPAN_S {
            return None;
        }
        let half = plots.len() / 2;
        let first = plots[0].time;
        let mean = |plots: &[RatePlot], part: &dyn Fn(&RatePlot) -> f64| {
            plots.iter().map(part).sum::<f64>() / plots.len() as f64
        };
        let (before, after) = (&plots[..half], &plots[plots.len() - half..]);
        let change = |part: &dyn Fn(&RatePlot) -> f64| mean(after, part) - mean(before, part);
        let apart_s = change(&|seen| seen.time.seconds_since(first));
        let seen_m_s = change(&|seen| seen.range_m) / apart_s;
        let (count, spacing_s) = (half as f64, span_s / (plots.len() - 1) as f64);
        let bias = errors.bias_range_m.powi(2) * change_variance(count, spacing_s, errors.correlation_s);
        let noise = 2.0 * errors.noise_range_m.powi(2) / count;
        let off_m_s = mean(plots, &|seen| seen.reported_m_s) - seen_m_s;
        plots.clear();
        Some(RangeRateError { time: seen.time, off_m_s, variance: (bias + noise) / (apart_s * apart_s) })
    }
}
