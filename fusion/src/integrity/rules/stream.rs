//! What one receiver hears of one identity, and the rules that need no more.

use serde::{Deserialize, Serialize};

use super::frozen::Frozen;
use super::history::{Heard, History};
use super::jump::{Break, Jump};
use super::places::Places;
use super::replay::{Kin, Replay};
use super::velocity::Velocity;
use super::{Finding, Reason, silence};
use crate::report::SensorIndex;
use crate::time::Time;

/// What one receiver hears of one identity.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Stream {
    pub(super) sensor: SensorIndex,
    pub(super) history: History,
    number: u32,
    jump: Jump,
    frozen: Frozen,
    replay: Replay,
    velocity: Velocity,
}

impl Stream {
    /// A stream without a report; `number` is its own among all streams.
    pub(super) fn new(sensor: SensorIndex, number: u32) -> Self {
        Self {
            sensor,
            history: History::default(),
            number,
            jump: Jump::default(),
            frozen: Frozen::default(),
            replay: Replay::default(),
            velocity: Velocity::default(),
        }
    }

    /// Takes a report; false where it was there already or is too old to say anything.
    pub(super) fn hear(&mut self, heard: Heard, places: &mut Places, kin: Kin) -> bool {
        let Some(at) = self.history.insert(heard) else { return false };
        self.frozen.hear(&self.history, at);
        self.replay.hear(heard, self.number, places, kin);
        if at + 1 == self.history.len() {
            let noise_m = || self.jump.noise_m();
            self.velocity.look(&self.history, noise_m);
        }
        true
    }

    /// Judges the motion up to now: where it broke off.
    pub(super) fn breaks(&mut self) -> impl Iterator<Item = Break> {
        std::iter::from_fn(|| self.jump.judge(&self.history)).flatten()
    }

    /// Adds what its rules find at the deadline.
    pub(super) fn tell(&self, deadline: Time, finding: &mut Finding) {
        let Finding { suspect, failed, still_since, .. } = finding;
        if self.jump.holds(deadline) {
            suspect.insert(Reason::Jump);
        }
        if self.velocity.holds(deadline) {
            suspect.insert(Reason::Velocity);
        }
        if self.frozen.is_suspect() && self.is_heard(deadline) {
            suspect.insert(Reason::Frozen);
        }
        if self.frozen.has_failed() && self.is_heard(deadline) {
            failed.insert(Reason::Frozen);
        }
        if self.replay.holds() && self.is_heard(deadline) {
            failed.insert(Reason::Replay);
        }
        let stands = self.frozen.still_since().filter(|_| self.is_heard(deadline));
        *still_since = still_since.iter().copied().chain(stands).min();
    }

    /// Whether it sends what was sent before.
    pub(super) fn is_replay(&self) -> bool {
        self.replay.holds()
    }

    fn is_heard(&self, deadline: Time) -> bool {
        !silence::is_over(&self.history, deadline)
    }
}
