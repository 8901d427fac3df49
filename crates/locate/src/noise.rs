//! Sizes and durations of a radar's errors, by restricted maximum likelihood: the fitted parameters take part of the scatter.

use nalgebra::{DMatrix, SMatrix};

use crate::whitening::{AxisNoise, Information, Row, whitened};

/// Steps of the coordinate search, as factors.
const STEPS: [f64; 4] = [2.0, 1.4, 1.2, 1.1];
/// Deviations of the prior on the logarithms: of sizes and of the time constant.
const PRIOR: (f64, f64) = (1.5, 0.7);

/// Rows of one axis, by aircraft.
pub(crate) type Rows<const N: usize> = Vec<Vec<Row<N>>>;

/// The most probable noise near `first`, whose values are also the medians of the prior. `other` is the information that
/// does not depend on this axis: other axes, and priors of the parameters.
pub(crate) fn fitted<const N: usize>(
    rows: &Rows<N>,
    from: AxisNoise,
    first: &AxisNoise,
    other: &SMatrix<f64, N, N>,
) -> AxisNoise {
    let objective = |noise: &AxisNoise| {
        let sum = total(rows, noise);
        let off = |value: f64, usual: f64, sigma: f64| (value / usual).ln().powi(2) / (2.0 * sigma * sigma);
        sum.log_likelihood
            - 0.5 * log_determinant(&(sum.bordered + other))
            - off(noise.slow, first.slow, PRIOR.0)
            - off(noise.white, first.white, PRIOR.0)
            - off(noise.time_s, first.time_s, PRIOR.1)
    };
    let mut best = from;
    let mut highest = objective(&best);
    for step in STEPS {
        // A coarse step may be taken several times.
        for _ in 0..3 {
            let before = highest;
            for (value, factor) in
                [(0, step), (0, 1.0 / step), (1, step), (1, 1.0 / step), (2, step), (2, 1.0 / step)]
            {
                let mut tried = best;
                match value {
                    0 => tried.slow *= factor,
                    1 => tried.time_s *= factor,
                    _ => tried.white *= factor,
                }
                let reached = objective(&tried);
                if reached > highest {
                    (best, highest) = (tried, reached);
                }
            }
            if highest - before < 1e-3 {
                break;
            }
        }
    }
    best
}

/// Information of all aircraft.
pub(crate) fn total<const N: usize>(rows: &Rows<N>, noise: &AxisNoise) -> Information<N> {
    rows.iter().fold(Information::default(), |mut sum, rows| {
        let one = whitened(rows, noise);
        sum.bordered += one.bordered;
        sum.log_likelihood += one.log_likelihood;
        sum
    })
}

/// Logarithm of the determinant of the parameters' part.
fn log_determinant<const N: usize>(bordered: &SMatrix<f64, N, N>) -> f64 {
    let part = DMatrix::from_fn(N - 1, N - 1, |row, column| bordered[(row, column)]);
    part.cholesky().map_or(f64::INFINITY, |factor| {
        factor.l_dirty().diagonal().iter().map(|value| 2.0 * value.ln()).sum()
    })
}
