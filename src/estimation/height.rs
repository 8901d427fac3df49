//! The state above ground: height, climb, and the slow error of the radar's height.

use nalgebra::{SMatrix, SVector, matrix, vector};

use super::imm::{Gaussian, Linear, Observation};
use super::slow::{SlowChange, SlowError};

/// Height (metres), climb (metres a second), and the radar's slow error (metres).
pub(super) const STATES: usize = 3;

pub(super) type Height = Gaussian<STATES>;

/// Rates of climb that a target may have when it is first seen, one standard deviation, metres a second.
const FIRST_CLIMB: f64 = 2.0;
/// A target whose height was never measured may be at any that drones fly at: one standard deviation, metres.
const UNKNOWN_M: f64 = 60.0;
/// Power spectral density of the vertical acceleration, m²/s³.
const NOISE: f64 = 1.0;

/// A target about which only this is known.
pub(super) fn first(height: Option<(f64, f64)>, assumed_m: f64, slow: Option<&SlowError>) -> Height {
    let (mean, deviation) = height.unwrap_or((assumed_m, UNKNOWN_M));
    let slow = slow.copied().unwrap_or(SlowError::NONE);
    Gaussian {
        mean: vector![mean, 0.0, slow.height_m.0],
        covariance: SMatrix::from_diagonal(&vector![
            deviation * deviation,
            FIRST_CLIMB * FIRST_CLIMB,
            slow.height_m.1
        ]),
    }
}

/// The motion over `dt` seconds, and what becomes of the slow error.
pub(super) fn motion(dt: f64, slow: &SlowChange) -> Linear<STATES> {
    let (p, c, v) = (NOISE * dt.powi(3) / 3.0, NOISE * dt * dt / 2.0, NOISE * dt);
    Linear {
        transition: matrix![1.0, dt, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, slow.kept],
        shift: vector![0.0, 0.0, slow.added.height_m.0],
        noise: matrix![p, c, 0.0; c, v, 0.0; 0.0, 0.0, slow.added.height_m.1],
    }
}

/// A height with that deviation; `radar`: its slow error is in it.
pub(super) fn height(height_m: f64, deviation_m: f64, radar: bool) -> Observation<STATES, 1> {
    Observation {
        value: SVector::<f64, 1>::new(height_m),
        matrix: matrix![1.0, 0.0, if radar { 1.0 } else { 0.0 }],
        noise: SMatrix::<f64, 1, 1>::new(deviation_m * deviation_m),
    }
}

/// A rate of climb with that deviation.
pub(super) fn climb(climb: f64, deviation: f64) -> Observation<STATES, 1> {
    Observation {
        value: SVector::<f64, 1>::new(climb),
        matrix: matrix![0.0, 1.0, 0.0],
        noise: SMatrix::<f64, 1, 1>::new(deviation * deviation),
    }
}
