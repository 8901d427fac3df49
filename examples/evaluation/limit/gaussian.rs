//! Gaussian states of a fixed size, and the operations of a Kalman filter.

/// Natural logarithm of 2 pi.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

/// Mean and covariance of a state.
#[derive(Clone, Copy, Debug)]
pub struct GaussianState<const N: usize> {
    pub mean: [f64; N],
    pub covariance: [[f64; N]; N],
}

/// One row of a transition matrix: the entry `of` becomes the sum of other entries times their factors. Terms with a
/// factor of zero are unused.
#[derive(Clone, Copy, Debug)]
pub struct MeasurementRow {
    pub of: usize,
    pub terms: [(usize, f64); 4],
}

impl MeasurementRow {
    /// The entry times a factor.
    pub fn scaled(of: usize, factor: f64) -> Self {
        Self { of, terms: [(of, factor), (0, 0.0), (0, 0.0), (0, 0.0)] }
    }

    /// The entry plus other entries times their factors.
    pub fn plus(of: usize, others: [(usize, f64); 3]) -> Self {
        Self { of, terms: [(of, 1.0), others[0], others[1], others[2]] }
    }

    /// A copy of another entry.
    pub fn copy(of: usize, from: usize) -> Self {
        Self { of, terms: [(from, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)] }
    }
}

/// A scalar measurement: measurement row, innovation, and variance.
#[derive(Clone, Copy, Debug)]
pub struct ScalarMeasurement<const N: usize> {
    pub factors: [f64; N],
    pub residual: f64,
    pub variance: f64,
}

impl<const N: usize> GaussianState<N> {
    /// State with independent entries of these means and standard deviations.
    pub fn independent(mean: [f64; N], deviations: [f64; N]) -> Self {
        let mut covariance = [[0.0; N]; N];
        for (entry, deviation) in deviations.into_iter().enumerate() {
            covariance[entry][entry] = deviation * deviation;
        }
        Self { mean, covariance }
    }

    /// Transforms the state. The matrix is the identity except for these rows; no row may use an entry that an earlier
    /// row has changed.
    pub fn transform(&mut self, rows: &[MeasurementRow]) {
        for row in rows {
            let (mut mean, mut line) = (0.0, [0.0; N]);
            for (entry, factor) in &row.terms {
                if *factor != 0.0 {
                    mean += factor * self.mean[*entry];
                    add(&mut line, *factor, &self.covariance[*entry]);
                }
            }
            self.mean[row.of] = mean;
            self.covariance[row.of] = line;
        }
        for line in &mut self.covariance {
            for row in rows {
                let mut sum = 0.0;
                for (entry, factor) in &row.terms {
                    sum += factor * line[*entry];
                }
                line[row.of] = sum;
            }
        }
    }

    /// Adds to a variance, or to a covariance and its mirror image.
    pub fn add(&mut self, one: usize, other: usize, value: f64) {
        self.covariance[one][other] += value;
        if one != other {
            self.covariance[other][one] += value;
        }
    }

    /// Sets an entry to this mean and standard deviation, independent of all others.
    pub fn renew(&mut self, entry: usize, mean: f64, deviation: f64) {
        self.mean[entry] = mean;
        self.covariance[entry] = [0.0; N];
        for line in &mut self.covariance {
            line[entry] = 0.0;
        }
        self.covariance[entry][entry] = deviation * deviation;
    }

    /// Updates the state with a measurement; returns the logarithm of its likelihood.
    pub fn update(&mut self, measured: &ScalarMeasurement<N>) -> f64 {
        let mut with = [0.0; N];
        for (entry, &factor) in measured.factors.iter().enumerate() {
            if factor != 0.0 {
                add(&mut with, factor, &self.covariance[entry]);
            }
        }
        let mut variance = measured.variance;
        for (factor, with) in measured.factors.iter().zip(&with) {
            variance += factor * with;
        }
        add(&mut self.mean, measured.residual / variance, &with);
        let mut row = 0;
        while row < N {
            add(&mut self.covariance[row], -with[row] / variance, &with);
            row += 1;
        }
        -0.5 * (LN_TAU + variance.ln() + measured.residual * measured.residual / variance)
    }

    /// Mean and covariance of a mixture with these weights, which add up to one.
    pub fn merged<'a>(parts: impl Iterator<Item = (f64, &'a Self)> + Clone) -> Self {
        let mut all = Self { mean: [0.0; N], covariance: [[0.0; N]; N] };
        for (weight, part) in parts.clone() {
            add(&mut all.mean, weight, &part.mean);
        }
        for (weight, part) in parts {
            let mut off = part.mean;
            add(&mut off, -1.0, &all.mean);
            let mut row = 0;
            while row < N {
                add(&mut all.covariance[row], weight, &part.covariance[row]);
                add(&mut all.covariance[row], weight * off[row], &off);
                row += 1;
            }
        }
        all
    }
}

/// Adds `factor` times `other` to `to`.
#[inline]
fn add<const N: usize>(to: &mut [f64; N], factor: f64, other: &[f64; N]) {
    let mut entry = 0;
    while entry < N {
        to[entry] += factor * other[entry];
        entry += 1;
    }
}
