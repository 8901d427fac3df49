//! The state over ground: position, velocity, where the model has one the acceleration, and the bias of each radar that
//! sees it.

use nalgebra::Vector2;

use super::bias::{Bias, SlowChange};
use super::errors::{LineOfSight, RadarErrors};
use super::gaussian::{Gaussian, Motion, Pair, Slow};
use super::imm::Mixture;
use super::motion::{Course, MODELS, Models, speed_factor};
use super::singer::{OverGroundAxes, Singer};
use super::symmetric::Symmetric;

/// East, north (metres), their rates (metres a second); behind them, of each radar, its bias in range (metres) and azimuth
/// (radians).
const EAST_RATE: usize = 2;
const NORTH_RATE: usize = 3;
/// With the acceleration before the biases, east and north, metres a second squared.
const EAST_ACCELERATION: usize = 4;
const NORTH_ACCELERATION: usize = 5;

/// How many numbers a state has with the biases of so many radars.
pub(super) const fn states(radars: usize) -> usize {
    4 + 2 * radars
}

/// The same with the acceleration.
pub(super) const fn states_singer(radars: usize) -> usize {
    6 + 2 * radars
}

/// Before anything is measured it is anywhere: one standard deviation of each axis, metres.
const ANYWHERE_M: f64 = 10_000.0;
/// Speeds that a target may have when it is first seen, one standard deviation of each axis, metres a second.
const FIRST_SPEED: f64 = 12.0;
/// As good as not known, metres.
const ALONG_M: f64 = 1e6;
/// How likely each of the interacting models is then.
const FIRST_WEIGHTS: [f64; MODELS] = [0.6, 0.3, 0.05, 0.05];

/// How a target moves over ground: `M` models of a state of `D` numbers.
pub(super) trait OverGround<const D: usize, const M: usize> {
    /// The motion by one of the models.
    type Motion: Motion<D>;

    /// A target somewhere about there, before anything is measured; of the biases nothing is known.
    fn first(&self, place: Vector2<f64>) -> Mixture<D, M>;

    /// Each model's motion over `dt` seconds, of a target of that speed over ground, m/s.
    fn motions(&self, dt: f64, speed_m_s: f64) -> [Self::Motion; M];

    /// Probabilities to change from one model to another within `dt` seconds.
    fn switch(&self, dt: f64) -> [[f64; M]; M];
}

impl<const D: usize> OverGround<D, MODELS> for Models {
    type Motion = Course;

    fn first(&self, place: Vector2<f64>) -> Mixture<D, MODELS> {
        Mixture { weights: FIRST_WEIGHTS, parts: [resting(place); MODELS] }
    }

    fn motions(&self, dt: f64, speed_m_s: f64) -> [Course; MODELS] {
        self.each.map(|model| model.at_speed(speed_m_s).over(dt))
    }

    fn switch(&self, dt: f64) -> [[f64; MODELS]; MODELS] {
        self.switch(dt)
    }
}

impl<const D: usize> OverGround<D, 1> for Singer {
    type Motion = OverGroundAxes;

    fn first(&self, place: Vector2<f64>) -> Mixture<D, 1> {
        let mut part = resting(place);
        for acceleration in [EAST_ACCELERATION, NORTH_ACCELERATION] {
            part.covariance.set_diagonal(acceleration, self.horizontal * self.horizontal);
        }
        Mixture { weights: [1.0], parts: [part] }
    }

    fn motions(&self, dt: f64, speed_m_s: f64) -> [OverGroundAxes; 1] {
        [OverGroundAxes(self.over(dt, self.horizontal * speed_factor(speed_m_s)))]
    }

