//! Conversion from a scenario's local metres to WGS-84 and to a radar's measurements.

use nalgebra::Vector3;

use crate::scenario::{Place, Radar};
use fusion::frames::{AtRadar, Geodetic, TangentPlane};

/// Ground at a constant height above mean sea level, on an ellipsoidal Earth.
#[derive(Clone, Debug)]
pub struct Ground {
    frame: TangentPlane,
    ground_amsl_m: f64,
    undulation_m: f64,
}

/// A sensor's position and its tangent plane.
#[derive(Clone, Debug)]
pub struct Antenna {
    frame: TangentPlane<AtRadar>,
    /// Position of the sensor.
    pub position: Geodetic,
    /// Height of the sensor above mean sea level, metres.
    pub altitude_amsl_m: f64,
}

impl Ground {
    /// Ground of a scenario's place.
    pub fn new(place: &Place) -> Self {
        let height_m = place.ground_amsl_m + place.geoid_undulation_m;
        let origin = Geodetic::from_degrees(place.latitude_deg, place.longitude_deg, height_m);
        Self {
            frame: TangentPlane::at(origin),
            ground_amsl_m: place.ground_amsl_m,
            undulation_m: place.geoid_undulation_m,
        }
    }

    /// WGS-84 position of a point given by east, north and height above ground, metres. East and north are those of the
    /// tangent plane; the height above ground is exact.
    pub fn geodetic(&self, position: &Vector3<f64>) -> Geodetic {
        let flat = fusion::Enu::new(position.x, position.y, 0.0);
        let place = self.frame.to_geodetic(flat);
        Geodetic { height_m: self.ground_amsl_m + self.undulation_m + position.z, ..place }
    }

    /// Height above mean sea level, metres.
    pub fn altitude_amsl_m(&self, position: &Vector3<f64>) -> f64 {
        self.ground_amsl_m + position.z
    }

    /// Antenna of a radar.
    pub fn antenna(&self, radar: &Radar) -> Antenna {
        self.stand(Vector3::new(radar.east_m, radar.north_m, radar.antenna_agl_m))
    }

    /// Sensor at a point given by east, north and height above ground, metres.
    pub fn stand(&self, local: Vector3<f64>) -> Antenna {
        let position = self.geodetic(&local);
        Antenna { frame: TangentPlane::at(position), position, altitude_amsl_m: self.altitude_amsl_m(&local) }
    }
}

impl Antenna {
    /// Slant range in metres, and azimuth in radians clockwise from north, -pi to pi.
    pub fn polar(&self, place: Geodetic) -> (f64, f64) {
        let local = self.frame.from_geodetic(place);
        (local.0.norm(), local.east().atan2(local.north()))
    }

    /// Slant range in metres, azimuth in radians clockwise from north, -pi to pi, and elevation in radians.
    pub fn spherical(&self, place: Geodetic) -> (f64, f64, f64) {
        let local = self.frame.from_geodetic(place);
        let elevation = local.up().atan2(local.east().hypot(local.north()));
        (local.0.norm(), local.east().atan2(local.north()), elevation)
    }
}
