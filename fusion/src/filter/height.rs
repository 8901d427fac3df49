//! The state above ground: height, climb, where the model has one the acceleration, and the bias of each radar's height.

use super::bias::{Bias, SlowChange};
use super::gaussian::{Gaussian, Motion, Scalar, Slow};
use super::motion::{Models, white_acceleration};
use super::singer::{HeightAxis, Singer};
use super::symmetric::{Rows, Symmetric};

/// Height (metres), climb (metres a second); behind them, of each radar, its bias (metres).
const CLIMB: usize = 1;
/// With the acceleration before the biases, metres a second squared.
const ACCELERATION: usize = 2;

/// How many numbers a state has with the biases of so many radars.
pub(super) const fn states(radars: usize) -> usize {
    2 + radars
}

/// The same with the acceleration.
pub(super) const fn states_singer(radars: usize) -> usize {
    3 + radars
}

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
    /// The motion.
    type Motion: Motion<D>;

    /// A target at about this height, before that is measured; `is_measured`: it will be. Of the biases nothing is known.
    fn first(&self, height_m: f64, is_measured: bool) -> Gaussian<D>;

    /// The motion over `dt` seconds.
    fn motion(&self, dt: f64) -> Self::Motion;
}

/// A climb that goes on, disturbed by white acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Climb {
    dt: f64,
    /// Covariance of height, height and climb, climb.
    noise: [f64; 3],
}

impl<const D: usize> Motion<D> for Climb {
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

/// What is known first of height and climb.
fn level<const D: usize>(height_m: f64, is_measured: bool) -> Gaussian<D> {
    let deviation = if is_measured { ANYWHERE_M } else { UNKNOWN_M };
    let mut first = Gaussian { mean: [0.0; D], covariance: Symmetric::ZERO };
    first.mean[0] = height_m;
    first.covariance.set_diagonal(0, deviation * deviation);
    first.covariance.set_diagonal(CLIMB, FIRST_CLIMB * FIRST_CLIMB);
    first
}

/// What is known first of the biases.
pub(super) fn begin<const D: usize, const S: usize>(state: &mut Gaussian<D>, biases: &[Bias; S]) {
    for (radar, bias) in biases.iter().enumerate() {
        let place = D - S + radar;
        state.mean[place] = bias.height_m.mean;
        state.covariance.set_diagonal(place, bias.height_m.variance);
    }
}

/// What becomes of the biases.
pub(super) fn slow<const D: usize, const S: usize>(changes: &[SlowChange; S]) -> Slow<D> {
    let mut slow = Slow::NONE;
    for (radar, SlowChange { kept, added }) in changes.iter().enumerate() {
        slow.set(D - S + radar, *kept, added.height_m);
    }
    slow
}

/// A height with that deviation; `radar`: whose bias, of `S`, is in it.
pub(super) fn height<const D: usize, const S: usize>(
    height_m: f64,
    sigma_m: f64,
    radar: Option<usize>,
) -> Scalar {
    let bias = radar.map_or((0, 0.0), |radar| (D - S + radar, 1.0));
    Scalar { row: [(0, 1.0), bias, (0, 0.0)], value: height_m, noise: sigma_m * sigma_m }
}

/// A rate of climb with that deviation.
pub(super) fn climb(climb: f64, deviation: f64) -> Scalar {
    Scalar { row: [(CLIMB, 1.0), (0, 0.0), (0, 0.0)], value: climb, noise: deviation * deviation }
}
