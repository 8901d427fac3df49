//! The Singer model: a target with an acceleration that is correlated in time.
//!
//! On each axis the acceleration is a first-order Gauss–Markov process: its mean is zero, and its correlation over t
//! seconds is σ² exp(-t/τ). R. A. Singer, *Estimating optimal tracking filter performance for manned maneuvering
//! targets*, IEEE Transactions on Aerospace and Electronic Systems 6 (1970); Bar-Shalom (2001), section 8.2; with the
//! acceleration in discrete time, G. Fasano et al., *Radar/electro-optical data fusion for non-cooperative UAS sense
//! and avoid*, eq. 1.

use nalgebra::{Matrix3, matrix};
use serde::{Deserialize, Serialize};

use super::gaussian::LinearMotion;
use super::symmetric::{Rows, Symmetric};

/// Parameters of the Singer model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Singer {
    /// Correlation time τ of the acceleration (to 1/e), seconds; above zero.
    pub lasts_s: f64,
    /// Standard deviation σ of the acceleration on each axis over ground, metres a second squared.
    pub horizontal: f64,
    /// Standard deviation σ of the vertical acceleration, metres a second squared.
    pub vertical: f64,
}

/// Parameters for multirotors and small fixed wings.
impl Default for Singer {
    fn default() -> Self {
        /// Default limits of the PX4 autopilot over ground and upward (`MPC_ACC_HOR_MAX`, `MPC_ACC_UP_MAX`), metres a
        /// second squared.
        const MOST: (f64, f64) = (5.0, 4.0);
        // Both probabilities are assumed, as is the correlation time: no source states them for drones. In simulated
        // flights they matter little: from 2 to 5 s and from 1.6 to 2 m/s² the error of tracks with a transponder
        // changes by at most 5 %.
        const AT_MOST: f64 = 0.05;
        const NOT_AT_ALL: f64 = 0.8;
        Self {
            lasts_s: 3.0,
            horizontal: deviation(MOST.0, AT_MOST, NOT_AT_ALL),
            vertical: deviation(MOST.1, AT_MOST, NOT_AT_ALL),
        }
    }
}

/// Standard deviation of an acceleration that is `most` in one of two directions with probability `at_most` each, zero
/// with probability `not_at_all`, and otherwise uniformly distributed between: σ² = A²/3 (1 + 4 P_max - P_0) (Singer
/// (1970)).
fn deviation(most: f64, at_most: f64, not_at_all: f64) -> f64 {
    most * ((1.0 + 4.0 * at_most - not_at_all) / 3.0).sqrt()
}

/// The motion along one axis over an interval, x' = F x + w, w normal with covariance Q; the state is position
/// (metres), velocity (metres a second) and acceleration (metres a second squared).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingerTransition {
    pub(super) transition: Matrix3<f64>,
    pub(super) noise: Matrix3<f64>,
}

impl Singer {
    /// The motion along an axis over `dt` seconds, not negative; `deviation` is the standard deviation of its
    /// acceleration.
    ///
    /// In Singer's closed form (Bar-Shalom (2001), section 8.2) nearly all terms cancel for a small x = dt/τ. So it is
    /// written with the functions `phi`, where T = dt:
    ///
    /// ```text
    ///     1  T φ1  T² φ2          T⁴ (32 φ5' - 4 φ4)   T³ (16 φ4' - 2 φ4 - 2 φ3)   T² (8 φ3' - 2 φ2)
    /// F = 0  1     T  φ1    Q = σ² x  .                T² (8 φ3' - 4 φ3)           T  φ1²
    ///     0  0        φ0              .                .                           2 φ1'
    /// ```
    ///
    /// where φn = φn(-x), φn' = φn(-2x). For a large x they lose about as many digits as x has.
    pub fn over(&self, dt: f64, deviation: f64) -> SingerTransition {
        let x = dt / self.lasts_s;
        let [f0, f1, f2, f3, f4] = std::array::from_fn(|n| phi(n as u32, x));
        let [g1, g3, g4, g5] = [1, 3, 4, 5].map(|n| phi(n, 2.0 * x));
        let transition = matrix![
            1.0, dt, dt * dt * f2;
            0.0, 1.0, dt * f1;
            0.0, 0.0, f0;
        ];
        let place = dt.powi(4) * (32.0 * g5 - 4.0 * f4);
        let place_velocity = dt.powi(3) * (16.0 * g4 - 2.0 * f4 - 2.0 * f3);
        let place_acceleration = dt * dt * (8.0 * g3 - 2.0 * f2);
        let velocity = dt * dt * (8.0 * g3 - 4.0 * f3);
        let velocity_acceleration = dt * f1 * f1;
        let acceleration = 2.0 * g1;
        let noise = matrix![
            place, place_velocity, place_acceleration;
            place_velocity, velocity, velocity_acceleration;
            place_acceleration, velocity_acceleration, acceleration;
        ] * (deviation * deviation * x);
        SingerTransition { transition, noise }
    }
}

