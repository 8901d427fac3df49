//! Likelihood ratio that a radar track and a transponder are one aircraft, from the offset between them over time.
//!
//! If they are one, the offset of the radar's plots from the transponder's curve is the radar's bias, a first-order
//! Gauss–Markov process whose size is estimated from the plots, and white noise. If not, it is the distance between two
//! aircraft that move independently ([`axis`]). The logarithms of the plots' likelihood ratios are summed.

mod axis;

pub(super) use axis::{OffsetAxis, PlotErrors, Scales};

use serde::{Deserialize, Serialize};

use super::settings::{OperationalSettings, RadarSettings};
use super::transponder::{Transponder, TransponderBias};
use super::tuning::{
    BIAS_PENALTY_MAX_LLR, CHANGE_OVER_HZ, COMPARE_WITHIN_S, PAIR_LIKELY_LLR, PAIR_LLR_MAX, PLOT_LLR_MAX,
    SEPARATION_IN_HEIGHT, SEPARATION_OVER_GROUND, Separation,
};
use crate::filter::{Bias, LineOfSight, Moments, RadarErrors};
use crate::report::Plot;
use crate::time::Time;

/// Number of axes: range, azimuth (as metres across), height.
const AXES: usize = 3;
const SEPARATIONS: [Separation; AXES] =
    [SEPARATION_OVER_GROUND, SEPARATION_OVER_GROUND, SEPARATION_IN_HEIGHT];

/// Offset of a plot from the curve, and the errors of both.
#[derive(Clone, Copy, Debug)]
struct PlotOffset {
    /// Outward, clockwise and up, metres; the last is `None` if no height was measured.
    metres: [Option<f64>; AXES],
    errors: [PlotErrors; AXES],
    /// Correlation time of the radar's bias, seconds.
    correlation_s: f64,
}

impl PlotOffset {
    /// Offset of a plot of the radar at this distance over ground; `curve_m`: standard deviation of the curve, metres.
    fn new(
        metres: [Option<f64>; AXES],
        range_m: f64,
        radar: &RadarSettings,
        curve_m: f64,
        bias: &TransponderBias,
    ) -> Self {
        let RadarSettings { errors, data_sheet: sheet, scales, .. } = radar;
        let across = range_m * errors.noise_azimuth;
        let of = |bias_m, white_m, sheet_white_m, transponder_m2| PlotErrors {
            bias_m,
            white_m,
            sheet_white_m,
            curve_m,
            transponder_m2,
            scales: *scales,
        };
        Self {
            metres,
            errors: [
                of(errors.bias_range_m, errors.noise_range_m, sheet.noise_range_m, bias.horizontal_m2),
                of(range_m * errors.bias_azimuth, across, range_m * sheet.noise_azimuth, bias.horizontal_m2),
                of(errors.bias_height_m, errors.noise_height_m, sheet.noise_height_m, bias.vertical_m2),
            ],
            correlation_s: errors.correlation_s,
        }
    }
}

/// Likelihood ratio of a pair, and the prediction for the next plot.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct PairLikelihood {
    /// Sum over the plots.
    pub(super) llr: f64,
    /// Time of the last plot after which the pair was likely.
    pub(super) last_likely: Option<Time>,
    /// Penalty for the size of the bias that would explain the offset. It is not part of the sum, which is made of
    /// changes from plot to plot.
    pub(super) bias_penalty: f64,
    expected: Option<[OffsetAxis; AXES]>,
}

impl PairLikelihood {
    /// The sum with the penalty; `None` without a comparison.
    pub(super) fn total(&self) -> Option<f64> {
        self.expected.map(|_| self.llr - self.bias_penalty)
    }

    /// The likelihood as it counts at `time`. Since the last comparison the track may have changed to another object,
    /// so evidence for the pair is limited by the probability that it has not.
    pub(super) fn at(mut self, time: Time) -> Self {
        let unheard_s = self.last_likely.map_or(0.0, |last| time.seconds_since(last) - COMPARE_WITHIN_S);
        if unheard_s > 0.0 {
            self.llr = self.llr.min(-(CHANGE_OVER_HZ * unheard_s).min(1.0).ln());
        }
        self
    }

