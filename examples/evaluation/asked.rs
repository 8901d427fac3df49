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
    figure: String,
    decimals: usize,
    required: Bound,
    ambition: Bound,
    /// What it was when it was asked for, where that is known.
    now: &'static str,
    cases: Vec<Case>,
    /// Why it falls short, if it does.
    why: &'static str,
}

/// A figure of one row of flights; of several the worst counts.
#[derive(Clone, Copy)]
pub struct Case {
    pub at: &'static str,
    pub reached: Option<Mean>,
    pub reference: Option<Mean>,
}

/// What a figure is of a stream.
pub type Measure = fn(&Seeds<'_>, &Stream) -> Option<Mean>;

/// The figure of each of these rows.
pub fn each(scores: &[Scores], rows: &[Row], measure: Measure) -> Vec<Case> {
    let case = |row: &Row| {
        let seeds = Seeds::of(scores, row);
        let of = |stream: &Stream| measure(&seeds, stream);
        Case { at: row.name(), reached: of(&OPERATIONAL), reference: of(&REFERENCE) }
    };
    rows.iter().map(case).collect()
}

/// The figure of each first row over that of the second, flight by flight.
pub fn against(scores: &[Scores], pairs: &[(Row, Row)], figure: fn(&Scores) -> Option<f64>) -> Vec<Case> {
    let case = |(row, other): &(Row, Row)| {
        let reached = Seeds::of(scores, row).against(&Seeds::of(scores, other), figure);
        Case { at: row.name(), reached, reference: None }
    };
    pairs.iter().map(case).collect()
}

/// A figure that is in no scores.
pub fn measured(reached: Option<Mean>, reference: Option<Mean>) -> Vec<Case> {
    vec![Case { at: "", reached, reference }]
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
    /// A figure of which nothing is asked yet, with two decimals.
    pub fn new(figure: impl Into<String>, cases: Vec<Case>) -> Self {
        Self {
            figure: figure.into(),
            decimals: 2,
            required: Bound::Nothing,
            ambition: Bound::Nothing,
            now: "–",
            cases,
            why: "",
        }
    }

    pub fn required(self, required: Bound) -> Self {
        Self { required, ..self }
    }

    pub fn ambition(self, ambition: Bound) -> Self {
        Self { ambition, ..self }
    }

    pub fn now(self, now: &'static str) -> Self {
        Self { now, ..self }
    }

    pub fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }

    pub fn why(self, why: &'static str) -> Self {
        Self { why, ..self }
    }

    /// The case that is furthest outside the bound.
    fn worst(&self) -> Option<(Mean, Case)> {
        let bound = if self.required == Bound::Nothing { self.ambition } else { self.required };
        let known = self.cases.iter().filter_map(|case| Some((case.reached?, *case)));
        known.max_by(|a, b| bound.excess(a.0).total_cmp(&bound.excess(b.0)))
    }

    fn keeps_to(&self, bound: Bound) -> bool {
        bound != Bound::Nothing && self.worst().is_some_and(|(mean, _)| bound.excess(mean) <= 0.0)
    }

    fn is_missed(&self) -> bool {
        self.worst().is_some() && self.required != Bound::Nothing && !self.keeps_to(self.required)
    }

    fn mark(&self) -> &'static str {
        match self {
            _ if self.worst().is_none() => "",
            _ if self.keeps_to(self.ambition) => " ✓✓",
            _ if self.is_missed() => " ✗",
            _ if self.required != Bound::Nothing => " ✓",
            _ => " ·",
        }
    }

    /// What is reached, how that is judged, and where, if it is the worst of several.
    fn reached(&self) -> String {
        let worst = self.worst();
        let at = worst.filter(|_| self.cases.len() > 1).map(|(_, case)| format!(" (`{}`)", case.at));
        let reached = show(worst.map(|(mean, _)| mean), self.decimals);
        format!("{reached}{}{}", self.mark(), at.unwrap_or_default())
    }
}

