//! One axis of the offset between a transponder and a radar track: its likelihood under two hypotheses.
//!
//! * One aircraft: the offset is a first-order Gauss–Markov process, the biases of radar and transponder.
//! * Two aircraft: it is the distance between them, which changes with a nearly constant velocity.
//!
//! The true size of the radar's errors is unknown: a data sheet is no measurement. So "one aircraft" is a mixture over
//! multiples of the known errors, each with a filter, weighted by how well it has predicted the plots so far. The
//! better the errors are known, the nearer the multiples are to 1. For a quiet radar the offset of one aircraft is then
//! predicted at least as precisely as the constant offset of two. The latter is never predicted more precisely than the
//! data sheet's white noise. So an offset that stays near zero is no evidence against one aircraft, however quiet the
//! radar is.
//!
//! Source: the static multiple-model estimator, Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications
//! to Tracking and Navigation* (2001), section 11.6.2.

use serde::{Deserialize, Serialize};

use crate::operational::tuning::{
    BIAS_FREE_SIGMAS2, ERROR_SCALES, MODEL_PROBABILITY_MIN, SCALES_UNSURE_MIN, Separation,
};

const COUNT: usize = ERROR_SCALES.len();

/// Errors at a plot along one axis, standard deviations; those of the radar as they are known.
#[derive(Clone, Copy, Debug)]
pub(in crate::operational) struct PlotErrors {
    /// Bias of the radar, metres.
    pub(super) bias_m: f64,
    /// White noise of the radar, metres.
    pub(super) white_m: f64,
    /// White noise from interpolating the transponder's curve, metres.
    pub(super) curve_m: f64,
    /// White noise of the radar by its data sheet, metres, which is used for the distance of two aircraft.
    pub(super) sheet_white_m: f64,
    /// Variance of the transponder's bias, m², which limits the precision for any radar.
    pub(super) transponder_m2: f64,
    /// Possible multiples of the radar's errors.
    pub(super) scales: Scales,
}

/// Possible multiples of a radar's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::operational) struct Scales([f64; COUNT]);

impl Scales {
    /// Multiples for the errors of a data sheet.
    pub(in crate::operational) fn of_data_sheet() -> Self {
        Self::of(1.0)
    }

    /// Multiples for errors with this uncertainty of their logarithm, relative to that of a data sheet.
    pub(in crate::operational) fn of(unsure: f64) -> Self {
        let power = unsure.clamp(SCALES_UNSURE_MIN, 1.0);
        Self(ERROR_SCALES.map(|(scale, _)| if scale < 1.0 { scale.powf(power) } else { scale }))
    }
}

impl PlotErrors {
    /// Errors of the distance between the lines of sight of two cameras, whose accuracy is known about as well as a learnt one:
    /// standard deviations of the lasting and of the white errors, metres.
    pub(in crate::operational) fn of_lines(lasting_m: f64, white_m: f64) -> Self {
        Self {
            bias_m: lasting_m,
            white_m,
            curve_m: 0.0,
            sheet_white_m: white_m,
            transponder_m2: 0.0,
            scales: Scales::of(SCALES_UNSURE_MIN),
        }
    }

    /// Variance of the bias between the two sensors, m².
    fn bias(&self, scale: f64) -> f64 {
        (scale * self.bias_m).powi(2) + self.transponder_m2
    }

    /// Variance of the white noise if both are one aircraft, m².
    fn white(&self, scale: f64) -> f64 {
        (scale * self.white_m).powi(2) + self.curve_m.powi(2)
    }

    /// Variance of the white noise if they are two, m². For a radar that is worse than its data sheet it is halfway.
    /// With the radar's own noise, one of fifteen plots of `three` at twice the data sheet was no longer associated;
    /// with the data sheet's, one of ten of `crossing` was associated wrongly.
    fn white_of_two(&self) -> f64 {
        let learnt_m = self.white_m.max(self.sheet_white_m);
        learnt_m * self.sheet_white_m + self.curve_m.powi(2)
    }
}

/// Both hypotheses, given the plots so far.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(in crate::operational) struct OffsetAxis {
    /// One aircraft, for each of [`ERROR_SCALES`].
    one: [WeightedHypothesis; COUNT],
    two: TwoAircraft,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct WeightedHypothesis {
    /// Probability of this multiple; the sum is 1.
    weight: f64,
    filter: OneAircraft,
}

/// Offset of one aircraft: mean and variance.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct OneAircraft {
    mean: f64,
    variance: f64,
}

/// Offset of two aircraft and its rate: means, and covariance (variance of the offset, covariance, variance of the
/// rate).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct TwoAircraft {
    mean: [f64; 2],
    covariance: [f64; 3],
}

impl OffsetAxis {
    /// State before the first plot.
    pub(in crate::operational) fn new(errors: &PlotErrors, separation: &Separation) -> Self {
        let Scales(scales) = errors.scales;
        let weighted = |index: usize| WeightedHypothesis {
            weight: ERROR_SCALES[index].1,
            filter: OneAircraft { mean: 0.0, variance: errors.bias(scales[index]) },
        };
        let covariance = [separation.distance_m.powi(2), 0.0, separation.rate_m_s.powi(2)];
        Self { one: std::array::from_fn(weighted), two: TwoAircraft { mean: [0.0; 2], covariance } }
    }

