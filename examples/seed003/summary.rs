//! Results of all sessions, and their requirements.

use crate::cameras::{AircraftCamera, CAMERAS, PRECISION_M, UNCERTAINTY_M};
use crate::experiment::{ExperimentRequirement, quantile, rms, runs, said};
use crate::session::{PositionErrors, SessionErrors, session};

/// Numbers of measurements.
const COUNTS: [usize; 8] = [4, 8, 15, 30, 60, 120, 240, 480];
/// Number of measurements from which the exponent is fitted. With fewer, the places of the targets matter, too.
const FITTED_FROM: usize = 8;
/// Largest difference of the exponent from -0.5.
const EXPONENT_TOLERANCE: f64 = 0.03;
/// Share of the sessions, on either side, outside of which a published residual contradicts the experiment.
const TAIL: f64 = 0.025;
/// "Of the order of 0.1°": within a factor of √10.
const ORDER_DEG: [f64; 2] = [0.0316, 0.316];

/// Results of one camera.
struct CameraResult {
    camera: AircraftCamera,
    /// Sessions with the mean position uncertainty of the paper.
    sessions: Vec<SessionErrors>,
    /// Position uncertainties with which the published residual is the median, and at the ends of the central 95 %, metres.
    explained_m: [f64; 3],
    /// Sessions with the uncertainty that explains the residual.
    explained: Vec<SessionErrors>,
}

/// Root mean square errors of the calibration with a number of measurements.
struct CountResult {
    count: usize,
    axis_deg: f64,
    rotation_deg: f64,
    /// Error of the axis with an equal, constant error of the camera's position.
    axis_with_camera_deg: f64,
}

pub struct CalibrationSummary {
    results: Vec<CameraResult>,
    counts: Vec<CountResult>,
}

fn rms_of(sessions: &[SessionErrors], of: impl Fn(&SessionErrors) -> f64) -> f64 {
    rms(&sessions.iter().map(of).collect::<Vec<_>>())
}

fn residuals(sessions: &[SessionErrors]) -> Vec<f64> {
    sessions.iter().map(|session| session.residual_deg).collect()
}

