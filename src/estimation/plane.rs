//! The state over ground: position, velocity, and the slow error of the radar that sees it.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2, vector};

use super::imm::{Gaussian, Linear, MODELS, Mixture, Observation};
use super::motion::Model;
use super::slow::{SlowChange, SlowError};
use super::track::{RadarErrors, Seen};

/// East, north (metres), their rates (metres a second), and the radar's slow error in range (metres) and azimuth (radians).
pub(super) const STATES: usize = 6;
const EAST_RATE: usize = 2;
const NORTH_RATE: usize = 3;
const RANGE: usize = 4;
const AZIMUTH: usize = 5;

pub(super) type Plane = Mixture<STATES>;

/// Speeds that a target may have when it is first seen, one standard deviation of each axis, metres a second.
const FIRST_SPEED: f64 = 12.0;
/// How likely each model is then.
const FIRST_WEIGHTS: [f64; MODELS] = [0.6, 0.3, 0.05, 0.05];

/// A target about which only this is known.
pub(super) fn first(place: Vector2<f64>, spread: Matrix2<f64>, slow: Option<&SlowError>) -> Plane {
    let mut covariance = SMatrix::<f64, STATES, STATES>::zeros();
    covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&spread);
    covariance.fixed_view_mut::<2, 2>(2, 2).fill_diagonal(FIRST_SPEED * FIRST_SPEED);
    let slow = slow.copied().unwrap_or(SlowError::NONE);
    covariance[(RANGE, RANGE)] = slow.range_m.1;
    covariance[(AZIMUTH, AZIMUTH)] = slow.azimuth.1;
    let mean = vector![place.x, place.y, 0.0, 0.0, slow.range_m.0, slow.azimuth.0];
    Mixture { weights: FIRST_WEIGHTS, parts: [Gaussian { mean, covariance }; MODELS] }
}

/// Each model's motion over `dt` seconds, and what becomes of the slow error.
pub(super) fn motions(models: &[Model; MODELS], dt: f64, slow: &SlowChange) -> [Linear<STATES>; MODELS] {
    models.map(|model| {
        let motion = model.over(dt);
        let mut transition = SMatrix::<f64, STATES, STATES>::zeros();
        let mut noise = SMatrix::<f64, STATES, STATES>::zeros();
        let mut shift = SVector::<f64, STATES>::zeros();
        transition.fixed_view_mut::<4, 4>(0, 0).copy_from(&motion.transition);
        noise.fixed_view_mut::<4, 4>(0, 0).copy_from(&motion.noise);
        for (index, (mean, variance)) in [(RANGE, slow.added.range_m), (AZIMUTH, slow.added.azimuth)] {
            transition[(index, index)] = slow.kept;
            shift[index] = mean;
            noise[(index, index)] = variance;
        }
        Linear { transition, shift, noise }
    })
}

/// Its place is known less well by that.
pub(super) fn spread(state: &mut Gaussian<STATES>, by: &Matrix2<f64>) {
    let mut block = state.covariance.fixed_view_mut::<2, 2>(0, 0);
    block += by;
}

/// A transponder's position.
pub(super) fn fix(place: Vector2<f64>, deviation_m: f64) -> Observation<STATES, 2> {
    let mut matrix = SMatrix::<f64, 2, STATES>::zeros();
    matrix[(0, 0)] = 1.0;
    matrix[(1, 1)] = 1.0;
    Observation { value: place, matrix, noise: Matrix2::identity() * deviation_m * deviation_m }
}

/// A velocity over ground, whoever tells it.
pub(super) fn velocity(velocity: Vector2<f64>, deviation: f64) -> Observation<STATES, 2> {
    let mut matrix = SMatrix::<f64, 2, STATES>::zeros();
    matrix[(0, EAST_RATE)] = 1.0;
    matrix[(1, NORTH_RATE)] = 1.0;
    Observation { value: velocity, matrix, noise: Matrix2::identity() * deviation * deviation }
}

/// A radar's plot: what it shows is the position and its slow error.
pub(super) fn plot(place: Vector2<f64>, seen: &Seen, errors: &RadarErrors) -> Observation<STATES, 2> {
    let mut matrix = SMatrix::<f64, 2, STATES>::zeros();
    matrix[(0, 0)] = 1.0;
    matrix[(1, 1)] = 1.0;
    matrix.fixed_view_mut::<2, 1>(0, RANGE).copy_from(&seen.outward);
    matrix.fixed_view_mut::<2, 1>(0, AZIMUTH).copy_from(&(seen.clockwise * seen.range_m));
    Observation { value: place, matrix, noise: seen.spread(errors.fast_range_m, errors.fast_azimuth) }
}

/// Everything a plot may be wrong by.
pub(super) fn plot_spread(seen: &Seen, errors: &RadarErrors) -> Matrix2<f64> {
    seen.spread(
        errors.fast_range_m.hypot(errors.slow_range_m),
        errors.fast_azimuth.hypot(errors.slow_azimuth),
    )
}
