//! An assessment: sections of tables of figures.

use serde::{Serialize, Serializer};

use super::bootstrap::{BlockSums, Estimate, Estimator};
use super::compare::ComparedFigure;

/// All of a report: where it comes from, the figures, and a comparison.
#[derive(Clone, Debug, Serialize)]
pub struct AssessmentReport {
    /// Layout of this object.
    pub format: &'static str,
    /// Program, files and configuration.
    pub provenance: Provenance,
    /// Figures on the recording.
    #[serde(flatten)]
    pub assessment: Assessment,
    /// Files of the other recording, with `--against`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Provenance>,
    /// Differences: the other recording less this one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub comparison: Vec<ComparedFigure>,
}

/// Program and files of an assessment. The same ones give the same report, octet by octet.
#[derive(Clone, Debug, Serialize)]
pub struct Provenance {
    /// Name and version of the program.
    pub program: String,
    /// Commit that it was built from, if the build stated it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Name of the site.
    pub site: String,
    /// Profile of the engine.
    pub profile: String,
    /// Configuration and further files that it names, recordings, and truth.
    pub files: Vec<AssessedFile>,
}

/// A file that was read.
#[derive(Clone, Debug, Serialize)]
pub struct AssessedFile {
    /// Role of the file: `recording`, `configuration` or `truth`.
    pub role: &'static str,
    /// Name, without its folder.
    pub name: String,
    /// Size, octets.
    pub octets: u64,
    /// SHA-256 of the contents, hexadecimal.
    pub sha256: String,
}

/// Figures on a recording.
#[derive(Clone, Debug, Serialize)]
pub struct Assessment {
    /// Reference of the figures.
    pub reference: ReferenceKind,
    /// How the intervals are made.
    pub method: IntervalMethod,
    /// Sections, in order.
    pub sections: Vec<AssessmentSection>,
    /// Statements that the recording does not permit, with reasons.
    pub cannot_say: Vec<Limit>,
}

/// Positions that the recording is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceKind {
    /// A truth file.
    Truth,
    /// The recorded reports of transponders.
    Transponders,
}

/// Parameters of the intervals.
#[derive(Clone, Debug, Serialize)]
pub struct IntervalMethod {
    /// Confidence, percent.
    pub confidence_percent: f64,
    /// Number of bootstrap replicates.
    pub replicates: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Aircraft of the reference with slots that count.
    pub aircraft: usize,
    /// Length of a block, seconds; `None` if a block is all of an aircraft's flight.
    pub block_s: Option<f64>,
}

/// A section of the report.
#[derive(Clone, Debug, Serialize)]
pub struct AssessmentSection {
    /// Short name, stable over releases.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Text below the heading.
    #[serde(skip)]
    pub text: &'static str,
    /// Tables of figures.
    pub tables: Vec<FigureTable>,
    /// Drawings (SVG) with their captions.
    #[serde(skip)]
    pub drawings: Vec<(String, String)>,
}

/// Figures on one subject: a sensor, or the picture.
#[derive(Clone, Debug, Serialize)]
pub struct FigureTable {
    /// Subject.
    pub title: String,
    /// Figures.
    pub figures: Vec<AssessmentFigure>,
}

/// A figure with its interval.
#[derive(Clone, Debug)]
pub struct AssessmentFigure {
    /// Unique key, for comparisons.
    pub key: String,
    /// Name.
    pub name: String,
    /// Unit; empty for counts.
    pub unit: &'static str,
    /// Decimals that are printed.
    pub digits: usize,
    /// Value; `None` without data.
    pub value: Option<f64>,
    /// 95 % interval; `None` if the recording has too few blocks.
    pub interval: Option<[f64; 2]>,
    /// Number of trials, reports, intervals or events behind the value.
    pub count: Option<u64>,
    /// Number of blocks behind the interval.
    pub blocks: Option<usize>,
    /// Effective number of blocks.
    pub(super) effective: usize,
    /// Values of the bootstrap, for comparisons.
    pub(super) replicates: Vec<f64>,
}

/// A statement that the recording does not permit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Limit {
    /// Statement that is not permitted.
    pub what: String,
    /// Reason.
    pub why: String,
}

impl AssessmentFigure {
    /// A figure without an interval.
    pub(super) fn plain(
        key: String,
        name: &str,
        unit: &'static str,
        digits: usize,
        value: Option<f64>,
    ) -> Self {
        Self {
            key,
            name: name.to_owned(),
            unit,
            digits,
            value,
            interval: None,
            count: None,
            blocks: None,
            effective: 0,
            replicates: Vec::new(),
        }
    }

    /// A figure estimated from blocks.
    pub(super) fn estimated(
        (key, name): (String, &str),
        (unit, digits): (&'static str, usize),
        estimator: Estimator,
        sums: &BlockSums,
        seed: u64,
    ) -> Self {
        let Estimate { value, interval, blocks, effective, replicates } = estimator.estimate(sums, seed);
        // Events of a rate; else trials, reports or intervals.
        let counted = usize::from(estimator != Estimator::Rate);
        let count = Some(sums.values().map(|sum| sum[counted]).sum::<f64>() as u64);
        Self {
            value,
            interval,
            count,
            blocks: Some(blocks),
            effective,
            replicates,
            ..Self::plain(key, name, unit, digits, None)
        }
    }

    /// Adds the number of values behind the figure.
    pub(super) fn with_count(self, count: u64) -> Self {
        Self { count: Some(count), ..self }
    }

    /// A value as printed.
    pub fn printed(&self, value: f64) -> String {
        let text = format!("{value:.*}", self.digits);
        // No sign before a zero.
        if text.trim_start_matches(['-', '0', '.']).is_empty() {
            text.trim_start_matches('-').to_owned()
        } else {
            text
        }
    }
}

/// Values are written with the digits that the report prints.
impl Serialize for AssessmentFigure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct FigureJson<'a> {
            key: &'a str,
            name: &'a str,
            unit: &'a str,
            #[serde(skip_serializing_if = "Option::is_none")]
            value: Option<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            low: Option<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            high: Option<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            count: Option<u64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            blocks: Option<usize>,
        }
        let rounded = |value: f64| self.printed(value).parse().unwrap_or(value);
        FigureJson {
            key: &self.key,
            name: &self.name,
            unit: self.unit,
            value: self.value.map(rounded),
            low: self.interval.map(|[low, _]| rounded(low)),
            high: self.interval.map(|[_, high]| rounded(high)),
            count: self.count,
            blocks: self.blocks,
        }
        .serialize(serializer)
    }
}