impl CameraResult {
    fn measure(camera: AircraftCamera, first_seed: u64, count: u64) -> Self {
        let sessions = |target_m: f64| {
            let errors = PositionErrors { target_m, camera_m: 0.0 };
            runs(first_seed, count, |seed| session(&camera, camera.points, errors, seed))
        };
        // The residual grows with the uncertainty, so bisection finds it.
        let explained_m = [0.5, 1.0 - TAIL, TAIL].map(|share| {
            let (mut low, mut high) = (0.0, 4.0 * UNCERTAINTY_M);
            for _ in 0..12 {
                let middle = f64::midpoint(low, high);
                if quantile(&residuals(&sessions(middle)), share) < camera.residual_deg {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            low
        });
        let explained = sessions(explained_m[0]);
        Self { camera, sessions: sessions(UNCERTAINTY_M), explained_m, explained }
    }

    fn axis_deg(&self) -> f64 {
        rms_of(&self.explained, |session| session.axis_deg)
    }

    /// Share of the sessions with a residual below the published one.
    fn share_below(&self) -> f64 {
        let below = self.sessions.iter().filter(|session| session.residual_deg < self.camera.residual_deg);
        below.count() as f64 / self.sessions.len() as f64
    }
}

impl CountResult {
    fn measure(count: usize, first_seed: u64, sessions: u64) -> Self {
        let measured = |camera_m: f64| {
            let errors = PositionErrors { target_m: UNCERTAINTY_M, camera_m };
            runs(first_seed, sessions, |seed| session(&CAMERAS[0], count, errors, seed))
        };
        let (without, with) = (measured(0.0), measured(UNCERTAINTY_M));
        Self {
            count,
            axis_deg: rms_of(&without, |session| session.axis_deg),
            rotation_deg: rms_of(&without, |session| session.rotation_deg),
            axis_with_camera_deg: rms_of(&with, |session| session.axis_deg),
        }
    }
}

impl CalibrationSummary {
    pub fn measure(first_seed: u64, sessions: u64) -> Self {
        let result = |&camera: &AircraftCamera| CameraResult::measure(camera, first_seed, sessions);
        let count = |&count: &usize| CountResult::measure(count, first_seed, sessions);
        Self { results: CAMERAS.iter().map(result).collect(), counts: COUNTS.iter().map(count).collect() }
    }

    /// Table of the cameras.
    pub fn cameras(&self) -> String {
        let mut table = "| camera | points | paper's residual (°) | residual at 3.5 cm: median, central 95 % (°) | uncertainty that explains the paper's residual, central 95 % (cm) | error of the axis with it (°) |\n|---|---|---|---|---|---|\n".to_owned();
        for result in &self.results {
            let of = residuals(&result.sessions);
            let [low, median, high] = [TAIL, 0.5, 1.0 - TAIL].map(|share| said(quantile(&of, share)));
            let [explained, least, most] = result.explained_m.map(|m| said(100.0 * m));
            let AircraftCamera { name, points, residual_deg, .. } = result.camera;
            table.push_str(&format!(
                "| {name} | {points} | {residual_deg} | {median}, {low} to {high} | {explained}, {least} to {most} | {} |\n",
                said(result.axis_deg()),
            ));
        }
        table
    }

    /// Table of errors by number of measurements.
    pub fn counts(&self) -> String {
        let mut table = "| measurements N | error of the axis (°) | · √N | error of the rotation (°) | · √N | error of the axis, camera 3.5 cm off (°) |\n|---|---|---|---|---|---|\n".to_owned();
        for of in &self.counts {
            let root = (of.count as f64).sqrt();
            let cells = [
                of.axis_deg,
                of.axis_deg * root,
                of.rotation_deg,
                of.rotation_deg * root,
                of.axis_with_camera_deg,
            ]
            .map(said);
            table.push_str(&format!("| {} | {} |\n", of.count, cells.join(" | ")));
        }
        table
    }

    /// Ratio of the infrared camera's median residual to that of the panchromatic camera, at the same uncertainty.
    pub fn fewer(&self) -> String {
        let median = |result: &CameraResult| quantile(&residuals(&result.sessions), 0.5);
        said(median(&self.results[2]) / median(&self.results[0]))
    }

    /// Exponent of an error as a power of the number of measurements: least squares of the logarithms.
    fn exponent(&self, of: impl Fn(&CountResult) -> f64) -> f64 {
        let points: Vec<(f64, f64)> = (self.counts.iter())
            .filter(|result| result.count >= FITTED_FROM)
            .map(|result| ((result.count as f64).ln(), of(result).ln()))
            .collect();
        let count = points.len() as f64;
        let (x, y) =
            points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
        let (xy, xx) = points.iter().fold((0.0, 0.0), |(xy, xx), point| {
            (xy + (point.0 - x) * (point.1 - y), xx + (point.0 - x) * (point.0 - x))
        });
        xy / xx
    }

    pub fn requirements(&self) -> Vec<ExperimentRequirement> {
        let exponents = -0.5 - EXPONENT_TOLERANCE..=-0.5 + EXPONENT_TOLERANCE;
        let mut all = vec![
            ExperimentRequirement::within(
                "error of the axis: exponent of N",
                self.exponent(|result| result.axis_deg),
                exponents.clone(),
            ),
            ExperimentRequirement::within(
                "error of the rotation: exponent of N",
                self.exponent(|result| result.rotation_deg),
                exponents,
            ),
            ExperimentRequirement::within(
                "infrared: share of sessions at 3.5 cm with a smaller residual than the paper's",
                self.results[2].share_below(),
                TAIL..=1.0 - TAIL,
            ),
        ];
        for result in &self.results {
            let name = result.camera.name;
            if result.camera.points > 8 {
                all.push(ExperimentRequirement::within(
                    format!("{name}: uncertainty that explains the paper's residual (cm)"),
                    100.0 * result.explained_m[0],
                    100.0 * PRECISION_M..=100.0 * UNCERTAINTY_M,
                ));
            }
            all.push(ExperimentRequirement::within(
                format!("{name}: error of the axis, rms (°), of the order of 0.1"),
                result.axis_deg(),
                ORDER_DEG[0]..=ORDER_DEG[1],
            ));
        }
        all
    }
}
