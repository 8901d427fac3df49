//! Reliability of predicted probabilities: comparison with observed frequencies.

use serde::Serialize;

/// Predictions whose probability lies within one interval of 0.1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ReliabilityBin {
    /// Number of predictions.
    pub stated: u64,
    /// Sum of the predicted probabilities.
    pub sum: f64,
    /// Number of predicted events that occurred.
    pub happened: u64,
}

impl ReliabilityBin {
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

    /// Difference between the observed frequency and the mean predicted probability.
    pub(super) fn difference(&self) -> Option<f64> {
        let stated = self.stated as f64;
        (self.stated > 0).then(|| (self.happened as f64 / stated - self.sum / stated).abs())
    }
}