    /// Estimate of the radar's bias for a plot at this distance over ground, `dt` seconds later; `None` without a
    /// comparison.
    pub(super) fn bias(&self, range_m: f64, dt: f64, errors: &RadarErrors) -> Option<Bias> {
        let axes = self.expected?;
        let kept = (-dt / errors.correlation_s).exp();
        let later = |axis: usize, sigma: f64, scale: f64| {
            let (mean, variance) = axes[axis].bias();
            let fresh = sigma * sigma * (1.0 - kept * kept);
            Moments { mean: mean * kept * scale, variance: variance * kept * kept * scale * scale + fresh }
        };
        Some(Bias {
            range_m: later(0, errors.bias_range_m, 1.0),
            azimuth: later(1, errors.bias_azimuth, 1.0 / range_m),
            height_m: later(2, errors.bias_height_m, 1.0),
        })
    }

    /// Adds plots at times with a transponder position, in the given order: forward or backward in time.
    pub(super) fn add_plots<'a>(
        &mut self,
        plots: impl Iterator<Item = &'a Plot>,
        transponder: &Transponder,
        radar: &RadarSettings,
        settings: &OperationalSettings,
    ) {
        let mut before: Option<(Time, PlotOffset)> = None;
        let mut plots = plots.peekable();
        if plots.peek().is_none() {
            return;
        }
        let Some(mut walk) = transponder.walk(settings) else { return };
        let bias = transponder.bias(settings).unwrap_or_default();
        for plot in plots {
            let Some(curve) = walk.at(plot.time) else { continue };
            let seen = LineOfSight::from(radar.position, plot.position);
            let apart = plot.position.0 - curve.position.0;
            let metres = [
                Some(seen.outward.dot(&apart.xy())),
                Some(seen.clockwise.dot(&apart.xy())),
                (plot.height_measured && curve.height_measured).then_some(apart.z),
            ];
            let offset = PlotOffset::new(metres, seen.range_m, radar, curve.sigma_m, &bias);
            let dt = before.map_or(radar.period_s, |(before, _)| plot.time.seconds_since(before).abs());
            self.add(&offset, plot.time, dt);
            before = Some((plot.time, offset));
        }
        if let Some((_, last)) = before {
            self.penalise(&last);
        }
    }

    /// Adds a plot, `dt` seconds after the previous one, without updating the penalty.
    fn add(&mut self, offset: &PlotOffset, time: Time, dt: f64) {
        let errors = &offset.errors;
        if let Some(axes) = &mut self.expected {
            let kept = (-dt / offset.correlation_s).exp();
            for ((axis, errors), separation) in axes.iter_mut().zip(errors).zip(&SEPARATIONS) {
                axis.predict(dt, kept, errors, separation);
            }
        }
        let new = |index: usize| OffsetAxis::new(&errors[index], &SEPARATIONS[index]);
        let axes = self.expected.get_or_insert_with(|| std::array::from_fn(new));
        for ((axis, metres), errors) in axes.iter_mut().zip(offset.metres).zip(errors) {
            if let Some(metres) = metres {
                self.llr += axis.observe(metres, errors).clamp(-PLOT_LLR_MAX, PLOT_LLR_MAX);
            }
        }
        self.llr = self.llr.clamp(-PAIR_LLR_MAX, PAIR_LLR_MAX);
        if self.llr >= PAIR_LIKELY_LLR {
            self.last_likely = Some(time);
        }
    }

    /// Updates the penalty after the last plot.
    fn penalise(&mut self, last: &PlotOffset) {
        let axes = self.expected.iter().flatten();
        let penalty: f64 = axes.zip(&last.errors).map(|(axis, errors)| axis.bias_penalty(errors)).sum();
        self.bias_penalty = penalty.min(BIAS_PENALTY_MAX_LLR);
    }
}

#[cfg(test)]
mod tests;
