//! The window's radar detections: by slot, by track, and by place.

use super::settings::Gate;
use super::slots::{RING, Slot, SlotGrid, SlotSet, Window, ring_place};
use crate::normalise::{Enu, Plot, RadarTrackKey};

/// A plot and the distance within which a transponder agrees with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detection {
    pub(super) plot: Plot,
    pub(super) gate_m: f64,
}

impl Detection {
    /// Distance to a transponder's point: horizontal where the radar measured no height.
    pub(super) fn distance_m(&self, point: Enu) -> f64 {
        let offset = self.plot.position.0 - point.0;
        if self.plot.height_measured { offset.norm() } else { offset.xy().norm() }
    }
}

/// A radar track's slots.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TrackSlots {
    /// Slots that hold a detection.
    pub(super) present: SlotSet,
    /// Slots whose detection is a UAV with probability above zero.
    pub(super) uav: SlotSet,
    /// The first slot that was emitted with a detection of it.
    pub(super) first_seen: Option<Slot>,
}

/// Detections of the window and of the reports that wait ahead of it.
#[derive(Debug)]
pub(super) struct Detections {
    grid: SlotGrid,
    gate: Gate,
    /// Side of a square cell: the widest gate, so that a detection within its gate is in the same or a neighbouring cell.
    cell_m: f64,
    slots: Box<[SlotDetections]>,
    /// By sensor and track number; those that hold no detection are as new.
    tracks: Vec<Vec<TrackSlots>>,
    /// Slots that got plots since they were last settled.
    unsettled: SlotSet,
}

#[derive(Clone, Debug, Default)]
struct SlotDetections {
    /// Settled: one detection a track, by track. Plots that came since stand behind, in order of reception.
    detections: Vec<Detection>,
    /// Cell and index into `detections`, by cell.
    cells: Vec<(Cell, u32)>,
}

impl Detections {
    pub(super) fn new(grid: SlotGrid, gate: Gate) -> Self {
        let cell_m = gate.widest_m().max(1.0);
        let slots = vec![SlotDetections::default(); RING].into_boxed_slice();
        Self { grid, gate, cell_m, slots, tracks: Vec::new(), unsettled: SlotSet::EMPTY }
    }

    /// A plot of a slot in the ring.
    pub(super) fn insert(&mut self, plot: Plot) {
        let slot = self.grid.of(plot.time);
        let gate_m = self.gate.at(plot.slant_range_m);
        self.slots[ring_place(slot)].detections.push(Detection { plot, gate_m });
        self.unsettled.set(slot, true);
    }

    /// Takes out a slot that left the window, after [`Self::settle`]: a track that has no other slot is as new.
    pub(super) fn remove(&mut self, slot: Slot) {
        let left = &mut self.slots[ring_place(slot)];
        for detection in left.detections.drain(..) {
            let track = track_mut(&mut self.tracks, detection.plot.track);
            track.present.set(slot, false);
            track.uav.set(slot, false);
            if track.present.is_empty() {
                *track = TrackSlots::default();
            }
        }
        left.cells.clear();
        self.unsettled.set(slot, false);
    }

    /// Brings the evaluated slots in order; returns those whose detections changed.
    pub(super) fn settle(&mut self, window: &Window) -> SlotSet {
        let stale = self.unsettled.and(window.evaluated());
        for slot in stale.slots_from(window.first) {
            let SlotDetections { detections, cells } = &mut self.slots[ring_place(slot)];
            // Stable: of two plots of one track and time the one received last stays last, and is kept.
            detections.sort_by_key(|detection| (detection.plot.track, detection.plot.time));
            detections.dedup_by(|later, kept| {
                let same = later.plot.track == kept.plot.track;
                if same {
                    *kept = *later;
                }
                same
            });
            cells.clear();
            for (index, detection) in detections.iter().enumerate() {
                let track = track_mut(&mut self.tracks, detection.plot.track);
                track.present.set(slot, true);
                track.uav.set(slot, detection.plot.uav_probability.is_some_and(|p| p > 0.0));
                cells.push((Cell::of(detection.plot.position, self.cell_m), index as u32));
            }
            cells.sort_unstable();
        }
        self.unsettled = self.unsettled.without(stale);
        stale
    }

