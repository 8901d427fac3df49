//! The pass that judges transponders: states from the evidence of radar tracks and from their own reports.

use std::collections::BTreeMap;

use super::cycle::Cycle;
use super::settings::Settings;
use super::targets::Targets;
use super::tracklets::Tracklets;
use crate::integrity::{Action, Assessment, Concern, HeldWord, ReportRules, Trust, Word};
use crate::point::Point;
use crate::report::{Fix, Identity};
use crate::slots::Slot;

/// What is known of every identity heard lately.
#[derive(Debug, Default)]
pub(super) struct Integrities {
    reports: ReportRules,
    assessments: BTreeMap<Identity, Assessment>,
    /// What operators say, by identity.
    words: BTreeMap<Identity, HeldWord>,
}

impl Integrities {
    /// Takes the reports that came since the last slot, by time.
    pub(super) fn hear(&mut self, fixes: &[Fix], settings: &Settings) {
        if settings.integrity.action != Action::Off {
            self.reports.take(fixes);
        }
    }

    /// Judges every identity by what is known at the slot's deadline.
    pub(super) fn assess(&mut self, _tracklets: &Tracklets, _targets: &Targets, cycle: &Cycle) {
        if cycle.settings.integrity.action != Action::Off {
            self.reports.look(cycle.deadline);
        }
    }

    /// Marks the points of the slot, and says what is wrong at it.
    pub(super) fn mark(&self, _points: &mut [Point]) -> Vec<Concern> {
        Vec::new()
    }

    /// An operator's word, from the slot `since` on.
    pub(super) fn say(&mut self, word: Word, since: Slot) {
        match word.trust {
            Trust::Automatic => _ = self.words.remove(&word.identity),
            Trust::Trusted | Trust::Distrusted => {
                _ = self.words.insert(word.identity, HeldWord { word, since })
            }
        }
    }

    /// The operators' words in force, by identity.
    pub(super) fn words(&self) -> impl Iterator<Item = HeldWord> {
        self.words.values().copied()
    }

    /// What is known of each identity heard lately.
    pub(super) fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.assessments.values()
    }
}
