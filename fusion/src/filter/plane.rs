//! The state over ground: position, velocity, the bias of the radar that sees it, and where the model has one, the
//! acceleration.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use super::bias::{Bias, Moments, SlowChange};
use super::errors::{LineOfSight, RadarErrors};
use super::imm::{Gaussian, Linear, Mixture, Observation};
use super::motion::{MODELS, Models};
use super::singer::Singer;

/// East, north (metres), their rates (metres a second), and the radar's bias in range (metres) and azimuth (radians).
pub(super) const STATES: usize = 6;
/// With the acceleration behind these, east and north, metres a second squared: what is measured has the same place in both.
pub(super) const STATES_SINGER: usize = 8;
const EAST_RATE: usize = 2;
const NORTH_RATE: usize = 3;
const RANGE: usize = 4;
const AZIMUTH: usize = 5;
const EAST_ACCELERATION: usize = 6;
const NORTH_ACCELERATION: usize = 7;

/// Before anything is measured it is anywhere: one standard deviation of each axis, metres.
const ANYWHERE_M: f64 = 10_000.0;
/// Speeds that a target may have when it is first seen, one standard deviation of each axis, metres a second.
const FIRST_SPEED: f64 = 12.0;
/// How likely each of the interacting models is then.
const FIRST_WEIGHTS: [f64; MODELS] = [0.6, 0.3, 0.05, 0.05];

/// How a target moves over ground: `M` models of a state of `D` numbers.
pub(super) trait OverGround<const D: usize, const M: usize> {
    /// A target somewhere about there, before anything is measured, and the radar's bias.
    fn first(&self, place: Vector2<f64>, slow: Option<&Bias>) -> Mixture<D, M>;

    /// Each model's motion over `dt` seconds, and what becomes of the bias.
    fn motions(&self, dt: f64, slow: &SlowChange) -> [Linear<D>; M];

    /// Probabilities to change from one model to another within `dt` seconds.
    fn switch(&self, dt: f64) -> [[f64; M]; M];
}

impl OverGround<STATES, MODELS> for Models {
    fn first(&self, place: Vector2<f64>, slow: Option<&Bias>) -> Mixture<STATES, MODELS> {
        Mixture { weights: FIRST_WEIGHTS, parts: [resting(place, slow); MODELS] }
    }

    fn motions(&self, dt: f64, slow: &SlowChange) -> [Linear<STATES>; MODELS] {
        self.each.map(|model| {
            let motion = model.over(dt);
            let mut moved: Linear<STATES> = unmoved(slow);
            moved.transition.fixed_view_mut::<4, 4>(0, 0).copy_from(&motion.transition);
            moved.noise.fixed_view_mut::<4, 4>(0, 0).copy_from(&motion.noise);
            moved
        })
    }

    fn switch(&self, dt: f64) -> [[f64; MODELS]; MODELS] {
        self.switch(dt)
    }
}

impl OverGround<STATES_SINGER, 1> for Singer {
    fn first(&self, place: Vector2<f64>, slow: Option<&Bias>) -> Mixture<STATES_SINGER, 1> {
        let mut part = resting(place, slow);
        for acceleration in [EAST_ACCELERATION, NORTH_ACCELERATION] {
            part.covariance[(acceleration, acceleration)] = self.horizontal * self.horizontal;
        }
        Mixture { weights: [1.0], parts: [part] }
    }

    fn motions(&self, dt: f64, slow: &SlowChange) -> [Linear<STATES_SINGER>; 1] {
        let axis = self.over(dt, self.horizontal);
        let mut moved = unmoved(slow);
        axis.put_into(&mut moved, [0, EAST_RATE, EAST_ACCELERATION]);
        axis.put_into(&mut moved, [1, NORTH_RATE, NORTH_ACCELERATION]);
        [moved]
    }

    fn switch(&self, _dt: f64) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

/// What is known first of each state but the acceleration.
fn resting<const D: usize>(place: Vector2<f64>, slow: Option<&Bias>) -> Gaussian<D> {
    let mut covariance = SMatrix::<f64, D, D>::zeros();
    covariance.fixed_view_mut::<2, 2>(0, 0).fill_diagonal(ANYWHERE_M * ANYWHERE_M);
    covariance.fixed_view_mut::<2, 2>(EAST_RATE, EAST_RATE).fill_diagonal(FIRST_SPEED * FIRST_SPEED);
    let slow = slow.copied().unwrap_or(Bias::NONE);
    covariance[(RANGE, RANGE)] = slow.range_m.variance;
    covariance[(AZIMUTH, AZIMUTH)] = slow.azimuth.variance;
    let mut mean = SVector::<f64, D>::zeros();
    mean.fixed_rows_mut::<2>(0).copy_from(&place);
    mean[RANGE] = slow.range_m.mean;
    mean[AZIMUTH] = slow.azimuth.mean;
    Gaussian { mean, covariance }
}

/// What becomes of the bias, and nothing else.
fn unmoved<const D: usize>(slow: &SlowChange) -> Linear<D> {
    let mut transition = SMatrix::<f64, D, D>::zeros();
    let mut noise = SMatrix::<f64, D, D>::zeros();
    let mut shift = SVector::<f64, D>::zeros();
    for (index, Moments { mean, variance }) in [(RANGE, slow.added.range_m), (AZIMUTH, slow.added.azimuth)] {
        transition[(index, index)] = slow.kept;
        shift[index] = mean;
        noise[(index, index)] = variance;
    }
    Linear { transition, shift, noise }
}

/// Its place is known less well by that.
pub(super) fn spread<const D: usize>(state: &mut Gaussian<D>, by: &Matrix2<f64>) {
    let mut block = state.covariance.fixed_view_mut::<2, 2>(0, 0);
    block += by;
}

/// A transponder's position.
pub(super) fn fix<const D: usize>(place: Vector2<f64>, sigma_m: f64) -> Observation<D, 2> {
    let mut matrix = SMatrix::<f64, 2, D>::zeros();
    matrix[(0, 0)] = 1.0;
    matrix[(1, 1)] = 1.0;
    Observation { value: place, matrix, noise: Matrix2::identity() * sigma_m * sigma_m }
}

/// A velocity over ground, whoever tells it.
pub(super) fn velocity<const D: usize>(velocity: Vector2<f64>, deviation: f64) -> Observation<D, 2> {
    let mut matrix = SMatrix::<f64, 2, D>::zeros();
    matrix[(0, EAST_RATE)] = 1.0;
    matrix[(1, NORTH_RATE)] = 1.0;
    Observation { value: velocity, matrix, noise: Matrix2::identity() * deviation * deviation }
}

/// A radar's plot: what it shows is the position and its bias.
pub(super) fn plot<const D: usize>(
    place: Vector2<f64>,
    seen: &LineOfSight,
    errors: &RadarErrors,
) -> Observation<D, 2> {
    let mut matrix = SMatrix::<f64, 2, D>::zeros();
    matrix[(0, 0)] = 1.0;
    matrix[(1, 1)] = 1.0;
    matrix.fixed_view_mut::<2, 1>(0, RANGE).copy_from(&seen.outward);
    matrix.fixed_view_mut::<2, 1>(0, AZIMUTH).copy_from(&(seen.clockwise * seen.range_m));
    Observation { value: place, matrix, noise: seen.spread(errors.noise_range_m, errors.noise_azimuth) }
}
