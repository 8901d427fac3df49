//! The state above ground: height, climb, the bias of the radar's height, and where the model has one, the
//! acceleration.

use nalgebra::{SMatrix, SVector, matrix, vector};

use super::bias::{Bias, Moments, SlowChange};
use super::imm::{Gaussian, Linear, Observation};
use super::motion::Models;
use super::singer::Singer;

/// Height (metres), climb (metres a second), and the radar's bias (metres).
pub(super) const STATES: usize = 3;
/// With the acceleration behind these, metres a second squared.
pub(super) const STATES_SINGER: usize = 4;
const CLIMB: usize = 1;
const SLOW: usize = 2;
const ACCELERATION: usize = 3;

/// Rates of climb that a target may have when it is first seen, one standard deviation, metres a second.
const FIRST_CLIMB: f64 = 2.0;
/// Before its height is measured it is anywhere: one standard deviation, metres.
const ANYWHERE_M: f64 = 10_000.0;
/// A target whose height was never measured may be at any that drones fly at: one standard deviation, metres.
const UNKNOWN_M: f64 = 60.0;
/// Power spectral density of the vertical acceleration beside the interacting models over ground, m²/s³.
const NOISE: f64 = 1.0;

/// How a target climbs and sinks: a model of a state of `D` numbers.
pub(super) trait AboveGround<const D: usize> {
    /// A target at about this height, before that is measured; `is_measured`: it will be. And the radar's bias.
    fn first(&self, height_m: f64, is_measured: bool, slow: Option<&Bias>) -> Gaussian<D>;

    /// The motion over `dt` seconds, and what becomes of the bias.
    fn motion(&self, dt: f64, slow: &SlowChange) -> Linear<D>;
}

impl AboveGround<STATES> for Models {
    fn first(&self, height_m: f64, is_measured: bool, slow: Option<&Bias>) -> Gaussian<STATES> {
        level(height_m, is_measured, slow)
    }

    fn motion(&self, dt: f64, slow: &SlowChange) -> Linear<STATES> {
        let (p, c, v) = (NOISE * dt.powi(3) / 3.0, NOISE * dt * dt / 2.0, NOISE * dt);
        Linear {
            transition: matrix![1.0, dt, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, slow.kept],
            shift: vector![0.0, 0.0, slow.added.height_m.mean],
            noise: matrix![p, c, 0.0; c, v, 0.0; 0.0, 0.0, slow.added.height_m.variance],
        }
    }
}

impl AboveGround<STATES_SINGER> for Singer {
    fn first(&self, height_m: f64, is_measured: bool, slow: Option<&Bias>) -> Gaussian<STATES_SINGER> {
        let mut first = level(height_m, is_measured, slow);
        first.covariance[(ACCELERATION, ACCELERATION)] = self.vertical * self.vertical;
        first
    }

    fn motion(&self, dt: f64, slow: &SlowChange) -> Linear<STATES_SINGER> {
        let mut moved =
            Linear { transition: SMatrix::zeros(), shift: SVector::zeros(), noise: SMatrix::zeros() };
        self.over(dt, self.vertical).put_into(&mut moved, [0, CLIMB, ACCELERATION]);
        moved.transition[(SLOW, SLOW)] = slow.kept;
        let Moments { mean, variance } = slow.added.height_m;
        (moved.shift[SLOW], moved.noise[(SLOW, SLOW)]) = (mean, variance);
        moved
    }
}

/// What is known first of each state but the acceleration.
fn level<const D: usize>(height_m: f64, is_measured: bool, slow: Option<&Bias>) -> Gaussian<D> {
    let deviation = if is_measured { ANYWHERE_M } else { UNKNOWN_M };
    let slow = slow.copied().unwrap_or(Bias::NONE);
    let mut mean = SVector::<f64, D>::zeros();
    let mut covariance = SMatrix::<f64, D, D>::zeros();
    mean[0] = height_m;
    covariance[(0, 0)] = deviation * deviation;
    covariance[(CLIMB, CLIMB)] = FIRST_CLIMB * FIRST_CLIMB;
    (mean[SLOW], covariance[(SLOW, SLOW)]) = (slow.height_m.mean, slow.height_m.variance);
    Gaussian { mean, covariance }
}

/// A height with that deviation; `radar`: its bias is in it.
pub(super) fn height<const D: usize>(height_m: f64, sigma_m: f64, radar: bool) -> Observation<D, 1> {
    let mut matrix = SMatrix::<f64, 1, D>::zeros();
    matrix[0] = 1.0;
    matrix[SLOW] = if radar { 1.0 } else { 0.0 };
    Observation {
        value: SVector::<f64, 1>::new(height_m),
        matrix,
        noise: SMatrix::<f64, 1, 1>::new(sigma_m * sigma_m),
    }
}

/// A rate of climb with that deviation.
pub(super) fn climb<const D: usize>(climb: f64, deviation: f64) -> Observation<D, 1> {
    let mut matrix = SMatrix::<f64, 1, D>::zeros();
    matrix[CLIMB] = 1.0;
    Observation {
        value: SVector::<f64, 1>::new(climb),
        matrix,
        noise: SMatrix::<f64, 1, 1>::new(deviation * deviation),
    }
}
