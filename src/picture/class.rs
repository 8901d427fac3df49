//! What a track is taken for.

use std::collections::BTreeSet;

use super::serial_text;
use fusion::Source;

/// Below this probability, by the radar's classifier, that it is a drone, a track of radar alone is held for something else:
/// likelier than not.
const DRONE_PROBABILITY: f64 = 0.5;

/// What a track is taken for: the configuration knows who is crewed, then a transponder is a drone's, then the radar's
/// classifier is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackClass {
    /// Nobody is on board: it has a transponder, or the radar holds that for likelier than not.
    Drone,
    /// Somebody is on board: its transponder is one of `[conflicts] crewed`.
    Crewed,
    /// The radar holds it for something else: a bird.
    Other,
    /// Of radar alone, which says nothing of it.
    Unknown,
}

impl TrackClass {
    /// All classes.
    pub const ALL: [Self; 4] = [Self::Drone, Self::Crewed, Self::Other, Self::Unknown];

    /// Its name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Drone => "drone",
            Self::Crewed => "crewed",
            Self::Other => "other",
            Self::Unknown => "unknown",
        }
    }

    /// Of what a track is made of; `crewed`: serial numbers of transponders.
    pub(super) fn of(source: &Source, crewed: &BTreeSet<String>) -> Self {
        if let Some(part) = source.transponder() {
            let is_crewed = !crewed.is_empty() && crewed.contains(&serial_text(part.identity));
            return if is_crewed { Self::Crewed } else { Self::Drone };
        }
        match source.radar().and_then(|radar| radar.uav_probability) {
            Some(probability) if probability < DRONE_PROBABILITY => Self::Other,
            Some(_) => Self::Drone,
            None => Self::Unknown,
        }
    }
}
