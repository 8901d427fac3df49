//! The engine's learnt state of sensors, for display and for restarts. The `reference` profile learns nothing.

use super::Engine;
use super::profile_state::ProfileState;
use crate::frames::Enu;
use crate::learning::{LearningState, LearningStateError, LearntType, TypeState};
use crate::operational::{
    CameraStarts, LabelledTrack, Operational, OrientedCamera, Registered, SensorValues, TrackHandover,
    TrackRef,
};
use crate::registration::{RegistrationState, RegistrationStateError};
use crate::report::{SensorIndex, TransponderType};
use crate::slots::Slot;

impl Engine {
    /// State of each radar's registration; empty in the `reference` profile.
    pub fn registered(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.operational().into_iter().flat_map(Operational::registered)
    }

    /// Orientation of each camera, as learnt; empty in the `reference` profile.
    pub fn oriented_cameras(&self) -> impl Iterator<Item = (SensorIndex, &OrientedCamera)> {
        self.operational().into_iter().flat_map(Operational::oriented)
    }

    /// Pairs of camera tracks that have begun no target; none in the `reference` profile.
    pub fn camera_starts(&self) -> CameraStarts {
        self.operational().map(Operational::camera_starts).unwrap_or_default()
    }

    /// Restores a radar's registration from before a restart; returns whether it was accepted. The `reference` profile
    /// has none.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not valid.
    pub fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<bool, RegistrationStateError> {
        match &mut self.rules {
            ProfileState::Operational(operational, _) => operational.restore(sensor, state).map(|()| true),
            ProfileState::Reference(_) => Ok(false),
        }
    }

    /// Restores a radar's learnt errors from before a restart; returns whether they were accepted. The `reference`
    /// profile learns none.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not valid.
    pub fn restore_learning(
        &mut self,
        sensor: SensorIndex,
        state: &LearningState,
    ) -> Result<bool, LearningStateError> {
        match &mut self.rules {
            ProfileState::Operational(operational, _) => {
                operational.restore_learning(sensor, state).map(|()| true)
            }
            ProfileState::Reference(_) => Ok(false),
        }
    }

    /// From now on the engine uses only the sensor values that it is given ([`Engine::use_values`]), not those that it
    /// learns itself. Returns `false` in the `reference` profile, which learns nothing.
    pub fn share_values(&mut self) -> bool {
        match &mut self.rules {
            ProfileState::Operational(operational, _) => {
                operational.share();
                true
            }
            ProfileState::Reference(_) => false,
        }
    }

    /// Learnt values of a radar or, with `None`, of all transponders, for use by other engines.
    pub fn learnt_values(&self, radar: Option<SensorIndex>) -> Option<SensorValues> {
        self.operational()?.learnt_values(radar)
    }

    /// Uses values learnt by another engine or by this one, from this slot on.
    pub fn use_values(&mut self, from: Slot, values: SensorValues) {
        if let ProfileState::Operational(operational, _) = &mut self.rules {
            operational.use_values(from, values);
        }
    }

    /// Returns the radar tracks that were labelled as drones or others since the last call, if values are shared
    /// ([`Engine::share_values`]). Each must be counted by exactly one engine ([`Engine::count_labelled`]).
    pub fn take_labelled(&mut self) -> Vec<LabelledTrack> {
        match &mut self.rules {
            ProfileState::Operational(operational, _) => operational.take_labelled(),
            ProfileState::Reference(_) => Vec::new(),
        }
    }

    /// Counts a radar track that this or another engine has labelled, to learn the classes of its radar.
    pub fn count_labelled(&mut self, track: &LabelledTrack) {
        if let ProfileState::Operational(operational, _) = &mut self.rules {
            operational.count_labelled(track);
        }
    }

    /// All aircraft and unassigned radar tracks, each with its position in the slot that was decided last; empty in the
    /// `reference` profile.
    pub fn names(&self) -> Vec<(TrackRef, Enu)> {
        self.operational().map(Operational::names).unwrap_or_default()
    }

    /// Reference to the aircraft that is published with this number.
    pub fn numbered(&self, number: u32) -> Option<TrackRef> {
        self.operational()?.numbered(number)
    }

    /// State of an aircraft or a radar track, for handover to another engine. It includes the unassigned radar tracks
    /// that could be this aircraft and whose position is `around`.
    pub fn handover(&self, name: TrackRef, around: impl Fn(Enu) -> bool) -> Option<TrackHandover> {
        self.operational()?.handover(name, around)
    }

    /// Continues an aircraft or a radar track with the state of another engine, from the slot after that state. A state
    /// that is older than 5 s by then, or of another version, is ignored.
    pub fn receive_handover(&mut self, acquaintance: TrackHandover) {
        if let ProfileState::Operational(operational, _) = &mut self.rules {
            operational.store_handover(acquaintance);
        }
    }

    /// Learnt values of each transponder type; empty in the `reference` profile.
    pub fn learnt_types(&self) -> Vec<(TransponderType, LearntType)> {
        match &self.rules {
            ProfileState::Operational(operational, settings) => operational.learnt_types(settings),
            ProfileState::Reference(_) => Vec::new(),
        }
    }

    /// State of each transponder type, to be restored after a restart.
    pub fn type_states(&self) -> Vec<TypeState> {
        self.operational().map(Operational::type_states).unwrap_or_default()
    }

    /// Restores the learnt state of a transponder type from before a restart; returns whether it was accepted. The
    /// `reference` profile learns nothing.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not valid.
    pub fn restore_type(&mut self, state: &TypeState) -> Result<bool, LearningStateError> {
        match &mut self.rules {
            ProfileState::Operational(operational, _) => operational.restore_type(state).map(|()| true),
            ProfileState::Reference(_) => Ok(false),
        }
    }
}
