//! Scores in the form of Table 1 of the paper, and a row per drone.

use std::fmt::{self, Write as _};

use super::{EvaluateScores, alerts, conflicts, integrity};
use crate::commands::table::TextTable;
use lab::evaluate::{ErrorStatistics, ScoredStream, StreamMetrics};

/// Comparison of a metric with that of a single input.
#[derive(Clone, Copy)]
enum Improvement {
    /// Difference in percentage points; higher values are better.
    Points,
    /// Reduction in percent of the input's value; lower values are better.
    Reduction,
    /// No comparison, because single inputs lack the metric.
    None,
}

type MetricValue = fn(&StreamMetrics) -> Option<f64>;

fn statistic(of: Option<ErrorStatistics>, what: fn(&ErrorStatistics) -> f64) -> Option<f64> {
    of.as_ref().map(what)
}

/// Metrics: name, value, decimals, comparison.
const ROWS: [(&str, MetricValue, usize, Improvement); 22] = [
    ("mean ePos (m)", |s| statistic(s.epos, |e| e.mean_m), 4, Improvement::Reduction),
    ("SEM ePos (m)", |s| statistic(s.epos, |e| e.sem_m), 4, Improvement::Reduction),
    ("mean ePosH (m)", |s| statistic(s.eposh, |e| e.mean_m), 4, Improvement::Reduction),
    ("SEM ePosH (m)", |s| statistic(s.eposh, |e| e.sem_m), 4, Improvement::Reduction),
    ("mean ePosV (m)", |s| statistic(s.eposv, |e| e.mean_m), 4, Improvement::Reduction),
    ("SEM ePosV (m)", |s| statistic(s.eposv, |e| e.sem_m), 4, Improvement::Reduction),
    ("p50 ePos (m)", |s| statistic(s.epos, |e| e.p50_m), 4, Improvement::Reduction),
    ("p95 ePos (m)", |s| statistic(s.epos, |e| e.p95_m), 4, Improvement::Reduction),
    ("p50 ePosH (m)", |s| statistic(s.eposh, |e| e.p50_m), 4, Improvement::Reduction),
    ("p95 ePosH (m)", |s| statistic(s.eposh, |e| e.p95_m), 4, Improvement::Reduction),
    ("PU, covered (%)", |s| s.pu_covered_percent, 2, Improvement::Points),
    ("PU, in gaps (%)", |s| s.pu_gap_percent, 2, Improvement::Points),
    ("gap slots within 50 m (%)", |s| s.gap_within_50_m_percent, 2, Improvement::Points),
    ("mean ePos, covered (m)", |s| statistic(s.epos_covered, |e| e.mean_m), 4, Improvement::Reduction),
    ("mean ePos, in gaps (m)", |s| statistic(s.epos_gap, |e| e.mean_m), 4, Improvement::Reduction),
    ("association precision", |s| s.precision, 4, Improvement::None),
    ("association recall", |s| s.recall, 4, Improvement::None),
    ("identity changes (/drone/min)", |s| s.id_changes, 2, Improvement::Reduction),
    ("slots with two numbers (%)", |s| s.two_numbers_percent, 2, Improvement::None),
    ("ghosts (s/min)", |s| s.ghosts_s, 2, Improvement::None),
    ("false track (s/min)", |s| s.false_track_s, 2, Improvement::Reduction),
    ("GOSPA (m)", |s| s.gospa_m, 4, Improvement::Reduction),
];

/// Metrics shown only if the output states its covariances.
const HONESTY: [(&str, MetricValue, usize, Improvement); 9] = [
    ("NEES, horizontal", |s| Some(s.nees?.horizontal), 4, Improvement::None),
    ("NEES, horizontal, covered", |s| Some(s.nees_covered?.horizontal), 4, Improvement::None),
    ("NEES, horizontal, in gaps", |s| Some(s.nees_gap?.horizontal), 4, Improvement::None),
    ("NEES, horizontal, straight", |s| Some(s.nees_straight?.horizontal), 4, Improvement::None),
    ("NEES, horizontal, turning", |s| Some(s.nees_turning?.horizontal), 4, Improvement::None),
    ("NEES, horizontal, walked off", |s| Some(s.nees_walked_off?.horizontal), 4, Improvement::None),
    ("NEES, vertical", |s| s.nees?.vertical, 4, Improvement::None),
    ("beyond 3.7 sigma, horizontal (%)", |s| Some(s.nees?.beyond_percent), 2, Improvement::None),
    ("beyond 3.7 sigma, vertical (%)", |s| s.nees?.vertical_beyond_percent, 2, Improvement::None),
];

pub(super) fn text(scores: &EvaluateScores<'_>) -> Result<String, fmt::Error> {
    let mut text = String::new();
    write!(text, "{}", metrics(scores))?;
    writeln!(text, "\n{}", drones(scores))?;
    if let Some(scored) = &scores.integrity {
        writeln!(text, "{}", integrity::text(scored)?)?;
    }
    if !scores.conflicts.is_empty() {
        writeln!(text, "{}", conflicts::text(&scores.conflicts)?)?;
    }
    if let Some(scored) = &scores.alerts {
        writeln!(text, "{}", alerts::text(scored)?)?;
    }
    remarks(&mut text, scores)?;
    Ok(text)
}

