//! Information from radar tracks, summed with slow decay.

use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};

use super::along::{Information, MeanOffset};
use super::parameters::{AXES, AZIMUTH, OWN, PRIOR};
use super::qmethod::AttitudeProfile;

/// Weighted sum over radar tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct MisalignmentSums {
    /// Least squares: azimuth, range, height.
    pub(super) axes: [Information; AXES],
    /// Profiles of the q-method: from azimuths, and from heights.
    pub(super) profiles: [AttitudeProfile; 2],
    /// Number of tracks, weighted.
    pub(super) tracks: f64,
    pub(super) spread: Scatter,
}

/// Scatter of the tracks about the others' estimate, relative to the expected deviations, by axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Scatter {
    /// Sum of squared normalised offsets.
    pub(super) squares: [f64; AXES],
    /// Number of tracks; each counts by its own share of the variance.
    pub(super) count: [f64; AXES],
}

/// Solution of the sums as one Gaussian: the misalignment of a radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SolvedSums {
    pub(super) mean: Vector6<f64>,
    pub(super) covariance: Matrix6<f64>,
}

/// Number of tracks with the expected scatter that are assumed in advance, because a few tracks do not determine the scatter.
const ASSUMED_TRACKS: f64 = 10.0;
/// Minimum factor of a variance.
const LEAST_FACTOR: f64 = 0.25;
/// Maximum factor of a variance. A larger scatter has another cause.
const LARGEST_FACTOR: f64 = 9.0;

impl Scatter {
    /// Factor of the variance on each axis: Birge's ratio, drawn towards 1.
    pub(super) fn factors(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| {
            let ratio = (ASSUMED_TRACKS + self.squares[axis]) / (ASSUMED_TRACKS + self.count[axis]);
            ratio.clamp(LEAST_FACTOR, LARGEST_FACTOR)
        })
    }

    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        for axis in 0..AXES {
            self.squares[axis] += weight * other.squares[axis];
            self.count[axis] += weight * other.count[axis];
        }
    }
}

impl MisalignmentSums {
    pub(super) fn none() -> Self {
        Self {
            axes: [Information::none(); AXES],
            profiles: [AttitudeProfile::none(); 2],
            tracks: 0.0,
            spread: Scatter::default(),
        }
    }

    /// Scales all sums by `kept`.
    pub(super) fn fade(&mut self, kept: f64) {
        let mut faded = Self::none();
        faded.add(self, kept);
        *self = faded;
    }

    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        for (sum, axis) in self.axes.iter_mut().zip(&other.axes) {
            sum.add(axis, weight);
        }
        for (sum, profile) in self.profiles.iter_mut().zip(&other.profiles) {
            sum.add(profile, weight);
        }
        self.tracks += weight * other.tracks;
        self.spread.add(&other.spread, weight);
    }

    /// The sums of one radar track.
    pub(super) fn of(axes: &[Information; AXES], spread: Scatter) -> Self {
        let turned = axes[AZIMUTH].offset(AZIMUTH).map_or(0.0, |offset| offset.mean);
        let [azimuth, _, height] = axes;
        let profiles = [AttitudeProfile::of(azimuth, turned), AttitudeProfile::of(height, turned)];
        Self { axes: *axes, profiles, tracks: 1.0, spread }
    }
}

impl SolvedSums {
    /// Solves the sums of each axis, with these factors of their variances.
    pub(super) fn from(axes: &[Information; AXES], factors: &[f64; AXES]) -> Self {
        let prior = Vector6::from(PRIOR);
        let mut all = Information::none();
        all.matrix.set_diagonal(&prior.map(|deviation| deviation.powi(-2)));
        for (axis, factor) in axes.iter().zip(factors) {
            all.add(axis, 1.0 / factor);
        }
        match all.matrix.cholesky() {
            Some(root) => {
                let covariance = root.inverse();
                Self { mean: covariance * all.vector, covariance }
            }
            // Only rounding can cause this, if the tracks' information exceeds the prior by more than the precision of a double.
            None => Self {
                mean: Vector6::zeros(),
                covariance: Matrix6::from_diagonal(&prior.component_mul(&prior)),
            },
        }
    }

    /// Distance of a track's mean offset on `axis` from the solution, the track's variance, and that of the solution.
    pub(super) fn compare(&self, track: &MeanOffset, axis: usize) -> (f64, f64, f64) {
        let MeanOffset { mean, variance, row } = track;
        let expected = row.dot(&self.mean);
        let distance = if OWN[axis] == super::parameters::BEARING {
            super::along::wrapped(mean - expected)
        } else {
            mean - expected
        };
        (distance, *variance, row.dot(&(self.covariance * row)))
    }
}
