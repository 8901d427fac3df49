//! Means over seeds.

use utm_fusion::evaluate::{ErrorStatistics, Score};

use crate::flights::{Groups, Row, Scores};

/// Mean over the seeds that tell the figure, and the standard error of that mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    pub mean: f64,
    /// `None` for a single flight.
    pub error: Option<f64>,
}

impl Mean {
    /// Of these; `None` of none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let error = (values.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt());
        (!values.is_empty()).then_some(Self { mean, error })
    }

    /// With so many decimals.
    pub fn show(self, decimals: usize) -> String {
        match self.error {
            Some(error) => format!("{:.decimals$} ± {error:.decimals$}", self.mean),
            None => format!("{:.decimals$}", self.mean),
        }
    }
}

/// A figure of a score.
pub type Figure = fn(&Score) -> Option<f64>;

/// The scores of one row, one a seed.
pub struct Seeds<'a>(pub Vec<&'a Scores>);

impl<'a> Seeds<'a> {
    /// Of the flights of a row.
    pub fn of(scores: &'a [Scores], row: &Row) -> Self {
        Self(scores.iter().filter(|scores| scores.row == *row).collect())
    }

    /// Mean of what `figure` tells of each flight.
    pub fn mean(&self, figure: impl Fn(&Scores) -> Option<f64>) -> Option<Mean> {
        Mean::of(&self.0.iter().filter_map(|scores| figure(scores)).collect::<Vec<_>>())
    }

    /// Mean of a figure of one stream and group.
    pub fn of_group(&self, group: fn(&Scores) -> &Score, figure: Figure) -> Option<Mean> {
        self.mean(|scores| figure(group(scores)))
    }
}

/// The mean of an error.
pub fn mean_of(error: Option<ErrorStatistics>) -> Option<f64> {
    error.map(|error| error.mean_m)
}

/// Streams and groups by name.
pub mod group {
    use super::{Groups, Score, Scores};

    macro_rules! groups {
        ($($name:ident: $stream:ident $group:ident;)*) => {
            $(pub fn $name(scores: &Scores) -> &Score {
                let Groups { $group, .. } = &scores.$stream;
                $group
            })*
        };
    }
    groups! {
        fused: fused all;
        fused_equipped: fused equipped;
        fused_unequipped: fused unequipped;
        radar: radar all;
        radar_equipped: radar equipped;
        radar_unequipped: radar unequipped;
        transponder_equipped: transponder equipped;
        transponder: transponder all;
    }
}
