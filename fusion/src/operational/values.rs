//! Sensor values learnt by one engine for use by others. Engines that process the same aircraft then agree.
//!
//! An engine that shares uses only the values that it is given, each from its slot on, and not what it has learnt
//! itself. It still learns, for others ([`Engine::learnt_values`](crate::Engine::learnt_values)).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Operational;
use super::classes::{ClassEvidence, LabelledTrack};
use super::registrations::AppliedRegistration;
use super::transponder_types::TypeValues;
use crate::report::SensorIndex;
use crate::slots::Slot;

/// Learnt values of a sensor: misalignment, errors and class statistics of a radar; delays and noise of all
/// transponders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorValues(LearntSensorValues);

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum LearntSensorValues {
    Radar(SensorIndex, Box<(AppliedRegistration, ClassEvidence)>),
    Transponders(TypeValues),
}

/// Values to be used, each with the slot from which they apply.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct PlannedValues(Vec<(Slot, SensorValues)>);

impl Operational {
    /// From now on only given sensor values are used.
    pub(crate) fn share(&mut self) {
        self.registrations.shared.get_or_insert_default();
        self.classes.shared.get_or_insert_default();
        self.types.shared.get_or_insert_default();
    }

    /// Learnt values of a radar, or of the transponders.
    pub(crate) fn learnt_values(&self, radar: Option<SensorIndex>) -> Option<SensorValues> {
        let values = match radar {
            Some(sensor) => {
                let of_radar = (self.registrations.learnt(sensor)?, *self.classes.learnt(sensor));
                LearntSensorValues::Radar(sensor, Box::new(of_radar))
            }
            None => LearntSensorValues::Transponders(self.types.values(self.registrations.delay())),
        };
        Some(SensorValues(values))
    }

    /// Returns the radar tracks that were labelled since the last call; each must be counted by one engine.
    pub(crate) fn take_labelled(&mut self) -> Vec<LabelledTrack> {
        self.classes.take_labelled()
    }

    /// Counts a radar track for the class statistics of its radar.
    pub(crate) fn count_labelled(&mut self, track: &LabelledTrack) {
        self.classes.count(track);
    }

    /// Uses these values from this slot on.
    pub(crate) fn use_values(&mut self, from: Slot, values: SensorValues) {
        let planned = &mut self.planned.0;
        // Values of one slot stay in the order of their arrival.
        planned.insert(planned.partition_point(|(slot, _)| *slot <= from), (from, values));
    }

    /// Applies the values that are due in this slot.
    pub(super) fn turn_values(&mut self, slot: Slot) {
        let due = self.planned.0.partition_point(|(from, _)| *from <= slot);
        for (_, SensorValues(values)) in self.planned.0.drain(..due) {
            match values {
                LearntSensorValues::Radar(sensor, of_radar) => {
                    let (applied, evidence) = *of_radar;
                    let known: &mut BTreeMap<_, _> = self.registrations.shared.get_or_insert_default();
                    known.insert(sensor, applied);
                    self.classes.shared.get_or_insert_default().insert(sensor, evidence);
                }
                LearntSensorValues::Transponders(values) => self.types.shared = Some(values),
            }
        }
    }
}
