//! The region's picture: those of all its cells for one slot.

use std::collections::BTreeMap;

use crate::picture::{Picture, PictureTrack};
use crate::territory::CellName;
use fusion::slots::Slot;

/// A cell's picture of a slot.
#[derive(Clone, Debug)]
pub struct Part {
    /// The cell.
    pub cell: CellName,
    /// The number of the lease under which it was made.
    pub epoch: u64,
    /// What it publishes.
    pub picture: Picture,
}

/// Makes one picture of those of several cells.
#[derive(Clone, Debug, Default)]
pub struct Merger {
    /// Tracks that were left out, because another cell published them, too.
    pub doubled: u64,
}

impl Merger {
    /// The picture of a slot; parts of other slots are left out. Of two tracks with one id, or with one number, that of the
    /// greater epoch stays, then that of the lower cell name.
    pub fn merge(&mut self, slot: Slot, parts: &[Part]) -> Option<Picture> {
        let mut parts: Vec<&Part> = parts.iter().filter(|part| part.picture.slot == slot).collect();
        parts.sort_by(|one, other| other.epoch.cmp(&one.epoch).then_with(|| one.cell.cmp(&other.cell)));
        let first = &parts.first()?.picture;
        let mut merged = Picture {
            slot,
            time: first.time,
            tracks: Vec::new(),
            concerns: Vec::new(),
            resolved: Vec::new(),
        };
        let (mut by_id, mut by_number) = (BTreeMap::new(), BTreeMap::new());
        for Part { cell, picture, .. } in &parts {
            for track in &picture.tracks {
                let (id, number) = (track.id.as_deref(), track.point.number);
                // Within a cell an engine knows what it does.
                let other = |of: Option<&&CellName>| of.is_some_and(|of| *of != cell);
                if other(id.and_then(|id| by_id.get(id))) || other(by_number.get(&number)) {
                    self.doubled += 1;
                    continue;
                }
                if let Some(id) = id {
                    by_id.insert(id, cell);
                }
                by_number.insert(number, cell);
                merged.tracks.push(track.clone());
            }
            merged.concerns.extend(picture.concerns.iter().cloned());
            merged.resolved.extend(picture.resolved.iter().cloned());
        }
        merged.tracks.sort_by_key(PictureTrack::order);
        Some(merged)
    }
}
