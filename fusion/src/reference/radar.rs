//! The window's radar detections: by slot, by track, and by position.

use serde::{Deserialize, Serialize};

use crate::cells::GroundCells;
use crate::frames::Enu;
use crate::report::{Plot, RadarTrackKey};
use crate::settings::Threshold;
use crate::slots::{RING, Slot, SlotGrid, SlotSet, Window, ring_place};
use crate::time::Time;

/// A plot and the distance within which a transponder agrees with it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Detection {
    pub(super) plot: Plot,
    pub(super) threshold_m: f64,
}

impl Detection {
    /// Distance from a transponder's point, metres: horizontal if the radar measured no height.
    pub(super) fn distance_m(&self, point: Enu) -> f64 {
        let offset = self.plot.position.0 - point.0;
        if self.plot.height_measured { offset.norm() } else { offset.xy().norm() }
    }
}

/// The slots of a radar track.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackSlots {
    /// Slots with a detection.
    pub(super) present: SlotSet,
    /// Slots whose detection is a UAV with a probability above zero.
    pub(super) uav: SlotSet,
    /// The first slot that was emitted with a detection of the track.
    pub(super) first_seen: Option<Slot>,
}

/// Detections of the window and of the reports that wait ahead of it.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Detections {
    grid: SlotGrid,
    threshold: Threshold,
    /// Side of a square cell: the widest threshold, so that a detection within its threshold lies in the same or an
    /// adjacent cell.
    cell_m: f64,
    slots: Box<[SlotDetections]>,
    /// Slots by sensor and track number; a track without a detection has its initial value.
    tracks: Vec<Vec<TrackSlots>>,
    /// Slots with new plots since they were last settled.
    unsettled: SlotSet,
    /// Buffer of `settle`, kept so that it does not allocate.
    order: Vec<((RadarTrackKey, Time), usize)>,
    sorted: Vec<Detection>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct SlotDetections {
    /// Settled: one detection for each track, by track. Later plots follow in order of reception.
    detections: Vec<Detection>,
    /// Spatial index of the settled detections. `outlines` has their positions close together in memory.
    cells: GroundCells,
    outlines: Vec<DetectionOutline>,
}

/// Position of a detection over ground, and its threshold, metres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct DetectionOutline {
    east: f64,
    north: f64,
    threshold_m: f64,
}

impl DetectionOutline {
    fn of(detection: &Detection) -> Self {
        let Detection { plot, threshold_m } = detection;
        Self { east: plot.position.east(), north: plot.position.north(), threshold_m: *threshold_m }
    }

    /// Whether the detection can be within its threshold of `point`: `false` if its distance over ground alone exceeds
    /// the threshold by more than rounding.
    fn may_reach(&self, point: Enu) -> bool {
        let (east, north) = (self.east - point.east(), self.north - point.north());
        east * east + north * north <= self.threshold_m * self.threshold_m * (1.0 + 1e-9)
    }
}

impl Detections {
    pub(super) fn new(grid: SlotGrid, threshold: Threshold) -> Self {
        let cell_m = threshold.widest_m().max(1.0);
        let slots = vec![SlotDetections::default(); RING].into_boxed_slice();
        Self {
            grid,
            threshold,
            cell_m,
            slots,
            tracks: Vec::new(),
            unsettled: SlotSet::EMPTY,
            order: Vec::new(),
            sorted: Vec::new(),
        }
    }

    /// Adds a plot whose slot is in the ring.
    pub(super) fn insert(&mut self, plot: Plot) {
        let slot = self.grid.of(plot.time);
        let threshold_m = self.threshold.at(plot.slant_range_m);
        self.slots[ring_place(slot)].detections.push(Detection { plot, threshold_m });
        self.unsettled.set(slot, true);
    }

