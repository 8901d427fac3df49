//! What transponders of one type have in common: how large the white noise of their positions is, and their delay.
//!
//! The noise is that of all of them, by their own reports alone ([`WhiteNoise`]). The delay is what radars show of it
//! ([`DelaySums`]), each of which knows its own misalignment.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::LearntValue;
use super::noise::{Likelihoods, WhiteNoise};
use crate::registration::{DelaySums, Sample, TimeInformation};
use crate::report::SensorIndex;
use crate::time::Time;

/// All that is known of a type.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct TypeLearning {
    /// Over ground, and in height.
    pub(super) noise: [WhiteNoise; 2],
    /// Reports that it rests upon.
    pub(super) reports: u64,
    /// By radar.
    pub(super) delays: BTreeMap<SensorIndex, DelaySums>,
    /// When one of them was heard last.
    pub(super) heard: Time,
}

/// The transponders of one type, as they have shown themselves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntType {
    /// Sigma of the white noise, each axis over ground, metres.
    pub horizontal_m: LearntValue,
    /// Sigma of the white noise in height, metres.
    pub vertical_m: LearntValue,
    /// Reports that both rest upon.
    pub reports: u64,
    /// Delay of the reports' times behind the measurement, seconds: the best guess.
    pub delay_s: LearntValue,
    /// The delay that is applied, seconds; never below zero.
    pub applied_s: f64,
}

impl TypeLearning {
    /// Takes in a report of one of them, heard `dt` seconds after the one before it; what is long ago fades to 1/e in
    /// `memory_s` of flight.
    pub(crate) fn take_report(&mut self, at: Time, reports: &[Likelihoods; 2], dt: f64, memory_s: f64) {
        for (noise, report) in self.noise.iter_mut().zip(reports) {
            noise.add(report, dt, memory_s);
        }
        self.reports += 1;
        self.heard = self.heard.max(at);
    }

    /// Takes in a piece of a track of one of them.
    pub(crate) fn take_sample(&mut self, radar: SensorIndex, sample: &Sample) {
        self.delays.entry(radar).or_insert(DelaySums::NONE).add(sample);
        self.heard = self.heard.max(sample.time());
    }

    /// What this radar has shown of the delay no longer holds: it was moved.
    pub(crate) fn forget_radar(&mut self, radar: SensorIndex) {
        self.delays.remove(&radar);
    }

    /// White noise over ground, and in height.
    pub(crate) fn noise(&self) -> &[WhiteNoise; 2] {
        &self.noise
    }

    /// When one of them was heard last.
    pub(crate) fn heard(&self) -> Time {
        self.heard
    }

    /// What the radars show of the delay; `given` makes information of the sums of one of them.
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

    /// As it is published, where white noise of so many metres is configured over ground and in height.
    pub(crate) fn learnt(&self, configured_m: [f64; 2], delay_s: LearntValue, applied_s: f64) -> LearntType {
        let sigma = |axis: usize| {
            let (scale, factor) = self.noise[axis].scale();
            let value = scale * configured_m[axis];
            LearntValue { value, deviation: value * (factor - 1.0) }
        };
        LearntType { horizontal_m: sigma(0), vertical_m: sigma(1), reports: self.reports, delay_s, applied_s }
    }
}
