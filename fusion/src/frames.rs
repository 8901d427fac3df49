//! WGS-84 geometry: geodetic, Earth-centred (ECEF) and local east-north-up (ENU) positions as three types that cannot
//! be mixed up. Proved against PROJ: `tests/oracles.rs`.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Semi-major axis of WGS-84, metres.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Flattening of WGS-84.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared.
const E2: f64 = FLATTENING * (2.0 - FLATTENING);
/// Semi-minor axis, metres.
const SEMI_MINOR_M: f64 = SEMI_MAJOR_M * (1.0 - FLATTENING);

/// A position on WGS-84: radians, and metres above the ellipsoid (not above mean sea level).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Geodetic latitude, radians, north positive.
    pub latitude: f64,
    /// Longitude, radians, east positive.
    pub longitude: f64,
    /// Height above the ellipsoid, metres.
    pub height_m: f64,
}

/// An Earth-centred, Earth-fixed position, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ecef(pub Vector3<f64>);

/// East, north, up in the tangent plane of a site, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enu(pub Vector3<f64>);

impl Geodetic {
    /// From degrees and metres above the ellipsoid.
    pub fn from_degrees(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Self {
        Self { latitude: latitude_deg.to_radians(), longitude: longitude_deg.to_radians(), height_m }
    }

    /// Latitude in degrees.
    pub fn latitude_deg(&self) -> f64 {
        self.latitude.to_degrees()
    }

    /// Longitude in degrees, -180 to 180.
    pub fn longitude_deg(&self) -> f64 {
        self.longitude.to_degrees()
    }

    /// Prime-vertical radius of curvature N', metres.
    fn prime_vertical_m(&self) -> f64 {
        SEMI_MAJOR_M / (1.0 - E2 * self.latitude.sin().powi(2)).sqrt()
    }

    /// Radii of curvature on the ellipsoid: of the meridian M and of the prime vertical N', metres.
    pub fn curvature_m(&self) -> (f64, f64) {
        let prime_vertical_m = self.prime_vertical_m();
        let meridian_m = prime_vertical_m * (1.0 - E2) / (1.0 - E2 * self.latitude.sin().powi(2));
        (meridian_m, prime_vertical_m)
    }

    /// Gaussian mean radius sqrt(M N') at this latitude, metres (M: the meridian radius of curvature).
    pub fn gaussian_radius_m(&self) -> f64 {
        SEMI_MINOR_M / (1.0 - E2 * self.latitude.sin().powi(2))
    }

    /// The same place, Earth-centred.
    pub fn to_ecef(&self) -> Ecef {
        let n = self.prime_vertical_m();
        let (sin_lat, cos_lat) = self.latitude.sin_cos();
        let (sin_lon, cos_lon) = self.longitude.sin_cos();
        let in_plane = (n + self.height_m) * cos_lat;
        Ecef(Vector3::new(in_plane * cos_lon, in_plane * sin_lon, (n * (1.0 - E2) + self.height_m) * sin_lat))
    }
}

impl Ecef {
    /// The same place, geodetic: Bowring's formula on the parametric latitude (Survey Review 28, 1985), repeated until
    /// it stands still. Near the Earth's surface two rounds are below a nanometre.
    pub fn to_geodetic(&self) -> Geodetic {
        let (x, y, z) = (self.0.x, self.0.y, self.0.z);
        let in_plane = x.hypot(y);
        let second_e2 = E2 / (1.0 - E2);
        let mut parametric = (SEMI_MAJOR_M * z).atan2(SEMI_MINOR_M * in_plane);
        let mut latitude = 0.0_f64;
        for _ in 0..3 {
            let (sin, cos) = parametric.sin_cos();
            latitude = (z + second_e2 * SEMI_MINOR_M * sin.powi(3))
                .atan2(in_plane - E2 * SEMI_MAJOR_M * cos.powi(3));
            parametric = ((1.0 - FLATTENING) * latitude.sin()).atan2(latitude.cos());
        }
        let (sin, cos) = latitude.sin_cos();
        // Holds at the poles too, where z / sin - N or p / cos - N would lose one of them.
        let height_m = in_plane * cos + z * sin - SEMI_MAJOR_M * (1.0 - E2 * sin * sin).sqrt();
        Geodetic { latitude, longitude: y.atan2(x), height_m }
    }
}

impl Enu {
    /// From metres east, north and up.
    pub const fn new(east: f64, north: f64, up: f64) -> Self {
        Self(Vector3::new(east, north, up))
    }

    /// Metres east.
    pub fn east(&self) -> f64 {
        self.0.x
    }

    /// Metres north.
    pub fn north(&self) -> f64 {
        self.0.y
    }

    /// Metres above the tangent plane at the origin (not a height).
    pub fn up(&self) -> f64 {
        self.0.z
    }
}

/// A tangent plane: its origin, and the way to and from Earth-centred positions.
#[derive(Clone, Debug)]
pub struct TangentPlane {
    origin: Geodetic,
    origin_ecef: Vector3<f64>,
    /// Turns Earth-centred differences into east, north, up.
    to_enu: Rotation3<f64>,
}

impl TangentPlane {
    /// East-north-up at `origin`.
    pub fn at(origin: Geodetic) -> Self {
        let (sin_lat, cos_lat) = origin.latitude.sin_cos();
        let (sin_lon, cos_lon) = origin.longitude.sin_cos();
        #[rustfmt::skip]
        let to_enu = Rotation3::from_matrix_unchecked(Matrix3::new(
            -sin_lon,            cos_lon,           0.0,
            -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,
             cos_lat * cos_lon,  cos_lat * sin_lon, sin_lat,
        ));
        Self { origin, origin_ecef: origin.to_ecef().0, to_enu }
    }

    /// Where the tangent plane touches.
    pub fn origin(&self) -> Geodetic {
        self.origin
    }

    /// An Earth-centred position in this frame.
    pub fn from_ecef(&self, position: Ecef) -> Enu {
        Enu(self.to_enu * (position.0 - self.origin_ecef))
    }

    /// A position of this frame, Earth-centred.
    pub fn to_ecef(&self, position: Enu) -> Ecef {
        Ecef(self.origin_ecef + self.to_enu.inverse() * position.0)
    }

    /// A geodetic position in this frame.
    pub fn from_geodetic(&self, position: Geodetic) -> Enu {
        self.from_ecef(position.to_ecef())
    }

    /// A position of this frame, geodetic.
    pub fn to_geodetic(&self, position: Enu) -> Geodetic {
        self.to_ecef(position).to_geodetic()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gaussian_radius_is_the_mean_of_the_two_curvatures() {
        for latitude_deg in [0.0, 30.0, 52.5, -89.9] {
            let place = Geodetic::from_degrees(latitude_deg, 0.0, 0.0);
            let sin2 = place.latitude.sin().powi(2);
            let meridian = SEMI_MAJOR_M * (1.0 - E2) / (1.0 - E2 * sin2).powf(1.5);
            let mean = (meridian * place.prime_vertical_m()).sqrt();
            assert!((place.gaussian_radius_m() - mean).abs() < 1e-6, "{latitude_deg}");
        }
    }
}
