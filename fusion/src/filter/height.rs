//! The vertical state: height, climb, the acceleration if the model has one, and the height bias of each radar.

use super::bias::{Bias, SlowChange};
use super::gaussian::{BiasTransition, Gaussian, LinearMotion, ScalarObservation};
use super::motion::{Models, white_acceleration};
use super::singer::{HeightAxis, Singer};
use super::symmetric::{Rows, Symmetric};

/// The state is height (metres) and climb (metres a second), followed by the bias of each radar (metres).
const CLIMB: usize = 1;
/// Index of the acceleration, metres a second squared, if the model has one. It precedes the biases.
const ACCELERATION: usize = 2;

/// Number of variables of a state with the biases of `radars` radars.
pub(super) const fn states(radars: usize) -> usize {
    2 + radars
}

/// Number of variables of a state with the acceleration and the biases of `radars` radars.
pub(super) const fn states_singer(radars: usize) -> usize {
    3 + radars
}

/// Standard deviation of the climb of a new target, metres a second.
const FIRST_CLIMB: f64 = 2.0;
/// Standard deviation of a height that is not measured yet, metres.
const ANYWHERE_M: f64 = 10_000.0;
/// Standard deviation of a height that is never measured, metres: any height at which drones fly.
const UNKNOWN_M: f64 = 60.0;
/// Power spectral density of the vertical acceleration, used with the interacting models over ground, m²/s³.
const NOISE: f64 = 1.0;

/// Vertical motion of a target, for a state of `D` variables.
pub(super) trait AboveGround<const D: usize> {
    /// Motion over an interval.
    type Motion: LinearMotion<D>;

    /// Initial state of a target at about this height; `is_measured`: its height will be measured. The biases are not
    /// set.
    fn first(&self, height_m: f64, is_measured: bool) -> Gaussian<D>;

    /// The motion over `dt` seconds.
    fn motion(&self, dt: f64) -> Self::Motion;
}

/// A constant climb, disturbed by white acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Climb {
    dt: f64,
    /// Variance of the height, covariance of height and climb, variance of the climb.
    noise: [f64; 3],
}

impl<const D: usize> LinearMotion<D> for Climb {
    const MOVING: usize = 2;

    #[inline]
    fn carry<const N: usize>(&self, rows: &mut Rows<N, D>) {
        for column in 0..N {
            rows[0][column] += self.dt * rows[CLIMB][column];
        }
    }

    #[inline]
    fn add_noise(&self, covariance: &mut Symmetric<D>) {
        let [height, across, climb] = self.noise;
        covariance.add_at(0, 0, height);
        covariance.add_at(0, CLIMB, across);
        covariance.add_at(CLIMB, CLIMB, climb);
    }
}

impl<const D: usize> AboveGround<D> for Models {
    type Motion = Climb;

    fn first(&self, height_m: f64, is_measured: bool) -> Gaussian<D> {
        level(height_m, is_measured)
    }

    fn motion(&self, dt: f64) -> Climb {
        Climb { dt, noise: white_acceleration(NOISE, dt) }
    }
}

impl<const D: usize> AboveGround<D> for Singer {
    type Motion = HeightAxis;

    fn first(&self, height_m: f64, is_measured: bool) -> Gaussian<D> {
        let mut first = level(height_m, is_measured);
        first.covariance.set_diagonal(ACCELERATION, self.vertical * self.vertical);
        first
    }

    fn motion(&self, dt: f64) -> HeightAxis {
        HeightAxis(self.over(dt, self.vertical))
    }
}

/// Prior of height and climb.
fn level<const D: usize>(height_m: f64, is_measured: bool) -> Gaussian<D> {
    let deviation = if is_measured { ANYWHERE_M } else { UNKNOWN_M };
    let mut first = Gaussian { mean: [0.0; D], covariance: Symmetric::ZERO };
    first.mean[0] = height_m;
    first.covariance.set_diagonal(0, deviation * deviation);
    first.covariance.set_diagonal(CLIMB, FIRST_CLIMB * FIRST_CLIMB);
    first
}

/// Sets the prior of the biases.
pub(super) fn begin<const D: usize, const S: usize>(state: &mut Gaussian<D>, biases: &[Bias; S]) {
    for (radar, bias) in biases.iter().enumerate() {
        let place = D - S + radar;
        state.mean[place] = bias.height_m.mean;
        state.covariance.set_diagonal(place, bias.height_m.variance);
    }
}

/// Change of the biases over an interval.
pub(super) fn slow<const D: usize, const S: usize>(changes: &[SlowChange; S]) -> BiasTransition<D> {
    let mut slow = BiasTransition::NONE;
    for (radar, SlowChange { kept, added }) in changes.iter().enumerate() {
        slow.set(D - S + radar, *kept, added.height_m);
    }
    slow
}

/// Observation of a height with standard deviation `sigma_m`; `radar`: index, of `S`, of the radar whose bias it
/// contains.
pub(super) fn height<const D: usize, const S: usize>(
    height_m: f64,
    sigma_m: f64,
    radar: Option<usize>,
) -> ScalarObservation {
    let bias = radar.map_or((0, 0.0), |radar| (D - S + radar, 1.0));
    ScalarObservation { row: [(0, 1.0), bias, (0, 0.0)], value: height_m, noise: sigma_m * sigma_m }
}

/// Observation of a climb with standard deviation `deviation`.
pub(super) fn climb(climb: f64, deviation: f64) -> ScalarObservation {
    ScalarObservation { row: [(CLIMB, 1.0), (0, 0.0), (0, 0.0)], value: climb, noise: deviation * deviation }
}
