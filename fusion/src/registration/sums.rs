//! What radar tracks told, added up and slowly forgotten.

use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};

use super::along::{Information, Offset};
use super::parameters::{AXES, AZIMUTH, OWN, PRIOR};
use super::qmethod::AttitudeProfile;

/// A sum over radar tracks, each with a weight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sums {
    /// Least squares: azimuth, range, height.
    pub(super) axes: [Information; AXES],
    /// The q-method: of azimuths, of heights.
    pub(super) profiles: [AttitudeProfile; 2],
    /// How many tracks.
    pub(super) tracks: f64,
    pub(super) spread: Scatter,
}

/// How far tracks lie from what the others say, against what the deviations promise; by axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Scatter {
    /// Squares of normalised offsets.
    pub(super) squares: [f64; AXES],
    /// How many: a track counts as much as its own share in the deviation.
    pub(super) count: [f64; AXES],
}

/// The same as one Gaussian: the misalignment of a radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Solved {
    pub(super) mean: Vector6<f64>,
    pub(super) covariance: Matrix6<f64>,
}

/// So many tracks that lie as they should are assumed beforehand: a few tracks do not tell their spread.
const ASSUMED_TRACKS: f64 = 10.0;
/// A variance is wrong by no more than these factors, or the reason is another one.
const LEAST_FACTOR: f64 = 0.25;
const LARGEST_FACTOR: f64 = 9.0;

impl Scatter {
    /// The factor of each axis' variance: Birge's ratio, drawn towards 1.
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

impl Sums {
    pub(super) fn none() -> Self {
        Self {
            axes: [Information::none(); AXES],
            profiles: [AttitudeProfile::none(); 2],
            tracks: 0.0,
            spread: Scatter::default(),
        }
    }

    /// Everything counts this much from now on.
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

    /// One radar track.
    pub(super) fn of(axes: &[Information; AXES], spread: Scatter) -> Self {
        let turned = axes[AZIMUTH].offset(AZIMUTH).map_or(0.0, |offset| offset.mean);
        let [azimuth, _, height] = axes;
        let profiles = [AttitudeProfile::of(azimuth, turned), AttitudeProfile::of(height, turned)];
        Self { axes: *axes, profiles, tracks: 1.0, spread }
    }
}

impl Solved {
    /// From the sums of each axis, with these factors of their variances.
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
            // Rounding alone can do that, with tracks that outweigh what is known beforehand by more than doubles hold.
            None => Self {
                mean: Vector6::zeros(),
                covariance: Matrix6::from_diagonal(&prior.component_mul(&prior)),
            },
        }
    }

    /// How far a track's mean offset in `axis` lies from this, and the variance of that: the track's own, and this one's.
    pub(super) fn compare(&self, track: &Offset, axis: usize) -> (f64, f64, f64) {
        let Offset { mean, variance, row } = track;
        let expected = row.dot(&self.mean);
        let distance = if OWN[axis] == super::parameters::BEARING {
            super::along::wrapped(mean - expected)
        } else {
            mean - expected
        };
        (distance, *variance, row.dot(&(self.covariance * row)))
    }
}
