//! `--require`: thresholds for scores.

use std::fmt;
use std::str::FromStr;

use super::Args;
use lab::evaluate::{ErrorStatistics, Evaluation, StreamMetrics};

/// A condition `[radar.|transponder.][equipped.|unequipped.]METRIC OP NUMBER`.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// Text as given by the user.
    text: String,
    stream: RequiredStream,
    group: RequiredGroup,
    metric: RequiredMetric,
    comparison: RequirementOperator,
    bound: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequiredStream {
    Fused,
    Radar,
    Transponder,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequiredGroup {
    All,
    Equipped,
    Unequipped,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequirementOperator {
    AtLeast,
    AtMost,
    Above,
    Below,
}

/// Name of a metric, and its value in a score.
type RequiredMetric = (&'static str, fn(&StreamMetrics) -> Option<f64>);

const METRICS: [RequiredMetric; 14] = [
    ("pu", |score| score.pu_percent),
    ("epos", |score| mean(score.epos)),
    ("eposh", |score| mean(score.eposh)),
    ("eposv", |score| mean(score.eposv)),
    ("epos_covered", |score| mean(score.epos_covered)),
    ("epos_gap", |score| mean(score.epos_gap)),
    ("gap_within_50_m", |score| score.gap_within_50_m_percent),
    ("precision", |score| score.precision),
    ("recall", |score| score.recall),
    ("id_changes", |score| score.id_changes),
    ("two_numbers", |score| score.two_numbers_percent),
    ("ghosts", |score| score.ghosts_s),
    ("false_track", |score| score.false_track_s),
    ("gospa", |score| score.gospa_m),
];

fn mean(statistics: Option<ErrorStatistics>) -> Option<f64> {
    statistics.map(|statistics| statistics.mean_m)
}

/// Longer operators first, because `>=` starts with `>`.
const COMPARISONS: [(&str, RequirementOperator); 4] = [
    (">=", RequirementOperator::AtLeast),
    ("<=", RequirementOperator::AtMost),
    (">", RequirementOperator::Above),
    ("<", RequirementOperator::Below),
];

impl FromStr for Requirement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let place = text.find(['<', '>']).ok_or_else(|| grammar("there is no >= <= > or <"))?;
        let (name, rest) = text.split_at(place);
        let found = COMPARISONS.iter().find_map(|(sign, is)| Some((*is, rest.strip_prefix(sign)?)));
        let (comparison, number) = found.ok_or_else(|| grammar("there is no >= <= > or <"))?;
        let number = number.trim();
        let bound = number.parse().ok().filter(|bound: &f64| bound.is_finite());
        let bound = bound.ok_or_else(|| grammar(&format!("{number:?} is no number")))?;
        let (stream, name) = prefix(
            name.trim(),
            [("radar.", RequiredStream::Radar), ("transponder.", RequiredStream::Transponder)],
        );
        let (group, name) = prefix(
            name,
            [("equipped.", RequiredGroup::Equipped), ("unequipped.", RequiredGroup::Unequipped)],
        );
        let metric = *METRICS
            .iter()
            .find(|(known, _)| *known == name)
            .ok_or_else(|| grammar(&format!("{name:?} is no metric")))?;
        let group = group.unwrap_or(RequiredGroup::All);
        if matches!(name, "false_track" | "gospa") && group != RequiredGroup::All {
            return Err(format!("{name} is of all drones together; leave out equipped. or unequipped."));
        }
        let stream = stream.unwrap_or(RequiredStream::Fused);
        Ok(Self { text: text.to_owned(), stream, group, metric, comparison, bound })
    }
}

/// The first of these prefixes that `name` has, and the rest of `name`.
fn prefix<'a, T>(name: &'a str, known: [(&str, T); 2]) -> (Option<T>, &'a str) {
    for (prefix, means) in known {
        if let Some(rest) = name.strip_prefix(prefix) {
            return (Some(means), rest);
        }
    }
    (None, name)
}