/// Table as in the paper: fused output, each input alone, and the change by fusion.
fn metrics(scores: &EvaluateScores<'_>) -> TextTable {
    let evaluation = scores.evaluation;
    let inputs = [&evaluation.radar, &evaluation.transponder].map(Option::as_ref);
    let mut table = if evaluation.radar.is_some() {
        TextTable::new("lrrrrr", &["metric", "fused", "radar", "transponder", "vs radar", "vs transponder"])
    } else {
        TextTable::new("lr", &["metric", "fused"])
    };
    let pu = format!("PU, {} Hz ref. (%)", (scores.reference_hz * 1000.0).round() / 1000.0);
    let pu: (&str, MetricValue, usize, Improvement) = (&pu, |s| s.pu_percent, 2, Improvement::Points);
    let honesty = HONESTY.into_iter().filter(|(_, value, ..)| value(&evaluation.fused.all).is_some());
    for (name, value, decimals, change) in std::iter::once(pu).chain(ROWS).chain(honesty) {
        let fused = value(&evaluation.fused.all);
        let alone = inputs.map(|input| input.and_then(|scored| value(&scored.all)));
        let mut row = vec![name.to_owned(), cell(fused, decimals)];
        if evaluation.radar.is_some() {
            row.extend(alone.map(|alone| match change {
                Improvement::None => String::new(),
                _ => cell(alone, decimals),
            }));
            row.extend(alone.map(|alone| changed(fused, alone, change)));
        }
        table.row(row);
    }
    table
}

fn cell(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

/// Column "Change" of the paper: positive values are better.
fn changed(fused: Option<f64>, alone: Option<f64>, change: Improvement) -> String {
    match (change, fused.zip(alone)) {
        (Improvement::Points, Some((fused, alone))) => format!("{:+.2} points", fused - alone),
        (Improvement::Reduction, Some((fused, alone))) if alone > 0.0 => {
            format!("{:+.2} %", 100.0 * (alone - fused) / alone)
        }
        _ => String::new(),
    }
}

/// Table with a row per drone, then per group.
fn drones(scores: &EvaluateScores<'_>) -> TextTable {
    let evaluation = scores.evaluation;
    let names = [
        "drone",
        "transponder",
        "PU %",
        "ePosH m",
        "ePosV m",
        "id changes/min",
        "PU radar %",
        "PU transponder %",
    ];
    let (columns, width) = if evaluation.radar.is_some() { ("llrrrrrr", 8) } else { ("llrrrr", 6) };
    let mut table = TextTable::new(columns, &names[..width]);
    let mut row = |name: &str, equipped: &str, score: &dyn Fn(&ScoredStream) -> StreamMetrics| {
        let fused = score(&evaluation.fused);
        let mut cells = vec![
            name.to_owned(),
            equipped.to_owned(),
            cell(fused.pu_percent, 2),
            cell(statistic(fused.eposh, |e| e.mean_m), 4),
            cell(statistic(fused.eposv, |e| e.mean_m), 4),
            cell(fused.id_changes, 2),
        ];
        let inputs = [&evaluation.radar, &evaluation.transponder].into_iter().flatten();
        cells.extend(inputs.map(|input| cell(score(input).pu_percent, 2)));
        table.row(cells);
    };
    for (index, drone) in evaluation.drones.iter().enumerate() {
        let equipped = drone.equipped.map_or("?", |equipped| if equipped { "yes" } else { "no" });
        row(&drone.id, equipped, &|scored| scored.drones[index].clone());
    }
    let has = |wanted: bool| evaluation.drones.iter().any(|drone| drone.equipped == Some(wanted));
    if has(true) && has(false) {
        row("all equipped", "yes", &|scored| scored.equipped.clone());
        row("all others", "no", &|scored| scored.unequipped.clone());
    }
    table
}

/// Lists missing values with the reason, then the requirements.
fn remarks(text: &mut String, scores: &EvaluateScores<'_>) -> fmt::Result {
    if scores.args.capture.is_empty() {
        writeln!(
            text,
            "Without --capture and --config each input alone, covered, gaps and recall are not told."
        )?;
    }
    if scores.args.labels.is_none() {
        writeln!(
            text,
            "Without --labels a point belongs to the nearest drone within 150 m; precision and recall are not told."
        )?;
    }
    for (requirement, value, is_met) in &scores.requirements {
        let verdict = if *is_met { "met" } else { "missed" };
        match value {
            Ok(value) => writeln!(text, "{verdict}: {requirement} ({value:.4})")?,
            Err(reason) => writeln!(text, "{verdict}: {requirement} ({reason})")?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::evaluate::Args;
    use lab::evaluate::{Evaluation, Nees};

    #[test]
    fn nees_row_is_shown_if_there_are_deviations() {
        let mut scored = ScoredStream {
            all: StreamMetrics::default(),
            equipped: StreamMetrics::default(),
            unequipped: StreamMetrics::default(),
            drones: vec![],
            samples: vec![],
        };
        let shown = |scored: &ScoredStream| {
            let evaluation =
                Evaluation { drones: vec![], fused: scored.clone(), radar: None, transponder: None };
            let args = Args::default();
            text(&EvaluateScores {
                args: &args,
                evaluation: &evaluation,
                reference_hz: 4.0,
                integrity: None,
                alerts: None,
                conflicts: Vec::new(),
                requirements: vec![],
            })
            .unwrap()
        };
        assert!(!shown(&scored).contains("NEES"));
        scored.all.nees = Some(Nees {
            count: 8,
            horizontal: 1.25,
            vertical: None,
            beyond_percent: 12.5,
            vertical_beyond_percent: None,
        });
        let table = shown(&scored);
        assert!(table.contains("NEES, horizontal   ") && table.contains("1.2500"), "{table}");
        assert!(!table.contains("NEES, vertical"), "{table}");
        assert!(table.contains("beyond 3.7 sigma, horizontal (%)   12.50"), "{table}");
        assert!(!table.contains("sigma, vertical"), "{table}");
    }
}
