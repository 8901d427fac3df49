//! The paper's Figures 9 to 15, for one encounter.

use utm_fusion::evaluate::plot::Figure;
use utm_fusion::evaluate::plot::curves::{CurveStyle, Panel, PlotCurve, panels};

use crate::approach::error_of_both;
use crate::encounter::{RelativeGeometry, SimulatedEncounter};
use crate::sensors::SensorDetection;
use crate::tracking::{EncounterRun, NEAR_M, TrackerOutput, reference};

const ACROSS: &str = "Time to the closest point of approach (s)";
const TRACKERS: [(&str, CurveStyle); 2] =
    [("radar-only tracker", CurveStyle::Second), ("multi-sensor tracker", CurveStyle::First)];
/// Root mean square errors of the angular rates in Table 2, degrees per second: azimuth and elevation, of each tracker.
const RATE_ERRORS_DEG: [[f64; 2]; 2] = [[0.29, 0.26], [0.099, 0.092]];

/// A column of Table 2 as a figure.
struct TableFigure {
    name: &'static str,
    title: &'static str,
    labels: [&'static str; 2],
    /// Half height of the frame of errors.
    error: f64,
    /// Value of the column in a detection: of the radar, of the camera.
    detected: Option<fn(&SensorDetection) -> Option<f64>>,
}

const COLUMNS: [TableFigure; 6] = [
    TableFigure {
        name: "seed000-range",
        title: "Range and its error (Figure 9)",
        labels: ["Range (m)", "Error (m)"],
        error: 20.0,
        detected: Some(|detection| detection.range),
    },
    TableFigure {
        name: "seed000-azimuth",
        title: "Azimuth and its error (Figure 10)",
        labels: ["Azimuth (°)", "Error (°)"],
        error: 6.0,
        detected: Some(|detection| Some(detection.angles[0].to_degrees())),
    },
    TableFigure {
        name: "seed000-elevation",
        title: "Elevation and its error (Figure 11)",
        labels: ["Elevation (°)", "Error (°)"],
        error: 5.0,
        detected: Some(|detection| Some(detection.angles[1].to_degrees())),
    },
    TableFigure {
        name: "seed000-range-rate",
        title: "Range rate and its error (Figure 12)",
        labels: ["Range rate (m/s)", "Error (m/s)"],
        error: 10.0,
        detected: None,
    },
    TableFigure {
        name: "seed000-azimuth-rate",
        title: "Azimuth rate and its error (Figure 13)",
        labels: ["Azimuth rate (°/s)", "Error (°/s)"],
        error: 1.5,
        detected: None,
    },
    TableFigure {
        name: "seed000-elevation-rate",
        title: "Elevation rate and its error (Figure 14)",
        labels: ["Elevation rate (°/s)", "Error (°/s)"],
        error: 1.5,
        detected: None,
    },
];

/// Figures of the encounter with this seed.
pub fn figures(encounter: &SimulatedEncounter, seed: u64) -> Vec<Figure> {
    let run = EncounterRun::fly(encounter, seed);
    let caption = format!("The encounter of seed {seed}, to 350 m.");
    let columns = COLUMNS.iter().enumerate().map(|(index, column)| {
        let panels_of = [value(encounter, &run, index, column), error(encounter, &run, index, column)];
        panels(column.name, column.title, &caption, ACROSS, &panels_of)
    });
    columns.chain([closest(encounter, &run)]).collect()
}

/// Outputs of a tracker, up to the end of the statistics.
fn counted<'a>(
    encounter: &SimulatedEncounter,
    outputs: &'a [TrackerOutput],
) -> impl Iterator<Item = &'a TrackerOutput> {
    let end = encounter.when_apart(NEAR_M);
    outputs.iter().filter(move |output| output.at < end)
}

/// Detections of a sensor in a column, with the true values.
fn detected(
    encounter: &SimulatedEncounter,
    run: &EncounterRun,
    index: usize,
    column: &TableFigure,
    radar: bool,
) -> Vec<(f64, f64, f64)> {
    let Some(detected) = column.detected else { return Vec::new() };
    let end = encounter.when_apart(NEAR_M);
    let of =
        run.detections.iter().filter(|detection| detection.range.is_some() == radar && detection.at < end);
    of.filter_map(|detection| {
        Some((detection.at, detected(detection)?, encounter.relative(detection.at).columns()[index]))
    })
    .collect()
}

