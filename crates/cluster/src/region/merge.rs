//! The region's picture: the pictures of all its cells for one slot.

use std::collections::BTreeMap;

use fusion::slots::Slot;
use picture::{Picture, PictureTrack};
use site::territory::CellName;

/// A cell's picture of a slot.
#[derive(Clone, Debug)]
pub struct CellPicture {
    /// The cell.
    pub cell: CellName,
    /// Number of the lease under which the picture was made.
    pub epoch: u64,
    /// The published picture.
    pub picture: Picture,
}

/// Merges the pictures of several cells.
#[derive(Clone, Debug, Default)]
pub struct PictureMerger {
    /// Number of tracks left out because another cell published them, too.
    pub doubled: u64,
}

impl PictureMerger {
    /// Merges the pictures of a slot; parts of other slots are ignored. Of two tracks with the same id or number the one with the
    /// greater epoch is kept, then the one of the lower cell name.
    pub fn merge(&mut self, slot: Slot, parts: &[CellPicture]) -> Option<Picture> {
        let mut parts: Vec<&CellPicture> = parts.iter().filter(|part| part.picture.slot == slot).collect();
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
        for CellPicture { cell, picture, .. } in &parts {
            for track in &picture.tracks {
                let (id, number) = (track.id.as_deref(), track.point.number);
                // Within a cell the engine ensures uniqueness.
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

#[cfg(test)]
mod tests {
    use super::super::test_tracks::track;
    use super::*;

    const SLOT: Slot = Slot(100);

    /// A cell's picture of aircraft with these ids and numbers, at a position that identifies the cell.
    fn part(
        cell: &str,
        epoch: u64,
        slot: Slot,
        east_m: f64,
        aircraft: &[(Option<&str>, u32)],
    ) -> CellPicture {
        let one = |&(id, number): &(Option<&str>, u32)| PictureTrack {
            id: id.map(Into::into),
            ..track(number, SLOT, slot, east_m)
        };
        let tracks: Vec<PictureTrack> = aircraft.iter().map(one).collect();
        let time = track(0, SLOT, slot, east_m).time;
        let picture = Picture { slot, time, tracks, concerns: Vec::new(), resolved: Vec::new() };
        CellPicture { cell: CellName::new(cell).unwrap(), epoch, picture }
    }

    /// Ids and numbers of the merged picture, the number of tracks from the first part, and the number left out.
    fn shown(parts: &[CellPicture]) -> (Vec<(Option<String>, u32)>, usize, u64) {
        let mut merger = PictureMerger::default();
        let merged = merger.merge(SLOT, parts).unwrap();
        let of_first = parts[0].picture.tracks[0].position;
        let firsts = merged.tracks.iter().filter(|track| track.position == of_first).count();
        let names =
            merged.tracks.iter().map(|track| (track.id.as_deref().map(Into::into), track.point.number));
        (names.collect(), firsts, merger.doubled)
    }

    #[test]
    fn duplicate_track_of_the_later_lease_is_kept() {
        let id = |id: &str, number| (Some(id.to_owned()), number);
        for (same, kept) in [((Some("a"), 8), id("a", 7)), ((Some("b"), 7), id("a", 7))] {
            let east = |epoch| part("east", epoch, SLOT, 10.0, &[(Some("a"), 7)]);
            let west = |epoch| part("west", epoch, SLOT, -10.0, &[same]);
            for parts in [[east(2), west(1)], [east(1), west(1)], [east(3), west(2)]] {
                assert_eq!(shown(&parts), (vec![kept.clone()], 1, 1));
            }
            let parts = [east(1), west(2)];
            assert_eq!(shown(&parts), (vec![id(same.0.unwrap(), same.1)], 0, 1), "the later lease");
        }
    }

    #[test]
    fn merged_tracks_are_sorted_and_other_slots_ignored() {
        let parts = [
            part("east", 1, SLOT, 10.0, &[(Some("c"), 9), (None, 3)]),
            part("north", 1, Slot(101), 0.0, &[(Some("d"), 1)]),
            part("west", 5, SLOT, -10.0, &[(Some("a"), 4), (Some("b"), 11)]),
        ];
        let (names, of_east, doubled) = shown(&parts);
        let numbers: Vec<u32> = names.iter().map(|name| name.1).collect();
        assert_eq!((numbers, of_east, doubled), (vec![3, 4, 9, 11], 2, 0));
        // Two tracks of one engine are both kept.
        let twice = [part("east", 1, SLOT, 10.0, &[(Some("a"), 7), (Some("a"), 7)])];
        assert_eq!((shown(&twice).0.len(), shown(&twice).2), (2, 0));
        assert!(PictureMerger::default().merge(Slot(102), &parts).is_none());
    }
}
