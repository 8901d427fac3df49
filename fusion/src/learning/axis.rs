//! Errors of one axis of a radar: estimates bias and white noise from the offsets of its tracks from the transponders'
//! curves.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::model::{AxisErrors, change_variance, mean_variance};
use super::pyramid::{LEVELS, MeanChange};
use super::sizes::SizeHistogram;

/// Number of axes: range (metres), azimuth (milliradians), height (metres).
pub(super) const AXES: usize = 3;

/// Number of plots whose mean is one sample of the bias.
pub(super) const MEAN_OF: usize = 4;
/// Correlation time of a transponder's bias, seconds: that of a satellite receiver lasts for a minute.
const TRANSPONDER_S: f64 = 60.0;
/// Correlation time of the error of the curve through its reports, seconds: about half the time between two of them.
const CURVE_S: f64 = 1.5;
/// Relative uncertainty of the variance assumed for a transponder's errors.
const TRANSPONDER_UNSURE: f64 = 1.0;
/// Model error of the logarithm of a variance: real errors are no Gauss–Markov process.
const MODEL_UNSURE: f64 = 0.1;

/// Changes or means of one kind: their sizes, and sums of the transponder's contributions to their variance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct GatheredChanges {
    pub(super) sizes: SizeHistogram,
    pub(super) count: f64,
    /// Sum of the times between plots, seconds.
    pub(super) spacing_s: f64,
    /// Sums of variances: of the transponder's bias, of the curve, and of constant errors of a track.
    pub(super) slow: f64,
    pub(super) curve: f64,
    pub(super) constant: f64,
}

/// Mean of the first plots of a track segment.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct SegmentMean {
    pub(super) size: f64,
    pub(super) spacing_s: f64,
    pub(super) slow: f64,
    pub(super) curve: f64,
    pub(super) constant: f64,
}

impl GatheredChanges {
    pub(super) const NONE: Self =
        Self { sizes: SizeHistogram::NONE, count: 0.0, spacing_s: 0.0, slow: 0.0, curve: 0.0, constant: 0.0 };

    fn add(&mut self, mean: &SegmentMean) {
        let SegmentMean { size, spacing_s, slow, curve, constant } = mean;
        self.sizes.add(*size);
        self.count += 1.0;
        self.spacing_s += spacing_s;
        self.slow += slow;
        self.curve += curve;
        self.constant += constant;
    }

    fn decay(&mut self, kept: f64) {
        self.sizes.decay(kept);
        let Self { sizes: _, count, spacing_s, slow, curve, constant } = self;
        for sum in [count, spacing_s, slow, curve, constant] {
            *sum *= kept;
        }
    }
}

/// Prior: the errors of the data sheet, and their uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ErrorPrior {
    pub(super) errors: AxisErrors,
    /// Standard deviations of the logarithms of bias, correlation time and noise.
    pub(super) unsure: [f64; 3],
    /// Ratio of the bias in turns to that in straight flight, and standard deviation of its logarithm.
    pub(super) turn_factor: f64,
    pub(super) turn_unsure: f64,
}

/// Estimated errors of one axis, with standard deviations of their logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FittedErrors {
    pub(super) errors: AxisErrors,
    pub(super) unsure: [f64; 3],
    pub(super) turn_factor: f64,
    pub(super) turn_unsure: f64,
    /// Number of independent samples of the bias.
    pub(super) tracks: f64,
}

/// Accumulated evidence of the radar's tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AxisSums {
    pub(super) changes: [GatheredChanges; LEVELS],
    pub(super) straight: GatheredChanges,
    pub(super) turning: GatheredChanges,
}

/// A measured variance, its model and its uncertainty.
struct MeasuredVariance {
    /// Logarithm of the variance.
    log: f64,
    /// Effective number of samples.
    count: f64,
    /// Model: variance for a bias of unit variance and a correlation time; share of the white noise.
    shape: fn(f64, f64, f64) -> f64,
    plots: f64,
    spacing_s: f64,
    white: f64,
    transponder: f64,
}

impl MeasuredVariance {
    fn of(
        gathered: &GatheredChanges,
        shape: fn(f64, f64, f64) -> f64,
        plots: usize,
        white: f64,
    ) -> Option<Self> {
        let (variance, plots, count) = (gathered.sizes.variance()?, plots as f64, gathered.count);
        let spacing_s = gathered.spacing_s / count;
        let GatheredChanges { slow, curve, constant, .. } = gathered;
        let transponder = slow * shape(plots, spacing_s, TRANSPONDER_S)
            + curve * shape(plots, spacing_s, CURVE_S)
            + constant;
        let effective = gathered.sizes.effective();
        // The expected logarithm of a mean of few squares is less than the logarithm of their variance.
        let log = variance.ln() + 1.0 / (effective + 1.0);
        Some(Self { log, count: effective, shape, plots, spacing_s, white, transponder: transponder / count })
    }

    /// Expected variance for these errors, and its derivatives: the contribution of the bias, its change with the
    /// logarithm of the correlation time, and the contribution of the white noise.
    fn expected(&self, errors: &AxisErrors) -> (f64, [f64; 3]) {
        const STEP: f64 = 0.05;
        let of = |correlation_s| {
            errors.bias * errors.bias * (self.shape)(self.plots, self.spacing_s, correlation_s)
        };
        let bias = of(errors.correlation_s);
        let slope =
            (of(errors.correlation_s * STEP.exp()) - of(errors.correlation_s * (-STEP).exp())) / (2.0 * STEP);
        let noise = self.white * errors.noise * errors.noise;
        (bias + noise + self.transponder, [bias, slope, noise])
    }

