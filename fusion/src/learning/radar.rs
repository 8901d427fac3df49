//! Learning of one radar's errors from its tracks.

use serde::{Deserialize, Serialize};

use super::axis::{AXES, AxisSums, ErrorPrior, FittedErrors};
use super::model::AxisErrors;
use super::range_rate::RangeRateError;
use super::track::{FlightPhase, TrackEvidence, TrackLearning};
use super::velocity::{VelocitySums, VelocityVerdict};
use crate::filter::RadarErrors;
use crate::time::Time;

/// Time constant with which evidence is forgotten (to 1/e), seconds: one hour with evidence.
const MEMORY_S: f64 = 3600.0;
/// Maximum elapsed time counted between two pieces of evidence, seconds: pauses do not make evidence obsolete.
const SILENCE_S: f64 = 60.0;
/// Interval between two fits, seconds.
const FIT_EVERY_S: f64 = 5.0;

/// Uncertainty of a data sheet: standard deviations of the logarithms of bias, correlation time, noise.
const SHEET_UNSURE: [f64; 3] = [1.0, 0.7, 1.0];
/// Prior factor of the bias in turns, by axis, and the standard deviation of its logarithm. Drones on test ranges: 1.7
/// in azimuth.
const TURN_FACTORS: [(f64, f64); AXES] = [(1.0, 0.2), (1.7, 0.2), (1.0, 0.2)];
/// Prior share of turns in flight, and its weight in plots.
const TURNS: f64 = 0.3;
const TURNS_PLOTS: f64 = 400.0;
const MILLI: f64 = 1e-3;

/// A learnt value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntValue {
    /// The value.
    pub value: f64,
    /// Its standard deviation, in the same unit.
    pub deviation: f64,
}

/// The errors of one axis; range and height in metres, azimuth in radians.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntAxis {
    /// Standard deviation of the bias, averaged over straight flight and turns as flown.
    pub bias: LearntValue,
    /// Correlation time of the bias (to 1/e), seconds.
    pub correlation_s: LearntValue,
    /// Standard deviation of the white noise.
    pub noise: LearntValue,
    /// Ratio of the bias in turns to that in straight flight.
    pub turn_factor: LearntValue,
    /// Ratio of bias and noise together to those of the data sheet.
    pub of_data_sheet: LearntValue,
    /// Effective number of independent samples of the bias; older samples count in part.
    pub tracks: f64,
}

/// Learnt errors of a radar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntRadar {
    /// Slant range, metres.
    pub range_m: LearntAxis,
    /// Azimuth, radians.
    pub azimuth: LearntAxis,
    /// Height, metres.
    pub height_m: LearntAxis,
    /// Whether its velocities are usable.
    pub velocity: VelocityVerdict,
    /// Errors used instead of the data sheet's.
    pub errors: RadarErrors,
    /// Relative standard deviation of the biases over ground.
    pub unsure: f64,
}

/// Accumulated evidence of a radar's tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RadarLearning {
    pub(super) now: Time,
    pub(super) axes: [AxisSums; AXES],
    /// Number of plots in straight flight and in turns.
    pub(super) plots: [f64; 2],
    pub(super) velocity: VelocitySums,
    pub(super) fitted: Option<(Time, LearntRadar)>,
}

impl Default for RadarLearning {
    fn default() -> Self {
        Self {
            now: Time::from_nanos(i64::MIN),
            axes: [AxisSums::NONE; AXES],
            plots: [0.0; 2],
            velocity: VelocitySums::NONE,
            fitted: None,
        }
    }
}

impl RadarLearning {
    /// Adds the evidence of a track up to `time`.
    pub(crate) fn add_evidence(&mut self, track: &mut TrackLearning, time: Time) {
        self.advance(time);
        for evidence in track.take_evidence() {
            match evidence {
                TrackEvidence::Change(axis, change) => self.axes[axis].change(&change),
                TrackEvidence::Mean(axis, mean, flight) => {
                    self.axes[axis].mean(&mean, flight == FlightPhase::Turning);
                }
                TrackEvidence::Plot(flight) => self.plots[flight as usize] += 1.0,
                TrackEvidence::Velocity(off) => self.velocity.add(&off),
            }
        }
    }

    /// Adds an error of the reported range rate.
    pub(crate) fn take_rate(&mut self, off: &RangeRateError) {
        self.advance(off.time);
        self.velocity.add_rate(off);
    }

    /// Whether transponders give too little evidence on the radar's velocities.
    pub(crate) fn asks_for_rates(&self) -> bool {
        !self.velocity.is_learnt_from_transponders()
    }

