//! What an engine has learnt of its sensors: to be shown, and to outlive a restart. The `reference` profile learns nothing.

use super::{Engine, Rules};
use crate::learning::{LearningState, LearningStateError, LearntType, TypeState};
use crate::operational::{Operational, Registered};
use crate::registration::{RegistrationState, RegistrationStateError};
use crate::report::{SensorIndex, TransponderType};

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
