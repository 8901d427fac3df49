//! A radar's errors, and its line of sight to a position.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::frames::Enu;

/// A radar's errors, standard deviations: a persistent bias (including unknown misalignment), and white noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadarErrors {
    /// Bias of the range, metres.
    pub bias_range_m: f64,
    /// Bias of the azimuth, radians.
    pub bias_azimuth: f64,
    /// Bias of the height, metres.
    pub bias_height_m: f64,
    /// Noise of the range, metres.
    pub noise_range_m: f64,
    /// Noise of the azimuth, radians.
    pub noise_azimuth: f64,
    /// Noise of the height, metres.
    pub noise_height_m: f64,
    /// The biases' correlation time (to 1/e), seconds.
    pub correlation_s: f64,
}

impl RadarErrors {
    /// Derives the errors from the accuracy in a radar's data sheet, standard deviations in metres, degrees, metres.
    ///
    /// A data sheet does not state which part of an error persists. Assumed are a bias about as large as the accuracy
    /// (in azimuth 1.3 times, because turns enlarge it), and noise of a fraction of it.
    pub fn of_data_sheet(range_m: f64, azimuth_deg: f64, height_m: f64) -> Self {
        let azimuth = azimuth_deg.to_radians();
        Self {
            bias_range_m: 0.9 * range_m,
            bias_azimuth: 1.3 * azimuth,
            bias_height_m: 0.9 * height_m,
            noise_range_m: 0.4 * range_m,
            noise_azimuth: 0.2 * azimuth,
            noise_height_m: 0.3 * height_m,
            correlation_s: 20.0,
        }
    }
}

/// A position over ground as seen from a radar: distance, and the axes along and across the line of sight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LineOfSight {
    /// Distance over ground, metres.
    pub range_m: f64,
    /// Unit vector away from the radar.
    pub outward: Vector2<f64>,
    /// Unit vector in the direction of increasing azimuth.
    pub clockwise: Vector2<f64>,
}

impl LineOfSight {
    /// The line of sight from the radar at `radar` to `place`.
    pub fn from(radar: Enu, place: Enu) -> Self {
        let away = (place.0 - radar.0).xy();
        let range_m = away.norm().max(1.0);
        let outward = away / range_m;
        Self { range_m, outward, clockwise: Vector2::new(outward.y, -outward.x) }
    }

    /// Covariance over ground of errors with these standard deviations in range, metres, and azimuth, radians.
    pub fn spread(&self, range_m: f64, azimuth: f64) -> Matrix2<f64> {
        let across = self.range_m * azimuth;
        self.outward * self.outward.transpose() * (range_m * range_m)
            + self.clockwise * self.clockwise.transpose() * (across * across)
    }
}
