//! Properties of a type of transponders: white noise of their positions, and delay.
//!
//! The noise is learnt from the reports of all transponders of the type ([`WhiteNoise`]). The delay is learnt from radars
//! ([`DelaySums`]), each with its own misalignment.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::noise::{Likelihoods, WhiteNoise};
use super::radar::LearntValue;
use crate::registration::{DelaySums, Sample, TimeInformation};
use crate::report::SensorIndex;
use crate::time::Time;

/// Learnt properties of a type.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct TypeLearning {
    /// White noise over ground, and in height.
    pub(super) noise: [WhiteNoise; 2],
    /// Number of reports used.
    pub(super) reports: u64,
    /// Sums for the delay, by radar.
    pub(super) delays: BTreeMap<SensorIndex, DelaySums>,
    /// Time of the latest report of the type.
    pub(super) heard: Time,
}

/// Learnt properties of a type, as published.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntType {
    /// Sigma of the white noise, each axis over ground, metres.
    pub horizontal_m: LearntValue,
    /// Sigma of the white noise in height, metres.
    pub vertical_m: LearntValue,
    /// Number of reports used.
    pub reports: u64,
    /// Delay of the reports' time stamps behind the measurement, seconds.
    pub delay_s: LearntValue,
    /// Delay that is applied, seconds; never below zero.
    pub applied_s: f64,
}

impl TypeLearning {
    /// Adds a report of a transponder, `dt` seconds after the one before it. Earlier evidence decays to 1/e in `memory_s` of
    /// flight.
    pub(crate) fn take_report(&mut self, at: Time, reports: &[Likelihoods; 2], dt: f64, memory_s: f64) {
        for (noise, report) in self.noise.iter_mut().zip(reports) {
            noise.add(report, dt, memory_s);
        }
        self.reports += 1;
        self.heard = self.heard.max(at);
    }

    /// Adds a segment of a radar track.
    pub(crate) fn take_sample(&mut self, radar: SensorIndex, sample: &Sample) {
        self.delays.entry(radar).or_insert(DelaySums::NONE).add(sample);
        self.heard = self.heard.max(sample.time());
    }

    /// Drops a radar's evidence on the delay: the radar was moved.
    pub(crate) fn forget_radar(&mut self, radar: SensorIndex) {
        self.delays.remove(&radar);
    }

    /// White noise over ground, and in height.
    pub(crate) fn noise(&self) -> &[WhiteNoise; 2] {
        &self.noise
    }

    /// Time of the latest report of the type.
    pub(crate) fn last_report(&self) -> Time {
        self.heard
    }

    /// Estimate of the delay from all radars; `given` evaluates the sums of one radar.
    pub(crate) fn delay(
        &self,
        given: impl Fn(SensorIndex, &DelaySums) -> Option<TimeInformation>,
    ) -> TimeInformation {
        let mut all = TimeInformation { inverse_variance: 0.0, weighted_mean: 0.0 };
        for one in self.delays.iter().filter_map(|(&radar, sums)| given(radar, sums)) {
            all.inverse_variance += one.inverse_variance;
            all.weighted_mean += one.weighted_mean;
        }
        all
    }

    /// Properties as published; `configured_m`: configured white noise over ground and in height, metres.
    pub(crate) fn learnt(&self, configured_m: [f64; 2], delay_s: LearntValue, applied_s: f64) -> LearntType {
        let sigma = |axis: usize| {
            let (scale, factor) = self.noise[axis].scale();
            let value = scale * configured_m[axis];
            LearntValue { value, deviation: value * (factor - 1.0) }
        };
        LearntType { horizontal_m: sigma(0), vertical_m: sigma(1), reports: self.reports, delay_s, applied_s }
    }
}
