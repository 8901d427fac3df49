//! Learnt white noise and delay of each type of transponder.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::heights::TransponderHeights;
use super::settings::{OperationalSettings, TransponderDelay};
use super::tuning::{DELAY_BETWEEN_TYPES_S, FRESH_SHARE, TRANSPONDERS_MAX, TYPE_NOISE_CHANGE_S, TYPES_MAX};
use crate::learning::{
    LearningStateError, LearntType, LearntValue, Likelihoods, TypeLearning, TypeState, WhiteNoise,
};
use crate::registration::{DelaySums, Sample, TimeInformation};
use crate::report::{Identity, SensorIndex, TransponderType};
use crate::time::Time;

/// The types that have been received.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct TransponderTypes {
    known: BTreeMap<TransponderType, TypeLearning>,
    /// Result of the last call of [`Self::delays`].
    delays: BTreeMap<TransponderType, TransponderDelay>,
    /// Evidence of the delays of single transponders.
    own: BTreeMap<Identity, OwnDelay>,
    /// Their heights against those of radars.
    pub(super) heights: TransponderHeights,
    /// Values learnt by another engine, used instead of its own; `None`: its own values are used.
    pub(super) shared: Option<TypeValues>,
}

/// Evidence of the delay of one transponder.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct OwnDelay {
    kind: TransponderType,
    by_radar: BTreeMap<SensorIndex, DelaySums>,
    /// End of the latest segment of a radar track.
    seen: Time,
}

/// Delays and noise of the types that are applied.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TypeValues {
    /// Delay of transponders without a value of their type.
    pub(super) delay: Option<TransponderDelay>,
    pub(super) delays: BTreeMap<TransponderType, TransponderDelay>,
    noise: BTreeMap<TransponderType, [WhiteNoise; 2]>,
}

fn of_type(learning: &TypeLearning) -> [WhiteNoise; 2] {
    learning.noise().each_ref().map(WhiteNoise::of_type)
}

impl TransponderTypes {
    /// White noise of a transponder of this type without evidence of its own: over ground, and in height.
    pub(super) fn noise(&self, kind: &TransponderType) -> [WhiteNoise; 2] {
        if let Some(shared) = &self.shared {
            return shared.noise.get(kind).copied().unwrap_or_default();
        }
        self.known.get(kind).map(of_type).unwrap_or_default()
    }

    /// Values learnt by this engine; `delay`: common delay of all types.
    pub(super) fn values(&self, delay: Option<TransponderDelay>) -> TypeValues {
        let noise = self.known.iter().map(|(kind, learning)| (*kind, of_type(learning)));
        TypeValues { delay, delays: self.delays.clone(), noise: noise.collect() }
    }

    /// Adds a report of a transponder of this type, `dt` seconds after the one before it.
    pub(super) fn take_report(
        &mut self,
        kind: TransponderType,
        at: Time,
        report: &[Likelihoods; 2],
        dt: f64,
    ) {
        self.of(kind).take_report(at, report, dt, TYPE_NOISE_CHANGE_S);
    }

    /// Adds a segment of a radar track of a transponder of this type.
    pub(super) fn take_sample(&mut self, kind: TransponderType, radar: SensorIndex, sample: &Sample) {
        self.of(kind).take_sample(radar, sample);
    }

    /// Adds a segment of a radar track to the evidence on one transponder.
    pub(super) fn take_own_sample(
        &mut self,
        identity: Identity,
        kind: TransponderType,
        radar: SensorIndex,
        sample: &Sample,
    ) {
        if self.own.len() >= TRANSPONDERS_MAX
            && !self.own.contains_key(&identity)
            && let Some(oldest) = self.own.iter().min_by_key(|(_, own)| own.seen).map(|known| *known.0)
        {
            self.own.remove(&oldest);
        }
        let new = || OwnDelay { kind, by_radar: BTreeMap::new(), seen: sample.time() };
        let own = self.own.entry(identity).or_insert_with(new);
        // Another receiver may stamp its reports differently.
        if own.kind != kind {
            *own = new();
        }
        own.seen = own.seen.max(sample.time());
        own.by_radar.entry(radar).or_insert(DelaySums::NONE).add(sample);
    }

    /// Drops a radar's evidence on delays: the radar was moved.
    pub(super) fn forget_radar(&mut self, radar: SensorIndex) {
        self.known.values_mut().for_each(|learning| learning.forget_radar(radar));
        self.own.values_mut().for_each(|own| _ = own.by_radar.remove(&radar));
        self.heights.forget_radar(radar);
    }

    /// Delay of each transponder with radar evidence. The prior is that of its type, or `common`.
    pub(super) fn own_delays(
        &self,
        common: TransponderDelay,
        given: impl Fn(SensorIndex, &DelaySums) -> Option<TimeInformation>,
    ) -> BTreeMap<Identity, TransponderDelay> {
        let of = |own: &OwnDelay| {
            let of_type = self.delays.get(&own.kind).copied().unwrap_or(common);
            let (mut inverse_variance, mut vector) = (0.0, 0.0);
            for told in own.by_radar.iter().filter_map(|(&radar, sums)| given(radar, sums)) {
                inverse_variance += told.inverse_variance;
                vector += told.weighted_mean;
            }
            let information = inverse_variance + of_type.of_one().sigma_s.powi(-2);
            let apart_s = (vector - of_type.applied_s * inverse_variance) / information;
            of_type.apart(apart_s, information.powf(-0.5))
        };
        self.own.iter().map(|(identity, own)| (*identity, of(own))).collect()
    }

