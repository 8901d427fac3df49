//! Who flies without a transponder where one is to be heard.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::areas::{AreaError, Areas, HeardAreas, Masks};
use crate::config::Config;
use crate::picture::{Picture, PictureMaker, PictureTrack};
use fusion::time::{SECOND, Time};
use fusion::{Identity, RadarTrackKey};

/// Time that a drone is published, seen by radar alone and inside the coverage of a transponder receiver, before it counts as
/// uncooperative, nanoseconds: transponders are heard every few seconds. By judgement.
const WAIT_NS: i64 = 15 * SECOND;
/// An aircraft that has had no point for so long has ended, nanoseconds: the engine finds one again for as long.
const GONE_NS: u64 = 50 * SECOND as u64;

/// Watches for drones without a transponder, slot by slot.
#[derive(Clone, Debug, Default)]
pub struct Lookout {
    heard: HeardAreas,
    masks: Masks,
    /// Length of a slot, nanoseconds.
    slot_ns: i64,
    /// By track id.
    watched: BTreeMap<String, Watched>,
}

/// A drone that was seen by radar alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Watched {
    /// Its latest point.
    seen: Time,
    /// The radar track of that.
    radar: RadarTrackKey,
    /// Time of its points inside the coverage, nanoseconds.
    inside_ns: i64,
    is_uncooperative: bool,
}

/// An uncooperative aircraft that is none any more.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resolved {
    /// Its track id.
    pub id: String,
    /// Whose it is; `None`: it is the other side of a transponder that lies.
    pub identity: Option<Identity>,
}

impl Lookout {
    /// For a site; nobody is watched where integrity is not judged, or no transponder receiver has an area of kind `coverage`.
    pub fn new(config: &Config, areas: &Areas) -> Self {
        if !config.judges_integrity() {
            return Self::default();
        }
        let slot_ns = config.fusion.slot.as_nanos() as i64;
        Self { heard: areas.heard(config), masks: areas.masks(), slot_ns, watched: BTreeMap::new() }
    }

    /// The same from the files of the areas that it needs.
    ///
    /// # Errors
    /// A file cannot be read or holds something else than polygons.
    pub fn load(config: &Config, masks: Masks) -> Result<Self, AreaError> {
        if !config.judges_integrity() {
            return Ok(Self::default());
        }
        let slot_ns = config.fusion.slot.as_nanos() as i64;
        Ok(Self { heard: HeardAreas::load(config)?, masks, slot_ns, watched: BTreeMap::new() })
    }

    /// Who is watched, as octets.
    pub fn checkpoint(&self) -> Vec<u8> {
        postcard::to_stdvec(&self.watched).expect("times and numbers can be written down")
    }

    /// Goes on with a checkpoint; whether it is one.
    pub fn go_on(&mut self, octets: &[u8]) -> bool {
        postcard::from_bytes(octets).map(|watched| self.watched = watched).is_ok()
    }

    /// Marks the tracks of the picture that are uncooperative, and notes in it which ones no longer are.
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

    /// Forgets those that an identity has joined, or that turned out to be the other side of one that lies.
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
            // Where the radar's track has joined another aircraft its own has ended.
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

    /// Counts the time of a track that nothing explains; whether it is uncooperative.
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
