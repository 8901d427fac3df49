//! `--conflicts`: scores of the predicted conflicts.

use std::fmt::{self, Write as _};

use serde::Serialize;

use super::EvaluateInputs;
use crate::commands::table::TextTable;
use lab::evaluate::plot::{self, Figure};
use lab::evaluate::{ConflictFlight, ConflictPrediction, ConflictScore, Scoring, encounter, score_conflicts};

/// Minimum number of predictions in a tenth of the range of probabilities for it to count in the reliability.
const STATED: u64 = 50;

/// Score of a volume.
#[derive(Serialize)]
pub(super) struct VolumeScore {
    volume: String,
    horizontal_m: f64,
    vertical_m: f64,
    #[serde(flatten)]
    score: ConflictScore,
}

/// Scores the predictions, each with the name of its volume, in the order of the configured volumes. Empty if a required input is
/// missing; the command line requires it.
pub(super) fn scored(
    all: &[(String, ConflictPrediction)],
    inputs: &EvaluateInputs,
    settings: &Scoring,
) -> Vec<VolumeScore> {
    let EvaluateInputs { config: Some(config), truth, labels: Some(labels), output, .. } = inputs else {
        return Vec::new();
    };
    let of_volume = |name: &str| -> Vec<ConflictPrediction> {
        all.iter().filter(|(volume, _)| volume == name).map(|(_, foreseen)| foreseen.clone()).collect()
    };
    let score = |volume: conflict::Volume| {
        let foreseen = of_volume(&volume.name);
        let (horizontal_m, vertical_m) = (volume.horizontal_m, volume.vertical_m);
        let flight = ConflictFlight {
            truth,
            labels,
            output,
            foreseen: &foreseen,
            volume: (horizontal_m, vertical_m),
            settings,
        };
        VolumeScore { volume: volume.name, horizontal_m, vertical_m, score: score_conflicts(&flight) }
    };
    config.conflicts.rules().volumes.into_iter().map(score).collect()
}

/// Figure of the closest encounter.
pub(super) fn figure(
    all: &[(String, ConflictPrediction)],
    inputs: &EvaluateInputs,
    settings: &Scoring,
) -> Option<Figure> {
    let EvaluateInputs { truth, labels: Some(labels), output, .. } = inputs else { return None };
    let foreseen = all.iter().map(|(_, foreseen)| foreseen);
    Some(plot::encounter(encounter(truth, labels, output, foreseen, settings).as_ref()))
}

/// Section of the report, with a table for each volume.
pub(super) fn text(scored: &[VolumeScore]) -> Result<String, fmt::Error> {
    let mut text = String::new();
    for VolumeScore { volume, horizontal_m, vertical_m, score } in scored {
        let title = format!("conflicts, {volume}: {horizontal_m:.0} m, {vertical_m:.0} m");
        let mut table = TextTable::new("lr", &[&title, "reached"]);
        let mut row = |name: &str, value: String| table.row(vec![name.to_owned(), value]);
        let percent = |share: Option<f64>| decimals(share.map(|share| 100.0 * share));
        row("violations between equipped drones", score.violations.to_string());
        row("warned of 10 s before (%)", percent(score.warned_share()));
        row("foreseeable then by the true states (%)", percent(score.foreseeable_share()));
        row("warnings", score.warnings.to_string());
        row("false warnings (/drone-hour)", decimals(score.false_per_h()));
        row("largest difference of stated and happened", decimals(score.unreliability(STATED)));
        row("time of the closest point, 10 to 30 s ahead, rms (s)", decimals(score.t_cpa_rms_s()));
        row("time of the entry, 10 to 30 s ahead, rms (s)", decimals(score.t_entry_rms_s()));
        row("true miss within 2 sigma then (%)", percent(score.within_share()));
        row("changes of level in a conflict", decimals(score.changes_each()));
        write!(text, "{table}")?;
    }
    Ok(text)
}

fn decimals(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"))
}
