//! `--alerts`: scores of what an operator is shown.

use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

use super::{Args, EvaluateInputs, files, integrity};
use crate::commands::table::TextTable;
use conflict::{TrafficKind, Volume};
use lab::evaluate::{AlertFlight, AlertLine, AlertScore, Scoring, score_alerts};
use site::areas::Areas;
use site::config::SensorKind;

/// Scores the alerts. `None` if a required input is missing; the command line requires it.
pub(super) fn scored(
    alerts: &[AlertLine],
    args: &Args,
    inputs: &EvaluateInputs,
    settings: &Scoring,
) -> Result<Option<AlertScore>, files::FileFailure> {
    let EvaluateInputs { config: Some(config), truth, labels: Some(labels), output, .. } = inputs else {
        return Ok(None);
    };
    let attacks =
        integrity::attack_file(args).as_deref().map(files::attacks).transpose()?.unwrap_or_default();
    let areas = Areas::load(&config.areas)?.alerts();
    let of_adsb = config.sensors.iter().filter(|sensor| matches!(sensor.kind, SensorKind::AdsB(_)));
    let receivers: BTreeSet<&str> = of_adsb.map(|sensor| sensor.id.as_str()).collect();
    let heard = labels.rows().iter().filter(|row| receivers.contains(row.sensor.as_str()));
    let crewed = heard.filter_map(|row| row.id.clone()).collect();
    let volumes = config.conflicts.rules().volumes;
    let between = |a: TrafficKind, b: TrafficKind| {
        let size = |volume: &Volume| (volume.horizontal_m, volume.vertical_m);
        volumes.iter().find(|volume| volume.is_between(a, b)).map(size)
    };
    Ok(Some(score_alerts(&AlertFlight {
        truth,
        labels,
        crewed: &crewed,
        output,
        alerts,
        attacks: &attacks,
        areas: (&areas, config.site.geoid_undulation_m.unwrap_or(0.0)),
        volumes: [
            between(TrafficKind::Drone, TrafficKind::Drone),
            between(TrafficKind::Drone, TrafficKind::Crewed),
        ],
        settings,
    })))
}

/// Section of the report.
pub(super) fn text(score: &AlertScore) -> Result<String, fmt::Error> {
    let mut text = String::new();
    let mut table = TextTable::new("lr", &["alerts", "reached"]);
    let mut row = |name: &str, value: String| table.row(vec![name.to_owned(), value]);
    row("items", score.items.to_string());
    row("items an hour", format!("{:.1}", score.items_per_h()));
    row("items in the first two minutes", score.items_first_2_min.to_string());
    row("critical items", score.critical.to_string());
    row("duplicates", score.duplicates.to_string());
    row("items without a cause", score.unfounded.to_string());
    row("critical items without a cause", score.unfounded_critical.to_string());
    for (kind, count) in &score.kinds {
        row(&format!("items of kind {kind}"), count.to_string());
    }
    writeln!(text, "{table}")?;
    let mut events = TextTable::new(
        "lrrrr",
        &["events to be raised", "number", "raised", "mean delay (s)", "longest (s)"],
    );
    for (kind, one) in &score.events {
        let delays = [one.mean_delay_s, one.longest_delay_s].map(seconds);
        let [mean, longest] = delays;
        events.row(vec![(*kind).to_owned(), one.events.to_string(), one.raised.to_string(), mean, longest]);
    }
    write!(text, "{events}")?;
    for missed in &score.missed {
        writeln!(
            text,
            "not raised: {} of {} from {} on",
            missed.kind,
            missed.aircraft.join(" and "),
            missed.begin
        )?;
    }
    for item in &score.questionable {
        let mut faults = Vec::new();
        faults.extend(item.is_duplicate.then_some("duplicate"));
        faults.extend(item.is_unfounded.then_some("without a cause"));
        let severity = if item.is_critical { "critical" } else { "warning" };
        writeln!(text, "{} ({severity}, {}): {}", item.id, faults.join(", "), item.text)?;
    }
    Ok(text)
}

fn seconds(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{seconds:.1}"))
}
