//! The closest encounter: time to the closest point of approach and distance there, over time, after figure 15 of G.
//! Fasano et al., *Radar/electro-optical data fusion for non-cooperative UAS sense and avoid*.

use super::super::types::PointSource;
use super::super::{ClosestApproach, Encounter, PredictedApproach};
use super::axis::{PlotAxis, decimal, drawable};
use super::chart::Chart;
use super::figure::{Figure, caption, moment};
use super::style::{Marker, Style};

const NAME: &str = "conflicts";
const TITLE: &str = "Closest point of approach, stated and true";
/// Size of each of the two charts, pixels.
const SIZE: (f64, f64) = (600.0, 210.0);
/// Maximum time between predictions that are joined by a line, seconds; predictions come once per second.
const APART_S: f64 = 1.5;
/// Half width of the band, in standard deviations.
const SIGMAS: f64 = 2.0;

/// Width of a line, pixels.
const WIDTH: f64 = 1.6;
/// Width of the band in the legend, pixels.
const BAND_KEY: f64 = 9.0;
/// Free space above the highest value, as a share of it.
const FREE: f64 = 0.05;

const TRUE: Style = Style { marker: Marker::Cross, colour: "#8a5600", line_colour: "#8a5600", dash: "7 3" };
const STATED: Style = Style::of(PointSource::Fused);
const BAND: Style = Style { marker: Marker::Dot, colour: "#c9d8ee", line_colour: "#c9d8ee", dash: "" };

/// Figure of the flight's closest encounter. It says so if there is no encounter, or no prediction of it.
pub fn encounter(encounter: Option<&Encounter>) -> Figure {
    let Some(encounter) = encounter else {
        let note = "no two drones with a transponder flew at one time";
        let axis = |label: &str| PlotAxis::linear(label, 0.0, 1.0);
        let empty = Chart::new(axis("Time (s)"), axis("Distance (m)"), SIZE);
        return empty.finish(NAME, TITLE, format!("There is nothing to show: {note}."), Some(note));
    };
    let Encounter { ids: [a, b], distance_m, ground_m, foreseen, .. } = encounter;
    let note = foreseen.is_empty().then(|| format!("nothing was foreseen of {a} and {b}"));
    let how = match &note {
        Some(note) => format!("True states alone: {note}."),
        None => "Nothing is stated where one of both was not in the picture, or a conflict less likely than 1 %. Band: 2 \
                 sigma of the stated distance."
            .to_owned(),
    };
    let text = caption(&[
        format!(
            "Over ground, as if both flew straight on. {a} and {b} came closest of all drones with a transponder:"
        ),
        format!("{} m, over ground {} m.", decimal(*distance_m, 1), decimal(*ground_m, 1)),
        how,
    ]);
    let mut times = chart(encounter, "Time to closest approach (s)", |approach| approach.t_cpa_s, None);
    times.key_line(&TRUE, WIDTH, false, "by the true states");
    if note.is_none() {
        times.key_line(&STATED, WIDTH, false, "as stated");
        times.key_line(&BAND, BAND_KEY, false, "2 sigma of the stated distance");
    }
    let distances =
        chart(encounter, "Distance at closest approach (m)", |approach| approach.d_cpa_m, Some(SIGMAS));
    Chart::stacked(NAME, TITLE, text, &[(times, None), (distances, note.as_deref())])
}

/// Chart of one value of the outlooks over time. With `sigmas`, predictions have a band of that number of standard
/// deviations.
fn chart(
    encounter: &Encounter,
    label: &str,
    value: fn(&ClosestApproach) -> f64,
    sigmas: Option<f64>,
) -> Chart {
    let Encounter { time, truth, foreseen, .. } = encounter;
    let point = |approach: &ClosestApproach| (approach.time.seconds_since(*time), value(approach));
    let of_truth: Vec<_> = truth.iter().map(point).filter(|(_, y)| drawable(*y)).collect();
    let stated: Vec<_> = foreseen
        .iter()
        .map(|PredictedApproach { approach, sigma_m }| (point(approach), sigmas.unwrap_or(0.0) * sigma_m))
        .filter(|((_, y), half)| drawable(*y) && drawable(*half))
        .collect();
    let xs = || of_truth.iter().map(|(x, _)| *x);
    let (first, last) = (xs().fold(0.0, f64::min), xs().fold(0.0, f64::max));
    let lines = of_truth.iter().copied().chain(stated.iter().map(|&((x, y), half)| (x, y + half)));
    let highest = lines.map(|(_, y)| y).fold(1.0, f64::max);
    let x = PlotAxis::linear(format!("Time since they were closest, {} UTC (s)", moment(*time)), first, last);
    let mut chart = Chart::new(x, PlotAxis::linear(label, 0.0, highest * (1.0 + FREE)), SIZE);
    let runs: Vec<&[((f64, f64), f64)]> =
        stated.chunk_by(|(one, _), (next, _)| next.0 - one.0 <= APART_S).collect();
    for run in runs.iter().filter(|_| sigmas.is_some()) {
        // A distance is never negative.
        let band: Vec<_> = run.iter().map(|&((x, y), half)| (x, (y - half).max(0.0), y + half)).collect();
        chart.band(BAND.colour, &band);
    }
    chart.lines(&TRUE, &[of_truth], false);
    let lines: Vec<Vec<_>> = runs.iter().map(|run| run.iter().map(|(point, _)| *point).collect()).collect();
    chart.lines(&STATED, &lines, false);
    chart.points(&STATED, &lines.concat());
    chart
}
