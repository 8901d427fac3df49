//! Operators' decisions of a flight that is replayed, or of before a restart: carried out when their time comes.

use serde::{Deserialize, Serialize};

use crate::integrity::Word;
use crate::operational::{self, Correlation, Operational, ResumedCorrelation, SavedCorrelation};
use crate::slots::Slot;
use crate::time::Time;

/// Correlations and words of then.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Plan {
    /// By slot, those of one slot in their order.
    pub(super) correlations: Vec<(Slot, Correlation)>,
    /// Operators' words on identities, by slot, those of one slot in their order.
    pub(super) words: Vec<(Slot, Word)>,
    /// The first slot of the replay.
    pub(super) first: Option<Slot>,
    /// Correlations on what never was there.
    pub(super) missed: u64,
    /// Correlations of before a restart of which it is not known yet whether they hold, and what has become of the others.
    pub(super) kept: Vec<SavedCorrelation>,
    pub(super) resumed: Vec<ResumedCorrelation>,
}

impl Plan {
    /// What was decided for this slot, and what is still to be found.
    pub(super) fn carry_out(
        &mut self,
        slot: Slot,
        window_slots: i64,
        operational: &mut Operational,
        profile: &operational::Settings,
    ) {
        let is_beginning = self.first.is_some_and(|first| slot < first.plus(window_slots));
        let due = self.words.partition_point(|planned| planned.0 <= slot);
        self.words.drain(..due).for_each(|(since, word)| operational.say(word, since));
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

    /// Looks for the radar tracks of the decisions of before a restart; none counts earlier than it did then.
    pub(super) fn resume(
        &mut self,
        (slot, time): (Slot, Time),
        operational: &mut Operational,
        profile: &operational::Settings,
    ) {
        let Self { kept, resumed, missed, .. } = self;
        kept.retain(|&kept| {
            if kept.held.since > slot {
                return true;
            }
            let known = operational.resume(kept, time, profile);
            *missed += u64::from(matches!(known, Some(ResumedCorrelation::Ended(_))));
            resumed.extend(known);
            known.is_none()
        });
    }

    /// The radar tracks of before are not heard again.
    pub(super) fn end_kept(&mut self) {
        self.missed += self.kept.len() as u64;
        self.resumed.extend(self.kept.drain(..).map(|kept| ResumedCorrelation::Ended(kept.held)));
    }
}
