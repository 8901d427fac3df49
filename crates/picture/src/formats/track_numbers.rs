//! 16-bit track numbers (I062/040), for tracks whose own numbers are longer.

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::PictureTrack;
use fusion::time::Time;
use fusion::{SensorIndex, Source};

/// Time for which a track keeps its number after its last picture, because it may reappear.
const KEPT: SignedDuration = SignedDuration::from_secs(10);

/// Assigns numbers to the tracks of a series of pictures: the low 16 bits of a track's own number, or the next free number. The
/// same pictures give the same numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct ShortTrackNumbers {
    alive: BTreeMap<PublishedTrackKey, Alive>,
    taken: BTreeSet<u16>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Alive {
    number: u16,
    seen: Time,
}

/// Number of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NumberedTrack {
    pub(super) number: u16,
    /// Whether this is the first picture with the track.
    pub(super) is_first: bool,
}

/// Data from which the id of a track is made ([`PictureMaker::track_id`](crate::PictureMaker::track_id)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum PublishedTrackKey {
    /// Number of an aircraft, for its lifetime.
    Own(u32),
    /// Number that is reused, with the time of the first slot.
    Again(u32, Time),
    /// Numbers of the `reference` profile: fused, radar only, or transponder only.
    Fused(u32),
    Radar(SensorIndex, u32, Time),
    Transponder(u32),
}

impl PublishedTrackKey {
    fn of(track: &PictureTrack) -> Self {
        let point = &track.point;
        let (number, first_seen) = (point.number, point.first_seen);
        match (&point.source, point.estimate.is_some()) {
            (_, true) if number >= 10_000 => Self::Own(number),
            (_, true) => Self::Again(number, first_seen),
            (Source::Fused(..), false) => Self::Fused(number),
            (Source::Radar(radar), false) => Self::Radar(radar.track.sensor, number, first_seen),
            (Source::Transponder(_), false) => Self::Transponder(number),
            (Source::Cameras, false) => Self::Again(number, first_seen),
        }
    }
}

impl ShortTrackNumbers {
    /// Number of a track of the next picture; `None` if 65,536 other tracks have one.
    pub(super) fn number(&mut self, track: &PictureTrack) -> Option<NumberedTrack> {
        let key = PublishedTrackKey::of(track);
        if let Some(alive) = self.alive.get_mut(&key) {
            alive.seen = track.time;
            return Some(NumberedTrack { number: alive.number, is_first: false });
        }
        let wanted = track.point.number as u16;
        let behind = (0..=u16::MAX).map(|step| wanted.wrapping_add(step));
        let number = behind.into_iter().find(|number| !self.taken.contains(number))?;
        self.taken.insert(number);
        self.alive.insert(key, Alive { number, seen: track.time });
        Some(NumberedTrack { number, is_first: true })
    }

    /// Numbers, in order, of tracks that end with the picture of `time`, missing for [`KEPT`]. The next picture may reuse them.
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
