//! Radar tracks whose numbers jump: each plot is too far from the one before it, so each begins a track.
//!
//! A faulty radar could begin thousands of tracks a second, and each stays until its plots are forgotten. A number belongs to one
//! object at a time, so of the tracks that had it before, only a limited number is kept. Tracks of known aircraft always stay.

use super::Tracklets;
use crate::operational::ids::TrackletId;
use crate::operational::tuning::{BEGUN_MAX, SUPERSEDED_MAX};
use crate::report::RadarTrackKey;
use crate::slots::Slot;

/// Whether as many of a number's tracklets began in this slot as are kept.
pub(super) fn is_jumping(of_number: &[TrackletId], slot: Slot) -> bool {
    of_number.iter().filter(|id| id.slot == slot).count() >= BEGUN_MAX
}

impl Tracklets {
    /// The oldest tracklets without a target whose numbers belong to later ones, above [`SUPERSEDED_MAX`] of each radar;
    /// in order.
    pub(super) fn jumping(&self) -> Vec<TrackletId> {
        let mut jumping = Vec::new();
        let numbers: Vec<(&RadarTrackKey, &[TrackletId])> = self
            .by_key
            .iter()
            .filter_map(|(key, ids)| Some((key, ids.split_last()?.1)))
            .filter(|(_, superseded)| !superseded.is_empty())
            .collect();
        for of_radar in numbers.chunk_by(|one, other| one.0.sensor == other.0.sensor) {
            let superseded = || of_radar.iter().flat_map(|(_, ids)| ids.iter().copied());
            if superseded().count() <= SUPERSEDED_MAX {
                continue;
            }
            let is_free = |id: &TrackletId| self.get(*id).is_some_and(|known| known.target.is_none());
            let mut free: Vec<TrackletId> = superseded().filter(is_free).collect();
            free.sort_unstable();
            free.truncate(free.len().saturating_sub(SUPERSEDED_MAX));
            jumping.append(&mut free);
        }
        jumping.sort_unstable();
        jumping
    }
}