    /// Removes a slot that left the window, after [`Self::sort_evaluated`]; a track without other slots gets its initial value.
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
        left.outlines.clear();
        self.unsettled.set(slot, false);
    }

    /// Sorts the evaluated slots; returns those whose detections changed.
    pub(super) fn sort_evaluated(&mut self, window: &Window) -> SlotSet {
        let stale = self.unsettled.and(window.evaluated());
        for slot in stale.slots_from(window.first) {
            let SlotDetections { detections, cells, outlines } = &mut self.slots[ring_place(slot)];
            // By track, time and order of reception: the last detection of a track is kept.
            self.order.clear();
            let keys = detections.iter().map(|detection| (detection.plot.track, detection.plot.time));
            self.order.extend(keys.zip(0..));
            self.order.sort_unstable();
            self.sorted.clear();
            for tracks in self.order.chunk_by(|a, b| a.0.0 == b.0.0) {
                self.sorted.extend(tracks.last().map(|&(_, index)| detections[index]));
            }
            std::mem::swap(detections, &mut self.sorted);
            for detection in detections.iter() {
                let track = track_mut(&mut self.tracks, detection.plot.track);
                track.present.set(slot, true);
                track.uav.set(slot, detection.plot.uav_probability.is_some_and(|p| p > 0.0));
            }
            cells.fill(detections.iter().map(|detection| detection.plot.position), self.cell_m);
            outlines.clear();
            outlines.extend(detections.iter().map(DetectionOutline::of));
        }
        self.unsettled = self.unsettled.without(stale);
        stale
    }

    /// One detection for each track, by track, in a settled slot.
    pub(super) fn of_slot(&self, slot: Slot) -> &[Detection] {
        debug_assert!(!self.unsettled.contains(slot));
        &self.slots[ring_place(slot)].detections
    }

    /// The detection of a track in a settled slot.
    pub(super) fn detection(&self, track: RadarTrackKey, slot: Slot) -> Option<&Detection> {
        let detections = self.of_slot(slot);
        detections.binary_search_by_key(&track, |detection| detection.plot.track).ok().map(|i| &detections[i])
    }

    /// Detections of a settled slot within their threshold of `point`.
    pub(super) fn within_threshold(&self, slot: Slot, point: Enu) -> impl Iterator<Item = &Detection> {
        let SlotDetections { detections, cells, outlines } = &self.slots[ring_place(slot)];
        cells
            .around(point, self.cell_m)
            .filter(move |&index| outlines[index].may_reach(point))
            .map(|index| &detections[index])
            .filter(move |detection| detection.distance_m(point) <= detection.threshold_m)
    }

    /// The slots of a track.
    pub(super) fn track(&self, key: RadarTrackKey) -> TrackSlots {
        let tracks = self.tracks.get(usize::from(key.sensor.0));
        tracks.and_then(|tracks| tracks.get(usize::from(key.number))).copied().unwrap_or_default()
    }

    /// Marks the detections of `slot` as emitted.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::SensorIndex;

    #[test]
    fn a_detection_on_its_threshold_is_within() {
        let grid = SlotGrid::default();
        let window = Window { first: Slot(0), emitted: Slot(0), horizon: Slot(0), last: Slot(0) };
        for (east, count) in [(60.0, 1), (60.0_f64.next_up(), 0), (-60.0, 1), (0.0, 1)] {
            let threshold = Threshold::new(vec![(0.0, 60.0)]).unwrap();
            let mut detections = Detections::new(grid, threshold);
            detections.insert(Plot {
                track: RadarTrackKey { sensor: SensorIndex(0), number: 1 },
                time: Time::default(),
                position: Enu::new(east, 0.0, 0.0),
                height_measured: true,
                slant_range_m: 60.0,
                uav_probability: None,
                velocity: None,
            });
            detections.sort_evaluated(&window);
            assert_eq!(
                detections.within_threshold(Slot(0), Enu::new(0.0, 0.0, 0.0)).count(),
                count,
                "{east}"
            );
        }
    }
}
