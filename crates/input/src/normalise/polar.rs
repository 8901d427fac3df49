//! Conversion of a radar's slant range and azimuth, with the target's height, to east-north-up.

use nalgebra::Vector2;

use fusion::Enu;
use fusion::frames::{AtRadar, Geodetic, TangentPlane};

/// Position and orientation of a radar.
#[derive(Clone, Debug)]
pub struct RadarSite {
    local: TangentPlane<AtRadar>,
    /// R + H0: Gaussian mean radius at the radar plus its ellipsoidal height, in metres.
    centre_distance_m: f64,
    radius_m: f64,
    bearing_correction: f64,
}

impl RadarSite {
    /// A radar at `position`; `bearing_correction_deg` is added to its azimuths, clockwise.
    pub fn new(position: Geodetic, bearing_correction_deg: f64) -> Self {
        let radius_m = position.gaussian_radius_m();
        Self {
            local: TangentPlane::at(position),
            centre_distance_m: radius_m + position.height_m,
            radius_m,
            bearing_correction: bearing_correction_deg.to_radians(),
        }
    }

    /// The tangent plane at this radar.
    pub fn frame(&self) -> &TangentPlane<AtRadar> {
        &self.local
    }

    /// East and north components of a speed and a heading, in radians clockwise from the radar's north mark.
    pub fn velocity(&self, speed_m_s: f64, heading: f64) -> Vector2<f64> {
        let (sin, cos) = (heading + self.bearing_correction).sin_cos();
        Vector2::new(speed_m_s * sin, speed_m_s * cos)
    }

    /// Position of a plot in this radar's tangent plane.
    ///
    /// `slant_range_m` is greater than zero; `azimuth` is in radians clockwise from the radar's north mark; `height_m` is
    /// above the ellipsoid. The elevation is that on a sphere of the Gaussian mean radius: with ρ the slant range, H the
    /// height, sin ε = ((R+H)² - (R+H₀)² - ρ²) / (2 ρ (R+H₀)), clamped if range and height contradict each other.
    pub fn position(&self, slant_range_m: f64, azimuth: f64, height_m: f64) -> Enu<AtRadar> {
        let target = self.radius_m + height_m;
        let site = self.centre_distance_m;
        // The difference of squares is computed as a product, because the squares differ only in their twelfth digit.
        let sin_elevation = (((target - site) * (target + site) - slant_range_m * slant_range_m)
            / (2.0 * slant_range_m * site))
            .clamp(-1.0, 1.0);
        let ground_m = slant_range_m * (1.0 - sin_elevation * sin_elevation).sqrt();
        let (sin, cos) = (azimuth + self.bearing_correction).sin_cos();
        Enu::new(ground_m * sin, ground_m * cos, slant_range_m * sin_elevation)
    }
}
