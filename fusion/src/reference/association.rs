//! Which radar tracks are this aircraft: by distance threshold and ratio.

use super::radar::Detections;
use super::transponder::Curve;
use crate::report::RadarTrackKey;
use crate::settings::Settings;
use crate::slots::{Slot, SlotSet, Window};

/// The radar tracks that came within the gate of one transponder somewhere in the window.
///
/// Only these are looked at: a radar track that was never near costs nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs(Vec<Pair>);

/// A radar track that came near.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) track: RadarTrackKey,
    /// Slots where both have a point and their distance is within the gate.
    within: SlotSet,
}

/// How a pair stands at a slot, counted from the window's first slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Evidence {
    /// Slots where both have a point.
    pub co_present: u32,
    /// Slots among them where their distance is within the gate.
    pub within: u32,
}

impl Evidence {
    /// Share of slots within the gate.
    pub fn ratio(&self) -> f64 {
        f64::from(self.within) / f64::from(self.co_present)
    }

    /// Whether it is enough for an association.
    pub(super) fn suffices(&self, settings: &Settings) -> bool {
        // In whole numbers: 0.9 of 10 slots is 9, not 9.000000000000002.
        self.co_present >= settings.min_samples
            && u64::from(self.within) * 1_000_000 >= settings.ratio_min_ppm * u64::from(self.co_present)
    }
}

impl Pairs {
    /// Compares curve and detections again in the slots of `changed`; forgets pairs that are nowhere near any more.
    pub(super) fn update(
        &mut self,
        window: &Window,
        changed: SlotSet,
        curve: &Curve,
        detections: &Detections,
    ) {
        let unchanged = window.evaluated().without(changed);
        for pair in &mut self.0 {
            pair.within = pair.within.and(unchanged);
        }
        for slot in changed.and(curve.present()).slots_from(window.first) {
            for detection in detections.within_gate(slot, curve.point(slot)) {
                self.entry(detection.plot.track).within.set(slot, true);
            }
        }
        self.0.retain(|pair| !pair.within.is_empty());
    }

    fn entry(&mut self, track: RadarTrackKey) -> &mut Pair {
        let index = self.0.binary_search_by_key(&track, |pair| pair.track).unwrap_or_else(|index| {
            self.0.insert(index, Pair { track, within: SlotSet::EMPTY });
            index
        });
        &mut self.0[index]
    }

    /// The pairs, by radar track.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Pair> {
        self.0.iter()
    }

    /// Whether any pair is associated in one of the slots from `from` to `to`.
    pub(super) fn any_associated(
        &self,
        (from, to): (Slot, Slot),
        window: &Window,
        curve: &Curve,
        detections: &Detections,
        settings: &Settings,
    ) -> bool {
        self.0.iter().any(|pair| {
            let both = curve.present().and(detections.track(pair.track).present);
            pair.within
                .and(SlotSet::span(from, to))
                .slots_from(window.first)
                .any(|slot| pair.associated(slot, window, both, settings).is_some())
        })
    }
}

impl Pair {
    /// The evidence at `slot` if the pair is associated there; `both`: the slots where both have a point.
    pub(super) fn associated(
        &self,
        slot: Slot,
        window: &Window,
        both: SlotSet,
        settings: &Settings,
    ) -> Option<Evidence> {
        if !self.within.contains(slot) {
            return None;
        }
        let so_far = SlotSet::span(window.first, slot);
        let evidence =
            Evidence { co_present: both.and(so_far).count(), within: self.within.and(so_far).count() };
        evidence.suffices(settings).then_some(evidence)
    }
}