/// φn(-x) for x not negative: φ0 is the exponential function, and φ(n+1)(z) = (φn(z) - 1/n!) / z, which is the series
/// of z^k / (k + n)!; its value at zero is 1/n!.
fn phi(n: u32, x: f64) -> f64 {
    /// Number of terms of the series that are sufficient for an `f64` up to `SMALL`.
    const TERMS: u32 = 24;
    const SMALL: f64 = 2.0;
    if x < SMALL {
        let sum = (1..=TERMS).rev().fold(1.0, |sum, k| 1.0 - sum * x / f64::from(n + k));
        return (1..=n).fold(sum, |sum, k| sum / f64::from(k));
    }
    let (mut value, mut first) = ((-x).exp(), 1.0);
    for k in 1..=n {
        value = (first - value) / x;
        first /= f64::from(k);
    }
    value
}

impl SingerTransition {
    /// Applies the motion to the rows of position, velocity and acceleration.
    #[inline]
    pub fn carry<const N: usize, const D: usize>(
        &self,
        rows: &mut Rows<N, D>,
        [place, rate, acceleration]: [usize; 3],
    ) {
        let f = &self.transition;
        for column in 0..N {
            let (v, a) = (rows[rate][column], rows[acceleration][column]);
            rows[place][column] += f[(0, 1)] * v + f[(0, 2)] * a;
            rows[rate][column] = v + f[(1, 2)] * a;
            rows[acceleration][column] = f[(2, 2)] * a;
        }
    }

    /// Adds Q to a covariance, for the variables of one axis: position, rate, acceleration.
    #[inline]
    pub fn add_noise<const D: usize>(&self, covariance: &mut Symmetric<D>, states: [usize; 3]) {
        for row in 0..3 {
            for column in row..3 {
                covariance.add_at(states[row], states[column], self.noise[(row, column)]);
            }
        }
    }
}

/// Both axes over ground: east, north, their rates, their accelerations.
#[derive(Clone, Copy, Debug)]
pub(super) struct OverGroundAxes(pub(super) SingerTransition);

impl OverGroundAxes {
    const STATES: [[usize; 3]; 2] = [[0, 2, 4], [1, 3, 5]];
}

impl<const D: usize> LinearMotion<D> for OverGroundAxes {
    const MOVING: usize = 6;

    #[inline]
    fn carry<const N: usize>(&self, rows: &mut Rows<N, D>) {
        Self::STATES.into_iter().for_each(|states| self.0.carry(rows, states));
    }

    #[inline]
    fn add_noise(&self, covariance: &mut Symmetric<D>) {
        Self::STATES.into_iter().for_each(|states| self.0.add_noise(covariance, states));
    }
}

/// Height, climb and acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeightAxis(pub(super) SingerTransition);

impl<const D: usize> LinearMotion<D> for HeightAxis {
    const MOVING: usize = 3;

    #[inline]
    fn carry<const N: usize>(&self, rows: &mut Rows<N, D>) {
        self.0.carry(rows, [0, 1, 2]);
    }

