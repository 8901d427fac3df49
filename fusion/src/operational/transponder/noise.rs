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

use super::super::tuning::{
    CHORD_MAX_S, NOISE_CHANGE_S, NOISE_PRIOR_FALL, NOISE_SCALES, REPORT_MOTIONS, REPORT_OUTLIER,
};
use crate::report::Fix;

const COUNT: usize = NOISE_SCALES.len();

/// What is known of the size of the white noise along one axis, relative to what is configured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::operational) struct WhiteNoise {
    /// Logarithms of the weights of [`NOISE_SCALES`], without a common summand.
    logs: [f64; COUNT],
    /// What they make of it: asked for far more often than reports come.
    scale: (f64, f64),
}

impl Default for WhiteNoise {
    fn default() -> Self {
        Self { logs: prior(), scale: weighed(&prior()) }
    }
}

/// The configured size is likeliest; each step away from it is less so.
fn prior() -> [f64; COUNT] {
    NOISE_SCALES.map(|scale| -NOISE_PRIOR_FALL * scale.log2().abs())
}

impl WhiteNoise {
    /// Takes in what a report tells that came `dt` seconds after the one before; what was long ago fades.
    pub(in crate::operational) fn add(&mut self, told: &[f64; COUNT], dt: f64) {
        let kept = (-dt / NOISE_CHANGE_S).exp();
        for ((log, told), prior) in self.logs.iter_mut().zip(told).zip(prior()) {
            *log = prior + (*log - prior) * kept + told;
        }
        let most = self.logs.into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.logs.iter_mut().for_each(|log| *log -= most);
        self.scale = weighed(&self.logs);
    }

    /// The size relative to the configured one: geometric mean, in steps of a twentieth so that what was filtered with nearly
    /// the same one is not filtered again; and its standard deviation as a factor.
    pub(in crate::operational) fn scale(&self) -> (f64, f64) {
        self.scale
    }
}

/// The same of weights whose logarithms these are.
fn weighed(logs: &[f64; COUNT]) -> (f64, f64) {
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
/// `sigma_m`: the configured white noise of an axis of either. `None`: they are too far apart to tell.
pub(super) fn told([before, at, after]: [&Fix; 3], sigma_m: [f64; 2]) -> Option<[[f64; COUNT]; 2]> {
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
