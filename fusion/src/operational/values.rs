//! What one engine has learnt of a sensor, for others to use as it does: engines that see the same aircraft then say the same.
//!
//! An engine that shares uses what it is given from the slot on from which it is to be used, and nothing that it has learnt
//! itself. It learns all the same, for others ([`Engine::learnt_values`](crate::Engine::learnt_values)).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Operational;
use super::classes::{ClassEvidence, LabelledTrack};
use super::registrations::Applied;
use super::transponder_types::TypeValues;
use crate::report::SensorIndex;
use crate::slots::Slot;

/// What is known of a sensor: of a radar its misalignment, its errors and its classes; of all transponders their delays and
/// their noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorValues(Values);

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Values {
    Radar(SensorIndex, Box<(Applied, ClassEvidence)>),
    Transponders(TypeValues),
}

/// What is to be used, and from when.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Planned(Vec<(Slot, SensorValues)>);

impl Operational {
    /// From now on only what it is given counts of what is known of sensors.
    pub(crate) fn share(&mut self) {
        self.registrations.shared.get_or_insert_default();
        self.classes.shared.get_or_insert_default();
        self.types.shared.get_or_insert_default();
    }

    /// What was learnt: of a radar, or of the transponders.
    pub(crate) fn learnt_values(&self, radar: Option<SensorIndex>) -> Option<SensorValues> {
        let values = match radar {
            Some(sensor) => {
                let of_radar = (self.registrations.learnt(sensor)?, *self.classes.learnt(sensor));
                Values::Radar(sensor, Box::new(of_radar))
            }
            None => Values::Transponders(self.types.values(self.registrations.delay())),
        };
        Some(SensorValues(values))
    }

    /// Radar tracks that were labelled since the last call; each is to be counted by one engine.
    pub(crate) fn take_labelled(&mut self) -> Vec<LabelledTrack> {
        self.classes.take_labelled()
    }

    /// Counts a radar track for what is learnt of its radar's classes.
    pub(crate) fn count_labelled(&mut self, track: &LabelledTrack) {
        self.classes.count(track);
    }

    /// These are to be used from this slot on.
    pub(crate) fn use_values(&mut self, from: Slot, values: SensorValues) {
        let planned = &mut self.planned.0;
        // Of one slot in the order in which they came.
        planned.insert(planned.partition_point(|(slot, _)| *slot <= from), (from, values));
    }

    /// What is used from this slot on.
    pub(super) fn turn_values(&mut self, slot: Slot) {
        let due = self.planned.0.partition_point(|(from, _)| *from <= slot);
        for (_, SensorValues(values)) in self.planned.0.drain(..due) {
            match values {
                Values::Radar(sensor, of_radar) => {
                    let (applied, evidence) = *of_radar;
                    let known: &mut BTreeMap<_, _> = self.registrations.shared.get_or_insert_default();
                    known.insert(sensor, applied);
                    self.classes.shared.get_or_insert_default().insert(sensor, evidence);
                }
                Values::Transponders(values) => self.types.shared = Some(values),
            }
        }
    }
}
