//! Orientation of a camera, learnt from looks at aircraft whose position is known.
//!
//! The state is the rotation from the directions that the camera states to the true ones, and the covariance of the rotation that
//! is left. A look measures two angles of it. Each look is linearised at the present rotation (multiplicative extended Kalman
//! filter; F. L. Markley, *Attitude error representations for Kalman filtering*, 2003), so that large rotations need no other start.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::estimate::BiasValue;

/// Factor of the variance of a look. Errors of a lens, of clocks and of the reference persist from look to look.
const PERSISTENCE: f64 = 6.0;
/// Growth of the variance about each axis: 0.1° in an hour, radians² per second.
const GROWTH: f64 = 0.1 * 0.1 * (TAU / 360.0) * (TAU / 360.0) / 3600.0;
/// Maximum standard deviation of a rotation that is known, radians (0.5°).
const KNOWN: f64 = 0.5 * TAU / 360.0;
/// Deviation of an orientation by errors that do not show in its looks, radians (0.2°).
const FLOOR: f64 = 0.2 * TAU / 360.0;
/// Deviation that no number of looks removes, radians (0.03°): delays of transponders, and lenses.
const LEAST: f64 = 0.03 * TAU / 360.0;
/// Distance of a look, in standard deviations, from which its variance grows with the distance (Huber).
const HUBER: f64 = 3.0;
/// Time in which the mean of the residuals forgets, looks.
const RESIDUAL_LOOKS: f64 = 100.0;

/// A look, and where its aircraft is. Angles in radians, azimuths clockwise from north.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraLook {
    /// Azimuth as stated.
    pub(crate) azimuth: f64,
    /// Elevation as stated; `None`: not measured.
    pub(crate) elevation: Option<f64>,
    /// Azimuth and elevation of the aircraft's known position.
    pub(crate) expected: [f64; 2],
    /// Variances of the stated angles, radians²: azimuth, elevation.
    pub(crate) measured2: [f64; 2],
    /// Variances of the expected angles, radians².
    pub(crate) expected2: [f64; 2],
}

/// Orientation of a camera, as learnt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraOrientation {
    /// Rotation from stated to true directions, in the site's axes.
    rotation: UnitQuaternion<f64>,
    /// Covariance of the rotation vector that is left, site's axes, radians².
    covariance: Matrix3<f64>,
    /// Number of looks used.
    pub looks: u64,
    /// Mean square of the residuals after the correction, radians², of the latest looks.
    residual2: f64,
}

/// Orientation as a misalignment: stated minus true, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMisalignment {
    /// Bearing: azimuths are too large.
    pub bearing: BiasValue,
    /// Tilt about east: aircraft in the north appear too high.
    pub tilt_east: BiasValue,
    /// Tilt about north: aircraft in the east appear too low.
    pub tilt_north: BiasValue,
    /// Number of looks used.
    pub looks: u64,
    /// Root mean square of the residuals of an angle after the correction, radians; `None` before any look.
    pub residual: Option<f64>,
}

impl CameraOrientation {
    /// The configured orientation: no rotation, with this standard deviation about each axis, radians.
    pub(crate) fn configured(deviation: f64) -> Self {
        Self {
            rotation: UnitQuaternion::identity(),
            covariance: Matrix3::identity() * (deviation * deviation),
            looks: 0,
            residual2: 0.0,
        }
    }

    /// True azimuth and elevation of a stated direction; without a stated elevation, that of a direction at `elevation`.
    pub(crate) fn correct(&self, azimuth: f64, elevation: f64) -> [f64; 2] {
        let there = self.rotation * direction(azimuth, elevation);
        [there.x.atan2(there.y), there.z.atan2(there.xy().norm())]
    }

    /// Azimuth and elevation as the camera would state them, of a true direction. Radians, azimuths clockwise from north.
    pub fn stated(&self, [azimuth, elevation]: [f64; 2]) -> [f64; 2] {
        let there = self.rotation.inverse() * direction(azimuth, elevation);
        [there.x.atan2(there.y), there.z.atan2(there.xy().norm())]
    }

    /// Variances of the corrected azimuth and elevation by the rotation that is left, radians².
    pub(crate) fn variances(&self, [azimuth, elevation]: [f64; 2]) -> [f64; 2] {
        rows(azimuth, elevation).map(|row| (row.transpose() * self.covariance * row).x)
    }

