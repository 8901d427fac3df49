//! The place of a scenario: local metres to WGS-84 and to what a radar measures.

use nalgebra::Vector3;

use super::scenario::{Place, Radar};
use fusion::frames::{AtRadar, Geodetic, TangentPlane};

/// The ground: flat in height above mean sea level, round on Earth.
#[derive(Clone, Debug)]
pub struct Ground {
    frame: TangentPlane,
    ground_amsl_m: f64,
    undulation_m: f64,
}

/// A radar's own tangent plane.
#[derive(Clone, Debug)]
pub struct Antenna {
    frame: TangentPlane<AtRadar>,
    /// Where it stands.
    pub position: Geodetic,
    /// The same height above mean sea level, metres.
    pub altitude_amsl_m: f64,
}

impl Ground {
    /// The ground of a place.
    pub fn new(place: &Place) -> Self {
        let height_m = place.ground_amsl_m + place.geoid_undulation_m;
        let origin = Geodetic::from_degrees(place.latitude_deg, place.longitude_deg, height_m);
        Self {
            frame: TangentPlane::at(origin),
            ground_amsl_m: place.ground_amsl_m,
            undulation_m: place.geoid_undulation_m,
        }
    }

    /// East and north of the origin and height above ground, metres, on Earth: the height is exact, and the place that
    /// of east and north in the tangent plane.
    pub fn geodetic(&self, position: &Vector3<f64>) -> Geodetic {
        let flat = fusion::Enu::new(position.x, position.y, 0.0);
        let place = self.frame.to_geodetic(flat);
        Geodetic { height_m: self.ground_amsl_m + self.undulation_m + position.z, ..place }
    }

    /// Height above mean sea level, metres.
    pub fn altitude_amsl_m(&self, position: &Vector3<f64>) -> f64 {
        self.ground_amsl_m + position.z
    }

    /// Where a radar stands.
    pub fn antenna(&self, radar: &Radar) -> Antenna {
        let local = Vector3::new(radar.east_m, radar.north_m, radar.antenna_agl_m);
        let position = self.geodetic(&local);
        Antenna { frame: TangentPlane::at(position), position, altitude_amsl_m: self.altitude_amsl_m(&local) }
    }
}

impl Antenna {
    /// Slant range in metres and azimuth in radians clockwise from north, -pi to pi, of a place.
    pub fn polar(&self, place: Geodetic) -> (f64, f64) {
        let local = self.frame.from_geodetic(place);
        (local.0.norm(), local.east().atan2(local.north()))
    }
}
