//! One axis of the offset between a transponder and a radar track: how likely it is under either hypothesis.
//!
//! * One aircraft: the offset is a first-order Gauss–Markov process, the radar's bias and the transponder's.
//! * Two aircraft: it is the distance between them, which changes with a nearly constant velocity.
//!
//! How large the radar's errors really are is not known: a data sheet is a promise, not a measurement. So "one aircraft" is
//! a mixture over multiples of the errors as they are known, a filter each, weighted by how well it has predicted the plots so
//! far; the better they are known, the nearer the multiples lie to 1. What a quiet radar shows of one aircraft is then expected
//! at least as precisely as the constant offset of two, which is never expected more precisely than the data sheet's white
//! noise: an offset that stays near zero does not speak against one aircraft, however quiet the radar is.
//!
//! Source: the static multiple-model estimator, Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and
//! Navigation* (2001), section 11.6.2.

use serde::{Deserialize, Serialize};

use crate::operational::tuning::{
    BIAS_FREE_SIGMAS2, ERROR_SCALES, MODEL_PROBABILITY_MIN, SCALES_UNSURE_MIN, Separation,
};

const COUNT: usize = ERROR_SCALES.len();

/// The errors at a plot along one axis, one sigma; the radar's as they are known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    /// The radar's bias, metres.
    pub(super) bias_m: f64,
    /// The radar's white noise, metres.
    pub(super) white_m: f64,
    /// White noise from interpolating the transponder's curve, metres.
    pub(super) curve_m: f64,
    /// The same by the radar's data sheet: what the distance of two aircraft is expected to show.
    pub(super) sheet_white_m: f64,
    /// The transponder's bias: variance, m². However good the radar is, this is between them.
    pub(super) transponder_m2: f64,
    /// The multiples of the radar's errors that may be the true ones.
    pub(super) scales: Scales,
}

/// Multiples of a radar's errors, each of which may be the true size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::operational) struct Scales([f64; COUNT]);

impl Scales {
    /// Of errors that a data sheet tells.
    pub(in crate::operational) fn of_data_sheet() -> Self {
        Self::of(1.0)
    }

    /// Of errors the logarithm of whose size is known to so much, where a data sheet's is to 1.
    pub(in crate::operational) fn of(unsure: f64) -> Self {
        let power = unsure.clamp(SCALES_UNSURE_MIN, 1.0);
        Self(ERROR_SCALES.map(|(scale, _)| if scale < 1.0 { scale.powf(power) } else { scale }))
    }
}

impl Errors {
    /// Variance of the bias between the two sensors, m².
    fn bias(&self, scale: f64) -> f64 {
        (scale * self.bias_m).powi(2) + self.transponder_m2
    }

    /// Variance of the white noise if both are one aircraft, m².
    fn white(&self, scale: f64) -> f64 {
        (scale * self.white_m).powi(2) + self.curve_m.powi(2)
    }

    /// If they are two. Of a radar that is worse than its data sheet it is halfway: with its own noise one of fifteen plots of
    /// `three` at twice the data sheet was tied no more, with the data sheet's one of ten of `crossing` was tied wrongly.
    fn white_of_two(&self) -> f64 {
        let learnt_m = self.white_m.max(self.sheet_white_m);
        learnt_m * self.sheet_white_m + self.curve_m.powi(2)
    }
}

/// Both hypotheses, as the plots so far have them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Axis {
    /// One aircraft, for each of [`ERROR_SCALES`].
    one: [Weighted; COUNT],
    two: TwoAircraft,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Weighted {
    /// Probability of this multiple; they add up to 1.
    weight: f64,
    filter: OneAircraft,
}

/// The offset of one aircraft: mean and variance.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct OneAircraft {
    mean: f64,
    variance: f64,
}

/// The offset of two and its rate: means, and covariance (offset, both, rate).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct TwoAircraft {
    mean: [f64; 2],
    covariance: [f64; 3],
}

impl Axis {
    /// Before the first plot.
    pub(super) fn new(errors: &Errors, separation: &Separation) -> Self {
        let Scales(scales) = errors.scales;
        let weighted = |index: usize| Weighted {
            weight: ERROR_SCALES[index].1,
            filter: OneAircraft { mean: 0.0, variance: errors.bias(scales[index]) },
        };
        let covariance = [separation.distance_m.powi(2), 0.0, separation.rate_m_s.powi(2)];
        Self { one: std::array::from_fn(weighted), two: TwoAircraft { mean: [0.0; 2], covariance } }
    }

    /// `dt` seconds later, in which the bias keeps the share `kept`.
    pub(super) fn predict(&mut self, dt: f64, kept: f64, errors: &Errors, separation: &Separation) {
        for (one, scale) in self.one.iter_mut().zip(errors.scales.0) {
            one.filter.predict(kept, errors.bias(scale));
        }
        self.two.predict(dt, separation.acceleration_m2_s3);
    }

    /// Takes an offset in, metres; its log-likelihood ratio, one aircraft over two.
    pub(super) fn observe(&mut self, metres: f64, errors: &Errors) -> f64 {
        let mut logs = [0.0; COUNT];
        for ((one, scale), log) in self.one.iter_mut().zip(errors.scales.0).zip(&mut logs) {
            *log = one.filter.observe(metres, errors.white(scale));
        }
        self.reweigh(logs) - self.two.observe(metres, errors.white_of_two())
    }

    /// Weighs the multiples by how likely they made a plot, logarithms; logarithm of how likely all together made it.
    fn reweigh(&mut self, logs: [f64; COUNT]) -> f64 {
        // Relative to the largest, so that nothing underflows but what is negligible.
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

    /// Makes the weights add up to 1; what they added up to.
    fn normalise(&mut self) -> f64 {
        let sum: f64 = self.one.iter().map(|one| one.weight).sum();
        self.one.iter_mut().for_each(|one| one.weight /= sum);
        sum
    }

    /// Mean and variance of the bias if both are one aircraft, metres and m².
    pub(super) fn bias(&self) -> (f64, f64) {
        let mean: f64 = self.one.iter().map(|one| one.weight * one.filter.mean).sum();
        let variance = |one: &Weighted| one.filter.variance + (one.filter.mean - mean).powi(2);
        (mean, self.one.iter().map(|one| one.weight * variance(one)).sum())
    }

    /// What the size of the bias that explains the offset counts against one aircraft, as a logarithm.
    pub(super) fn bias_penalty(&self, errors: &Errors) -> f64 {
        let mut penalties = [0.0; COUNT];
        for ((one, scale), penalty) in self.one.iter().zip(errors.scales.0).zip(&mut penalties) {
            *penalty = 0.5 * (one.filter.mean.powi(2) / errors.bias(scale) - BIAS_FREE_SIGMAS2).max(0.0);
        }
        if penalties == [0.0; COUNT] {
            return 0.0; // most often, and cheaper
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

    /// Takes an offset in; the logarithm of its likelihood.
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

    /// Takes an offset in; the logarithm of its likelihood.
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

/// Of a Gaussian innovation, without the constant that all have in common.
fn log_likelihood(innovation: f64, variance: f64) -> f64 {
    -0.5 * (innovation * innovation / variance + variance.ln())
}