    /// Learnt delay of each type; `common`: delay of all types; `given`: evidence from the sums of a radar.
    pub(super) fn delays(
        &mut self,
        common: TransponderDelay,
        given: impl Fn(SensorIndex, &DelaySums) -> Option<TimeInformation>,
    ) -> BTreeMap<TransponderType, TransponderDelay> {
        let of = |learning: &TypeLearning| {
            let of_type = learning.delay(&given);
            if of_type.inverse_variance <= 0.0 {
                return common;
            }
            // These tracks are also part of the common delay, which serves as prior only. With a single type the difference is
            // close to zero.
            let information = of_type.inverse_variance + DELAY_BETWEEN_TYPES_S.powi(-2);
            let apart_s = (of_type.weighted_mean - common.applied_s * of_type.inverse_variance) / information;
            common.apart(apart_s, information.powf(-0.5))
        };
        self.delays = self.known.iter().map(|(kind, learning)| (*kind, of(learning))).collect();
        self.delays.clone()
    }

    /// Each type as published; only if its receiver is configured.
    pub(super) fn learnt(&self, settings: &OperationalSettings) -> Vec<(TransponderType, LearntType)> {
        let of = |(kind, learning): (&TransponderType, &TypeLearning)| {
            let receiver = settings.transponder(kind.receiver)?;
            let configured_m =
                [receiver.horizontal_m, receiver.vertical_m].map(|sigma_m| sigma_m * FRESH_SHARE);
            let learnt = || self.delays.get(kind).copied().unwrap_or_default();
            let delay = receiver.delay_s.map_or_else(learnt, TransponderDelay::configured);
            let delay_s = LearntValue { value: delay.mean_s, deviation: delay.sigma_s };
            Some((*kind, learning.learnt(configured_m, delay_s, delay.applied_s)))
        };
        self.known.iter().filter_map(of).collect()
    }

    /// The types, for a restart.
    pub(super) fn to_states(&self) -> Vec<TypeState> {
        self.known.iter().map(|(kind, learning)| TypeState::of(kind, learning)).collect()
    }

    /// Restores a type after a restart.
    pub(super) fn restore(&mut self, state: &TypeState) -> Result<(), LearningStateError> {
        let (kind, learning) = state.restored()?;
        *self.of(kind) = learning;
        Ok(())
    }

    fn of(&mut self, kind: TransponderType) -> &mut TypeLearning {
        if self.known.len() >= TYPES_MAX
            && !self.known.contains_key(&kind)
            && let Some(oldest) =
                self.known.iter().min_by_key(|(_, learning)| learning.last_report()).map(|known| *known.0)
        {
            self.known.remove(&oldest);
        }
        self.known.entry(kind).or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registration::Registration;
    use crate::registration::tests::World;
    use crate::report::UasItems;

    /// Index of the delay among the parameters of a radar's misalignment.
    const TIME: usize = 5;

    #[test]
    fn delays_differ_within_one_type() {
        let radar = SensorIndex(0);
        let kind = TransponderType::of(SensorIndex(1), &UasItems::default());
        let identities = [b"A", b"B"].map(|name| Identity::new(name, None).unwrap());
        let delays_s = [0.0, 0.2];
        for seed in 0..20 {
            let (mut world, mut registration) = (World::wrong(8000 + seed), Registration::default());
            let mut types = TransponderTypes::default();
            // Forty minutes of tracks.
            for track in 0..40 {
                let which = track % 2;
                world.bias[TIME] = delays_s[which];
                let sample = world.sample(60.0, 2.0);
                registration.add(&sample);
                types.take_sample(kind, radar, &sample);
                types.take_own_sample(identities[which], kind, radar, &sample);
            }
            let estimate = registration.estimate();
            let given = |_, sums: &DelaySums| Some(sums.given(&estimate));
            let of_type = types.delays(TransponderDelay::default(), given)[&kind];
            let own = types.own_delays(TransponderDelay::default(), given);
            let [first, second] = identities.map(|identity| own[&identity]);
            assert!(first.applied_s < of_type.applied_s && of_type.applied_s < second.applied_s, "{own:?}");
            for (delay, true_s) in [(first, delays_s[0]), (second, delays_s[1])] {
                assert!((delay.mean_s - true_s).abs() < 4.0 * delay.sigma_s, "{seed}: {delay:?}");
            }
            types.forget_radar(radar);
            types.delays(TransponderDelay::default(), given);
            let nothing = types.own_delays(TransponderDelay::default(), given);
            assert!(nothing.values().all(|delay| delay.mean_s == 0.0), "{nothing:?}");
        }
    }

    #[test]
    fn transponder_seen_least_recently_is_evicted() {
        let kind = TransponderType::of(SensorIndex(1), &UasItems::default());
        let identity = |number: usize| Identity::new(format!("{number:08}").as_bytes(), None).unwrap();
        let (mut world, mut types) = (World::wrong(1), TransponderTypes::default());
        for number in 0..=TRANSPONDERS_MAX {
            types.take_own_sample(identity(number), kind, SensorIndex(0), &world.sample(10.0, 2.0));
        }
        assert_eq!(types.own.len(), TRANSPONDERS_MAX);
        assert!(!types.own.contains_key(&identity(0)) && types.own.contains_key(&identity(TRANSPONDERS_MAX)));
    }
}