    fn switch(&self, _dt: f64) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

/// What is known first of place and velocity.
fn resting<const D: usize>(place: Vector2<f64>) -> Gaussian<D> {
    let mut first = Gaussian { mean: [0.0; D], covariance: Symmetric::ZERO };
    for axis in [0, 1] {
        first.mean[axis] = place[axis];
        first.covariance.set_diagonal(axis, ANYWHERE_M * ANYWHERE_M);
        first.covariance.set_diagonal(axis + EAST_RATE, FIRST_SPEED * FIRST_SPEED);
    }
    first
}

/// Where the biases of a radar stand in a state of `D` numbers that has those of `radars`: range and azimuth.
const fn places<const D: usize>(radars: usize, radar: usize) -> [usize; 2] {
    let range = D - 2 * radars + 2 * radar;
    [range, range + 1]
}

/// What is known first of the biases.
pub(super) fn begin<const D: usize, const S: usize>(state: &mut Gaussian<D>, biases: &[Bias; S]) {
    for (radar, bias) in biases.iter().enumerate() {
        for (place, moments) in places::<D>(S, radar).into_iter().zip([bias.range_m, bias.azimuth]) {
            state.mean[place] = moments.mean;
            state.covariance.set_diagonal(place, moments.variance);
        }
    }
}

/// What becomes of the biases.
pub(super) fn slow<const D: usize, const S: usize>(changes: &[SlowChange; S]) -> Slow<D> {
    let mut slow = Slow::NONE;
    for (radar, SlowChange { kept, added }) in changes.iter().enumerate() {
        for (place, moments) in places::<D>(S, radar).into_iter().zip([added.range_m, added.azimuth]) {
            slow.set(place, *kept, moments);
        }
    }
    slow
}

/// Its place is known less well: by the square of that distance.
pub(super) fn spread<const D: usize>(state: &mut Gaussian<D>, away: Vector2<f64>) {
    state.covariance.add_at(0, 0, away.x * away.x);
    state.covariance.add_at(0, 1, away.x * away.y);
    state.covariance.add_at(1, 1, away.y * away.y);
}

/// A transponder's position.
pub(super) fn fix(place: Vector2<f64>, sigma_m: f64) -> Pair {
    on_both_axes([0, 1], place, sigma_m)
}

/// A camera's line through a place: across it the place is known with that deviation, along it not.
pub(super) fn line(place: Vector2<f64>, clockwise: Vector2<f64>, across_m: f64) -> Pair {
    let outward = Vector2::new(-clockwise.y, clockwise.x);
    let row = |axis: Vector2<f64>| [(0, axis.x), (1, axis.y), (0, 0.0)];
    Pair {
        rows: [row(clockwise), row(outward)],
        values: [clockwise.dot(&place), outward.dot(&place)],
        noise: [across_m * across_m, 0.0, ALONG_M * ALONG_M],
    }
}

/// A velocity over ground, whoever tells it.
pub(super) fn velocity(velocity: Vector2<f64>, deviation: f64) -> Pair {
    on_both_axes([EAST_RATE, NORTH_RATE], velocity, deviation)
}

fn on_both_axes(places: [usize; 2], values: Vector2<f64>, deviation: f64) -> Pair {
    let variance = deviation * deviation;
    Pair {
        rows: places.map(|place| [(place, 1.0), (place, 0.0), (place, 0.0)]),
        values: [values.x, values.y],
        noise: [variance, 0.0, variance],
    }
}

/// A plot of the radar whose bias has that place among `S`: what it shows is the position and its bias, along and across
/// the line of sight, where its noise is independent.
pub(super) fn plot<const D: usize, const S: usize>(
    place: Vector2<f64>,
    seen: &LineOfSight,
    errors: &RadarErrors,
    radar: usize,
) -> Pair {
    let [range, azimuth] = places::<D>(S, radar);
    let row = |axis: &Vector2<f64>, bias| [(0, axis.x), (1, axis.y), bias];
    Pair {
        rows: [row(&seen.outward, (range, 1.0)), row(&seen.clockwise, (azimuth, seen.range_m))],
        values: [seen.outward.dot(&place), seen.clockwise.dot(&place)],
        noise: [errors.noise_range_m.powi(2), 0.0, (seen.range_m * errors.noise_azimuth).powi(2)],
    }
}
