//! A radar's velocities against its own plots: along the line of sight, where no transponder tells better.

use serde::{Deserialize, Serialize};

use super::model::change_variance;
use crate::filter::RadarErrors;
use crate::time::Time;

/// The rate of the range is taken over this long, seconds,
const SPAN_S: f64 = 2.0;
/// and over so many plots at least.
const PLOTS: usize = 4;
/// Longer, plots are of no use: a drone may have turned meanwhile.
const LONGEST_S: f64 = 6.0;

/// The plots of a radar track since its last comparison.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct RangeRate(Vec<Seen>);

/// A plot.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Seen {
    pub(crate) time: Time,
    /// Distance over ground, metres.
    pub(crate) range_m: f64,
    /// Its rate by the velocity that the radar told, m/s.
    pub(crate) told_m_s: f64,
}

/// How far the told rate of the range was off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RateOff {
    pub(super) time: Time,
    pub(super) off_m_s: f64,
    /// Variance of the rate as it was seen, m²/s².
    pub(super) variance: f64,
}

impl RangeRate {
    /// One plot more of a radar that errs so, later than those before.
    pub(crate) fn add(&mut self, seen: Seen, errors: &RadarErrors) -> Option<RateOff> {
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
        let mean = |plots: &[Seen], part: &dyn Fn(&Seen) -> f64| {
            plots.iter().map(part).sum::<f64>() / plots.len() as f64
        };
        let (before, after) = (&plots[..half], &plots[plots.len() - half..]);
        let change = |part: &dyn Fn(&Seen) -> f64| mean(after, part) - mean(before, part);
        let apart_s = change(&|seen| seen.time.seconds_since(first));
        let seen_m_s = change(&|seen| seen.range_m) / apart_s;
        let (count, spacing_s) = (half as f64, span_s / (plots.len() - 1) as f64);
        let bias = errors.bias_range_m.powi(2) * change_variance(count, spacing_s, errors.correlation_s);
        let noise = 2.0 * errors.noise_range_m.powi(2) / count;
        let off_m_s = mean(plots, &|seen| seen.told_m_s) - seen_m_s;
        plots.clear();
        Some(RateOff { time: seen.time, off_m_s, variance: (bias + noise) / (apart_s * apart_s) })
    }
}
