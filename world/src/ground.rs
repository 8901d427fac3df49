//! From a scenario's local metres to WGS-84 and to a radar's measurements.

use nalgebra::Vector3;

use crate::scenario::{Place, Radar};
use fusion::frames::{AtRadar, Geodetic, TangentPlane};

/// The ground: one height above mean sea level, on a round Earth.
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
    /// Its position.
    pub position: Geodetic,
    /// Its height above mean sea level, metres.
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

    /// WGS-84 position of east, north and height above ground, metres: east and north are those of the tangent plane, the
    /// height is exact.
    pub fn geodetic(&self, position: &Vector3<f64>) -> Geodetic {
        let flat = fusion::Enu::new(position.x, position.y, 0.0);
        let place = self.frame.to_geodetic(flat);
        Geodetic { height_m: self.ground_amsl_m + self.undulation_m + position.z, ..place }
    }

    /// Height above mean sea level, metres.
    pub fn altitude_amsl_m(&self, position: &Vector3<f64>) -> f64 {
        self.ground_amsl_m + position.z
    }

    /// A radar's antenna.
    pub fn antenna(&self, radar: &Radar) -> Antenna {
        self.stand(Vector3::new(radar.east_m, radar.north_m, radar.antenna_agl_m))
    }

    /// What stands at east, north and height above ground, metres.
    pub fn stand(&self, local: Vector3<f64>) -> Antenna {
        let position = self.geodetic(&local);
        Antenna { frame: TangentPlane::at(position), position, altitude_amsl_m: self.altitude_amsl_m(&local) }
    }
}

impl Antenna {
    /// Slant range, metres, and azimuth, radians clockwise from north, -pi to pi.
    pub fn polar(&self, place: Geodetic) -> (f64, f64) {
        let local = self.frame.from_geodetic(place);
        (local.0.norm(), local.east().atan2(local.north()))
    }

    /// Slant range, metres, azimuth, radians clockwise from north, -pi to pi, and elevation, radians.
    pub fn spherical(&self, place: Geodetic) -> (f64, f64, f64) {
        let local = self.frame.from_geodetic(place);
        let elevation = local.up().atan2(local.east().hypot(local.north()));
        (local.0.norm(), local.east().atan2(local.north()), elevation)
    }
}
