//! Radar tracks whose numbers jump: each plot is too far from the one before it, so each begins a track.
//!
//! A faulty radar could begin thousands of tracks a second, and each stays until its plots are forgotten. A number belongs to one
//! object at a time, so of the tracks that had it before, only a limited number is kept. Tracks of known aircraft always stay.

use super::Tracklets;
use crate::operational::ids::TrackletId;
use crate::operational::tuning::{BEGUN_MAX, SUPERSEDED_MAX};
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
        let superseded =
            self.by_key.values().filter_map(|ids| ids.split_last()).flat_map(|(_, earlier)| earlier);
        // In order of the keys, so those of a radar follow each other.
        let superseded: Vec<TrackletId> = superseded.copied().collect();
        for of_radar in superseded.chunk_by(|one, other| one.track.sensor == other.track.sensor) {
            if of_radar.len() <= SUPERSEDED_MAX {
                continue;
            }
            let is_free = |id: &&TrackletId| self.get(**id).is_some_and(|known| known.target.is_none());
            let mut free: Vec<TrackletId> = of_radar.iter().filter(is_free).copied().collect();
            free.sort_unstable();
            free.truncate(free.len().saturating_sub(SUPERSEDED_MAX));
            jumping.append(&mut free);
        }
        jumping.sort_unstable();
        jumping
    }
}
