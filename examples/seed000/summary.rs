//! Table 2 over many encounters, and its requirements.

use std::ops::RangeInclusive;

use crate::encounter::SimulatedEncounter;
use crate::experiment::{ExperimentRequirement, mean, quantile, runs, said};
use crate::sensors::{CAMERA_BIAS, RADAR_BIAS, SensorDetection};
use crate::tracking::{EncounterErrors, EncounterRun};
use tracker::wrapped;

/// Columns of Table 2.
const COLUMNS: [&str; 6] = ["range", "azimuth", "elevation", "range rate", "azimuth rate", "elevation rate"];
const TRACKERS: [&str; 2] = ["radar alone", "radar and camera"];
/// Table 2: standard deviations and means of both trackers' errors; metres, degrees, seconds.
const PAPER_STD: [[f64; 6]; 2] = [[3.9, 0.88, 0.92, 1.6, 0.29, 0.26], [3.6, 0.31, 0.26, 1.6, 0.099, 0.092]];
const PAPER_MEAN: [[f64; 6]; 2] =
    [[3.8, -2.3, -0.52, -0.064, 0.037, -0.035], [3.6, -2.2, -0.60, 0.41, 0.029, -0.035]];
/// Section 4.3: rms error of the time to the closest point, seconds.
const PAPER_TIME_S: [f64; 2] = [0.41, 0.34];

/// Permitted ratio of the medians to the paper's values.
const MEDIAN_WITHIN: RangeInclusive<f64> = 0.6..=1.5;
/// Permitted ratio of the angular rate errors, radar and camera to radar alone (paper: 0.34 and 0.35).
const RATIO_WITHIN: RangeInclusive<f64> = 0.25..=0.45;
/// Maximum distance of the means from the sensors' biases: range, azimuth, elevation, and of the rates from zero.
const MEAN_WITHIN: [f64; 6] = [3.0, 0.2, 0.2, 0.5, 0.05, 0.05];

pub struct EncounterSummary {
    pub encounter: SimulatedEncounter,
    pub first_seed: u64,
    /// Errors of each run: radar alone, radar and camera.
    pub errors: Vec<[EncounterErrors; 2]>,
    /// Errors of all detections of the intruder: range, azimuth and elevation of the radar; azimuth and elevation of
    /// the camera.
    radar: [Vec<f64>; 3],
    camera: [Vec<f64>; 2],
}

impl EncounterSummary {
    pub fn measure(first_seed: u64, count: u64) -> Self {
        let encounter = SimulatedEncounter::fly();
        let all = runs(first_seed, count, |seed| {
            let run = EncounterRun::fly(&encounter, seed);
            ([0, 1].map(|tracker| run.errors(&encounter, tracker)), run.detections)
        });
        let mut summary = Self {
            errors: all.iter().map(|(errors, _)| *errors).collect(),
            first_seed,
            radar: Default::default(),
            camera: Default::default(),
            encounter,
        };
        for SensorDetection { at, range, angles, is_true, .. } in
            all.into_iter().flat_map(|(_, detections)| detections)
        {
            let truth = summary.encounter.relative(at);
            if !is_true || truth.range < crate::tracking::NEAR_M {
                continue;
            }
            let off = [truth.azimuth, truth.elevation];
            let off = [0, 1].map(|axis| wrapped(angles[axis] - off[axis]).to_degrees());
            match range {
                Some(range) => {
                    let off = [range - truth.range, off[0], off[1]];
                    summary.radar.iter_mut().zip(off).for_each(|(all, off)| all.push(off));
                }
                None => summary.camera.iter_mut().zip(off).for_each(|(all, off)| all.push(off)),
            }
        }
        summary
    }

    fn of(&self, tracker: usize, value: impl Fn(&EncounterErrors) -> f64) -> Vec<f64> {
        self.errors.iter().map(|errors| value(&errors[tracker])).collect()
    }

    fn std(&self, tracker: usize, column: usize) -> Vec<f64> {
        self.of(tracker, |errors| errors.std[column])
    }