    #[inline]
    fn add_noise(&self, covariance: &mut Symmetric<D>) {
        self.0.add_noise(covariance, [0, 1, 2]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lasting(lasts_s: f64) -> Singer {
        Singer { lasts_s, ..Singer::default() }
    }

    /// Largest difference of two matrices, each element relative to the diagonal elements of its row and column.
    fn differ(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
        let differs = |row: usize, column: usize| {
            let scale = (b[(row, row)] * b[(column, column)]).sqrt();
            (a[(row, column)] - b[(row, column)]).abs() / scale
        };
        (0..9).map(|place| differs(place / 3, place % 3)).fold(0.0, f64::max)
    }

    /// Integrates the differential equations F' = A F and Q' = A Q + Q Aᵀ + B in `steps` Runge-Kutta steps.
    fn integrated(lasts_s: f64, deviation: f64, dt: f64, steps: u32) -> SingerTransition {
        let a = matrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, -1.0 / lasts_s];
        let b = Matrix3::from_partial_diagonal(&[0.0, 0.0, 2.0 * deviation * deviation / lasts_s]);
        let slope = |f: Matrix3<f64>, q: Matrix3<f64>| (a * f, a * q + q * a.transpose() + b);
        let h = dt / f64::from(steps);
        let (mut f, mut q) = (Matrix3::identity(), Matrix3::zeros());
        for _ in 0..steps {
            let (f1, q1) = slope(f, q);
            let (f2, q2) = slope(f + f1 * (h / 2.0), q + q1 * (h / 2.0));
            let (f3, q3) = slope(f + f2 * (h / 2.0), q + q2 * (h / 2.0));
            let (f4, q4) = slope(f + f3 * h, q + q3 * h);
            f += (f1 + (f2 + f3) * 2.0 + f4) * (h / 6.0);
            q += (q1 + (q2 + q3) * 2.0 + q4) * (h / 6.0);
        }
        SingerTransition { transition: f, noise: q }
    }

    #[test]
    fn singer_transition_solves_its_differential_equation() {
        // Around the borders between series and recursion: x = 1 and 2.
        for (lasts_s, dt) in [
            (3.0, 0.01),
            (3.0, 0.25),
            (3.0, 2.0),
            (3.0, 2.999),
            (3.0, 3.0),
            (3.0, 5.999),
            (3.0, 6.0),
            (3.0, 60.0),
            (600.0, 1.0),
            (0.1, 3.0),
        ] {
            let exact = lasting(lasts_s).over(dt, 1.3);
            let small_steps = integrated(lasts_s, 1.3, dt, 20_000);
            let apart = (exact.transition - small_steps.transition).abs().max() / dt.powi(2).max(1.0);
            assert!(apart < 1e-10, "F, τ {lasts_s} s, {dt} s: {apart}");
            let apart = differ(&exact.noise, &small_steps.noise);
            assert!(apart < 1e-9, "Q, τ {lasts_s} s, {dt} s: {apart}");
        }
    }

    #[test]
    fn singer_transition_matches_other_implementations() {
        // Published output of MathWorks' `singerProcessNoise`: steps of 1 and 2 s, τ = 20 and 10 s, σ = 1 m/s².
        for (dt, lasts_s, shown) in [
            (1.0, 20.0, [0.0049, 0.0121, 0.0159, 0.0321, 0.0476, 0.0952]),
            (2.0, 10.0, [0.2868, 0.3508, 0.2188, 0.4603, 0.3286, 0.3297]),
        ] {
            let noise = lasting(lasts_s).over(dt, 1.0).noise;
            let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| noise[place]);
            for (value, shown) in upper.into_iter().zip(shown) {
                assert!((value - shown).abs() <= 0.000_051, "{value} {shown}");
            }
        }
    }

