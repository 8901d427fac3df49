//! Association of radar tracks with a transponder, by distance threshold and ratio.

use serde::{Deserialize, Serialize};

use super::radar::Detections;
use super::transponder::IdentityCurve;
use crate::point::SlotRatio;
use crate::report::RadarTrackKey;
use crate::settings::ReferenceRules;
use crate::slots::{Slot, SlotSet, Window};

/// The radar tracks that came within the threshold of one transponder in the window. Others are not stored.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackAgreements(Vec<TrackAgreement>);

/// A radar track that came within the threshold.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct TrackAgreement {
    pub(super) track: RadarTrackKey,
    /// Slots in which both have a point and their distance is within the threshold.
    within: SlotSet,
}

impl TrackAgreements {
    /// Compares curve and detections again in the slots of `changed`; removes pairs that are no longer within the
    /// threshold.
    pub(super) fn update(
        &mut self,
        window: &Window,
        changed: SlotSet,
        curve: &IdentityCurve,
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

    fn entry(&mut self, track: RadarTrackKey) -> &mut TrackAgreement {
        let index = self.0.binary_search_by_key(&track, |pair| pair.track).unwrap_or_else(|index| {
            self.0.insert(index, TrackAgreement { track, within: SlotSet::EMPTY });
            index
        });
        &mut self.0[index]
    }

    /// The pairs, by radar track.
    pub(super) fn iter(&self) -> impl Iterator<Item = &TrackAgreement> {
        self.0.iter()
    }

    /// Whether any pair is associated in one of the slots from `from` to `to`.
    pub(super) fn any_associated(
        &self,
        (from, to): (Slot, Slot),
        window: &Window,
        curve: &IdentityCurve,
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

impl TrackAgreement {
    /// The ratio at `slot` if the pair is associated there; `both` are the slots in which both have a point.
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
