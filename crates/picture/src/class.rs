//! Classification of a track.

use std::collections::BTreeSet;

use super::serial_text;
use fusion::Source;
use fusion::report::AircraftKind;

/// Minimum probability of a drone, by the radar's classifier, below which a radar-only track is classified as another target.
const DRONE_PROBABILITY: f64 = 0.5;

/// Class of a track. The configuration of crewed aircraft takes precedence, then the transponder's own statement, then the
/// radar's classifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackClass {
    /// Unmanned aircraft: it has a drone's transponder, or the radar considers a drone more likely than not.
    Drone,
    /// Crewed aircraft: its transponder is in `[conflicts] crewed`, or is ADS-B that does not state otherwise.
    Crewed,
    /// Ground vehicle of an aerodrome.
    Vehicle,
    /// The radar considers another target more likely, such as a bird.
    Other,
    /// Radar-only track without a classification.
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
    /// Class of a track with this source; `crewed` contains serial numbers of transponders.
    pub fn of(source: &Source, crewed: &BTreeSet<String>) -> Self {
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
