//! What was asked of the `operational` profile, and what is reached.

use std::fmt::Write as _;

use utm_fusion::evaluate::honest_band;

use crate::figures::{OPERATIONAL, REFERENCE, Stream};
use crate::flights::Row;
use crate::score::Scores;
use crate::summary::{Mean, Seeds, show};

/// What a figure must keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    AtMost(f64),
    AtLeast(f64),
    Between(f64, f64),
    /// Nothing is asked.
    Nothing,
    /// The 95 % band of a mean NEES of so many degrees of freedom a drone: each drone of each flight is one sample.
    Honest(f64),
}

/// A figure with its bounds.
pub struct Asked {
    pub figure: String,
    pub decimals: usize,
    pub required: Bound,
    pub ambition: Bound,
    pub reference: Option<Mean>,
    pub reached: Option<Mean>,
    /// Where, if it is the worst of several.
    pub at: Option<&'static str>,
    /// Why it falls short, if it does.
    pub why: &'static str,
}

/// What a figure is of a stream.
pub type Measure = fn(&Seeds<'_>, &Stream) -> Option<Mean>;

/// A figure of scenarios, the worst of which counts.
pub struct Demand {
    pub figure: &'static str,
    pub rows: Vec<Row>,
    pub measure: Measure,
    pub decimals: usize,
    pub required: Bound,
    pub ambition: Bound,
    pub why: &'static str,
}

impl Demand {
    /// What is reached.
    pub fn over(self, scores: &[Scores]) -> Asked {
        let bound = if self.required == Bound::Nothing { self.ambition } else { self.required };
        let of = |row: &Row, stream: &Stream| (self.measure)(&Seeds::of(scores, row), stream);
        let told = self.rows.iter().filter_map(|row| Some((row, of(row, &OPERATIONAL)?)));
        let worst = told.max_by(|a, b| bound.excess(a.1).total_cmp(&bound.excess(b.1)));
        Asked {
            figure: self.figure.to_owned(),
            decimals: self.decimals,
            required: self.required,
            ambition: self.ambition,
            reference: worst.and_then(|(row, _)| of(row, &REFERENCE)),
            reached: worst.map(|(_, mean)| mean),
            at: worst.filter(|_| self.rows.len() > 1).map(|(row, _)| row.name()),
            why: self.why,
        }
    }
}

impl Bound {
    /// From, to.
    fn range(self, samples: usize) -> (f64, f64) {
        match self {
            Self::AtMost(high) => (f64::NEG_INFINITY, high),
            Self::AtLeast(low) => (low, f64::INFINITY),
            Self::Between(low, high) => (low, high),
            Self::Nothing => (f64::INFINITY, f64::NEG_INFINITY),
            Self::Honest(degrees) => honest_band(degrees * samples as f64),
        }
    }

    /// How far outside; not above 0 where it is kept to.
    fn excess(self, mean: Mean) -> f64 {
        let (low, high) = self.range(mean.count);
        (mean.mean - high).max(low - mean.mean)
    }

    fn show(self, samples: usize) -> String {
        match self {
            Self::AtMost(high) => format!("≤ {high}"),
            Self::AtLeast(low) => format!("≥ {low}"),
            Self::Between(low, high) => format!("{low} to {high}"),
            Self::Nothing => "–".to_owned(),
            Self::Honest(_) if samples == 0 => "95 % band".to_owned(),
            Self::Honest(_) => {
                let (low, high) = self.range(samples);
                format!("{low:.2} to {high:.2}")
            }
        }
    }
}

impl Asked {
    fn keeps_to(&self, bound: Bound) -> bool {
        self.reached.is_some_and(|mean| bound != Bound::Nothing && bound.excess(mean) <= 0.0)
    }

    fn is_missed(&self) -> bool {
        self.reached.is_some() && self.required != Bound::Nothing && !self.keeps_to(self.required)
    }

    fn mark(&self) -> &'static str {
        match self {
            _ if self.reached.is_none() => "",
            _ if self.keeps_to(self.ambition) => " ✓✓",
            _ if self.is_missed() => " ✗",
            _ if self.required != Bound::Nothing => " ✓",
            _ => " ·",
        }
    }

    fn place(&self) -> String {
        self.at.map_or(String::new(), |at| format!(" (`{at}`)"))
    }
}

/// The table, and what falls short.
pub fn text(asked: &[Asked]) -> String {
    let mut text = String::from(
        "| figure | paper (`reference`) | required | ambition | reached |\n|---|---:|---:|---:|---:|\n",
    );
    for asked in asked {
        let Asked { figure, decimals, required, ambition, reference, reached, .. } = asked;
        let samples = reached.map_or(0, |mean| mean.count);
        let _ = writeln!(
            text,
            "| {figure} | {} | {} | {} | {}{}{} |",
            show(*reference, *decimals),
            required.show(samples),
            ambition.show(samples),
            show(*reached, *decimals),
            asked.mark(),
            asked.place(),
        );
    }
    text += "\n### What falls short, and why\n\n";
    let missed: Vec<&Asked> = asked.iter().filter(|asked| asked.is_missed()).collect();
    for asked in &missed {
        let why = if asked.why.is_empty() { "not explained yet." } else { asked.why };
        let reached = show(asked.reached, asked.decimals);
        let _ = writeln!(text, "* **{}**, {reached}{}: {why}", asked.figure, asked.place());
    }
    if missed.is_empty() {
        text += "Nothing that is measured.\n";
    }
    text
}
