//! Comparison of two recordings.

use std::collections::BTreeMap;

use serde::Serialize;

use super::bootstrap::percentiles;
use super::types::{Assessment, AssessmentFigure};

/// A figure of two recordings.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedFigure {
    /// Key of the figure.
    pub key: String,
    /// Section, subject and name.
    pub name: String,
    /// Unit.
    pub unit: &'static str,
    /// Value of this recording.
    pub value: f64,
    /// Value of the other recording.
    pub other: f64,
    /// Difference: the other less this one.
    pub difference: f64,
    /// 95 % interval of the difference; `None` if one of the recordings has too few blocks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Conclusion.
    pub verdict: Verdict,
    /// Decimals that are printed.
    #[serde(skip)]
    pub digits: usize,
}

/// Result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The other recording has the higher value.
    Higher,
    /// The other recording has the lower value.
    Lower,
    /// The interval of the difference contains 0.
    NotDistinguishable,
    /// The recordings are too short for an interval.
    NoInterval,
}

impl Verdict {
    /// Text for a table.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Higher => "higher",
            Self::Lower => "lower",
            Self::NotDistinguishable => "not distinguishable",
            Self::NoInterval => "too few blocks",
        }
    }
}

/// Compares all figures with intervals or block counts that both recordings have. The draws of both must have different seeds.
pub fn compare(this: &Assessment, other: &Assessment) -> Vec<ComparedFigure> {
    let others: BTreeMap<&str, &AssessmentFigure> =
        figures(other).map(|(_, _, figure)| (figure.key.as_str(), figure)).collect();
    let compared = figures(this).filter_map(|(section, subject, figure)| {
        let other = others.get(figure.key.as_str())?;
        figure.blocks?;
        let (value, with) = (figure.value?, other.value?);
        let interval = interval(figure, other);
        let verdict = match interval {
            None => Verdict::NoInterval,
            Some([low, _]) if low > 0.0 => Verdict::Higher,
            Some([_, high]) if high < 0.0 => Verdict::Lower,
            Some(_) => Verdict::NotDistinguishable,
        };
        let rounded = |value: f64| figure.printed(value).parse().unwrap_or(value);
        Some(ComparedFigure {
            key: figure.key.clone(),
            name: format!("{section}: {subject}, {}", figure.name),
            unit: figure.unit,
            value: rounded(value),
            other: rounded(with),
            difference: rounded(with - value),
            interval: interval.map(|interval| interval.map(rounded)),
            verdict,
            digits: figure.digits,
        })
    });
    compared.collect()
}

/// Interval of the difference: from the replicates of both; if one has none, from the ends of the intervals, which is wider.
fn interval(this: &AssessmentFigure, other: &AssessmentFigure) -> Option<[f64; 2]> {
    if !this.replicates.is_empty() && !other.replicates.is_empty() {
        let pairs = this.replicates.iter().zip(&other.replicates);
        let differences: Vec<f64> = pairs.map(|(this, other)| other - this).collect();
        return percentiles(&differences, this.effective.min(other.effective));
    }
    let ([low, high], [other_low, other_high]) = (this.interval?, other.interval?);
    Some([other_low - high, other_high - low])
}

/// Figures with their section and subject.
fn figures(assessment: &Assessment) -> impl Iterator<Item = (&'static str, &str, &AssessmentFigure)> {
    assessment.sections.iter().flat_map(|section| {
        let tables = section.tables.iter();
        tables.flat_map(move |table| {
            table.figures.iter().map(move |figure| (section.title, table.title.as_str(), figure))
        })
    })
}
