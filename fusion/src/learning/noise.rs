//! How large the white noise of a transponder's positions is: learnt from its reports alone.
//!
//! A report lies off the chord between the one before and the one after it, by its own noise and theirs, and by how the
//! aircraft turned meanwhile. Which of the two it was is not known of one report; of many it is, because every aircraft flies
//! straight or hovers now and then. So each of a few sizes of the noise is weighed by how well it explains the reports, with
//! motion of several vigours mixed in (a static multiple-model estimator, Bar-Shalom (2001), section 11.6.2).
//!
//! The slow error of a satellite receiver moves all three reports alike and does not show: of that the configured accuracy
//! remains the only witness.

use std::array;

use serde::{Deserialize, Serialize};

use crate::report::Fix;

/// Sizes of a transponder's white noise that are weighed, as multiples of what is configured.
const NOISE_SCALES: [f64; COUNT] = [
    0.0625, 0.0884, 0.125, 0.177, 0.25, 0.354, 0.5, 0.707, 1.0, 1.414, 2.0, 2.828, 4.0, 5.657, 8.0, 11.31,
    16.0,
];
pub(crate) const COUNT: usize = 17;
/// Logarithm of how much less likely each doubling or halving is before there are reports.
const NOISE_PRIOR_FALL: f64 = 1.5;
/// What its type has shown makes no size less likely for one transponder than this, logarithm: units differ.
const TYPE_FALL_MAX: f64 = 6.0;
/// How an aircraft moves between three reports: power spectral density of the acceleration, m²/s³, and how often.
const REPORT_MOTIONS: [(f64, f64); 6] =
    [(0.0005, 0.2), (0.05, 0.2), (0.6, 0.1), (6.0, 0.15), (60.0, 0.25), (600.0, 0.1)];
/// A report that is off for another reason: sigma, metres, and how often.
const REPORT_OUTLIER: (f64, f64) = (50.0, 0.01);
/// Three reports over a longer time than this show nothing of noise, seconds.
const CHORD_MAX_S: f64 = 12.0;

/// Logarithm of how likely each of [`NOISE_SCALES`] makes a report, without a common summand.
pub(crate) type Likelihoods = [f64; COUNT];

/// What is known of the size of the white noise along one axis, relative to what is configured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WhiteNoise {
    /// Logarithms of the weights before any report, and now.
    prior: Likelihoods,
    logs: Likelihoods,
    /// What they make of it: asked for far more often than reports come.
    scale: (f64, f64),
}

/// The configured size is likeliest; each step away from it is less so.
impl Default for WhiteNoise {
    fn default() -> Self {
        Self::starting_at(NOISE_SCALES.map(|scale| -NOISE_PRIOR_FALL * scale.log2().abs()))
    }
}

impl WhiteNoise {
    fn starting_at(prior: Likelihoods) -> Self {
        Self { prior, logs: prior, scale: weighed(&prior) }
    }

    /// Of a transponder of a type whose white noise is this.
    pub(crate) fn of_type(of_type: &Self) -> Self {
        Self::starting_at(of_type.logs.map(|log| log.max(-TYPE_FALL_MAX)))
    }

    /// Takes in a report `dt` seconds of flight after the one before; what is long ago fades to 1/e in `memory_s`.
    pub(crate) fn add(&mut self, report: &Likelihoods, dt: f64, memory_s: f64) {
        let kept = (-dt / memory_s).exp();
        for ((log, report), prior) in self.logs.iter_mut().zip(report).zip(self.prior) {
            *log = prior + (*log - prior) * kept + report;
        }
        let most = self.logs.into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.logs.iter_mut().for_each(|log| *log -= most);
        self.scale = weighed(&self.logs);
    }

    /// The size relative to the configured one: geometric mean, in steps of a twentieth so that what was filtered with nearly
    /// the same one is not filtered again; and its standard deviation as a factor.
    pub(crate) fn scale(&self) -> (f64, f64) {
        self.scale
    }

    /// What outlives a restart.
    pub(super) fn weights(&self) -> &Likelihoods {
        &self.logs
    }

    /// Goes on where these weights were written.
    pub(super) fn from_weights(logs: &Likelihoods) -> Self {
        Self { logs: *logs, scale: weighed(logs), ..Self::default() }
    }
}

/// The same of weights whose logarithms these are.
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

/// The logarithm of how likely each size of the noise makes the middle one of three reports, over ground and in height;
/// `sigma_m`: the configured white noise of an axis of either. `None`: they are too far apart to show it.
pub(crate) fn likelihoods([before, at, after]: [&Fix; 3], sigma_m: [f64; 2]) -> Option<[Likelihoods; 2]> {
    let (first_s, second_s) = (at.time.seconds_since(before.time), after.time.seconds_since(at.time));
    let span_s = first_s + second_s;
    if first_s <= 0.0 || second_s <= 0.0 || span_s > CHORD_MAX_S {
        return None;
    }
    let (early, late) = (second_s / span_s, first_s / span_s);
    let off = at.position.0 - before.position.0 * early - after.position.0 * late;
    // Variance of the chord's noise in that of one report, and of the way off it in the density of the acceleration: of an
    // integrated Wiener process that is known at both ends.
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
            // Each report is part of three chords: as much is new as if it were part of two.
            0.5 * (motions + share * likelihood(outlier_m * outlier_m)).max(f64::MIN_POSITIVE).ln()
        })
    };
    Some([of(&[off.x, off.y], sigma_m[0]), of(&[off.z], sigma_m[1])])
}

#[cfg(test)]
mod tests;
