//! What an engine has learnt of its sensors: to be shown, and to outlive a restart. The `reference` profile learns nothing.

use super::{Engine, Rules};
use crate::frames::Enu;
use crate::learning::{LearningState, LearningStateError, LearntType, TypeState};
use crate::operational::{Acquaintance, LabelledTrack, Name, Operational, Registered, SensorValues};
use crate::registration::{RegistrationState, RegistrationStateError};
use crate::report::{SensorIndex, TransponderType};
use crate::slots::Slot;

impl Engine {
    /// What is known of each radar's registration; nothing in the `reference` profile.
    pub fn registered(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.operational().into_iter().flat_map(Operational::registered)
    }

    /// Takes over what was known of a radar's registration in an earlier life; whether it did. The `reference` profile knows
    /// none.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<bool, RegistrationStateError> {
        match &mut self.rules {
            Rules::Operational(operational, _) => operational.restore(sensor, state).map(|()| true),
            Rules::Reference(_) => Ok(false),
        }
    }

    /// Takes over what was learnt of a radar's errors in an earlier life; whether it did. The `reference` profile learns none.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub fn restore_learning(
        &mut self,
        sensor: SensorIndex,
        state: &LearningState,
    ) -> Result<bool, LearningStateError> {
        match &mut self.rules {
            Rules::Operational(operational, _) => operational.restore_learning(sensor, state).map(|()| true),
            Rules::Reference(_) => Ok(false),
        }
    }

    /// From now on what counts of what is known of the sensors is what it is given ([`Engine::use_values`]), and not what it
    /// learns itself; whether it does: the `reference` profile learns nothing.
    pub fn share_values(&mut self) -> bool {
        match &mut self.rules {
            Rules::Operational(operational, _) => {
                operational.share();
                true
            }
            Rules::Reference(_) => false,
        }
    }

    /// What it has learnt of a radar or, with `None`, of all transponders, for others to use.
    pub fn learnt_values(&self, radar: Option<SensorIndex>) -> Option<SensorValues> {
        self.operational()?.learnt_values(radar)
    }

    /// Uses what another engine, or this one, has learnt, from this slot on.
    pub fn use_values(&mut self, from: Slot, values: SensorValues) {
        if let Rules::Operational(operational, _) = &mut self.rules {
            operational.use_values(from, values);
        }
    }

    /// Radar tracks that were labelled as drones or others since the last call, where values are shared
    /// ([`Engine::share_values`]). Each is to be counted by one engine ([`Engine::count_labelled`]).
    pub fn take_labelled(&mut self) -> Vec<LabelledTrack> {
        match &mut self.rules {
            Rules::Operational(operational, _) => operational.take_labelled(),
            Rules::Reference(_) => Vec::new(),
        }
    }

    /// Counts a radar track that this engine, or another one, has labelled, for what is learnt of its radar's classes.
    pub fn count_labelled(&mut self, track: &LabelledTrack) {
        if let Rules::Operational(operational, _) = &mut self.rules {
            operational.count_labelled(track);
        }
    }

    /// All aircraft, and the radar tracks that are nobody's, and where each was in the slot that was decided last; none in the
    /// `reference` profile.
    pub fn names(&self) -> Vec<(Name, Enu)> {
        self.operational().map(Operational::names).unwrap_or_default()
    }

    /// The name of the aircraft that is published under this number.
    pub fn numbered(&self, number: u32) -> Option<Name> {
        self.operational()?.numbered(number)
    }

    /// What is known of an aircraft or a radar track, for an engine that begins to see it, and of the radar tracks that could be
    /// this aircraft and are nobody's, where those are `around`.
    pub fn acquaintance(&self, name: Name, around: impl Fn(Enu) -> bool) -> Option<Acquaintance> {
        self.operational()?.acquaintance(name, around)
    }

    /// Goes on with what another engine knows of an aircraft or a radar track, with the next slot after the one in which that
    /// one knew it; what is older than 5 s by then, or of another version, is passed over.
    pub fn meet(&mut self, acquaintance: Acquaintance) {
        if let Rules::Operational(operational, _) = &mut self.rules {
            operational.await_acquaintance(acquaintance);
        }
    }

    /// What was learnt of each type of transponders; nothing in the `reference` profile.
    pub fn learnt_types(&self) -> Vec<(TransponderType, LearntType)> {
        match &self.rules {
            Rules::Operational(operational, settings) => operational.learnt_types(settings),
            Rules::Reference(_) => Vec::new(),
        }
    }

    /// The same, to outlive a restart.
    pub fn type_states(&self) -> Vec<TypeState> {
        self.operational().map(Operational::type_states).unwrap_or_default()
    }

    /// Takes over what was learnt of a type of transponders in an earlier life; whether it did. The `reference` profile learns
    /// nothing.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub fn restore_type(&mut self, state: &TypeState) -> Result<bool, LearningStateError> {
        match &mut self.rules {
            Rules::Operational(operational, _) => operational.restore_type(state).map(|()| true),
            Rules::Reference(_) => Ok(false),
        }
    }
}
