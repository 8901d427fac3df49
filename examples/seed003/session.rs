//! A calibration session: simulated measurements, and the camera's attitude from them.

use fusion::registration::{DirectionPair, attitude};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rand::RngExt;

use crate::cameras::{ATTITUDE_DEG, AircraftCamera, DISTANCE_M, RECTANGLE_M};
use crate::experiment::{Draws, rms};

/// Errors of a session.
#[derive(Clone, Copy, Debug)]
pub struct SessionErrors {
    /// Root mean square of the angles between measured directions and those of the solution, degrees.
    pub residual_deg: f64,
    /// Angle between the camera's true and calibrated optical axis, degrees.
    pub axis_deg: f64,
    /// Angle of the rotation between true and calibrated attitude, degrees.
    pub rotation_deg: f64,
}

/// Root mean square errors of positions in space, metres.
#[derive(Clone, Copy, Debug)]
pub struct PositionErrors {
    /// Error of each target, independent of the others.
    pub target_m: f64,
    /// Error of the camera's position, constant during the session.
    pub camera_m: f64,
}

/// M321 of the paper's equation 2, of yaw, pitch and roll in degrees: from the reference axes to the turned ones.
fn m321(angles_deg: [f64; 3]) -> UnitQuaternion<f64> {
    let [yaw, pitch, roll] = angles_deg.map(f64::to_radians);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(roll, pitch, yaw)).inverse()
}

impl Draws {
    fn uniform(&mut self, width: f64) -> f64 {
        (self.0.random::<f64>() - 0.5) * width
    }

    /// Error of a position whose distance has this root mean square.
    fn in_space(&mut self, error_m: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal(error_m / 3.0_f64.sqrt()))
    }

    /// A target in the rectangle that the camera sees, metres in the aircraft's axes (nose, right wing, down).
    fn target(&mut self, camera: &AircraftCamera, mounted: &UnitQuaternion<f64>) -> Vector3<f64> {
        loop {
            let [right_m, down_m] = RECTANGLE_M.map(|width| self.uniform(width));
            let target = Vector3::new(DISTANCE_M, right_m, down_m);
            let seen = mounted * target;
            let is_within =
                |across: f64, field_deg: f64| across.atan2(seen.x).abs() <= (field_deg / 2.0).to_radians();
            if is_within(seen.y, camera.field_deg[0]) && is_within(seen.z, camera.field_deg[1]) {
                return target;
            }
        }
    }
}

/// Simulates a session with `points` targets, and calibrates the camera with equal weights as the paper does.
pub fn session(camera: &AircraftCamera, points: usize, errors: PositionErrors, seed: u64) -> SessionErrors {
    let mut draws = Draws::of(seed);
    let mounted = m321(camera.angles_deg);
    let aircraft = m321([draws.uniform(360.0), 0.0, 0.0]);
    let camera_error = draws.in_space(errors.camera_m);
    // A target is extracted to a pixel: a uniform error.
    let pixel = camera.pixel_deg.to_radians();
    let pairs: Vec<DirectionPair> = (0..points)
        .map(|_| {
            let target = draws.target(camera, &mounted);
            let seen = mounted * target;
            let image = Vector3::new(
                1.0,
                seen.y / seen.x + draws.uniform(pixel),
                seen.z / seen.x + draws.uniform(pixel),
            );
            let surveyed = aircraft.inverse() * target + draws.in_space(errors.target_m) - camera_error;
            let wobble = m321(ATTITUDE_DEG.map(|sigma| draws.normal(sigma)));
            let reference = wobble * aircraft * surveyed;
            DirectionPair { measured: image.normalize(), reference: reference.normalize(), weight: 1.0 }
        })
        .collect();
    let found = attitude(pairs.iter().copied()).expect("the targets lie in different directions");
    let residuals: Vec<f64> =
        pairs.iter().map(|pair| pair.measured.angle(&(found * pair.reference)).to_degrees()).collect();
    let axis = |mounted: &UnitQuaternion<f64>| mounted.inverse() * Vector3::x();
    SessionErrors {
        residual_deg: rms(&residuals),
        axis_deg: axis(&found).angle(&axis(&mounted)).to_degrees(),
        rotation_deg: found.angle_to(&mounted).to_degrees(),
    }
}
