//! The state over ground: position, velocity, the acceleration if the model has one, and the bias of each radar that
//! detects the target.

use nalgebra::Vector2;

use super::bias::{Bias, SlowChange};
use super::errors::{LineOfSight, RadarErrors};
use super::gaussian::{BiasTransition, Gaussian, LinearMotion, PairObservation};
use super::imm::Mixture;
use super::motion::{Course, MODELS, Models, speed_factor};
use super::singer::{OverGroundAxes, Singer};
use super::symmetric::Symmetric;

/// The state is east, north (metres), and their rates (metres a second), followed by the bias of each radar in range
/// (metres) and azimuth (radians).
const EAST_RATE: usize = 2;
const NORTH_RATE: usize = 3;
/// Indices of the acceleration, east and north, metres a second squared, if the model has one. It precedes the biases.
const EAST_ACCELERATION: usize = 4;
const NORTH_ACCELERATION: usize = 5;

/// Number of variables of a state with the biases of `radars` radars.
pub(super) const fn states(radars: usize) -> usize {
    4 + 2 * radars
}

/// Number of variables of a state with the acceleration and the biases of `radars` radars.
pub(super) const fn states_singer(radars: usize) -> usize {
    6 + 2 * radars
}

/// Standard deviation of each axis of a position that is not measured yet, metres.
const ANYWHERE_M: f64 = 10_000.0;
/// Standard deviation of each axis of the velocity of a new target, metres a second.
const FIRST_SPEED: f64 = 12.0;
/// Standard deviation along a camera's line, metres: practically unknown.
const ALONG_M: f64 = 1e6;
/// Initial probabilities of the interacting models.
const FIRST_WEIGHTS: [f64; MODELS] = [0.6, 0.3, 0.05, 0.05];

/// Motion of a target over ground: `M` models of a state of `D` variables.
pub(super) trait OverGround<const D: usize, const M: usize> {
    /// Motion of one model over an interval.
    type Motion: LinearMotion<D>;

    /// Initial state of a target near this position, before any measurement. The biases are not set.
    fn first(&self, place: Vector2<f64>) -> Mixture<D, M>;

    /// Each model's motion over `dt` seconds, for a target of that speed over ground, m/s.
    fn motions(&self, dt: f64, speed_m_s: f64) -> [Self::Motion; M];

    /// Probabilities of a change from one model to another within `dt` seconds.
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

/// Prior of position and velocity.
fn resting<const D: usize>(place: Vector2<f64>) -> Gaussian<D> {
    let mut first = Gaussian { mean: [0.0; D], covariance: Symmetric::ZERO };
    for axis in [0, 1] {
        first.mean[axis] = place[axis];
        first.covariance.set_diagonal(axis, ANYWHERE_M * ANYWHERE_M);
        first.covariance.set_diagonal(axis + EAST_RATE, FIRST_SPEED * FIRST_SPEED);
    }
    first
}

/// Indices of a radar's biases, range and azimuth, in a state of `D` variables with the biases of `radars` radars.
const fn places<const D: usize>(radars: usize, radar: usize) -> [usize; 2] {
    let range = D - 2 * radars + 2 * radar;
    [range, range + 1]
}

/// Sets the prior of the biases.
pub(super) fn begin<const D: usize, const S: usize>(state: &mut Gaussian<D>, biases: &[Bias; S]) {
    for (radar, bias) in biases.iter().enumerate() {
        for (place, moments) in places::<D>(S, radar).into_iter().zip([bias.range_m, bias.azimuth]) {
            state.mean[place] = moments.mean;
            state.covariance.set_diagonal(place, moments.variance);
        }
    }
}

/// Change of the biases over an interval.
pub(super) fn slow<const D: usize, const S: usize>(changes: &[SlowChange; S]) -> BiasTransition<D> {
    let mut slow = BiasTransition::NONE;
    for (radar, SlowChange { kept, added }) in changes.iter().enumerate() {
        for (place, moments) in places::<D>(S, radar).into_iter().zip([added.range_m, added.azimuth]) {
            slow.set(place, *kept, moments);
        }
    }
    slow
}

/// Enlarges the covariance of the position by the square of a displacement.
pub(super) fn spread<const D: usize>(state: &mut Gaussian<D>, away: Vector2<f64>) {
    state.covariance.add_at(0, 0, away.x * away.x);
    state.covariance.add_at(0, 1, away.x * away.y);
    state.covariance.add_at(1, 1, away.y * away.y);
}

/// Observation of a transponder's position.
pub(super) fn fix(place: Vector2<f64>, sigma_m: f64) -> PairObservation {
    on_both_axes([0, 1], place, sigma_m)
}

/// Observation of a camera's line through a position, with standard deviation `across_m` across it; unknown along it.
pub(super) fn line(place: Vector2<f64>, clockwise: Vector2<f64>, across_m: f64) -> PairObservation {
    let outward = Vector2::new(-clockwise.y, clockwise.x);
    let row = |axis: Vector2<f64>| [(0, axis.x), (1, axis.y), (0, 0.0)];
    PairObservation {
        rows: [row(clockwise), row(outward)],
        values: [clockwise.dot(&place), outward.dot(&place)],
        noise: [across_m * across_m, 0.0, ALONG_M * ALONG_M],
    }
}

/// Observation of a velocity over ground, by any sensor.
pub(super) fn velocity(velocity: Vector2<f64>, deviation: f64) -> PairObservation {
    on_both_axes([EAST_RATE, NORTH_RATE], velocity, deviation)
}

fn on_both_axes(places: [usize; 2], values: Vector2<f64>, deviation: f64) -> PairObservation {
    let variance = deviation * deviation;
    PairObservation {
        rows: places.map(|place| [(place, 1.0), (place, 0.0), (place, 0.0)]),
        values: [values.x, values.y],
        noise: [variance, 0.0, variance],
    }
}

/// Observation of a plot by the radar with index `radar` of `S`: the sum of position and bias, along and across the
/// line of sight, on which its noise is independent.
pub(super) fn plot<const D: usize, const S: usize>(
    place: Vector2<f64>,
    seen: &LineOfSight,
    errors: &RadarErrors,
    radar: usize,
) -> PairObservation {
    let [range, azimuth] = places::<D>(S, radar);
    let row = |axis: &Vector2<f64>, bias| [(0, axis.x), (1, axis.y), bias];
    PairObservation {
        rows: [row(&seen.outward, (range, 1.0)), row(&seen.clockwise, (azimuth, seen.range_m))],
        values: [seen.outward.dot(&place), seen.clockwise.dot(&place)],
        noise: [errors.noise_range_m.powi(2), 0.0, (seen.range_m * errors.noise_azimuth).powi(2)],
    }
}
