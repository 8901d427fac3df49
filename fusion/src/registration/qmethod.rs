//! The rotation that best maps reference directions to measured ones: Davenport's q-method.
//!
//! Wahba's loss Σ w |b - A r|² / 2 = Σ w - tr(A Bᵀ), B = Σ w b rᵀ, is least for the quaternion of the largest eigenvalue of a
//! symmetric 4 × 4 matrix made from B. A radar has different information about each axis of rotation: azimuth and elevation
//! differ in accuracy, and heights may be missing. Its loss has the same form: with the information F about a small rotation, B =
//! tr(F) 1 / 2 - F (Shuster, who has F = tr(B) 1 - B).

use nalgebra::{Matrix3, Matrix3x6, Matrix4, Quaternion, Rotation3, UnitQuaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::along::Information;
use super::parameters::{BEARING, HEIGHT, TILT_EAST, TILT_NORTH, TIME};

/// Second singular value of an attitude profile over the first, below which the rotation about one axis is undetermined.
const SINGULAR: f64 = 1e-12;

/// Attitude profile B of a segment of a track or of their sum, and its change with the other parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AttitudeProfile {
    pub(super) matrix: Matrix3<f64>,
    /// Change per metre of height.
    pub(super) by_height: Matrix3<f64>,
    /// Change per second of time.
    pub(super) by_time: Matrix3<f64>,
}

impl AttitudeProfile {
    pub(super) fn none() -> Self {
        Self { matrix: Matrix3::zeros(), by_height: Matrix3::zeros(), by_time: Matrix3::zeros() }
    }

    /// Profile of a segment with a mean rotation of `turned` (clockwise, radians). This rotation is applied exactly; the
    /// remainder is treated as small. Half of it is applied on either side, so that tilts keep their meaning for any rotation.
    pub(super) fn of(information: &Information, turned: f64) -> Self {
        let small = rotations();
        let spread = small * information.matrix * small.transpose();
        let half = *Rotation3::from_axis_angle(&Vector3::z_axis(), -turned / 2.0).matrix();
        let about_up = Vector3::new(0.0, 0.0, -turned);
        let linear = |vector: Vector3<f64>| vector.cross_matrix() / 2.0;
        let column = |parameter: usize| small * information.matrix.column(parameter);
        let matrix = bare(&spread) + linear(small * information.vector - spread * about_up);
        Self {
            matrix: half * matrix * half,
            by_height: half * linear(column(HEIGHT)) * half,
            by_time: half * linear(column(TIME)) * half,
        }
    }

    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        self.matrix += other.matrix * weight;
        self.by_height += other.by_height * weight;
        self.by_time += other.by_time * weight;
    }

    /// The profile without the effect of a height and a time bias.
    pub(super) fn without(&self, height_m: f64, time_s: f64) -> Matrix3<f64> {
        self.matrix - self.by_height * height_m - self.by_time * time_s
    }
}

/// Matrix from p to the rotation vector (east, north, up): the bearing is clockwise.
fn rotations() -> Matrix3x6<f64> {
    let mut rows = Matrix3x6::zeros();
    rows[(0, TILT_EAST)] = 1.0;
    rows[(1, TILT_NORTH)] = 1.0;
    rows[(2, BEARING)] = -1.0;
    rows
}

/// Rotation vector of these parameters, radians.
pub(super) fn rotation_vector(parameters: &Vector6<f64>) -> Vector3<f64> {
    rotations() * parameters
}

/// Profile B of no rotation, with this information about a small rotation.
pub(super) fn bare(information: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (information.trace() / 2.0) - information
}

/// A direction as a sensor measured it, and as a reference has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionPair {
    /// Measured unit vector.
    pub measured: Vector3<f64>,
    /// Unit vector of the reference, in its axes.
    pub reference: Vector3<f64>,
    /// Weight, without a unit: inverse variances up to a common factor.
    pub weight: f64,
}

/// The rotation A from the reference's axes to the sensor's that minimises Wahba's loss Σ w |b - A r|² of measured directions b
/// and reference directions r (G. Fasano et al., *An Innovative Procedure for Calibration of Strapdown Electro-Optical Sensors
/// Onboard Unmanned Air Vehicles*, equation 3).
///
/// `None`: the directions do not determine a rotation, because fewer than two of them differ.
pub fn attitude(pairs: impl IntoIterator<Item = DirectionPair>) -> Option<UnitQuaternion<f64>> {
    let profile = pairs
        .into_iter()
        .fold(Matrix3::zeros(), |sum, pair| sum + pair.measured * pair.reference.transpose() * pair.weight);
    let mut sizes = profile.singular_values();
    sizes.as_mut_slice().sort_unstable_by(|a, b| b.total_cmp(a));
    (sizes[1] > SINGULAR * sizes[0]).then(|| rotation(&profile).0)
}

/// The rotation A with the largest tr(A Bᵀ), for b = A r and B = Σ w b rᵀ, and that trace.
pub(super) fn rotation(profile: &Matrix3<f64>) -> (UnitQuaternion<f64>, f64) {
    let sum = profile + profile.transpose();
    let trace = profile.trace();
    let turn = Vector3::new(
        profile[(2, 1)] - profile[(1, 2)],
        profile[(0, 2)] - profile[(2, 0)],
        profile[(1, 0)] - profile[(0, 1)],
    );
    // The quaternion's scalar is last.
    let mut matrix = Matrix4::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(sum - Matrix3::identity() * trace));
    matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&turn);
    matrix.fixed_view_mut::<1, 3>(3, 0).copy_from(&turn.transpose());
    matrix[(3, 3)] = trace;
    let eigen = matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.imax();
    let vector = eigen.eigenvectors.column(largest);
    // The sign of the quaternion with the smaller rotation.
    let sign = if vector[3] < 0.0 { -1.0 } else { 1.0 };
    let quaternion = Quaternion::new(vector[3], vector[0], vector[1], vector[2]) * sign;
    (UnitQuaternion::from_quaternion(quaternion), eigen.eigenvalues[largest])
}

/// The rotation in the plane, without tilts: clockwise angle, and the trace Σ w cos of the remainder.
pub(super) fn turn(profile: &Matrix3<f64>) -> (f64, f64) {
    let cos = profile[(0, 0)] + profile[(1, 1)];
    let sin = profile[(0, 1)] - profile[(1, 0)];
    (sin.atan2(cos), sin.hypot(cos))
}
