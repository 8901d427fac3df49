//! Track numbers of 16 bits (I062/040), for tracks whose own are longer.

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::picture::PictureTrack;
use fusion::time::Time;
use fusion::{SensorIndex, Source};

/// How long a track keeps its number after the last picture that it is in: meanwhile it may come again.
const KEPT: SignedDuration = SignedDuration::from_secs(10);

/// Gives the tracks of a series of pictures numbers: the low 16 bits of their own, or the next number behind that no other
/// track has. The same pictures give the same numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackNumbers {
    alive: BTreeMap<Key, Alive>,
    taken: BTreeSet<u16>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Alive {
    number: u16,
    seen: Time,
}

/// A track's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Numbered {
    pub(super) number: u16,
    /// Whether the track begins.
    pub(super) is_first: bool,
}

/// What a track's id is made of ([`PictureMaker::track_id`](crate::picture::PictureMaker::track_id)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum Key {
    /// Of an aircraft, for its life.
    Own(u32),
    /// A number that comes again.
    Again(u32, Time),
    /// Of the `reference` profile: of radar and transponder, of a radar alone, of a transponder alone.
    Fused(u32),
    Radar(SensorIndex, u32, Time),
    Transponder(u32),
}

impl Key {
    fn of(track: &PictureTrack) -> Self {
        let point = &track.point;
        let (number, first_seen) = (point.number, point.first_seen);
        match (&point.source, point.estimate.is_some()) {
            (_, true) if number >= 10_000 => Self::Own(number),
            (_, true) => Self::Again(number, first_seen),
            (Source::Fused(..), false) => Self::Fused(number),
            (Source::Radar(radar), false) => Self::Radar(radar.track.sensor, number, first_seen),
            (Source::Transponder(_), false) => Self::Transponder(number),
        }
    }
}

impl TrackNumbers {
    /// The number of a track of the next picture; `None` where 65,536 others have one.
    pub(super) fn number(&mut self, track: &PictureTrack) -> Option<Numbered> {
        let key = Key::of(track);
        if let Some(alive) = self.alive.get_mut(&key) {
            alive.seen = track.time;
            return Some(Numbered { number: alive.number, is_first: false });
        }
        let wanted = track.point.number as u16;
        let behind = (0..=u16::MAX).map(|step| wanted.wrapping_add(step));
        let number = behind.into_iter().find(|number| !self.taken.contains(number))?;
        self.taken.insert(number);
        self.alive.insert(key, Alive { number, seen: track.time });
        Some(Numbered { number, is_first: true })
    }

    /// The numbers, in order, of tracks that end with the picture of `time`: they have been in none for [`KEPT`]. Others
    /// may have them from the next picture on.
    pub(super) fn end(&mut self, time: Time) -> Vec<u16> {
        let mut ended = Vec::new();
        self.alive.retain(|_, alive| {
            let stays = time - alive.seen <= KEPT;
            if !stays {
                ended.push(alive.number);
            }
            stays
        });
        ended.sort_unstable();
        ended.iter().for_each(|number| _ = self.taken.remove(number));
        ended
    }
}
