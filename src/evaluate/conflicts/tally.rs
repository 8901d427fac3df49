//! Whether what is stated happens as often as it is stated.

use serde::Serialize;

/// Statements with probabilities of one tenth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bin {
    /// How many.
    pub stated: u64,
    /// Sum of the probabilities.
    pub sum: f64,
    /// How often it happened.
    pub happened: u64,
}

impl Bin {
    pub(super) fn note(bins: &mut [Self; 10], probability: f64, happened: bool) {
        let bin = &mut bins[((probability * 10.0) as usize).min(9)];
        bin.stated += 1;
        bin.sum += probability;
        bin.happened += u64::from(happened);
    }

    pub(super) fn and(&self, other: &Self) -> Self {
        Self {
            stated: self.stated + other.stated,
            sum: self.sum + other.sum,
            happened: self.happened + other.happened,
        }
    }

    /// Between the share that happened and the mean that was stated.
    pub(super) fn difference(&self) -> Option<f64> {
        let stated = self.stated as f64;
        (self.stated > 0).then(|| (self.happened as f64 / stated - self.sum / stated).abs())
    }
}
