//! Means over seeds.

use crate::figures::{DroneScores, ScoreFigure, ScoreGroup};
use crate::flights::FlightRow;
use crate::score::FlightScores;

/// Mean over the flights or drones that have the figure, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanValue {
    pub mean: f64,
    /// `None` for a single value.
    pub error: Option<f64>,
    /// Number of values.
    pub count: usize,
}

impl MeanValue {
    /// Mean of these values; `None` without any.
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let n = count as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let error = (count > 1).then(|| (squares / (n - 1.0) / n).sqrt());
        (count > 0).then_some(Self { mean, error, count })
    }

    /// Text with this number of decimals.
    pub fn show(self, decimals: usize) -> String {
        match self.error {
            Some(error) => format!("{:.decimals$} ± {error:.decimals$}", self.mean),
            None => format!("{:.decimals$}", self.mean),
        }
    }
}

/// Text like [`MeanValue::show`], or a dash if there is no mean.
pub fn show(mean: Option<MeanValue>, decimals: usize) -> String {
    mean.map_or("–".to_owned(), |mean| mean.show(decimals))
}

/// Scores of one row, one per seed.
pub struct SeedScores<'a>(pub Vec<&'a FlightScores>);

impl<'a> SeedScores<'a> {
    /// Scores of the flights of a row.
    pub fn of(scores: &'a [FlightScores], row: &FlightRow) -> Self {
        Self(scores.iter().filter(|scores| scores.row == *row).collect())
    }

    /// Mean of `figure` over the flights.
    pub fn mean(&self, figure: impl Fn(&FlightScores) -> Option<f64>) -> Option<MeanValue> {
        MeanValue::of(&self.0.iter().filter_map(|scores| figure(scores)).collect::<Vec<_>>())
    }

    /// Mean of a figure of one stream and group.
    pub fn of_group(&self, group: ScoreGroup, figure: ScoreFigure) -> Option<MeanValue> {
        self.mean(|scores| figure(group(scores)))
    }

    /// Mean over the flights of the ratio of a figure between two groups.
    pub fn ratio(&self, of: ScoreGroup, over: ScoreGroup, figure: ScoreFigure) -> Option<MeanValue> {
        self.mean(|scores| Some(figure(of(scores))? / figure(over(scores))?))
    }

    /// Mean over the flights of the ratio to the flight with the same seed in `others`.
    pub fn against(
        &self,
        others: &SeedScores<'_>,
        figure: impl Fn(&FlightScores) -> Option<f64>,
    ) -> Option<MeanValue> {
        self.mean(|scores| {
            let other = others.0.iter().find(|other| other.seed == scores.seed)?;
            Some(figure(scores)? / figure(other)?)
        })
    }

    /// Mean over all drones of all flights; each drone counts once.
    pub fn of_drones(&self, drones: DroneScores, figure: ScoreFigure) -> Option<MeanValue> {
        let each = self.0.iter().flat_map(|scores| drones(scores).iter().filter_map(figure));
        MeanValue::of(&each.collect::<Vec<_>>())
    }
}
