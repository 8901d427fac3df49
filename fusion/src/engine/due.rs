//! The slots that an input makes due.

use super::Engine;
use crate::point::Emission;
use crate::slots::Slot;
use crate::time::Time;

/// The slots that are due, in order. Dropping it emits and discards the slots that were not taken.
#[derive(Debug)]
#[must_use = "the due slots are the engine's output"]
pub struct Due<'a> {
    pub(super) engine: &'a mut Engine,
    pub(super) last: Option<Slot>,
    pub(super) restart: Option<Time>,
}

impl Due<'_> {
    /// Whether the engine restarts with an empty window after these slots.
    pub fn restarts(&self) -> bool {
        self.restart.is_some()
    }
}

impl Iterator for Due<'_> {
    type Item = Emission;

    fn next(&mut self) -> Option<Emission> {
        if self.last.zip(self.engine.next_slot()).is_some_and(|(last, next)| next <= last) {
            return self.engine.emit();
        }
        if let Some(received) = self.restart.take() {
            self.engine.restart(received);
        }
        None
    }
}

impl Drop for Due<'_> {
    fn drop(&mut self) {
        self.for_each(drop);
    }
}
