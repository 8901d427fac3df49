//! What is known of the types of transponders: white noise and delay.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::settings::{Delay, Settings};
use super::tuning::{DELAY_BETWEEN_TYPES_S, FRESH_SHARE, TYPE_NOISE_CHANGE_S, TYPES_MAX};
use crate::learning::{
    LearningStateError, LearntType, LearntValue, Likelihoods, TypeLearning, TypeState, WhiteNoise,
};
use crate::registration::{DelaySums, Sample, TimeInformation};
use crate::report::{SensorIndex, TransponderType};
use crate::time::Time;

/// The types that have been heard.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct TransponderTypes {
    known: BTreeMap<TransponderType, TypeLearning>,
    /// As [`Self::delays`] had them last.
    delays: BTreeMap<TransponderType, Delay>,
    /// What another engine has learnt; `None`: what it learns itself counts.
    pub(super) shared: Option<TypeValues>,
}

/// What is used of the types' delays and noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TypeValues {
    /// Of those of which no more is known.
    pub(super) delay: Option<Delay>,
    pub(super) delays: BTreeMap<TransponderType, Delay>,
    noise: BTreeMap<TransponderType, [WhiteNoise; 2]>,
}

fn of_type(learning: &TypeLearning) -> [WhiteNoise; 2] {
    learning.noise().each_ref().map(WhiteNoise::of_type)
}

impl TransponderTypes {
    /// White noise of a transponder of this type of which nothing else is known: over ground, and in height.
    pub(super) fn noise(&self, kind: &TransponderType) -> [WhiteNoise; 2] {
        if let Some(shared) = &self.shared {
            return shared.noise.get(kind).copied().unwrap_or_default();
        }
        self.known.get(kind).map(of_type).unwrap_or_default()
    }

    /// What has shown itself here; `delay`: that of all.
    pub(super) fn values(&self, delay: Option<Delay>) -> TypeValues {
        let noise = self.known.iter().map(|(kind, learning)| (*kind, of_type(learning)));
        TypeValues { delay, delays: self.delays.clone(), noise: noise.collect() }
    }

    /// Takes in a report of one of this type, `dt` seconds after the one before it.
    pub(super) fn take_report(
        &mut self,
        kind: TransponderType,
        at: Time,
        report: &[Likelihoods; 2],
        dt: f64,
    ) {
        self.of(kind).take_report(at, report, dt, TYPE_NOISE_CHANGE_S);
    }

    /// Takes in a piece of a radar's track of one of this type.
    pub(super) fn take_sample(&mut self, kind: TransponderType, radar: SensorIndex, sample: &Sample) {
        self.of(kind).take_sample(radar, sample);
    }

    /// What this radar has shown of delays no longer holds: it was moved.
    pub(super) fn forget_radar(&mut self, radar: SensorIndex) {
        self.known.values_mut().for_each(|learning| learning.forget_radar(radar));
    }

    /// The delay of each type, unless it is configured; `common` is that of all, `given` what the sums of a radar show.
    pub(super) fn delays(
        &mut self,
        common: Delay,
        given: impl Fn(SensorIndex, &DelaySums) -> Option<TimeInformation>,
    ) -> BTreeMap<TransponderType, Delay> {
        let of = |learning: &TypeLearning| {
            let of_type = learning.delay(&given);
            if of_type.inverse_variance <= 0.0 {
                return common;
            }
            // Its tracks are among those of all, whose delay is only what this begins with: where there is one type, what
            // is apart of it is next to nothing.
            let information = of_type.inverse_variance + DELAY_BETWEEN_TYPES_S.powi(-2);
            let apart_s = (of_type.weighted_mean - common.applied_s * of_type.inverse_variance) / information;
            common.apart(apart_s, information.powf(-0.5))
        };
        self.delays = self.known.iter().map(|(kind, learning)| (*kind, of(learning))).collect();
        self.delays.clone()
    }

    /// Each type as it is published; only where its receiver is configured.
    pub(super) fn learnt(&self, settings: &Settings) -> Vec<(TransponderType, LearntType)> {
        let of = |(kind, learning): (&TransponderType, &TypeLearning)| {
            let receiver = settings.transponder(kind.receiver)?;
            let configured_m =
                [receiver.horizontal_m, receiver.vertical_m].map(|sigma_m| sigma_m * FRESH_SHARE);
            let learnt = || self.delays.get(kind).copied().unwrap_or_default();
            let delay = receiver.delay_s.map_or_else(learnt, Delay::configured);
            let delay_s = LearntValue { value: delay.mean_s, deviation: delay.sigma_s };
            Some((*kind, learning.learnt(configured_m, delay_s, delay.applied_s)))
        };
        self.known.iter().filter_map(of).collect()
    }

    /// All that outlives a restart.
    pub(super) fn to_states(&self) -> Vec<TypeState> {
        self.known.iter().map(|(kind, learning)| TypeState::of(kind, learning)).collect()
    }

    /// Takes over what was known of a type before a restart.
    pub(super) fn restore(&mut self, state: &TypeState) -> Result<(), LearningStateError> {
        let (kind, learning) = state.restored()?;
        *self.of(kind) = learning;
        Ok(())
    }

    fn of(&mut self, kind: TransponderType) -> &mut TypeLearning {
        if self.known.len() >= TYPES_MAX
            && !self.known.contains_key(&kind)
            && let Some(oldest) =
                self.known.iter().min_by_key(|(_, learning)| learning.heard()).map(|known| *known.0)
        {
            self.known.remove(&oldest);
        }
        self.known.entry(kind).or_default()
    }
}