    /// One detection a track, by track, of a settled slot.
    pub(super) fn of_slot(&self, slot: Slot) -> &[Detection] {
        debug_assert!(!self.unsettled.contains(slot));
        &self.slots[ring_place(slot)].detections
    }

    /// The detection of a track in a settled slot.
    pub(super) fn detection(&self, track: RadarTrackKey, slot: Slot) -> Option<&Detection> {
        let detections = self.of_slot(slot);
        detections.binary_search_by_key(&track, |detection| detection.plot.track).ok().map(|i| &detections[i])
    }

    /// Detections of a settled slot within their gate of `point`.
    pub(super) fn within_gate(&self, slot: Slot, point: Enu) -> impl Iterator<Item = &Detection> {
        let SlotDetections { detections, cells } = &self.slots[ring_place(slot)];
        Cell::of(point, self.cell_m).rows_around().into_iter().flat_map(move |(first, last)| {
            let start = cells.partition_point(|&(cell, _)| cell < first);
            cells[start..]
                .iter()
                .take_while(move |&&(cell, _)| cell <= last)
                .map(|&(_, index)| &detections[index as usize])
                .filter(move |detection| detection.distance_m(point) <= detection.gate_m)
        })
    }

    /// The slots of a track.
    pub(super) fn track(&self, key: RadarTrackKey) -> TrackSlots {
        let tracks = self.tracks.get(usize::from(key.sensor.0));
        tracks.and_then(|tracks| tracks.get(usize::from(key.number))).copied().unwrap_or_default()
    }

    /// Notes that the detections of `slot` have now been emitted.
    pub(super) fn mark_seen(&mut self, slot: Slot) {
        for detection in &self.slots[ring_place(slot)].detections {
            track_mut(&mut self.tracks, detection.plot.track).first_seen.get_or_insert(slot);
        }
    }
}

fn track_mut(tracks: &mut Vec<Vec<TrackSlots>>, key: RadarTrackKey) -> &mut TrackSlots {
    fn grown<T: Default>(list: &mut Vec<T>, index: u16) -> &mut T {
        let index = usize::from(index);
        if index >= list.len() {
            list.resize_with(index + 1, T::default);
        }
        &mut list[index]
    }
    grown(grown(tracks, key.sensor.0), key.number)
}

/// A square on the ground. Orders by row, then column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    row: i32,
    column: i32,
}

impl Cell {
    fn of(position: Enu, side_m: f64) -> Self {
        // `as` saturates, and no position on Earth comes near the limits with cells of a metre or more.
        let index = |metres: f64| (metres / side_m).floor() as i32;
        Self { row: index(position.north()), column: index(position.east()) }
    }

    /// First and last cell of the three rows that surround this one.
    fn rows_around(self) -> [(Self, Self); 3] {
        [-1, 0, 1].map(|offset| {
            let row = self.row.saturating_add(offset);
            let cell = |by| Self { row, column: self.column.saturating_add(by) };
            (cell(-1), cell(1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normalise::SensorIndex;
    use crate::time::Time;

    #[test]
    fn a_detection_on_its_gate_is_within() {
        let grid = SlotGrid::new(250_000_000);
        let window = Window { first: Slot(0), emitted: Slot(0), horizon: Slot(0), last: Slot(0) };
        for (east, count) in [(60.0, 1), (60.0_f64.next_up(), 0), (-60.0, 1), (0.0, 1)] {
            let gate = Gate::new(vec![(0.0, 60.0)]).unwrap();
            let mut detections = Detections::new(grid, gate);
            detections.insert(Plot {
                track: RadarTrackKey { sensor: SensorIndex(0), number: 1 },
                time: Time::default(),
                position: Enu::new(east, 0.0, 0.0),
                height_measured: true,
                slant_range_m: 60.0,
                uav_probability: None,
            });
            detections.settle(&window);
            assert_eq!(detections.within_gate(Slot(0), Enu::new(0.0, 0.0, 0.0)).count(), count, "{east}");
        }
    }
}