    /// Variance of the logarithm.
    fn log_variance(&self, expected: f64) -> f64 {
        let transponder = TRANSPONDER_UNSURE * self.transponder / expected;
        2.0 / self.count * (1.0 + 1.0 / self.count) + transponder * transponder + MODEL_UNSURE * MODEL_UNSURE
    }
}

impl AxisSums {
    pub(super) const NONE: Self = Self {
        changes: [GatheredChanges::NONE; LEVELS],
        straight: GatheredChanges::NONE,
        turning: GatheredChanges::NONE,
    };

    pub(super) fn change(&mut self, change: &MeanChange) {
        let MeanChange { level, size, spacing_s, slow, curve } = *change;
        self.changes[level].add(&SegmentMean { size, spacing_s, slow, curve, constant: 0.0 });
    }

    pub(super) fn mean(&mut self, mean: &SegmentMean, turning: bool) {
        if turning { self.turning.add(mean) } else { self.straight.add(mean) }
    }

    pub(super) fn decay(&mut self, kept: f64) {
        self.changes.iter_mut().for_each(|change| change.decay(kept));
        self.straight.decay(kept);
        self.turning.decay(kept);
    }

    /// Errors that best explain the sums, given the prior.
    ///
    /// Least squares of the logarithms of variances (Gauss–Newton), in the logarithms of the errors.
    pub(super) fn fit(&self, prior: &ErrorPrior) -> FittedErrors {
        let measured = self.measured();
        let logs = |errors: &AxisErrors| {
            Vector3::new(errors.bias.ln(), errors.correlation_s.ln(), errors.noise.ln())
        };
        let errors = |logs: &Vector3<f64>| AxisErrors {
            bias: logs[0].exp(),
            correlation_s: logs[1].exp(),
            noise: logs[2].exp(),
        };
        let beforehand = logs(&prior.errors);
        let certainty = Matrix3::from_diagonal(&Vector3::from(prior.unsure).map(|sigma| sigma.powi(-2)));
        let normal = |at: &Vector3<f64>| {
            let (mut matrix, mut vector) = (certainty, certainty * (beforehand - at));
            for measured in &measured {
                let (variance, parts) = measured.expected(&errors(at));
                let [bias, slope, noise] = parts.map(|part| part / variance);
                let row = Vector3::new(2.0 * bias, slope, 2.0 * noise);
                let weight = 1.0 / measured.log_variance(variance);
                matrix += row * row.transpose() * weight;
                vector += row * (weight * (measured.log - variance.ln()));
            }
            (matrix, vector)
        };
        let mut at = beforehand;
        for _ in 0..FIT_STEPS {
            let (matrix, vector) = normal(&at);
            let Some(step) = matrix.cholesky().map(|root| root.solve(&vector)) else { break };
            let longest = step.amax();
            at += step * (LONGEST_STEP / longest).min(1.0);
            if longest < FIT_SETTLED {
                break;
            }
        }
        let covariance = normal(&at).0.cholesky().map_or(Matrix3::zeros(), |root| root.inverse());
        let unsure = std::array::from_fn(|index| covariance[(index, index)].sqrt());
        let errors = errors(&at);
        let (turn_factor, turn_unsure) = self.turn_factor(prior, &errors, unsure[0]);
        FittedErrors { errors, unsure, turn_factor, turn_unsure, tracks: self.straight.count }
    }

    /// Ratio of the bias in turns to that in straight flight, and standard deviation of its logarithm.
    fn turn_factor(&self, prior: &ErrorPrior, errors: &AxisErrors, bias_unsure: f64) -> (f64, f64) {
        let beforehand = (prior.turn_factor, prior.turn_unsure);
        let Some(turning) = MeasuredVariance::of(&self.turning, mean_variance, MEAN_OF, 1.0 / MEAN_OF as f64)
        else {
            return beforehand;
        };
        let (mut log, mut unsure) = (beforehand.0.ln(), beforehand.1);
        for _ in 0..FIT_STEPS {
            let turned = AxisErrors { bias: errors.bias * log.exp(), ..*errors };
            let (variance, [bias, ..]) = turning.expected(&turned);
            let slope = 2.0 * bias / variance;
            let weight = 1.0 / (turning.log_variance(variance) + (slope * bias_unsure).powi(2));
            let certainty = beforehand.1.powi(-2) + slope * slope * weight;
            let pull = (beforehand.0.ln() - log) * beforehand.1.powi(-2)
                + slope * weight * (turning.log - variance.ln());
            let step = pull / certainty;
            log += step.clamp(-LONGEST_STEP, LONGEST_STEP);
            unsure = certainty.powf(-0.5);
            if step.abs() < FIT_SETTLED {
                break;
            }
        }
        (log.exp(), unsure)
    }

    fn measured(&self) -> Vec<MeasuredVariance> {
        let changes = self.changes.iter().enumerate().filter_map(|(level, gathered)| {
            let plots = 1 << level;
            MeasuredVariance::of(gathered, change_variance, plots, 2.0 / plots as f64)
        });
        let straight = MeasuredVariance::of(&self.straight, mean_variance, MEAN_OF, 1.0 / MEAN_OF as f64);
        changes.chain(straight).collect()
    }
}

/// Longest step of the fit, a logarithm; maximum number of steps; step at which the fit has converged.
const LONGEST_STEP: f64 = 0.7;
const FIT_STEPS: usize = 50;
const FIT_SETTLED: f64 = 1e-9;
