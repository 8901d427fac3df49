//! WGS-84 geometry: geodetic, Earth-centred (ECEF) and local east-north-up (ENU) positions as types that cannot be
//! mixed up. ENU at the site and ENU at a radar are two types. Checked against PROJ in `fusion/tests/oracles.rs`.

use std::marker::PhantomData;

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

/// Semi-major axis of WGS-84, metres.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Flattening of WGS-84.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared.
const E2: f64 = FLATTENING * (2.0 - FLATTENING);
/// Semi-minor axis, metres.
const SEMI_MINOR_M: f64 = SEMI_MAJOR_M * (1.0 - FLATTENING);

/// A position on WGS-84: radians, and metres above the ellipsoid (not above mean sea level).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

/// The site's axes: those of the tangent plane at its origin. Fusion uses only these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtSite {}

/// A radar's own axes: those of the tangent plane at its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtRadar {}

/// East, north, up in a tangent plane, metres.
///
/// ```
/// use utm_fusion_engine::frames::{AtRadar, Enu};
///
/// let at_site: Enu = Enu::new(3.0, 4.0, 0.0);
/// assert_eq!(at_site.0.norm(), 5.0);
/// // Another frame is another type: `let wrong: Enu<AtRadar> = at_site;` does not compile.
/// let at_radar = Enu::<AtRadar>::new(0.0, 1200.0, 80.0);
/// assert_eq!(at_radar.north(), 1200.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Enu<F = AtSite>(pub Vector3<f64>, PhantomData<F>);

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

    /// Radii of curvature on the ellipsoid, metres: of the meridian, M, and of the prime vertical, N'.
    pub fn curvature_m(&self) -> (f64, f64) {
        let prime_vertical_m = self.prime_vertical_m();
        let meridian_m = prime_vertical_m * (1.0 - E2) / (1.0 - E2 * self.latitude.sin().powi(2));
        (meridian_m, prime_vertical_m)
    }

    /// Gaussian mean radius sqrt(M N') at this latitude, metres (M: the meridian radius of curvature).
    pub fn gaussian_radius_m(&self) -> f64 {
        SEMI_MINOR_M / (1.0 - E2 * self.latitude.sin().powi(2))
    }

    /// Converts to Earth-centred coordinates.
    pub fn to_ecef(&self) -> Ecef {
        let n = self.prime_vertical_m();
        let (sin_lat, cos_lat) = self.latitude.sin_cos();
        let (sin_lon, cos_lon) = self.longitude.sin_cos();
        let in_plane = (n + self.height_m) * cos_lat;
        Ecef(Vector3::new(in_plane * cos_lon, in_plane * sin_lon, (n * (1.0 - E2) + self.height_m) * sin_lat))
    }
}

impl Ecef {
    /// Converts to geodetic coordinates by Bowring's formula on the parametric latitude (Survey Review 28, 1985), in
    /// three rounds. Near the Earth's surface the error is below a nanometre after two.
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
        // Valid at the poles too, where z / sin - N or p / cos - N would lose precision.
        let height_m = in_plane * cos + z * sin - SEMI_MAJOR_M * (1.0 - E2 * sin * sin).sqrt();
        Geodetic { latitude, longitude: y.atan2(x), height_m }
    }
}

impl<F> From<Vector3<f64>> for Enu<F> {
    fn from(vector: Vector3<f64>) -> Self {
        Self(vector, PhantomData)
    }
}