fn grammar(what: &str) -> String {
    let metrics: Vec<&str> = METRICS.iter().map(|(name, _)| *name).collect();
    format!(
        "{what}; write [radar.|transponder.][equipped.|unequipped.]METRIC OP NUMBER, for example 'pu>=90', with METRIC one of {} and OP one of >= <= > <",
        metrics.join(" ")
    )
}

impl Requirement {
    /// The value to compare with the bound.
    ///
    /// # Errors
    /// There is no value. The error states the reason.
    pub(super) fn value(&self, evaluation: &Evaluation, args: &Args) -> Result<f64, String> {
        let scored = match self.stream {
            RequiredStream::Fused => Some(&evaluation.fused),
            RequiredStream::Radar => evaluation.radar.as_ref(),
            RequiredStream::Transponder => evaluation.transponder.as_ref(),
        };
        let scored = scored.ok_or("it needs --capture and --config")?;
        let score = match self.group {
            RequiredGroup::All => &scored.all,
            RequiredGroup::Equipped => &scored.equipped,
            RequiredGroup::Unequipped => &scored.unequipped,
        };
        (self.metric.1)(score).ok_or_else(|| self.missing(args).to_owned())
    }

    /// Whether `value` meets the bound.
    pub(super) fn is_met_by(&self, value: f64) -> bool {
        match self.comparison {
            RequirementOperator::AtLeast => value >= self.bound,
            RequirementOperator::AtMost => value <= self.bound,
            RequirementOperator::Above => value > self.bound,
            RequirementOperator::Below => value < self.bound,
        }
    }

    /// Reason why there is no value.
    fn missing(&self, args: &Args) -> &'static str {
        let (has_labels, has_capture) = (args.labels.is_some(), !args.capture.is_empty());
        match self.metric.0 {
            "precision" | "recall" if self.stream != RequiredStream::Fused => {
                "an input alone associates nothing"
            }
            "precision" | "recall" if !has_labels => "it needs --labels",
            "recall" | "epos_covered" | "epos_gap" if !has_capture => "it needs --capture and --config",
            _ if self.group != RequiredGroup::All && !has_labels && !has_capture => {
                "it needs --labels or --capture to tell which drones carry a transponder"
            }
            _ => "there is nothing that it could be told of",
        }
    }
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_requirement_spellings_are_parsed() {
        let parsed = |text: &str| text.parse::<Requirement>().unwrap();
        let plain = parsed("pu>=90");
        assert_eq!(
            (plain.stream, plain.group, plain.metric.0),
            (RequiredStream::Fused, RequiredGroup::All, "pu")
        );
        assert_eq!((plain.comparison, plain.bound), (RequirementOperator::AtLeast, 90.0));
        let long = parsed(" radar.unequipped.epos_gap < 12.5 ");
        assert_eq!((long.stream, long.group), (RequiredStream::Radar, RequiredGroup::Unequipped));
        assert_eq!(
            (long.metric.0, long.comparison, long.bound),
            ("epos_gap", RequirementOperator::Below, 12.5)
        );
        assert!(
            plain.is_met_by(90.0) && !parsed("pu>90").is_met_by(90.0) && parsed("pu<=90").is_met_by(90.0)
        );
    }

    #[test]
    fn invalid_requirement_is_explained() {
        for (wrong, word) in [
            ("pu", "there is no >="),
            ("pu=90", "there is no >="),
            ("pu>=ninety", "\"ninety\" is no number"),
            ("pu>=nan", "is no number"),
            ("sonar.pu>=1", "\"sonar.pu\" is no metric"),
            ("equipped.radar.pu>=1", "is no metric"),
            ("equipped.gospa<1", "of all drones together"),
        ] {
            let error = wrong.parse::<Requirement>().unwrap_err();
            assert!(error.contains(word), "{wrong}: {error}");
        }
        assert!(
            "x>1".parse::<Requirement>().unwrap_err().contains("epos_gap gap_within_50_m precision recall")
        );
    }
}