    /// Whether the measured angles of looks there are known well enough to be used.
    pub(crate) fn is_known(&self, at: [f64; 2], has_elevation: bool) -> bool {
        let [azimuth2, elevation2] = self.variances(at);
        azimuth2 <= KNOWN * KNOWN && (!has_elevation || elevation2 <= KNOWN * KNOWN)
    }

    /// Sum of the variances about all axes, radians².
    pub(crate) fn uncertainty(&self) -> f64 {
        self.covariance.trace()
    }

    /// Mean square of the latest residuals, radians².
    pub(crate) fn residual2(&self) -> f64 {
        self.residual2
    }

    /// Squared distance of two orientations in deviations, with three degrees of freedom. Each has a further deviation of 0.2°.
    pub(crate) fn distance2(&self, other: &Self) -> f64 {
        let off = (self.rotation * other.rotation.inverse()).scaled_axis();
        let covariance = self.covariance + other.covariance + Matrix3::identity() * (2.0 * FLOOR * FLOOR);
        covariance.cholesky().map_or(f64::INFINITY, |root| off.dot(&root.solve(&off)))
    }

    /// Lets the rotation drift for some seconds.
    pub(crate) fn advance(&mut self, seconds: f64) {
        self.covariance += Matrix3::identity() * (GROWTH * seconds.max(0.0));
    }

    /// Logarithm of the likelihood of a look, one value for each angle, radians⁻¹; an angle that is not measured has none.
    pub(crate) fn log_likelihoods(&self, look: &CameraLook) -> [Option<f64>; 2] {
        let corrected = self.correct(look.azimuth, look.elevation.unwrap_or(look.expected[1]));
        let left2 = self.variances(corrected);
        [0, 1].map(|angle| {
            look.is_measured(angle).then(|| {
                let variance = look.measured2[angle] + look.expected2[angle] + left2[angle];
                let off = wrapped(corrected[angle] - look.expected[angle]);
                -0.5 * off * off / variance - 0.5 * (TAU * variance).ln()
            })
        })
    }

    /// Learns from a look.
    pub(crate) fn learn(&mut self, look: &CameraLook) {
        self.looks += 1;
        for angle in [0, 1].into_iter().filter(|&angle| look.is_measured(angle)) {
            let corrected = self.correct(look.azimuth, look.elevation.unwrap_or(look.expected[1]));
            let row = rows(corrected[0], corrected[1])[angle];
            let gained = self.covariance * row;
            let left2 = (row.transpose() * gained).x;
            let off = wrapped(look.expected[angle] - corrected[angle]);
            let noise2 = look.measured2[angle] + look.expected2[angle];
            let distance = off.abs() / (noise2 + left2).sqrt();
            let variance = left2 + PERSISTENCE * noise2 * (distance / HUBER).max(1.0);
            self.rotation = UnitQuaternion::from_scaled_axis(gained * (off / variance)) * self.rotation;
            self.covariance -= gained * gained.transpose() / variance;
            self.covariance = (self.covariance + self.covariance.transpose()) / 2.0;
            let share = 1.0 / (self.looks as f64).min(RESIDUAL_LOOKS);
            let residual = wrapped(
                look.expected[angle]
                    - self.correct(look.azimuth, look.elevation.unwrap_or(look.expected[1]))[angle],
            );
            self.residual2 += (residual * residual - self.residual2) * share;
        }
    }

    /// The orientation for the interfaces.
    pub fn misalignment(&self) -> CameraMisalignment {
        // The rotation turns stated directions into true ones; the misalignment is its inverse. Clockwise is negative about up.
        let left = -self.rotation.scaled_axis();
        let value = |axis: usize, sign: f64| {
            let deviation = self.covariance[(axis, axis)].sqrt().hypot(LEAST);
            BiasValue { value: sign * left[axis], deviation, observable: deviation <= KNOWN }
        };
        CameraMisalignment {
            bearing: value(2, -1.0),
            tilt_east: value(0, 1.0),
            tilt_north: value(1, 1.0),
            looks: self.looks,
            residual: (self.looks > 0).then(|| self.residual2.sqrt()),
        }
    }
}

impl CameraLook {
    fn is_measured(&self, angle: usize) -> bool {
        angle == 0 || self.elevation.is_some()
    }
}

/// Unit vector of a direction: east, north, up.
pub(crate) fn direction(azimuth: f64, elevation: f64) -> Vector3<f64> {
    let level = elevation.cos();
    Vector3::new(azimuth.sin() * level, azimuth.cos() * level, elevation.sin())
}

