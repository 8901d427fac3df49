//! The delay of some of the transponders, apart from all others: least squares over the radar tracks that go with them, with the
//! radar's misalignment as what is known otherwise.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::along::Sample;
use super::estimate::{BiasValue, Misalignment, TimeInformation};
use super::parameters::{PARAMETERS, TIME};

/// Sums over pieces of radar tracks of one radar, slowly forgotten.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DelaySums {
    /// Information about the delay, and about it together with each other parameter of the radar.
    row: Vector6<f64>,
    /// Information times the mean, with all other parameters zero.
    sum: f64,
}

/// This share of what the pieces before have shown is forgotten with each piece.
const FORGOTTEN: f64 = 1.0 / 200.0;

impl DelaySums {
    /// Numbers of which it is made.
    pub(crate) const NUMBERS: usize = PARAMETERS + 1;
    pub(crate) const NONE: Self = Self { row: Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), sum: 0.0 };

    /// A piece of a radar track more.
    pub(crate) fn add(&mut self, sample: &Sample) {
        *self = Self { row: self.row * (1.0 - FORGOTTEN), sum: self.sum * (1.0 - FORGOTTEN) };
        for information in &sample.axes {
            self.row += information.matrix.column(TIME);
            self.sum += information.vector[TIME];
        }
    }

    /// What they show of the delay of a radar that is misaligned so; none without a prior.
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
        // Sums of before a restart may be any numbers.
        if (known.inverse_variance + known.weighted_mean).is_finite() { known } else { none }
    }

    /// The same as numbers.
    pub(crate) fn to_numbers(self) -> [f64; Self::NUMBERS] {
        std::array::from_fn(|index| self.row.as_slice().get(index).copied().unwrap_or(self.sum))
    }

    /// From such numbers.
    pub(crate) fn from_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let [row @ .., sum] = numbers;
        Self { row: Vector6::from_column_slice(row), sum: *sum }
    }
}
