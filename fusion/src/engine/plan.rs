//! Operators' decisions of a replayed flight or from before a restart, carried out when they are due.

use serde::{Deserialize, Serialize};

use crate::integrity::TrustOverride;
use crate::operational::{
    self, ManualAssociation, Operational, RadarRelocation, RestoredAssociation, SavedAssociation,
};
use crate::slots::Slot;
use crate::time::Time;

/// Planned correlations and trust overrides.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Plan {
    /// Correlations by slot; those of one slot in their order.
    pub(super) correlations: Vec<(Slot, ManualAssociation)>,
    /// Operators' trust overrides by slot; those of one slot in their order.
    pub(super) overrides: Vec<(Slot, TrustOverride)>,
    /// Operators' relocations of radars by slot; those of one slot in their order.
    pub(super) relocations: Vec<(Slot, RadarRelocation)>,
    /// First slot of the replay.
    pub(super) first: Option<Slot>,
    /// Number of correlations whose radar track or transponder was never present.
    pub(super) missed: u64,
    /// Restored correlations that are still undecided. `resumed` has the outcomes of the others.
    pub(super) kept: Vec<SavedAssociation>,
    pub(super) resumed: Vec<RestoredAssociation>,
}

impl Plan {
    /// Carries out the decisions of this slot, and earlier ones whose radar track is still missing.
    pub(super) fn carry_out(
        &mut self,
        slot: Slot,
        window_slots: i64,
        operational: &mut Operational,
        profile: &operational::OperationalSettings,
    ) {
        let is_beginning = self.first.is_some_and(|first| slot < first.plus(window_slots));
        let due = self.overrides.partition_point(|planned| planned.0 <= slot);
        self.overrides.drain(..due).for_each(|(since, word)| operational.set_trust(word, since));
        let due = self.relocations.partition_point(|planned| planned.0 <= slot);
        // The registration from before the replay rests on the relocations from then.
        let first = self.first;
        for (since, decided) in self.relocations.drain(..due) {
            operational.relocate(decided, since, first.is_none_or(|first| since >= first));
        }
        let missed = &mut self.missed;
        self.correlations.retain(|&(at, correlation)| {
            if at > slot {
                return true;
            }
            let is_there = operational.correlate(correlation, at, profile).is_ok();
            *missed += u64::from(!is_there && !is_beginning);
            !is_there && is_beginning
        });
    }

    /// Looks for the radar tracks of restored correlations; none takes effect before its original slot.
    pub(super) fn resume(
        &mut self,
        (slot, time): (Slot, Time),
        operational: &mut Operational,
        profile: &operational::OperationalSettings,
    ) {
        let Self { kept, resumed, missed, .. } = self;
        kept.retain(|&kept| {
            if kept.held.since > slot {
                return true;
            }
            let known = operational.resume(kept, time, profile);
            *missed += u64::from(matches!(known, Some(RestoredAssociation::Ended(_))));
            resumed.extend(known);
            known.is_none()
        });
    }

    /// Ends the restored correlations: their radar tracks do not come back.
    pub(super) fn end_kept(&mut self) {
        self.missed += self.kept.len() as u64;
        self.resumed.extend(self.kept.drain(..).map(|kept| RestoredAssociation::Ended(kept.held)));
    }
}