    /// Advances the time and forgets old evidence accordingly.
    fn advance(&mut self, time: Time) {
        if time <= self.now {
            return;
        }
        if self.now > Time::from_nanos(i64::MIN) {
            let passed_s = time.seconds_since(self.now).min(SILENCE_S);
            let kept = (-passed_s / MEMORY_S).exp();
            self.axes.iter_mut().for_each(|axis| axis.decay(kept));
            self.plots.iter_mut().for_each(|count| *count *= kept);
            self.velocity.decay(kept);
        }
        self.now = time;
    }

    /// The learnt errors with the data sheet as prior; fitted again when due.
    pub(crate) fn learnt(&mut self, sheet: &RadarErrors) -> LearntRadar {
        match self.fitted {
            Some((at, learnt)) if self.now.nanos().abs_diff(at.nanos()) < (FIT_EVERY_S * 1e9) as u64 => {
                learnt
            }
            _ => self.fitted.insert((self.now, self.fit(sheet))).1,
        }
    }

    fn fit(&self, sheet: &RadarErrors) -> LearntRadar {
        let units = [1.0, MILLI, 1.0];
        let biases = [sheet.bias_range_m, sheet.bias_azimuth, sheet.bias_height_m];
        let noises = [sheet.noise_range_m, sheet.noise_azimuth, sheet.noise_height_m];
        let turning = (self.plots[1] + TURNS * TURNS_PLOTS) / (self.plots[0] + self.plots[1] + TURNS_PLOTS);
        let axes = [0, 1, 2].map(|axis| {
            let (turn_factor, turn_unsure) = TURN_FACTORS[axis];
            let straight = biases[axis] / enlarged(TURNS, turn_factor);
            let prior = ErrorPrior {
                errors: AxisErrors {
                    bias: straight / units[axis],
                    correlation_s: sheet.correlation_s,
                    noise: noises[axis] / units[axis],
                },
                unsure: SHEET_UNSURE,
                turn_factor,
                turn_unsure,
            };
            let fitted = self.axes[axis].fit(&prior);
            (LearntAxis::of(&fitted, turning, units[axis], biases[axis].hypot(noises[axis])), fitted)
        });
        let [range_m, azimuth, height_m] = axes.map(|axis| axis.0);
        // One correlation time for all axes: combines the information of each beyond the data sheet's.
        let (mut information, mut vector) = (SHEET_UNSURE[1].powi(-2), 0.0);
        for (_, fitted) in &axes {
            let own = fitted.unsure[1].powi(-2);
            vector += own * (fitted.errors.correlation_s / sheet.correlation_s).ln();
            information += (own - SHEET_UNSURE[1].powi(-2)).max(0.0);
        }
        let errors = RadarErrors {
            bias_range_m: range_m.bias.value,
            bias_azimuth: azimuth.bias.value,
            bias_height_m: height_m.bias.value,
            noise_range_m: range_m.noise.value,
            noise_azimuth: azimuth.noise.value,
            noise_height_m: height_m.noise.value,
            correlation_s: sheet.correlation_s * (vector / information).exp(),
        };
        let unsure = axes[0].1.unsure[0].max(axes[1].1.unsure[0]);
        LearntRadar { range_m, azimuth, height_m, velocity: self.velocity.verdict(), errors, unsure }
    }
}

/// Ratio of the mean bias over straight flight and turns to that of straight flight.
fn enlarged(turning: f64, factor: f64) -> f64 {
    (1.0 + turning * (factor * factor - 1.0)).sqrt()
}

impl LearntAxis {
    fn of(fitted: &FittedErrors, turning: f64, unit: f64, sheet: f64) -> Self {
        let FittedErrors { errors, unsure, turn_factor, turn_unsure, tracks } = *fitted;
        let value = |value: f64, unsure: f64| LearntValue { value, deviation: value * unsure };
        let larger = enlarged(turning, turn_factor);
        let share = turning * turn_factor * turn_factor / (larger * larger);
        let bias = value(unit * errors.bias * larger, unsure[0].hypot(share * turn_unsure));
        let noise = value(unit * errors.noise, unsure[2]);
        let both = bias.value.hypot(noise.value);
        let deviation = (bias.value * bias.deviation).hypot(noise.value * noise.deviation) / both;
        Self {
            bias,
            correlation_s: value(errors.correlation_s, unsure[1]),
            noise,
            turn_factor: value(turn_factor, turn_unsure),
            of_data_sheet: LearntValue { value: both / sheet, deviation: deviation / sheet },
            tracks,
        }
    }
}