impl<F> Enu<F> {
    /// From metres east, north and up.
    pub const fn new(east: f64, north: f64, up: f64) -> Self {
        Self(Vector3::new(east, north, up), PhantomData)
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

/// A tangent plane: its origin, and the conversion to and from Earth-centred positions.
#[derive(Clone, Debug)]
pub struct TangentPlane<F = AtSite> {
    origin: Geodetic,
    origin_ecef: Vector3<f64>,
    /// Rotates Earth-centred differences into east, north, up.
    to_enu: Rotation3<f64>,
    frame: PhantomData<F>,
}

impl TangentPlane {
    /// The site's plane, which touches the ellipsoid at `origin`.
    pub fn at_site(origin: Geodetic) -> Self {
        Self::at(origin)
    }
}

impl<F: Copy> TangentPlane<F> {
    /// The tangent plane at `origin`.
    pub fn at(origin: Geodetic) -> Self {
        let (sin_lat, cos_lat) = origin.latitude.sin_cos();
        let (sin_lon, cos_lon) = origin.longitude.sin_cos();
        #[rustfmt::skip]
        let to_enu = Rotation3::from_matrix_unchecked(Matrix3::new(
            -sin_lon,            cos_lon,           0.0,
            -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,
             cos_lat * cos_lon,  cos_lat * sin_lon, sin_lat,
        ));
        Self { origin, origin_ecef: origin.to_ecef().0, to_enu, frame: PhantomData }
    }

    /// The position at which the plane touches the ellipsoid.
    pub fn origin(&self) -> Geodetic {
        self.origin
    }

    /// Rotation from this frame's axes to those of another; the identity if both origins have one latitude and
    /// longitude.
    pub fn turn_to<G>(&self, other: &TangentPlane<G>) -> Rotation3<f64> {
        if (self.origin.latitude, self.origin.longitude) == (other.origin.latitude, other.origin.longitude) {
            return Rotation3::identity();
        }
        other.to_enu * self.to_enu.inverse()
    }

    /// Converts an Earth-centred position to this frame.
    pub fn from_ecef(&self, position: Ecef) -> Enu<F> {
        Enu::from(self.to_enu * (position.0 - self.origin_ecef))
    }

    /// Converts a position of this frame to Earth-centred coordinates.
    pub fn to_ecef(&self, position: Enu<F>) -> Ecef {
        Ecef(self.origin_ecef + self.to_enu.inverse() * position.0)
    }

    /// Converts a geodetic position to this frame.
    pub fn from_geodetic(&self, position: Geodetic) -> Enu<F> {
        self.from_ecef(position.to_ecef())
    }

    /// Converts a position of this frame to geodetic coordinates.
    pub fn to_geodetic(&self, position: Enu<F>) -> Geodetic {
        self.to_ecef(position).to_geodetic()
    }
}

/// A radar's position in the site's frame, and the rotation of its axes relative to the site's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarFrame {
    origin: Enu,
    to_site: Rotation3<f64>,
}

impl RadarFrame {
    /// A radar at `radar` with the axes of the tangent plane there. They are rotated relative to the site's by the
    /// convergence of the meridians and the curvature of the Earth; at the site's origin they coincide.
    pub fn new(site: &TangentPlane, radar: Geodetic) -> Self {
        let own = TangentPlane::<AtRadar>::at(radar);
        Self { origin: site.from_geodetic(radar), to_site: own.turn_to(site) }
    }

    /// A radar at `origin` whose axes are the site's: exact at the site's origin, and accurate near it. At 10 km the
    /// true axes are rotated by up to 0.1° about the horizontal, and about the vertical by 0.1° times the tangent of
    /// the latitude.
    pub fn parallel(origin: Enu) -> Self {
        Self { origin, to_site: Rotation3::identity() }
    }

    /// The radar's position in the site's frame.
    pub fn origin(&self) -> Enu {
        self.origin
    }

    /// The same axes at a position that is moved along them.
    pub fn moved(&self, by: Vector3<f64>) -> Self {
        Self { origin: (self.origin.0 + self.to_site * by).into(), ..*self }
    }

    /// Converts a position of the site's frame to the radar's frame.
    pub fn from_site(&self, position: Enu) -> Enu<AtRadar> {
        self.vector_from_site(position.0 - self.origin.0).into()
    }

    /// Converts a position of the radar's frame to the site's frame.
    pub fn to_site(&self, position: Enu<AtRadar>) -> Enu {
        (self.origin.0 + self.to_site * position.0).into()
    }

    /// Rotates a difference of positions, or a velocity, from the site's axes to the radar's.
    pub fn vector_from_site(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.to_site.inverse() * vector
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A displacement along the radar's axes, computed on the Earth, equals the displacement computed by the frame.
    #[test]
    fn a_radars_axes_are_those_where_it_stands() {
        let origin = Geodetic::from_degrees(58.0, 10.0, 100.0);
        let site = TangentPlane::at_site(origin);
        for (latitude_deg, longitude_deg, height_m) in
            [(58.05, 10.2, 30.0), (57.8, 9.9, 400.0), (58.0, 10.0, 104.0)]
        {
            let radar = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m);
            let own = TangentPlane::<AtRadar>::at(radar);
            let frame = RadarFrame::new(&site, radar);
            for at in [[3000.0, -800.0, 90.0], [0.0, 5000.0, 20.0], [0.0, 0.0, 1000.0]] {
                let there = Enu::<AtRadar>::from(Vector3::from(at));
                let on_earth = site.from_ecef(own.to_ecef(there));
                assert!((frame.to_site(there).0 - on_earth.0).norm() < 1e-8, "{latitude_deg} {at:?}");
                assert!((frame.from_site(on_earth).0 - there.0).norm() < 1e-8, "{latitude_deg} {at:?}");
            }
            let convergence = (radar.longitude - origin.longitude) * radar.latitude.sin();
            let north = frame.vector_from_site(Vector3::y());
            assert!((north.x.atan2(north.y) - convergence).abs() < 1e-4, "{latitude_deg}");
        }
    }

    #[test]
    fn a_radar_above_the_sites_origin_has_its_axes() {
        let site = TangentPlane::at_site(Geodetic::from_degrees(58.0, 10.0, 100.0));
        let frame = RadarFrame::new(&site, Geodetic::from_degrees(58.0, 10.0, 104.0));
        let vector = Vector3::new(1.0, 2.0, 3.0);
        assert_eq!(frame.vector_from_site(vector), vector);
    }

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
