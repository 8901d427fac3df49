//! Tables of results, with a row for each measure.

use std::fmt::Write as _;

use crate::figures::{OPERATIONAL, REFERENCE, ScoreStream};
use crate::flights::FlightRow;
use crate::score::FlightScores;
use crate::summary::{MeanValue, SeedScores, show};

/// The case that is shown if a measure has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WorstCase {
    Highest,
    Lowest,
    /// The value with the largest ratio to 1, or of 1 to it.
    FarthestFromOne,
}

/// A measure and its results.
pub struct ResultRow {
    measure: String,
    decimals: usize,
    cases: Vec<ResultCase>,
    worst: WorstCase,
    /// Reason why the result falls short of what a user needs; empty if it does not.
    limitation: &'static str,
}

/// Result of a measure for one row of flights.
#[derive(Clone, Copy)]
pub struct ResultCase {
    pub at: &'static str,
    pub result: Option<MeanValue>,
    /// Result of the profile `reference`.
    pub reference: Option<MeanValue>,
}

/// Value of a measure for a stream.
pub type Measure = fn(&SeedScores<'_>, &ScoreStream) -> Option<MeanValue>;

/// Value of the measure for each of these rows.
pub fn each(scores: &[FlightScores], rows: &[FlightRow], measure: Measure) -> Vec<ResultCase> {
    let case = |row: &FlightRow| {
        let seeds = SeedScores::of(scores, row);
        let of = |stream: &ScoreStream| measure(&seeds, stream);
        ResultCase { at: row.name(), result: of(&OPERATIONAL), reference: of(&REFERENCE) }
    };
    rows.iter().map(case).collect()
}

/// Value of the measure for each first row divided by that of the second, flight by flight.
pub fn against(
    scores: &[FlightScores],
    pairs: &[(FlightRow, FlightRow)],
    measure: fn(&FlightScores) -> Option<f64>,
) -> Vec<ResultCase> {
    let case = |(row, other): &(FlightRow, FlightRow)| {
        let result = SeedScores::of(scores, row).against(&SeedScores::of(scores, other), measure);
        ResultCase { at: row.name(), result, reference: None }
    };
    pairs.iter().map(case).collect()
}

/// A measure that is not part of the scores.
pub fn measured(result: Option<MeanValue>, reference: Option<MeanValue>) -> Vec<ResultCase> {
    vec![ResultCase { at: "", result, reference }]
}

impl WorstCase {
    /// Orders values: the worst is the largest.
    fn rank(self, value: f64) -> f64 {
        match self {
            Self::Highest => value,
            Self::Lowest => -value,
            Self::FarthestFromOne => value.ln().abs(),
        }
    }
}

impl ResultRow {
    /// A measure with two decimals, whose worst case is the highest.
    pub fn new(measure: impl Into<String>, cases: Vec<ResultCase>) -> Self {
        Self { measure: measure.into(), decimals: 2, cases, worst: WorstCase::Highest, limitation: "" }
    }

    /// The lowest case is the worst.
    pub fn lowest(self) -> Self {
        Self { worst: WorstCase::Lowest, ..self }
    }

    /// The case farthest from 1 is the worst.
    pub fn farthest_from_one(self) -> Self {
        Self { worst: WorstCase::FarthestFromOne, ..self }
    }

    pub fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }

    /// Sets the reason why the result falls short of what a user needs.
    pub fn limitation(self, limitation: &'static str) -> Self {
        Self { limitation, ..self }
    }

    fn worst_case(&self) -> Option<(MeanValue, ResultCase)> {
        let known = self.cases.iter().filter_map(|case| Some((case.result?, *case)));
        known.max_by(|a, b| self.worst.rank(a.0.mean).total_cmp(&self.worst.rank(b.0.mean)))
    }

    /// The worst result, and its row if there are several.
    fn result(&self) -> String {
        let worst = self.worst_case();
        let at = worst.filter(|_| self.cases.len() > 1).map(|(_, case)| format!(" (`{}`)", case.at));
        format!("{}{}", show(worst.map(|(mean, _)| mean), self.decimals), at.unwrap_or_default())
    }
}

/// Column between the measure and its result.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum SideColumn {
    None,
    /// Number of samples.
    Count,
    /// Result of the profile `reference`.
    Reference,
}

/// Table of the results.
pub fn table(rows: &[ResultRow], side: SideColumn) -> String {
    let (heading, rule) = match side {
        SideColumn::None => ("", ""),
        SideColumn::Count => (" n |", "---:|"),
        SideColumn::Reference => (" `reference` |", "---:|"),
    };
    let mut text = format!("| measure |{heading} result |\n|---|{rule}---:|\n");
    for row in rows {
        let worst = row.worst_case();
        let beside = match side {
            SideColumn::None => String::new(),
            SideColumn::Count => format!(" {} |", worst.map_or(0, |(mean, _)| mean.count)),
            SideColumn::Reference => {
                format!(" {} |", show(worst.and_then(|(_, case)| case.reference), row.decimals))
            }
        };
        let _ = writeln!(text, "| {} |{beside} {} |", row.measure, row.result());
    }
    text
}

/// List of the results that fall short, with reasons. Measures without a result are left out.
pub fn limitations<'a>(rows: impl IntoIterator<Item = &'a ResultRow>) -> String {
    let short = rows.into_iter().filter(|row| !row.limitation.is_empty() && row.worst_case().is_some());
    short.map(|row| format!("* **{}**, {}: {}\n", row.measure, row.result(), row.limitation)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(at: &'static str, mean: f64) -> ResultCase {
        ResultCase { at, result: Some(MeanValue { mean, error: Some(0.01), count: 20 }), reference: None }
    }

    fn row(means: &[(&'static str, f64)]) -> ResultRow {
        ResultRow::new("error", means.iter().map(|&(at, mean)| case(at, mean)).collect())
    }

    #[test]
    fn worst_of_several_cases_is_shown_with_its_name() {
        let three = [("a", 0.5), ("b", 1.3), ("c", 1.1)];
        assert_eq!(row(&three).result(), "1.30 ± 0.01 (`b`)");
        assert_eq!(row(&three).lowest().result(), "0.50 ± 0.01 (`a`)");
        assert_eq!(row(&three[1..]).farthest_from_one().decimals(1).result(), "1.3 ± 0.0 (`b`)");
        assert_eq!(row(&three).farthest_from_one().result(), "0.50 ± 0.01 (`a`)");
        assert_eq!(row(&three[..1]).result(), "0.50 ± 0.01", "a single case needs no name");
    }

    #[test]
    fn measure_without_result_is_a_dash_and_no_limitation() {
        let row = ResultRow::new("lateness", measured(None, None)).limitation("it is too large.");
        assert_eq!(limitations([&row]), "");
        assert!(table(&[row], SideColumn::Count).ends_with("| lateness | 0 | – |\n"));
    }

    #[test]
    fn limitation_is_listed_with_result() {
        let rows = [row(&[("a", 2.0)]).limitation("It is too large."), row(&[("a", 2.0)])];
        assert_eq!(limitations(&rows), "* **error**, 2.00 ± 0.01: It is too large.\n");
        assert!(table(&rows[1..], SideColumn::None).ends_with("|---|---:|\n| error | 2.00 ± 0.01 |\n"));
    }
}
