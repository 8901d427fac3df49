//! A Kalman filter along one aircraft that turns correlated residuals into independent ones.
//!
//! residual = row · change of the parameters + error of the radar track + error of the transponder + white noise. Both errors are
//! first-order Gauss–Markov processes; the radar's error restarts with each track. The filter runs over the residual and the
//! columns of its Jacobian at once: generalised least squares with the dense covariance, as in `registration/along.rs`.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// One residual with its row: `N - 1` derivatives, then the residual.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<const N: usize> {
    pub(crate) time_s: f64,
    /// Number of the uninterrupted radar track.
    pub(crate) run: usize,
    pub(crate) columns: SVector<f64, N>,
    /// Units of this axis per metre of the transponder's error.
    pub(crate) per_metre: f64,
    /// Standard deviation of the path's interpolation, metres.
    pub(crate) sigma_m: f64,
}

/// Errors of one axis of a radar, in units of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisNoise {
    /// Standard deviation of the error that a track keeps.
    pub(crate) slow: f64,
    /// Its time constant, seconds.
    pub(crate) time_s: f64,
    /// Standard deviation of the white noise.
    pub(crate) white: f64,
    /// Standard deviation of the transponder's error, metres, and its time constant, seconds.
    pub(crate) transponder: (f64, f64),
}

impl AxisNoise {
    /// Standard deviation of a single plot.
    pub(crate) fn total(&self) -> f64 {
        self.slow.hypot(self.white)
    }
}

/// Information of one or more sequences: Σ w wᵀ of the whitened rows, with the residual as last column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Information<const N: usize> {
    pub(crate) bordered: SMatrix<f64, N, N>,
    /// Logarithm of the residuals' likelihood.
    pub(crate) log_likelihood: f64,
}

impl<const N: usize> Default for Information<N> {
    fn default() -> Self {
        Self { bordered: SMatrix::zeros(), log_likelihood: 0.0 }
    }
}

/// Normalised innovation from which it counts less (Huber).
const HUBER: f64 = 2.5;

/// Information of one aircraft's rows, in order of time.
pub(crate) fn whitened<const N: usize>(rows: &[Row<N>], noise: &AxisNoise) -> Information<N> {
    let mut sum = Information::default();
    let (slow2, carried2) = (noise.slow.powi(2), noise.transponder.0.powi(2));
    let mut state = SMatrix::<f64, 2, N>::zeros();
    let mut covariance = Matrix2::new(slow2, 0.0, 0.0, carried2);
    let mut before: Option<&Row<N>> = None;
    for row in rows {
        if let Some(before) = before {
            let passed_s = row.time_s - before.time_s;
            let kept = if row.run == before.run { (-passed_s / noise.time_s).exp() } else { 0.0 };
            let carried = (-passed_s / noise.transponder.1).exp();
            let decay = Matrix2::new(kept, 0.0, 0.0, carried);
            state = decay * state;
            covariance = decay * covariance * decay;
            covariance[(0, 0)] += slow2 * (1.0 - kept * kept);
            covariance[(1, 1)] += carried2 * (1.0 - carried * carried);
        }
        before = Some(row);
        let sees = Vector2::new(1.0, row.per_metre);
        let innovation = row.columns - state.tr_mul(&sees);
        let white2 = noise.white.powi(2) + (row.sigma_m * row.per_metre).powi(2);
        let spread = covariance * sees;
        let expected = sees.dot(&spread) + white2;
        let distance = innovation[N - 1].abs() / expected.sqrt();
        let excess = (distance / HUBER).max(1.0);
        let variance = expected * excess;
        sum.bordered += innovation * innovation.transpose() / variance;
        let loss = if distance > HUBER { HUBER * (2.0 * distance - HUBER) } else { distance * distance };
        sum.log_likelihood -= 0.5 * (expected.ln() + loss);
        let gain = spread / variance;
        state += gain * innovation.transpose();
        covariance -= gain * spread.transpose();
    }
    sum
}
