//! Size of the white noise of a transponder's positions, learnt from its reports alone.
//!
//! The distance of a report from the chord between its neighbours has two causes: the noise of the three reports, and turns of
//! the aircraft. One report does not separate them; many do, because every aircraft sometimes flies straight or hovers. Each of
//! several sizes of noise is therefore weighted by the likelihood of the reports, under a mixture of motions of different agility
//! (a static multiple-model estimator, Bar-Shalom (2001), section 11.6.2).
//!
//! The slow error of a GNSS receiver shifts all three reports together and cannot be seen. The configured accuracy is its only
//! source.

use std::array;

use serde::{Deserialize, Serialize};

use crate::report::Fix;

/// Candidate sizes of a transponder's white noise, as multiples of the configured one.
const NOISE_SCALES: [f64; COUNT] = [
    0.0625, 0.0884, 0.125, 0.177, 0.25, 0.354, 0.5, 0.707, 1.0, 1.414, 2.0, 2.828, 4.0, 5.657, 8.0, 11.31,
    16.0,
];
pub(crate) const COUNT: usize = 17;
/// Prior: decrease of the logarithm of the probability with each doubling or halving.
const NOISE_PRIOR_FALL: f64 = 1.5;
/// Maximum decrease of a size's log-probability that a transponder inherits from its type, because single units differ.
const TYPE_FALL_MAX: f64 = 6.0;
/// Motion between three reports: power spectral density of the acceleration, m²/s³, and share of the reports.
const REPORT_MOTIONS: [(f64, f64); 6] =
    [(0.0005, 0.2), (0.05, 0.2), (0.6, 0.1), (6.0, 0.15), (60.0, 0.25), (600.0, 0.1)];
/// Outliers: sigma, metres, and share of the reports.
const REPORT_OUTLIER: (f64, f64) = (50.0, 0.01);
/// Maximum time spanned by three reports that are evaluated, seconds.
const CHORD_MAX_S: f64 = 12.0;

/// Log-likelihood of a report for each of [`NOISE_SCALES`], up to a common summand.
pub(crate) type Likelihoods = [f64; COUNT];

/// Estimated size of the white noise on one axis, relative to the configured one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WhiteNoise {
    /// Logarithms of the prior weights.
    prior: Likelihoods,
    /// Logarithms of the present weights.
    logs: Likelihoods,
    /// Size and its deviation, cached because they are used far more often than reports arrive.
    scale: (f64, f64),
}

/// The configured size has the highest prior probability; it decreases with each step away.
impl Default for WhiteNoise {
    fn default() -> Self {
        Self::starting_at(NOISE_SCALES.map(|scale| -NOISE_PRIOR_FALL * scale.log2().abs()))
    }
}

impl WhiteNoise {
    fn starting_at(prior: Likelihoods) -> Self {
        Self { prior, logs: prior, scale: weighed(&prior) }
    }

    /// Noise of a new transponder, from that of its type.
    pub(crate) fn of_type(of_type: &Self) -> Self {
        Self::starting_at(of_type.logs.map(|log| log.max(-TYPE_FALL_MAX)))
    }

    /// Adds a report `dt` seconds of flight after the one before. Earlier evidence decays to 1/e in `memory_s`.
    pub(crate) fn add(&mut self, report: &Likelihoods, dt: f64, memory_s: f64) {
        let kept = (-dt / memory_s).exp();
        for ((log, report), prior) in self.logs.iter_mut().zip(report).zip(self.prior) {
            *log = prior + (*log - prior) * kept + report;
        }
        let most = self.logs.into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.logs.iter_mut().for_each(|log| *log -= most);
        self.scale = weighed(&self.logs);
    }

    /// Size relative to the configured one, and its standard deviation as a factor. The size is a geometric mean, in steps of a
    /// twentieth so that nearly equal sizes do not repeat the filtering.
    pub(crate) fn scale(&self) -> (f64, f64) {
        self.scale
    }

    /// Weights, kept across restarts.
    pub(super) fn weights(&self) -> &Likelihoods {
        &self.logs
    }

    /// Restores these weights.
    pub(super) fn from_weights(logs: &Likelihoods) -> Self {
        Self { logs: *logs, scale: weighed(logs), ..Self::default() }
    }
}

/// Size and deviation from the logarithms of the weights.
fn weighed(logs: &Likelihoods) -> (f64, f64) {
    let weights = logs.map(f64::exp);
    let sum: f64 = weights.iter().sum();
    let moment = |power: i32| {
        weights.iter().zip(NOISE_SCALES).map(|(weight, scale)| weight * scale.ln().powi(power)).sum::<f64>()
            / sum
    };
    let (mean, square) = (moment(1), moment(2));
    ((mean * 20.0).round().mul_add(0.05, 0.0).exp(), (square - mean * mean).max(0.0).sqrt().exp())
}

/// Log-likelihood of the middle one of three reports for each size of the noise, over ground and in height. `sigma_m`: configured
/// white noise on an axis of either. `None`: the reports are too far apart.
pub(crate) fn likelihoods([before, at, after]: [&Fix; 3], sigma_m: [f64; 2]) -> Option<[Likelihoods; 2]> {
    let (first_s, second_s) = (at.time.seconds_since(before.time), after.time.seconds_since(at.time));
    let span_s = first_s + second_s;
    if first_s <= 0.0 || second_s <= 0.0 || span_s > CHORD_MAX_S {
        return None;
    }
    let (early, late) = (second_s / span_s, first_s / span_s);
    let off = at.position.0 - before.position.0 * early - after.position.0 * late;
    // `noises`: variance of the distance from the chord, per variance of one report. `bends`: variance from turns, per density of
    // the acceleration: an integrated Wiener process that is known at both ends.
    let noises = 1.0 + early * early + late * late;
    let bends = (first_s * second_s).powi(2) / (3.0 * span_s);
    let of = |offs: &[f64], sigma_m: f64| {
        array::from_fn(|index| {
            let noise = (NOISE_SCALES[index] * sigma_m).powi(2) * noises;
            let squares: f64 = offs.iter().map(|off| off * off).sum();
            let likelihood =
                |variance: f64| (-0.5 * squares / variance).exp() / variance.powf(offs.len() as f64 / 2.0);
            let motions: f64 = REPORT_MOTIONS
                .iter()
                .map(|&(density, share)| share * likelihood(noise + density * bends))
                .sum();
            let (outlier_m, share) = REPORT_OUTLIER;
            // Each report is part of three chords, which have the information of two independent ones.
            0.5 * (motions + share * likelihood(outlier_m * outlier_m)).max(f64::MIN_POSITIVE).ln()
        })
    };
    Some([of(&[off.x, off.y], sigma_m[0]), of(&[off.z], sigma_m[1])])
}

#[cfg(test)]
mod tests;
