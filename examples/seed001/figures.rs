//! The paper's Figures 3 to 6, for one flight each, and the errors over time of all flights.

use utm_fusion::evaluate::plot::Figure;
use utm_fusion::evaluate::plot::curves::{CurveStyle, Panel, PlotCurve, from_above, panels};

use crate::scenario::{INTRUDERS, observer};
use crate::sensors::CONFIGURATIONS;
use crate::summary::TurnSummary;
use crate::tracking::{TrackerModels, track};

const TRACKED: [(&str, &str); 3] = [
    ("seed001-radar", "Radar alone (Figure 4)"),
    ("seed001-iff-eo", "IFF and EO/IR (Figure 5)"),
    ("seed001-radar-eo", "Radar and EO/IR (Figure 6)"),
];
const LOOKS: [(&str, CurveStyle); 3] = [
    ("1: radar", CurveStyle::Second),
    ("2: IFF and EO/IR", CurveStyle::Third),
    ("3: radar and EO/IR", CurveStyle::First),
];

pub fn figures(summary: &TurnSummary) -> Vec<Figure> {
    let scenario = from_above(
        "seed001-scenario",
        "The scenario (Figure 3)",
        "The own ship flies north, both intruders south; each turns left half way.",
        &flown(),
    );
    let caption = format!("The flight of seed {}.", summary.first_seed);
    let tracked = CONFIGURATIONS.iter().zip(TRACKED).map(|(sensors, (name, title))| {
        let mut curves = flown();
        for intruder in &INTRUDERS {
            let samples =
                track(intruder, &sensors.readings(intruder, summary.first_seed), TrackerModels::Seven);
            let points =
                samples.iter().map(|sample| (sample.position.x / 1000.0, sample.position.y / 1000.0));
            curves.push(PlotCurve { name: "track", look: CurveStyle::First, points: points.collect() });
        }
        from_above(name, title, &caption, &curves)
    });
    let errors = |intruder: usize, label: &'static str| Panel {
        label,
        curves: LOOKS
            .into_iter()
            .enumerate()
            .map(|(configuration, (name, look))| {
                let points = summary.over_time(intruder, configuration);
                PlotCurve { name, look, points }
            })
            .collect(),
        between: None,
    };
    let errors = panels(
        "seed001-errors",
        "Position errors over time",
        &format!("Root mean square over {} flights.", summary.runs),
        "Time since the first detection (s)",
        &[errors(0, "Intruder 1: error (m)"), errors(1, "Intruder 2: error (m)")],
    );
    std::iter::once(scenario).chain(tracked).chain([errors]).collect()
}

/// True paths, kilometres.
fn flown() -> Vec<PlotCurve> {
    let steps = |end: f64| (0..=200).map(move |step| end * f64::from(step) / 200.0);
    let mut curves = vec![PlotCurve {
        name: "own ship",
        look: CurveStyle::Third,
        points: steps(INTRUDERS[0].end_s())
            .map(|at| observer(at).position)
            .map(|place| (place.east() / 1000.0, place.north() / 1000.0))
            .collect(),
    }];
    curves.extend(INTRUDERS.iter().map(|intruder| {
        PlotCurve {
            name: "intruders",
            look: CurveStyle::Truth,
            points: steps(intruder.end_s())
                .map(|at| intruder.at(at).0)
                .map(|place| (place.x / 1000.0, place.y / 1000.0))
                .collect(),
        }
    }));
    curves
}
