//! The reports of one identity at one receiver, and the rules that need no others.

use serde::{Deserialize, Serialize};

use super::finding::Finding;
use super::frozen::Frozen;
use super::history::{ReportHistory, TimedReport};
use super::jump::{Jump, MotionBreak};
use super::places::ReportPlaces;
use super::replay::{Replay, SiblingStreams};
use super::silence;
use super::velocity::Velocity;
use crate::integrity::state::Reason;
use crate::report::SensorIndex;
use crate::time::Time;

/// The reports of one identity at one receiver.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ReportStream {
    pub(super) sensor: SensorIndex,
    pub(super) history: ReportHistory,
    number: u32,
    jump: Jump,
    frozen: Frozen,
    replay: Replay,
    velocity: Velocity,
}

impl ReportStream {
    /// Creates an empty stream; `number` is unique among all streams.
    pub(super) fn new(sensor: SensorIndex, number: u32) -> Self {
        Self {
            sensor,
            history: ReportHistory::default(),
            number,
            jump: Jump::default(),
            frozen: Frozen::default(),
            replay: Replay::default(),
            velocity: Velocity::default(),
        }
    }

    /// Adds a report; returns `false` if it is a duplicate or too old.
    pub(super) fn add_report(
        &mut self,
        heard: TimedReport,
        places: &mut ReportPlaces,
        kin: SiblingStreams,
    ) -> bool {
        let Some(at) = self.history.insert(heard) else { return false };
        self.frozen.add_report(&self.history, at);
        self.replay.add_report(heard, self.number, places, kin);
        if at + 1 == self.history.len() {
            let noise_m = || self.jump.noise_m();
            self.velocity.evaluate(&self.history, noise_m);
        }
        true
    }

    /// Evaluates the motion so far; returns its breaks.
    pub(super) fn breaks(&mut self) -> impl Iterator<Item = MotionBreak> {
        std::iter::from_fn(|| self.jump.evaluate_next_gap(&self.history)).flatten()
    }

    /// Adds the results of the stream's rules at the deadline.
    pub(super) fn add_findings(&self, deadline: Time, finding: &mut Finding) {
        let Finding { suspect, failed, still_since, .. } = finding;
        if self.jump.is_active(deadline) {
            suspect.insert(Reason::Jump);
        }
        if self.velocity.is_active(deadline) {
            suspect.insert(Reason::Velocity);
        }
        if self.frozen.is_suspect() && self.is_heard(deadline) {
            suspect.insert(Reason::Frozen);
        }
        if self.frozen.has_failed() && self.is_heard(deadline) {
            failed.insert(Reason::Frozen);
        }
        if self.replay.is_active() && self.is_heard(deadline) {
            failed.insert(Reason::Replay);
        }
        let stands = self.frozen.still_since().filter(|_| self.is_heard(deadline));
        *still_since = still_since.iter().copied().chain(stands).min();
    }

    /// Whether it repeats earlier reports.
    pub(super) fn is_replay(&self) -> bool {
        self.replay.is_active()
    }

    fn is_heard(&self, deadline: Time) -> bool {
        !silence::is_over(&self.history, deadline)
    }
}
