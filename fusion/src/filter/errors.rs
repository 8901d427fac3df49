//! A radar's errors, and how it sees a place.

use nalgebra::{Matrix2, Vector2};

use crate::frames::Enu;

/// How wrong a radar is, one standard deviation each: an error that lasts for a while (registration included, where that is
/// not known), and one that is new with every plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarErrors {
    /// Slow error of the range, metres.
    pub bias_range_m: f64,
    /// Slow error of the azimuth, radians.
    pub bias_azimuth: f64,
    /// Slow error of the height, metres.
    pub bias_height_m: f64,
    /// Error of a plot's range, metres.
    pub noise_range_m: f64,
    /// Error of a plot's azimuth, radians.
    pub noise_azimuth: f64,
    /// Error of a plot's height, metres.
    pub noise_height_m: f64,
    /// The slow errors are forgotten to 1/e in this time, seconds.
    pub correlation_s: f64,
}

impl RadarErrors {
    /// Of a radar whose data sheet tells its accuracy, one standard deviation each, as metres, degrees, metres.
    ///
    /// A data sheet does not tell how much of that lasts: assumed are a slow error that is as large (in azimuth 1.3 times: turns
    /// make it larger), and a fast one that is a fraction of it.
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

/// How a radar sees a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfSight {
    /// Distance over ground, metres.
    pub range_m: f64,
    /// Unit vector away from the radar.
    pub outward: Vector2<f64>,
    /// Unit vector of growing azimuth.
    pub clockwise: Vector2<f64>,
}

impl LineOfSight {
    /// A place as the radar at `radar` sees it.
    pub fn from(radar: Enu, place: Enu) -> Self {
        let away = (place.0 - radar.0).xy();
        let range_m = away.norm().max(1.0);
        let outward = away / range_m;
        Self { range_m, outward, clockwise: Vector2::new(outward.y, -outward.x) }
    }

    /// Covariance over ground of these deviations, metres and radians.
    pub fn spread(&self, range_m: f64, azimuth: f64) -> Matrix2<f64> {
        let across = self.range_m * azimuth;
        self.outward * self.outward.transpose() * (range_m * range_m)
            + self.clockwise * self.clockwise.transpose() * (across * across)
    }
}
