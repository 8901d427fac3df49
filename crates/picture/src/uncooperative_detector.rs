//! Drones without a transponder in places where transponders are received.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Picture, PictureMaker, PictureTrack};
use fusion::time::{SECOND, Time};
use fusion::{Identity, RadarTrackKey};
use site::areas::{AreaError, Areas, HeardAreas, Masks};
use site::config::Config;

/// Time, in nanoseconds, for which a drone is published from radar alone and inside the coverage of a transponder receiver before
/// it counts as uncooperative. Transponders report every few seconds. Chosen by judgement.
const WAIT_NS: i64 = 15 * SECOND;
/// An aircraft without a point for this time, in nanoseconds, has ended: the engine can reacquire it only within this time.
const GONE_NS: u64 = 50 * SECOND as u64;

/// Detects drones without a transponder, slot by slot.
#[derive(Clone, Debug, Default)]
pub struct UncooperativeDetector {
    heard: HeardAreas,
    masks: Masks,
    /// Length of a slot, in nanoseconds.
    slot_ns: i64,
    /// Drones by track id.
    watched: BTreeMap<String, Watched>,
}

/// A drone seen by radar only.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Watched {
    /// Time of its latest point.
    seen: Time,
    /// Radar track of that point.
    radar: RadarTrackKey,
    /// Total time of its points inside the coverage, in nanoseconds.
    inside_ns: i64,
    is_uncooperative: bool,
}

/// An aircraft that is no longer uncooperative.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resolved {
    /// Track id.
    pub id: String,
    /// Its transponder; `None`: it turned out to be the real aircraft of a transponder that states false positions.
    pub identity: Option<Identity>,
}

impl UncooperativeDetector {
    /// A detector for a site. Inactive without integrity checks, or without an area of kind `coverage` of a transponder receiver.
    pub fn new(config: &Config, areas: &Areas) -> Self {
        if !config.evaluates_integrity() {
            return Self::default();
        }
        let slot_ns = config.fusion.slot.as_nanos() as i64;
        Self { heard: areas.heard(config), masks: areas.masks(), slot_ns, watched: BTreeMap::new() }
    }

    /// A detector for a site that reads the files of its coverage areas.
    ///
    /// # Errors
    /// A file cannot be read, or contains something other than polygons.
    pub fn load(config: &Config, masks: Masks) -> Result<Self, AreaError> {
        if !config.evaluates_integrity() {
            return Ok(Self::default());
        }
        let slot_ns = config.fusion.slot.as_nanos() as i64;
        Ok(Self { heard: HeardAreas::load(config)?, masks, slot_ns, watched: BTreeMap::new() })
    }

    /// The watched drones, encoded.
    pub fn checkpoint(&self) -> Vec<u8> {
        postcard::to_stdvec(&self.watched).expect("times and numbers can be written down")
    }

    /// Restores a checkpoint; returns whether it was valid.
    pub fn restore(&mut self, octets: &[u8]) -> bool {
        postcard::from_bytes(octets).map(|watched| self.watched = watched).is_ok()
    }

    /// Marks uncooperative tracks in the picture, and lists in it those that no longer are.
    pub fn look(&mut self, picture: &mut Picture, maker: &PictureMaker) {
        if self.heard.is_empty() {
            return;
        }
        let now = picture.time;
        self.watched.retain(|_, watched| now.nanos().abs_diff(watched.seen.nanos()) <= GONE_NS);
        self.resolve(picture, maker);
        for track in &mut picture.tracks {
            track.is_uncooperative = self.is_uncooperative(track, maker, now);
        }
    }

    /// Stops watching drones that a transponder now identifies, or that proved to be the real aircraft behind false positions.
    fn resolve(&mut self, picture: &mut Picture, maker: &PictureMaker) {
        if self.watched.is_empty() {
            return;
        }
        let mut resolved = Vec::new();
        for track in &picture.tracks {
            let identity = track.point.source.transponder().map(|part| part.identity);
            if identity.is_none() && track.point.disputed.is_empty() {
                continue;
            }
            let radar = track.point.source.radar().map(|part| part.track);
            let own = maker.track_id(track);
            // If the radar track has joined another aircraft, the drone's own track has ended.
            self.watched.retain(|id, watched| {
                let is_over = *id == own || radar == Some(watched.radar);
                if is_over && watched.is_uncooperative {
                    resolved.push(Resolved { id: id.clone(), identity });
                }
                !is_over
            });
        }
        picture.resolved = resolved;
    }

    /// Adds the time of a track that has no explanation; returns whether it is uncooperative.
    fn is_uncooperative(&mut self, track: &PictureTrack, maker: &PictureMaker, now: Time) -> bool {
        let point = &track.point;
        let Some(radar) = point.source.radar().filter(|_| point.source.transponder().is_none()) else {
            return false;
        };
        if !point.is_unexplained && self.watched.is_empty() {
            return false;
        }
        let id = maker.track_id(track);
        if let Some(watched) = self.watched.get_mut(&id) {
            (watched.seen, watched.radar) = (now, radar.track);
            if watched.is_uncooperative {
                return true;
            }
        }
        let place = (track.position.longitude_deg(), track.position.latitude_deg());
        let counts = point.is_unexplained
            && self.heard.contain(place.0, place.1)
            && !self.masks.contain(place.0, place.1);
        if !counts {
            return false;
        }
        let new = Watched { seen: now, radar: radar.track, inside_ns: 0, is_uncooperative: false };
        let watched = self.watched.entry(id).or_insert(new);
        watched.inside_ns += self.slot_ns;
        watched.is_uncooperative = watched.inside_ns >= WAIT_NS;
        watched.is_uncooperative
    }
}

#[cfg(test)]
mod tests;