fn value(encounter: &SimulatedEncounter, run: &EncounterRun, index: usize, column: &TableFigure) -> Panel {
    let points = |radar, name, look| PlotCurve {
        name,
        look,
        points: detected(encounter, run, index, column, radar)
            .iter()
            .map(|(at, value, _)| (*at, *value))
            .collect(),
    };
    let mut curves = vec![
        points(true, "radar", CurveStyle::SecondPoints),
        points(false, "camera", CurveStyle::FirstPoints),
    ];
    curves.retain(|curve| !curve.points.is_empty());
    let truth = counted(encounter, &run.outputs[0]);
    curves.push(PlotCurve {
        name: "true",
        look: CurveStyle::Truth,
        points: truth.map(|output| (output.at, encounter.relative(output.at).columns()[index])).collect(),
    });
    for ((name, look), outputs) in TRACKERS.into_iter().zip(&run.outputs) {
        let outputs = counted(encounter, outputs);
        curves.push(PlotCurve {
            name,
            look,
            points: outputs.map(|output| (output.at, output.relative.columns()[index])).collect(),
        });
    }
    Panel { label: column.labels[0], curves, between: None }
}

fn error(encounter: &SimulatedEncounter, run: &EncounterRun, index: usize, column: &TableFigure) -> Panel {
    let points = |radar, name, look| PlotCurve {
        name,
        look,
        points: detected(encounter, run, index, column, radar)
            .iter()
            .map(|(at, value, truth)| (*at, value - truth))
            .collect(),
    };
    let mut curves = vec![
        points(true, "radar", CurveStyle::SecondPoints),
        points(false, "camera", CurveStyle::FirstPoints),
    ];
    curves.retain(|curve| !curve.points.is_empty());
    for ((name, look), outputs) in TRACKERS.into_iter().zip(&run.outputs) {
        let outputs = counted(encounter, outputs);
        let off = |output: &TrackerOutput| {
            let truth: RelativeGeometry = encounter.relative(output.at);
            (output.at, output.relative.errors(&truth)[index])
        };
        curves.push(PlotCurve { name, look, points: outputs.map(off).collect() });
    }
    Panel { label: column.labels[1], curves, between: Some((-column.error, column.error)) }
}

/// Figure 15: time to the closest point and distance there, with the envelopes of equation 7.
fn closest(encounter: &SimulatedEncounter, run: &EncounterRun) -> Figure {
    let truth: Vec<(f64, (f64, f64))> = counted(encounter, &run.outputs[0])
        .map(|output| (output.at, reference(encounter, output.at)))
        .collect();
    let true_curve = |of: fn(&(f64, f64)) -> f64| PlotCurve {
        name: "true",
        look: CurveStyle::Truth,
        points: truth.iter().map(|(at, closest)| (*at, of(closest))).collect(),
    };
    let of_tracker = |of: fn(&(f64, f64)) -> f64| {
        TRACKERS.into_iter().zip(&run.outputs).map(move |((name, look), outputs)| PlotCurve {
            name,
            look,
            points: counted(encounter, outputs).map(|output| (output.at, of(&output.closest))).collect(),
        })
    };
    let mut miss: Vec<PlotCurve> = Vec::new();
    let bounds = [
        ("bounds of the radar-only tracker", CurveStyle::SecondBound),
        ("bounds of the multi-sensor tracker", CurveStyle::FirstBound),
    ];
    for ((name, look), rates) in bounds.into_iter().zip(RATE_ERRORS_DEG) {
        for sign in [-1.0, 1.0] {
            let bound = |(at, (_, distance)): &(f64, (f64, f64))| {
                let relative = encounter.relative(*at);
                let off = error_of_both(relative.range, relative.range_rate, rates.map(f64::to_radians));
                (*at, (distance + sign * off).max(0.0))
            };
            miss.push(PlotCurve { name, look, points: truth.iter().map(bound).collect() });
        }
    }
    miss.push(true_curve(|closest| closest.1));
    miss.extend(of_tracker(|closest| closest.1));
    let time =
        std::iter::once(true_curve(|closest| closest.0)).chain(of_tracker(|closest| closest.0)).collect();
    panels(
        "seed000-closest",
        "Time and distance of the closest point of approach (Figure 15)",
        "The distance with the envelopes of equation 7, by the rates' errors of Table 2, about what is true.",
        ACROSS,
        &[
            Panel { label: "Time to it (s)", curves: time, between: None },
            Panel { label: "Distance at it (m)", curves: miss, between: Some((0.0, 900.0)) },
        ],
    )
}