/// What stands beside what is asked and what is reached.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// What it was when it was asked for.
    Before,
    /// What the paper's method reaches.
    Paper,
    /// Of how many.
    Count,
}

/// The table.
pub fn table(asked: &[Asked], beside: Beside) -> String {
    let head = match beside {
        Beside::Before => "before",
        Beside::Paper => "paper (`reference`)",
        Beside::Count => "n",
    };
    let mut text =
        format!("| figure | {head} | required | ambition | reached |\n|---|---:|---:|---:|---:|\n");
    for row in asked {
        let worst = row.worst();
        let samples = worst.map_or(0, |(mean, _)| mean.count);
        let beside = match beside {
            Beside::Before => row.now.to_owned(),
            Beside::Count => samples.to_string(),
            Beside::Paper => show(worst.and_then(|(_, case)| case.reference), row.decimals),
        };
        let (required, ambition) = (row.required.show(samples), row.ambition.show(samples));
        let _ = writeln!(text, "| {} | {beside} | {required} | {ambition} | {} |", row.figure, row.reached());
    }
    text
}

/// What falls short, and why.
pub fn missed<'a>(asked: impl IntoIterator<Item = &'a Asked>) -> String {
    let missed: String = asked
        .into_iter()
        .filter(|asked| asked.is_missed())
        .map(|asked| {
            let why = if asked.why.is_empty() { "not explained yet." } else { asked.why };
            format!("* **{}**, {}: {why}\n", asked.figure, asked.reached())
        })
        .collect();
    if missed.is_empty() { "Nothing that is measured.\n".to_owned() } else { missed }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(at: &'static str, mean: f64) -> Case {
        Case { at, reached: Some(Mean { mean, error: Some(0.01), count: 20 }), reference: None }
    }

    fn reached(means: &[(&'static str, f64)]) -> String {
        let cases = means.iter().map(|&(at, mean)| case(at, mean)).collect();
        Asked::new("error", cases).required(Bound::AtMost(1.0)).ambition(Bound::AtMost(0.8)).reached()
    }

    #[test]
    fn the_worst_case_is_judged_and_named() {
        assert_eq!(reached(&[("a", 0.7), ("b", 1.2), ("c", 1.1)]), "1.20 ± 0.01 ✗ (`b`)");
        assert_eq!(reached(&[("a", 0.7), ("b", 1.0)]), "1.00 ± 0.01 ✓ (`b`)");
        assert_eq!(reached(&[("a", 0.7)]), "0.70 ± 0.01 ✓✓", "one alone needs no name");
        let at_least =
            Asked::new("PU", vec![case("a", 97.0), case("b", 95.0)]).required(Bound::AtLeast(96.0));
        assert_eq!(at_least.decimals(0).reached(), "95 ± 0 ✗ (`b`)");
    }

    #[test]
    fn an_ambition_alone_is_no_requirement() {
        let asked = Asked::new("F1", vec![case("a", 0.9)]).ambition(Bound::AtLeast(0.99));
        assert_eq!((asked.mark(), asked.is_missed()), (" ·", false));
    }

    #[test]
    fn what_is_not_measured_is_neither_reached_nor_missed() {
        let asked = Asked::new("lateness", measured(None, None)).required(Bound::AtMost(20.0)).now("118");
        assert_eq!((asked.reached(), asked.is_missed()), ("–".to_owned(), false));
        assert!(table(&[asked], Beside::Before).ends_with("| lateness | 118 | ≤ 20 | – | – |\n"));
    }

    #[test]
    fn what_falls_short_says_why() {
        let short = |why| Asked::new("error", vec![case("a", 2.0)]).required(Bound::AtMost(1.0)).why(why);
        let text = missed(&[short("it is too large."), short("")]);
        assert_eq!(
            text,
            "* **error**, 2.00 ± 0.01 ✗: it is too large.\n* **error**, 2.00 ± 0.01 ✗: not explained yet.\n"
        );
        assert_eq!(missed(&[Asked::new("nothing", Vec::new())]), "Nothing that is measured.\n");
    }
}