    /// Table 2 with our values.
    pub fn table(&self) -> String {
        let mut table = "| | range (m) | azimuth (°) | elevation (°) | range rate (m/s) | azimuth rate (°/s) | elevation rate (°/s) |\n|---|---|---|---|---|---|---|\n".to_owned();
        let mut row = |name: String, cells: Vec<String>| {
            table.push_str(&format!("| {name} | {} |\n", cells.join(" | ")));
        };
        let sensors: [(&str, &[Vec<f64>], usize); 2] =
            [("radar", &self.radar, 0), ("camera", &self.camera, 1)];
        for (name, errors, before) in sensors {
            let mut cells = vec!["–".to_owned(); 6];
            for (column, errors) in errors.iter().enumerate() {
                let middle = mean(errors);
                let off: Vec<f64> = errors.iter().map(|error| error - middle).collect();
                cells[before + column] = format!("{} ± {}", said(middle), said(crate::experiment::rms(&off)));
            }
            row(format!("{name}, detections: mean ± deviation"), cells);
        }
        for (tracker, name) in TRACKERS.into_iter().enumerate() {
            row(format!("{name}: deviation, paper"), PAPER_STD[tracker].map(said).to_vec());
            let banded = |column| {
                let all = self.std(tracker, column);
                let [low, middle, high] = [0.05, 0.5, 0.95].map(|share| said(quantile(&all, share)));
                format!("{middle} ({low}–{high})")
            };
            row(format!("{name}: deviation, here"), (0..6).map(banded).collect());
        }
        for (tracker, name) in TRACKERS.into_iter().enumerate() {
            row(format!("{name}: mean, paper"), PAPER_MEAN[tracker].map(said).to_vec());
            let banded = |column: usize| {
                let all = self.of(tracker, |errors| errors.mean[column]);
                let [low, high] = [0.05, 0.95].map(|share| said(quantile(&all, share)));
                format!("{} ({low} to {high})", said(mean(&all)))
            };
            row(format!("{name}: mean, here"), (0..6).map(banded).collect());
        }
        table
    }

    /// Errors of the time to the closest point.
    pub fn times(&self) -> String {
        let said_of = |tracker: usize| {
            let all = self.of(tracker, |errors| errors.time_s);
            let [low, middle, high] = [0.05, 0.5, 0.95].map(|share| said(quantile(&all, share)));
            format!("| {} | {} | {middle} ({low}–{high}) |\n", TRACKERS[tracker], PAPER_TIME_S[tracker])
        };
        format!("| | paper (s) | here (s) |\n|---|---|---|\n{}{}", said_of(0), said_of(1))
    }

    pub fn requirements(&self) -> Vec<ExperimentRequirement> {
        let mut requirements = Vec::new();
        for (tracker, name) in TRACKERS.into_iter().enumerate() {
            for (column, quantity) in COLUMNS.into_iter().enumerate() {
                let (all, paper) = (self.std(tracker, column), PAPER_STD[tracker][column]);
                let [low, high] = [0.05, 0.95].map(|share| quantile(&all, share));
                requirements.push(ExperimentRequirement {
                    what: format!("{name}, {quantity}: paper within 5–95 %"),
                    required: said(paper),
                    measured: format!("{}–{}", said(low), said(high)),
                    met: (low..=high).contains(&paper),
                });
                let multiple = quantile(&all, 0.5) / paper;
                let what = format!("{name}, {quantity}: median / paper");
                requirements.push(ExperimentRequirement::within(what, multiple, MEDIAN_WITHIN));
            }
        }
        for column in [4, 5] {
            let ratio = quantile(&self.std(1, column), 0.5) / quantile(&self.std(0, column), 0.5);
            let what = format!("{}: median with / without camera", COLUMNS[column]);
            requirements.push(ExperimentRequirement::within(what, ratio, RATIO_WITHIN));
        }
        for (tracker, name) in TRACKERS.into_iter().enumerate() {
            let mut bias = [RADAR_BIAS[0], RADAR_BIAS[1], RADAR_BIAS[2], 0.0, 0.0, 0.0];
            if tracker == 1 {
                bias[1..3].copy_from_slice(&CAMERA_BIAS);
            }
            for (column, quantity) in COLUMNS.into_iter().enumerate() {
                let middle = mean(&self.of(tracker, |errors| errors.mean[column]));
                let (low, high) = (bias[column] - MEAN_WITHIN[column], bias[column] + MEAN_WITHIN[column]);
                requirements.push(ExperimentRequirement::within(
                    format!("{name}, {quantity}: mean"),
                    middle,
                    low..=high,
                ));
            }
            let middle = quantile(&self.of(tracker, |errors| errors.time_s), 0.5);
            let what = format!("{name}: rms time error, median (s)");
            let paper = PAPER_TIME_S[tracker];
            requirements.push(ExperimentRequirement::within(what, middle, paper / 2.0..=paper * 2.0));
        }
        requirements
    }
}
