//! Which radar tracks are this aircraft: by distance threshold and ratio.

use serde::{Deserialize, Serialize};

use super::radar::Detections;
use super::transponder::Curve;
use crate::point::SlotRatio;
use crate::report::RadarTrackKey;
use crate::settings::ReferenceRules;
use crate::slots::{Slot, SlotSet, Window};

/// The radar tracks that came within the threshold of one transponder somewhere in the window.
///
/// Only these are looked at: a radar track that was never near costs nothing.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Pairs(Vec<Pair>);

/// A radar track that came near.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Pair {
    pub(super) track: RadarTrackKey,
    /// Slots where both have a point and their distance is within the threshold.
    within: SlotSet,
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
            for detection in detections.within_threshold(slot, curve.point(slot)) {
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
        rules: &ReferenceRules,
    ) -> bool {
        self.0.iter().any(|pair| {
            let both = curve.present().and(detections.track(pair.track).present);
            pair.within
                .and(SlotSet::span(from, to))
                .slots_from(window.first)
                .any(|slot| pair.associated(slot, window, both, rules).is_some())
        })
    }
}

impl Pair {
    /// The ratio at `slot` if the pair is associated there; `both`: the slots where both have a point.
    pub(super) fn associated(
        &self,
        slot: Slot,
        window: &Window,
        both: SlotSet,
        rules: &ReferenceRules,
    ) -> Option<SlotRatio> {
        if !self.within.contains(slot) {
            return None;
        }
        let so_far = SlotSet::span(window.first, slot);
        let ratio =
            SlotRatio { co_present: both.and(so_far).count(), within: self.within.and(so_far).count() };
        // In whole numbers: 0.9 of 10 slots is 9, not 9.000000000000002.
        let is_enough = ratio.co_present >= rules.min_samples
            && u64::from(ratio.within) * 1_000_000 >= rules.min_ratio_ppm * u64::from(ratio.co_present);
        is_enough.then_some(ratio)
    }
}