    #[test]
    fn two_steps_are_one() {
        for (lasts_s, first, second) in [(3.0, 0.7, 1.1), (1e4, 0.3, 0.2), (0.2, 4.0, 9.0), (2.0, 1e-6, 2.0)]
        {
            let singer = lasting(lasts_s);
            let over = |dt| singer.over(dt, 1.7);
            let (a, b, both) = (over(first), over(second), over(first + second));
            assert!((b.transition * a.transition - both.transition).norm() < 1e-12 * both.transition.norm());
            let noise = b.transition * a.noise * b.transition.transpose() + b.noise;
            assert!(differ(&noise, &both.noise) < 1e-11, "τ {lasts_s} s");
        }
    }

    /// The variance of the acceleration stays constant.
    #[test]
    fn singer_acceleration_is_stationary() {
        for dt in [0.0, 1e-3, 1.0, 100.0] {
            let SingerTransition { transition, noise } = lasting(3.0).over(dt, 2.0);
            assert!((transition[(2, 2)].powi(2) * 4.0 + noise[(2, 2)] - 4.0).abs() < 1e-13, "{dt} s");
        }
        let now = lasting(3.0).over(0.0, 2.0);
        assert_eq!((now.transition, now.noise), (Matrix3::identity(), Matrix3::zeros()));
    }

    /// Bar-Shalom (2001), eq. 6.2.2-12: with a short correlation time it is white acceleration of the density 2σ²τ.
    #[test]
    fn a_short_one_is_constant_velocity() {
        for lasts_s in [1e-3, 1e-6] {
            let (dt, density) = (4.0_f64, 6.0);
            let deviation = f64::sqrt(density / (2.0 * lasts_s));
            let SingerTransition { transition, noise } = lasting(lasts_s).over(dt, deviation);
            let of_order = lasts_s / dt;
            assert!((transition[(0, 2)].abs() + transition[(1, 2)].abs()) < 2.0 * dt * lasts_s);
            for (place, white) in [
                ((0, 0), density * dt.powi(3) / 3.0),
                ((0, 1), density * dt * dt / 2.0),
                ((1, 1), density * dt),
            ] {
                assert!((noise[place] / white - 1.0).abs() < 4.0 * of_order, "{place:?}, τ {lasts_s} s");
            }
        }
    }

    /// Bar-Shalom (2001), section 6.2.3: with a long correlation time it is constant acceleration, with white noise of
    /// the density 2σ²/τ in its rate.
    #[test]
    fn a_long_one_is_constant_acceleration() {
        for lasts_s in [1e6, 1e12] {
            let (t, density) = (2.0_f64, 0.7);
            let deviation = f64::sqrt(density * lasts_s / 2.0);
            let SingerTransition { transition, noise } = lasting(lasts_s).over(t, deviation);
            let constant = matrix![1.0, t, t * t / 2.0; 0.0, 1.0, t; 0.0, 0.0, 1.0];
            assert!((transition - constant).norm() < 10.0 / lasts_s);
            let white = matrix![
                t.powi(5) / 20.0, t.powi(4) / 8.0, t.powi(3) / 6.0;
                t.powi(4) / 8.0, t.powi(3) / 3.0, t * t / 2.0;
                t.powi(3) / 6.0, t * t / 2.0, t;
            ] * density;
            assert!(differ(&noise, &white) < 10.0 / lasts_s + 1e-14, "τ {lasts_s} s");
        }
    }

    /// The noise is a covariance for any interval; otherwise the filter would diverge.
    #[test]
    fn the_noise_is_a_covariance() {
        for exponent in -12..=12 {
            let x = 10.0_f64.powi(exponent);
            for dt in [1e-9, 1e-3, 1.0, 1e3] {
                let noise = lasting(dt / x).over(dt, 1.0).noise;
                let scaled = Matrix3::from_fn(|row, column| {
                    noise[(row, column)] / (noise[(row, row)] * noise[(column, column)]).sqrt()
                });
                let least = scaled.symmetric_eigenvalues().min();
                assert!(least > -1e-12 && noise.iter().all(|value| value.is_finite()), "{x} {dt} s: {least}");
            }
        }
    }
}
