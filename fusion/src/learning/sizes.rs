//! Robust variance of numbers with a mean of zero: a histogram of their sizes with logarithmic classes, slowly
//! forgotten.

use serde::{Deserialize, Serialize};

/// Width of a class, logarithm of the size.
const WIDTH: f64 = 0.25;
/// Upper end of the smallest class: far below the resolution of any radar, in the units of the axes.
const SMALLEST: f64 = 1e-3;
/// Number of classes, which reach to 1000 of those units.
pub(super) const CLASSES: usize = 56;
/// Number of standard deviations at which numbers are clipped (Huber).
const CLIPPED: f64 = 2.0;
/// Mean square of standard normal numbers after clipping.
const CLIPPED_SQUARE: f64 = 0.920_54;
/// Loss of efficiency by clipping: number of clipped samples that are worth one without clipping.
const COST: f64 = 1.15;
/// Maximum number of fixed-point steps, which is sufficient for a relative change of `SETTLED`.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-6;

/// Weighted histogram of sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SizeHistogram(#[serde(with = "crate::checkpoint::array")] pub(super) [f64; CLASSES]);

impl SizeHistogram {
    pub(super) const NONE: Self = Self([0.0; CLASSES]);

    pub(super) fn add(&mut self, number: f64) {
        let class = ((number.abs().max(SMALLEST) / SMALLEST).ln() / WIDTH) as usize;
        self.0[class.min(CLASSES - 1)] += 1.0;
    }

    pub(super) fn decay(&mut self, kept: f64) {
        self.0.iter_mut().for_each(|count| *count *= kept);
    }

    /// Number of samples.
    fn count(&self) -> f64 {
        self.0.iter().sum()
    }

    /// Equivalent number of samples without clipping.
    pub(super) fn effective(&self) -> f64 {
        self.count() / COST
    }

    /// Variance (P. J. Huber, *Robust Statistics* (1981), section 5.2, proposal 2); `None` without samples.
    pub(super) fn variance(&self) -> Option<f64> {
        let count = self.count();
        if count <= 0.0 {
            return None;
        }
        let mean = |clipped: f64| {
            let squares = self.0.iter().enumerate().map(|(class, count)| count * square(class).min(clipped));
            squares.sum::<f64>() / (count * CLIPPED_SQUARE)
        };
        let mut variance = mean(f64::INFINITY);
        for _ in 0..STEPS {
            let next = mean(CLIPPED * CLIPPED * variance);
            let is_settled = (next / variance - 1.0).abs() < SETTLED;
            variance = next;
            if is_settled {
                break;
            }
        }
        Some(variance)
    }
}

/// Mean square of a class whose logarithms are uniformly distributed.
fn square(class: usize) -> f64 {
    let middle = SMALLEST * ((class as f64 + 0.5) * WIDTH).exp();
    middle * middle * WIDTH.sinh() / WIDTH
}
