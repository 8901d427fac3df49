//! What an engine has learnt of its sensors: to be shown, and to outlive a restart. The `reference` profile learns nothing.

use super::{Engine, Rules};
use crate::learning::{LearningState, LearningStateError, LearntType, TypeState};
use crate::operational::{Operational, Registered, SensorValues, TransponderValues};
use crate::registration::{RegistrationState, RegistrationStateError};
use crate::report::{Identity, SensorIndex, TransponderType};
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

    /// What is known of a transponder, for an engine that will hear it soon.
    pub fn transponder_values(&self, identity: Identity) -> Option<TransponderValues> {
        self.operational()?.transponder_values(identity)
    }

    /// Goes on with what another engine knows of a transponder, as soon as that is heard.
    pub fn use_transponder_values(&mut self, values: &TransponderValues) {
        if let Rules::Operational(operational, _) = &mut self.rules {
            operational.use_transponder_values(values);
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
