//! An evaluation as one HTML page: the paper's Table 1, the figures, and a table of the drones. The page needs no
//! script, font or network, and prints on A4.

use std::fmt::Write;

use super::super::types::{ErrorStatistics, Evaluation, ScoredStream, StreamMetrics};
use super::axis::decimal;
use super::figure::{Figure, counted, moment};
use picture::xml::escape;

const STYLE: &str = include_str!("page.css");
/// Placeholder for an unknown value.
const NONE: &str = "–";

/// Comparison of the output's value with the radar's.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SummaryChange {
    /// Higher is better: difference in percentage points.
    Points,
    /// Lower is better: reduction, as a share of the radar's value.
    Share,
}

/// A row of the summary.
struct SummaryMetric {
    name: &'static str,
    decimals: usize,
    change: SummaryChange,
    of: fn(&StreamMetrics) -> Option<f64>,
}

const fn metric(
    name: &'static str,
    decimals: usize,
    change: SummaryChange,
    of: fn(&StreamMetrics) -> Option<f64>,
) -> SummaryMetric {
    SummaryMetric { name, decimals, change, of }
}

fn of(statistics: Option<ErrorStatistics>, value: fn(&ErrorStatistics) -> f64) -> Option<f64> {
    statistics.as_ref().map(value)
}

/// Rows of the paper's Table 1, then further metrics.
const METRICS: [SummaryMetric; 20] = [
    metric("PU (%)", 2, SummaryChange::Points, |score| score.pu_percent),
    metric("mean ePos (m)", 3, SummaryChange::Share, |score| of(score.epos, |error| error.mean_m)),
    metric("SEM ePos (m)", 3, SummaryChange::Share, |score| of(score.epos, |error| error.sem_m)),
    metric("mean ePosH (m)", 3, SummaryChange::Share, |score| of(score.eposh, |error| error.mean_m)),
    metric("SEM ePosH (m)", 3, SummaryChange::Share, |score| of(score.eposh, |error| error.sem_m)),
    metric("mean ePosV (m)", 3, SummaryChange::Share, |score| of(score.eposv, |error| error.mean_m)),
    metric("SEM ePosV (m)", 3, SummaryChange::Share, |score| of(score.eposv, |error| error.sem_m)),
    metric("median ePos (m)", 3, SummaryChange::Share, |score| of(score.epos, |error| error.p50_m)),
    metric("P95 ePos (m)", 3, SummaryChange::Share, |score| of(score.epos, |error| error.p95_m)),
    metric("median ePosH (m)", 3, SummaryChange::Share, |score| of(score.eposh, |error| error.p50_m)),
    metric("P95 ePosH (m)", 3, SummaryChange::Share, |score| of(score.eposh, |error| error.p95_m)),
    metric("median ePosV (m)", 3, SummaryChange::Share, |score| of(score.eposv, |error| error.p50_m)),
    metric("P95 ePosV (m)", 3, SummaryChange::Share, |score| of(score.eposv, |error| error.p95_m)),
    metric("mean ePos, covered (m)", 3, SummaryChange::Share, |score| {
        of(score.epos_covered, |error| error.mean_m)
    }),
    metric("mean ePos, in gaps (m)", 3, SummaryChange::Share, |score| {
        of(score.epos_gap, |error| error.mean_m)
    }),
    metric("precision of fusion (%)", 2, SummaryChange::Points, |score| {
        score.precision.map(|share| 100.0 * share)
    }),
    metric("recall of fusion (%)", 2, SummaryChange::Points, |score| score.recall.map(|share| 100.0 * share)),
    metric("ID changes (1/min)", 3, SummaryChange::Share, |score| score.id_changes),
    metric("false tracks (s/min)", 2, SummaryChange::Share, |score| score.false_track_s),
    metric("GOSPA (m)", 3, SummaryChange::Share, |score| score.gospa_m),
];

const NOTES: &str = "PU: slots with a point of the drone, of all slots. ePos: distance in space from the drone’s true \
    place, ePosH its horizontal part, ePosV its vertical part. SEM: standard error of the mean. P95: 95th percentile. Covered: in slots where \
    the drone’s transponder tells a place; in gaps: in the others. Precision: fused points whose track and transponder \
    belong to one drone; recall: slots with such a point, of those where both are present. Change: from the radar alone \
    to the output, positive where the output is better: in percentage points where more is better, else as a share of \
    the radar’s value.";

/// HTML page with a summary, the figures, and a table of the drones.
pub fn page(title: &str, evaluation: &Evaluation, figures: &[Figure]) -> String {
    let title = escape(title);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n<p>{}</p>\n",
        extent(evaluation)
    );
    summary(&mut html, "All drones", evaluation, |scored| &scored.all);
    let is_carried = |carried| evaluation.drones.iter().any(|drone| drone.equipped == Some(carried));
    if is_carried(true) && is_carried(false) {
        summary(&mut html, "Drones with a transponder", evaluation, |scored| &scored.equipped);
        summary(&mut html, "Drones without a transponder", evaluation, |scored| &scored.unequipped);
    }
    let _ = writeln!(html, "<p class=\"notes\">{NOTES}</p>");
    if !figures.is_empty() {
        html.push_str("<h2>Figures</h2>\n");
    }
    for (number, figure) in figures.iter().enumerate() {
        let (title, caption) = (escape(&figure.title), escape(&figure.caption));
        let _ = writeln!(
            html,
            "<figure id=\"{}\">\n{}<figcaption><b>Figure {}. {title}.</b> {caption}</figcaption>\n</figure>",
            figure.name,
            figure.svg,
            number + 1
        );
    }
    per_drone(&mut html, evaluation);
    html.push_str("</main>\n</body>\n</html>\n");
    html
}

