//! Sensors and their measurements, with standard deviations in metres, radians, metres a second.

use nalgebra::Matrix2;

use super::quantity::Quantity;
use super::reading::{MeasuredValue, Reading, ReadingOrigin};
use fusion::frames::{Geodetic, TangentPlane};

/// A radar: range, azimuth, elevation, and the range rate if it measures one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarModel {
    /// Standard deviation of the range, metres.
    pub range_m: f64,
    /// Standard deviation of the azimuth, radians.
    pub azimuth: f64,
    /// Standard deviation of the elevation, radians.
    pub elevation: f64,
    /// Standard deviation of the range rate, metres a second; `None`: it measures none.
    pub range_rate: Option<f64>,
}

/// An interrogator of transponders (IFF, SSR): a good range, a coarse azimuth, and the altitude that the transponder
/// reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterrogatorModel {
    /// Standard deviation of the range, metres.
    pub range_m: f64,
    /// Standard deviation of the azimuth, radians.
    pub azimuth: f64,
    /// Standard deviation of the altitude, metres.
    pub altitude_m: f64,
}

/// A camera, of visible light or infrared: azimuth and elevation. It measures no range, so it starts no track alone,
/// but two cameras do ([`Reading::crossing`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraModel {
    /// Standard deviation of the azimuth, radians.
    pub azimuth: f64,
    /// Standard deviation of the elevation, radians.
    pub elevation: f64,
}

fn measured(quantity: Quantity, value: f64, sigma: f64) -> MeasuredValue {
    MeasuredValue { quantity, value, sigma }
}

impl RadarModel {
    /// Reading of a detection: range (metres), azimuth and elevation (radians), and the range rate (metres a second) if
    /// the radar measures one. `None` as for [`Reading::independent`].
    pub fn reading(
        &self,
        taken: ReadingOrigin,
        [range_m, azimuth, elevation]: [f64; 3],
        range_rate: Option<f64>,
    ) -> Option<Reading> {
        let mut all = vec![
            measured(Quantity::Range, range_m, self.range_m),
            measured(Quantity::Azimuth, azimuth, self.azimuth),
            measured(Quantity::Elevation, elevation, self.elevation),
        ];
        let rate = range_rate.zip(self.range_rate);
        all.extend(rate.map(|(rate, sigma)| measured(Quantity::RangeRate, rate, sigma)));
        Reading::independent(taken, &all)
    }
}

impl InterrogatorModel {
    /// Reading of a reply: range (metres), azimuth (radians), and the altitude on the site's upward axis (metres) if it
    /// has one.
    pub fn reading(
        &self,
        taken: ReadingOrigin,
        [range_m, azimuth]: [f64; 2],
        altitude_m: Option<f64>,
    ) -> Option<Reading> {
        let mut all = vec![
            measured(Quantity::Range, range_m, self.range_m),
            measured(Quantity::Azimuth, azimuth, self.azimuth),
        ];
        all.extend(altitude_m.map(|altitude| measured(Quantity::Altitude, altitude, self.altitude_m)));
        Reading::independent(taken, &all)
    }
}

impl CameraModel {
    /// Reading of a line of sight: azimuth and elevation, radians.
    pub fn reading(&self, taken: ReadingOrigin, [azimuth, elevation]: [f64; 2]) -> Option<Reading> {
        let all = [
            measured(Quantity::Azimuth, azimuth, self.azimuth),
            measured(Quantity::Elevation, elevation, self.elevation),
        ];
        Reading::independent(taken, &all)
    }
}

/// Covariance over ground, in the site's axes, of a position reported with standard deviations along its parallel and
/// along its meridian, metres (ADS-B, CAT129, Remote ID): J R Jᵀ. The meridians of aircraft and site converge, so the
/// errors to the east and to the north of the site are correlated unless both deviations are equal.
pub fn over_ground(
    site: &TangentPlane,
    aircraft: Geodetic,
    along_parallel_m: f64,
    along_meridian_m: f64,
) -> Matrix2<f64> {
    let turn = TangentPlane::<AtAircraft>::at(aircraft).turn_to(site);
    let over_ground = turn.matrix().fixed_view::<2, 2>(0, 0);
    let reported = Matrix2::from_partial_diagonal(&[along_parallel_m.powi(2), along_meridian_m.powi(2)]);
    over_ground * reported * over_ground.transpose()
}

/// The axes of the tangent plane at the aircraft.
#[derive(Clone, Copy, Debug)]
enum AtAircraft {}
