//! Means over seeds.

use crate::figures::{Each, Figure, Group};
use crate::flights::Row;
use crate::score::Scores;

/// Mean over what has the figure, and the standard error of that mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    pub mean: f64,
    /// `None` for a single value.
    pub error: Option<f64>,
    /// Of how many.
    pub count: usize,
}

impl Mean {
    /// Of these; `None` of none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let n = count as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let error = (count > 1).then(|| (squares / (n - 1.0) / n).sqrt());
        (count > 0).then_some(Self { mean, error, count })
    }

    /// With so many decimals.
    pub fn show(self, decimals: usize) -> String {
        match self.error {
            Some(error) => format!("{:.decimals$} ± {error:.decimals$}", self.mean),
            None => format!("{:.decimals$}", self.mean),
        }
    }
}

/// As [`Mean::show`], and a dash where there is none.
pub fn show(mean: Option<Mean>, decimals: usize) -> String {
    mean.map_or("–".to_owned(), |mean| mean.show(decimals))
}

/// The scores of one row, one a seed.
pub struct Seeds<'a>(pub Vec<&'a Scores>);

impl<'a> Seeds<'a> {
    /// Of the flights of a row.
    pub fn of(scores: &'a [Scores], row: &Row) -> Self {
        Self(scores.iter().filter(|scores| scores.row == *row).collect())
    }

    /// Mean of `figure` of each flight.
    pub fn mean(&self, figure: impl Fn(&Scores) -> Option<f64>) -> Option<Mean> {
        Mean::of(&self.0.iter().filter_map(|scores| figure(scores)).collect::<Vec<_>>())
    }

    /// Mean of a figure of one stream and group.
    pub fn of_group(&self, group: Group, figure: Figure) -> Option<Mean> {
        self.mean(|scores| figure(group(scores)))
    }

    /// Of each flight the one's figure over the other's, and the mean of that.
    pub fn ratio(&self, of: Group, over: Group, figure: Figure) -> Option<Mean> {
        self.mean(|scores| Some(figure(of(scores))? / figure(over(scores))?))
    }

    /// Of each flight the figure over that of the flight with the same seed in `others`, and the mean of that.
    pub fn against(&self, others: &Seeds<'_>, figure: impl Fn(&Scores) -> Option<f64>) -> Option<Mean> {
        self.mean(|scores| {
            let other = others.0.iter().find(|other| other.seed == scores.seed)?;
            Some(figure(scores)? / figure(other)?)
        })
    }

    /// Mean over all drones of all flights, each of which counts once.
    pub fn of_drones(&self, drones: Each, figure: Figure) -> Option<Mean> {
        let each = self.0.iter().flat_map(|scores| drones(scores).iter().filter_map(figure));
        Mean::of(&each.collect::<Vec<_>>())
    }
}
