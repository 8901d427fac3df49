//! Compares Jacobians with central differences, updates with dense matrices, and trackers with the path flown.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use fusion::filter::{Gaussian, LinearMotion, Symmetric};
use fusion::frames::Enu;
use fusion::report::SensorIndex;
use fusion::time::Time;

mod jacobians;
mod readings;
mod trackers;
mod updates;

/// F of a motion.
fn transition_of<const D: usize>(motion: &impl LinearMotion<D>) -> SMatrix<f64, D, D> {
    let mut rows =
        std::array::from_fn(|row| std::array::from_fn(|column| f64::from(u8::from(row == column))));
    motion.carry::<D>(&mut rows);
    SMatrix::from_fn(|row, column| rows[row][column])
}

/// Q of a motion.
fn noise_of<const D: usize>(motion: &impl LinearMotion<D>) -> SMatrix<f64, D, D> {
    let mut noise = Symmetric::ZERO;
    motion.add_noise(&mut noise);
    SMatrix::from_fn(|row, column| noise.at(row, column))
}

fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

fn seconds(at: f64) -> Time {
    Time::from_nanos((at * 1e9).round() as i64)
}

/// A vector in a random direction with a length between `near` and `far`, each order of magnitude equally likely.
fn away(rng: &mut ChaCha8Rng, near: f64, far: f64) -> Vector3<f64> {
    loop {
        let cube = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&cube.norm()) {
            return cube.normalize() * near * (far / near).powf(rng.random_range(0.0..1.0));
        }
    }
}

fn taken(at: f64, sensor: u16, observer: Observer) -> ReadingOrigin {
    ReadingOrigin { time: seconds(at), sensor: SensorIndex(sensor), observer }
}

/// A measurement by a sensor at rest at the site's origin.
fn at_origin(at: f64, sensor: u16) -> ReadingOrigin {
    taken(at, sensor, Observer::at_rest(Enu::new(0.0, 0.0, 0.0)))
}

const RADAR: RadarModel = RadarModel { range_m: 20.0, azimuth: 0.01, elevation: 0.02, range_rate: Some(1.5) };
const CAMERA: CameraModel = CameraModel { azimuth: 0.002, elevation: 0.003 };

/// The reading of a radar without noise.
fn seen_by_radar(taken: ReadingOrigin, position: &Vector3<f64>, velocity: &Vector3<f64>) -> Reading {
    let [range, azimuth, elevation, rate] =
        [Quantity::Range, Quantity::Azimuth, Quantity::Elevation, Quantity::RangeRate]
            .map(|quantity| quantity.expected(&taken.observer, position, velocity).unwrap().value);
    RADAR.reading(taken, [range, azimuth, elevation], Some(rate)).unwrap()
}

fn seen_by_camera(taken: ReadingOrigin, position: &Vector3<f64>) -> Reading {
    let angles = [Quantity::Azimuth, Quantity::Elevation]
        .map(|quantity| quantity.expected(&taken.observer, position, &Vector3::zeros()).unwrap().value);
    CAMERA.reading(taken, angles).unwrap()
}

fn gaussian(mean: [f64; 6], covariance: &Matrix6<f64>) -> Gaussian<6> {
    let rows = std::array::from_fn(|row| std::array::from_fn(|column| covariance[(row, column)]));
    Gaussian { mean, covariance: Symmetric::of_lower(rows) }
}

fn dense(symmetric: &Symmetric<6>) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| symmetric.at(row, column))
}

/// A random covariance without zero elements, with about `position_m` and `speed` on the diagonal.
fn covariance(rng: &mut ChaCha8Rng, position_m: f64, speed: f64) -> Matrix6<f64> {
    let factor = Matrix6::from_fn(|row, _| {
        let scale = if row < 3 { position_m } else { speed };
        scale * rng.random_range(-0.6..0.6)
    });
    let least = Matrix6::from_diagonal(
        &[position_m, position_m, position_m, speed, speed, speed].map(|scale| 0.01 * scale * scale).into(),
    );
    factor * factor.transpose() + least
}

/// Whether all eigenvalues are above zero, with each variable in units of its own deviation.
fn is_covariance(matrix: &Matrix6<f64>) -> bool {
    let deviations = matrix.diagonal().map(f64::sqrt);
    let scaled =
        Matrix6::from_fn(|row, column| matrix[(row, column)] / (deviations[row] * deviations[column]));
    matrix.iter().all(|value| value.is_finite()) && scaled.cholesky().is_some()
}

fn close(a: &Matrix3<f64>, b: &Matrix3<f64>, relative: f64) -> bool {
    (a - b).norm() <= relative * b.norm()
}
