//! How large numbers of zero mean are, whatever a few of them are: counted in classes of equal ratio, and forgotten slowly.

use serde::{Deserialize, Serialize};

/// Width of a class, logarithm of the size.
const WIDTH: f64 = 0.25;
/// The smallest class ends here: far below what any radar tells apart, in the units of the axes.
const SMALLEST: f64 = 1e-3;
/// So many classes reach to 1000 of those units.
pub(super) const CLASSES: usize = 56;
/// A number beyond so many deviations counts as one of so many (Huber).
const CLIPPED: f64 = 2.0;
/// Mean square of standard normal numbers that are clipped there.
const CLIPPED_SQUARE: f64 = 0.920_54;
/// What the clipping costs: so many numbers tell as much as one without it.
const COST: f64 = 1.15;
/// The fixed point is found to a millionth in fewer steps.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-6;

/// The sizes of numbers, each with a weight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sizes(#[serde(with = "crate::checkpoint::array")] pub(super) [f64; CLASSES]);

impl Sizes {
    pub(super) const NONE: Self = Self([0.0; CLASSES]);

    pub(super) fn add(&mut self, number: f64) {
        let class = ((number.abs().max(SMALLEST) / SMALLEST).ln() / WIDTH) as usize;
        self.0[class.min(CLASSES - 1)] += 1.0;
    }

    pub(super) fn fade(&mut self, kept: f64) {
        self.0.iter_mut().for_each(|count| *count *= kept);
    }

    /// Their number.
    fn count(&self) -> f64 {
        self.0.iter().sum()
    }

    /// How many numbers that are not clipped would tell the variance as well.
    pub(super) fn effective(&self) -> f64 {
        self.count() / COST
    }

    /// Their variance (P. J. Huber, *Robust Statistics* (1981), section 5.2, proposal 2); `None` where there are none.
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

/// Mean square of a class, of numbers whose logarithms are even over it.
fn square(class: usize) -> f64 {
    let middle = SMALLEST * ((class as f64 + 0.5) * WIDTH).exp();
    middle * middle * WIDTH.sinh() / WIDTH
}
