//! Delay of a group of transponders relative to all others: least squares over their radar tracks, given the radar's
//! misalignment.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::along::Sample;
use super::estimate::{BiasValue, Misalignment, TimeInformation};
use super::parameters::{PARAMETERS, TIME};

/// Sums over segments of radar tracks of one radar, with slow decay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DelaySums {
    /// Information about the delay, and cross information with each other parameter of the radar.
    row: Vector6<f64>,
    /// Information times mean, with all other parameters zero.
    sum: f64,
}

/// Share of the earlier information that is dropped with each segment.
const FORGOTTEN: f64 = 1.0 / 200.0;

impl DelaySums {
    /// Number of values in the serialised form.
    pub(crate) const NUMBERS: usize = PARAMETERS + 1;
    pub(crate) const NONE: Self = Self { row: Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), sum: 0.0 };

    /// Adds a segment of a radar track.
    pub(crate) fn add(&mut self, sample: &Sample) {
        *self = Self { row: self.row * (1.0 - FORGOTTEN), sum: self.sum * (1.0 - FORGOTTEN) };
        for information in &sample.axes {
            self.row += information.matrix.column(TIME);
            self.sum += information.vector[TIME];
        }
    }

    /// Estimate of the delay, given the misalignment of the radar, without a prior.
    pub(crate) fn given(&self, misalignment: &Misalignment) -> TimeInformation {
        let none = TimeInformation { inverse_variance: 0.0, weighted_mean: 0.0 };
        let own = self.row[TIME];
        if own <= 0.0 {
            return none;
        }
        let Misalignment { bearing, tilt_east, tilt_north, range_m, height_m, .. } = misalignment;
        let others = [bearing, tilt_east, tilt_north, range_m, height_m];
        let (mut mean, mut variance) = (self.sum / own, 1.0 / own);
        for (shared, BiasValue { value, deviation, .. }) in self.row.iter().zip(others) {
            mean -= shared / own * value;
            variance += (shared / own * deviation).powi(2);
        }
        let known = TimeInformation { inverse_variance: variance.recip(), weighted_mean: mean / variance };
        // Restored sums may hold any numbers.
        if (known.inverse_variance + known.weighted_mean).is_finite() { known } else { none }
    }

    /// The sums as numbers.
    pub(crate) fn to_numbers(self) -> [f64; Self::NUMBERS] {
        std::array::from_fn(|index| self.row.as_slice().get(index).copied().unwrap_or(self.sum))
    }

    /// The sums from these numbers.
    pub(crate) fn from_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let [row @ .., sum] = numbers;
        Self { row: Vector6::from_column_slice(row), sum: *sum }
    }
}
