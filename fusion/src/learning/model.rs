//! Variances that a radar's bias and white noise produce in its plots' offsets.

/// Errors of one axis, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisErrors {
    /// Standard deviation of the bias in straight flight.
    pub(super) bias: f64,
    /// Correlation time of the bias (to 1/e), seconds.
    pub(super) correlation_s: f64,
    /// Standard deviation of the white noise.
    pub(super) noise: f64,
}

/// Minimum step, in correlation times; a shorter one would be lost in rounding.
const SHORTEST: f64 = 1e-6;

/// Moments of a first-order Gauss–Markov process of unit variance, sampled every `spacing_s`: variance of the mean of
/// `count` successive values, and its covariance with the mean of the next `count`.
fn blocks(count: f64, spacing_s: f64, correlation_s: f64) -> (f64, f64) {
    let step = (spacing_s / correlation_s).max(SHORTEST);
    let (kept, lost) = ((-step).exp(), -(-step).exp_m1());
    let sum = -(-step * count).exp_m1() / lost;
    let own = (count * (1.0 + kept) - 2.0 * kept * sum) / lost;
    (own / (count * count), kept * sum * sum / (count * count))
}

/// Variance of the mean of `count` successive values.
pub(super) fn mean_variance(count: f64, spacing_s: f64, correlation_s: f64) -> f64 {
    blocks(count, spacing_s, correlation_s).0
}

/// Variance of the change from the mean of `count` successive values to that of the next.
pub(super) fn change_variance(count: f64, spacing_s: f64, correlation_s: f64) -> f64 {
    let (own, both) = blocks(count, spacing_s, correlation_s);
    2.0 * (own - both)
}