    /// Predicts the state `dt` seconds later, when a share `kept` of the bias remains.
    pub(in crate::operational) fn predict(
        &mut self,
        dt: f64,
        kept: f64,
        errors: &PlotErrors,
        separation: &Separation,
    ) {
        for (one, scale) in self.one.iter_mut().zip(errors.scales.0) {
            one.filter.predict(kept, errors.bias(scale));
        }
        self.two.predict(dt, separation.acceleration_m2_s3);
    }

    /// Updates the state by an offset, metres; returns the log-likelihood ratio of one aircraft against two.
    pub(in crate::operational) fn observe(&mut self, metres: f64, errors: &PlotErrors) -> f64 {
        let mut logs = [0.0; COUNT];
        for ((one, scale), log) in self.one.iter_mut().zip(errors.scales.0).zip(&mut logs) {
            *log = one.filter.observe(metres, errors.white(scale));
        }
        self.reweigh(logs) - self.two.observe(metres, errors.white_of_two())
    }

    /// Updates the weights of the multiples by the log-likelihoods of a plot; returns the log-likelihood of the
    /// mixture.
    fn reweigh(&mut self, logs: [f64; COUNT]) -> f64 {
        // Relative to the largest, so that only negligible values underflow.
        let most = logs.into_iter().fold(f64::NEG_INFINITY, f64::max);
        for (one, log) in self.one.iter_mut().zip(logs) {
            if log < most {
                one.weight *= (log - most).exp();
            }
        }
        let sum = self.normalise();
        for one in &mut self.one {
            one.weight = one.weight.max(MODEL_PROBABILITY_MIN);
        }
        self.normalise();
        most + sum.ln()
    }

    /// Normalises the weights to a sum of 1; returns their sum before.
    fn normalise(&mut self) -> f64 {
        let sum: f64 = self.one.iter().map(|one| one.weight).sum();
        self.one.iter_mut().for_each(|one| one.weight /= sum);
        sum
    }

    /// Mean and variance of the bias if both are one aircraft, metres and m².
    pub(super) fn bias(&self) -> (f64, f64) {
        let mean: f64 = self.one.iter().map(|one| one.weight * one.filter.mean).sum();
        let variance = |one: &WeightedHypothesis| one.filter.variance + (one.filter.mean - mean).powi(2);
        (mean, self.one.iter().map(|one| one.weight * variance(one)).sum())
    }

    /// Penalty against one aircraft for the size of the bias that explains the offset, a logarithm.
    pub(in crate::operational) fn bias_penalty(&self, errors: &PlotErrors) -> f64 {
        let mut penalties = [0.0; COUNT];
        for ((one, scale), penalty) in self.one.iter().zip(errors.scales.0).zip(&mut penalties) {
            *penalty = 0.5 * (one.filter.mean.powi(2) / errors.bias(scale) - BIAS_FREE_SIGMAS2).max(0.0);
        }
        if penalties == [0.0; COUNT] {
            return 0.0; // the most frequent case, and cheap
        }
        let believed: f64 =
            self.one.iter().zip(penalties).map(|(one, penalty)| one.weight * (-penalty).exp()).sum();
        -believed.max(f64::MIN_POSITIVE).ln()
    }
}

impl OneAircraft {
    fn predict(&mut self, kept: f64, bias: f64) {
        let variance = self.variance * kept * kept + bias * (1.0 - kept * kept);
        *self = Self { mean: self.mean * kept, variance };
    }

    /// Updates the state by an offset; returns the log-likelihood.
    fn observe(&mut self, metres: f64, white: f64) -> f64 {
        let total = self.variance + white;
        let innovation = metres - self.mean;
        let gain = self.variance / total;
        *self = Self { mean: self.mean + gain * innovation, variance: self.variance * (1.0 - gain) };
        log_likelihood(innovation, total)
    }
}

impl TwoAircraft {
    fn predict(&mut self, dt: f64, acceleration: f64) {
        let ([x, v], [p, c, q]) = (self.mean, self.covariance);
        self.mean = [x + v * dt, v];
        self.covariance = [
            p + 2.0 * dt * c + dt * dt * q + acceleration * dt.powi(3) / 3.0,
            c + dt * q + acceleration * dt * dt / 2.0,
            q + acceleration * dt,
        ];
    }

    /// Updates the state by an offset; returns the log-likelihood.
    fn observe(&mut self, metres: f64, white: f64) -> f64 {
        let ([x, v], [p, c, q]) = (self.mean, self.covariance);
        let total = p + white;
        let innovation = metres - x;
        let (g, h) = (p / total, c / total);
        self.mean = [x + g * innovation, v + h * innovation];
        self.covariance = [p * (1.0 - g), c * (1.0 - g), q - h * c];
        log_likelihood(innovation, total)
    }
}

/// Log-likelihood of a Gaussian innovation, without the common constant.
fn log_likelihood(innovation: f64, variance: f64) -> f64 {
    -0.5 * (innovation * innovation / variance + variance.ln())
}