/// Sentence about the extent of the evaluation.
fn extent(evaluation: &Evaluation) -> String {
    let Evaluation { drones, fused, radar, transponder } = evaluation;
    let points = |scored: &ScoredStream, what: &str| format!("{} {what}", counted(scored.samples.len()));
    let mut parts = vec![points(fused, "points of the output")];
    parts.extend(radar.as_ref().map(|radar| points(radar, "radar plots")));
    parts.extend(transponder.as_ref().map(|transponder| points(transponder, "transponder positions")));
    let times = || fused.samples.iter().map(|sample| sample.time);
    let span = times().min().zip(times().max());
    let span =
        span.map_or_else(String::new, |(first, last)| format!(", {} to {} UTC", moment(first), moment(last)));
    let noun = if drones.len() == 1 { "drone" } else { "drones" };
    format!("{} {noun}; {}{span}.", counted(drones.len()), parts.join(", "))
}

/// Scores of a group of drones in all streams; metrics without a value in any stream are omitted.
fn summary(
    html: &mut String,
    heading: &str,
    evaluation: &Evaluation,
    part: fn(&ScoredStream) -> &StreamMetrics,
) {
    let columns = [
        Some(part(&evaluation.fused)),
        evaluation.radar.as_ref().map(part),
        evaluation.transponder.as_ref().map(part),
    ];
    let _ = write!(
        html,
        "<h2>{heading}</h2>\n<table>\n<thead><tr><th>Metric</th><th>Fused</th><th>Radar</th><th>Transponder</th>\
         <th>Change</th></tr></thead>\n<tbody>\n"
    );
    let mut any = false;
    for metric in &METRICS {
        let values = columns.map(|score| score.and_then(metric.of).filter(|value| value.is_finite()));
        if values.iter().all(Option::is_none) {
            continue;
        }
        any = true;
        let [fused, radar, transponder] = values.map(|value| number(value, metric.decimals));
        let change = change(metric.change, values[0], values[1]);
        let name = metric.name;
        let _ = writeln!(
            html,
            "<tr><th>{name}</th><td>{fused}</td><td>{radar}</td><td>{transponder}</td><td>{change}</td></tr>"
        );
    }
    if !any {
        html.push_str(
            "<tr><td colspan=\"5\">Nothing can be told: no point and no true path of a drone.</td></tr>\n",
        );
    }
    html.push_str("</tbody>\n</table>\n");
}

fn per_drone(html: &mut String, evaluation: &Evaluation) {
    if evaluation.drones.is_empty() {
        return;
    }
    html.push_str(
        "<h2>Each drone</h2>\n<table class=\"drones\">\n<thead>\n<tr><th rowspan=\"2\">Drone</th>\
         <th rowspan=\"2\">Tran&#173;sponder</th><th colspan=\"3\">PU (%)</th><th colspan=\"3\">Mean ePos (m)</th>\
         <th rowspan=\"2\">Change</th><th rowspan=\"2\">P95 ePos, fused (m)</th>\
         <th rowspan=\"2\">ID changes (1/min)</th></tr>\n\
         <tr><th>Fused</th><th>Radar</th><th>Transp.</th><th>Fused</th><th>Radar</th><th>Transp.</th></tr>\n\
         </thead>\n<tbody>\n",
    );
    let streams = [Some(&evaluation.fused), evaluation.radar.as_ref(), evaluation.transponder.as_ref()];
    for (index, drone) in evaluation.drones.iter().enumerate() {
        let scores = streams.map(|scored| scored.and_then(|scored| scored.drones.get(index)));
        let pu = scores.map(|score| number(score.and_then(|score| score.pu_percent), 1));
        let mean = scores.map(|score| score.and_then(|score| of(score.epos, |error| error.mean_m)));
        let p95 = scores[0].and_then(|score| of(score.epos, |error| error.p95_m));
        let mut cells = pu.to_vec();
        cells.extend(mean.map(|mean| number(mean, 2)));
        cells.push(change(SummaryChange::Share, mean[0], mean[1]));
        cells.push(number(p95, 2));
        cells.push(number(scores[0].and_then(|score| score.id_changes), 2));
        let equipped = drone.equipped.map_or(NONE, |equipped| if equipped { "yes" } else { "no" });
        // `bdi`: an id may contain characters that change the text direction.
        let _ = write!(html, "<tr><th><bdi>{}</bdi></th><td>{equipped}</td>", escape(&drone.id));
        for cell in cells {
            let _ = write!(html, "<td>{cell}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table>\n");
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.filter(|value| value.is_finite()).map_or_else(|| NONE.to_owned(), |value| decimal(value, decimals))
}

/// Improvement of the output over the radar alone.
fn change(change: SummaryChange, fused: Option<f64>, radar: Option<f64>) -> String {
    let Some((fused, radar)) = fused.zip(radar) else { return NONE.to_owned() };
    let (better, unit) = match change {
        SummaryChange::Points => (fused - radar, " points"),
        SummaryChange::Share => (100.0 * (radar - fused) / radar, " %"),
    };
    if !better.is_finite() {
        return NONE.to_owned();
    }
    let sign = if better > 0.0 { "+" } else { "" };
    format!("{sign}{}{unit}", decimal(better, if change == SummaryChange::Points { 2 } else { 1 }))
}