/// Changes of azimuth and elevation with a small rotation of the direction.
fn rows(azimuth: f64, elevation: f64) -> [Vector3<f64>; 2] {
    let there = direction(azimuth, elevation);
    let clockwise = Vector3::new(azimuth.cos(), -azimuth.sin(), 0.0);
    let upward = Rotation3::from_axis_angle(&Vector3::z_axis(), -azimuth)
        * Vector3::new(0.0, -elevation.sin(), elevation.cos());
    [there.cross(&clockwise) / elevation.cos().max(1e-3), there.cross(&upward)]
}

/// The equivalent angle between -π and π.
pub(crate) fn wrapped(angle: f64) -> f64 {
    (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn rows_are_the_derivatives_of_the_angles() {
        for (azimuth, elevation) in [(0.3, 0.1), (2.5, 0.9), (-1.2, -0.4)] {
            for axis in 0..3 {
                let mut turn = Vector3::zeros();
                turn[axis] = 1e-6;
                let there = Rotation3::new(turn) * direction(azimuth, elevation);
                let changed =
                    [there.x.atan2(there.y) - azimuth, there.z.atan2(there.xy().norm()) - elevation];
                for (change, row) in changed.iter().zip(rows(azimuth, elevation)) {
                    assert!((change / 1e-6 - row[axis]).abs() < 1e-4, "{azimuth} {elevation} {axis}");
                }
            }
        }
    }

    /// A camera turned by up to 20° that looks at a drone all around it, with noise of 0.2°.
    #[test]
    fn learns_a_large_rotation_with_honest_deviations() {
        let mut rng = ChaCha8Rng::seed_from_u64(49);
        let mut normal =
            |sigma: f64| -> f64 { (0..12).map(|_| rng.random::<f64>()).sum::<f64>() * sigma - 6.0 * sigma };
        let (mut squares, count) = (0.0, 200);
        for _ in 0..count {
            let turn = Vector3::new(normal(0.1), normal(0.1), normal(0.1));
            let wrong = UnitQuaternion::from_scaled_axis(turn);
            let mut learnt = CameraOrientation::configured(0.1);
            for step in 0..120 {
                let expected = [f64::from(step) * 0.02, 0.2 + 0.1 * (f64::from(step) * 0.1).sin()];
                let stated = wrong.inverse() * direction(expected[0], expected[1]);
                let noise = 0.2_f64.to_radians();
                learnt.learn(&CameraLook {
                    azimuth: stated.x.atan2(stated.y) + normal(noise),
                    elevation: Some(stated.z.atan2(stated.xy().norm()) + normal(noise)),
                    expected,
                    measured2: [noise * noise; 2],
                    expected2: [0.0; 2],
                });
            }
            let off = (wrong * learnt.rotation.inverse()).scaled_axis();
            assert!(off.norm().to_degrees() < 0.4, "{off}");
            squares += (off.transpose() * learnt.covariance.try_inverse().unwrap() * off).x / 3.0;
        }
        // White noise: the deviations allow for errors that persist, and are too large by the square root of their factor.
        let mean = PERSISTENCE * squares / f64::from(count);
        assert!((0.8..1.25).contains(&mean), "{mean}");
    }

    #[test]
    fn misalignment_has_the_signs_of_a_radars() {
        let sigma = 0.1_f64.to_radians();
        let look = |azimuth: f64, elevation: f64, expected: [f64; 2]| CameraLook {
            azimuth,
            elevation: Some(elevation),
            expected,
            measured2: [sigma * sigma; 2],
            expected2: [0.0; 2],
        };
        let mut turned = CameraOrientation::configured(0.1);
        for step in 0..60 {
            let azimuth = f64::from(step) * 0.05;
            turned.learn(&look(azimuth + 0.05, 0.1, [azimuth, 0.1]));
        }
        assert!((turned.misalignment().bearing.value - 0.05).abs() < 0.002, "{turned:?}");
        let mut tilted = CameraOrientation::configured(0.1);
        for _ in 0..60 {
            tilted.learn(&look(0.0, 0.12, [0.0, 0.1])); // too high in the north
            tilted.learn(&look(TAU / 4.0, 0.09, [TAU / 4.0, 0.1])); // too low in the east
        }
        let misalignment = tilted.misalignment();
        assert!((misalignment.tilt_east.value - 0.02).abs() < 0.002, "{misalignment:?}");
        assert!((misalignment.tilt_north.value - 0.01).abs() < 0.002, "{misalignment:?}");
    }
}
