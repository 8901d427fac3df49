//! What a track is taken for.

use std::collections::BTreeSet;

use super::serial_text;
use fusion::Source;
use fusion::report::AircraftKind;

/// Below this probability, by the radar's classifier, that it is a drone, a track of radar alone is held for something else:
/// likelier than not.
const DRONE_PROBABILITY: f64 = 0.5;

/// What a track is taken for: the configuration knows who is crewed, then a transponder says what it is on, then the radar's
/// classifier is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackClass {
    /// Nobody is on board: it has a drone's transponder, or the radar holds that for likelier than not.
    Drone,
    /// Somebody is on board: its transponder is one of `[conflicts] crewed`, or ADS-B that does not say otherwise.
    Crewed,
    /// It stays on the ground: a vehicle of an aerodrome.
    Vehicle,
    /// The radar holds it for something else: a bird.
    Other,
    /// Of radar alone, which says nothing of it.
    Unknown,
}

fusion::interface_names!(TrackClass {
    Drone = "drone",
    Crewed = "crewed",
    Vehicle = "vehicle",
    Other = "other",
    Unknown = "unknown",
});

impl TrackClass {
    /// Of what a track is made of; `crewed`: serial numbers of transponders.
    pub(crate) fn of(source: &Source, crewed: &BTreeSet<String>) -> Self {
        if let Some(part) = source.transponder() {
            let is_crewed = !crewed.is_empty() && crewed.contains(&serial_text(part.identity));
            return match part.aircraft.kind {
                _ if is_crewed => Self::Crewed,
                AircraftKind::Unmanned => Self::Drone,
                AircraftKind::Crewed => Self::Crewed,
                AircraftKind::Vehicle => Self::Vehicle,
            };
        }
        match source.radar().and_then(|radar| radar.uav_probability) {
            Some(probability) if probability < DRONE_PROBABILITY => Self::Other,
            Some(_) => Self::Drone,
            None => Self::Unknown,
        }
    }
}
