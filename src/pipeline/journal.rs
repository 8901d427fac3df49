//! Outputs of the latest input, and the counters of all of them.

use std::collections::VecDeque;

use super::{Event, Tally};
use fusion::{Due, Emission};

/// A result of an input.
#[derive(Debug)]
pub enum Output {
    /// A slot that was due.
    Emission(Emission),
    /// The treatment of the input; already counted in the [`Tally`].
    Event(Event),
}

/// The outputs of the latest input, at most its due slots and an event or two per record; the buffer is reused.
#[derive(Debug, Default)]
pub(super) struct Journal {
    pub(super) tally: Tally,
    pub(super) outputs: VecDeque<Output>,
}

impl Journal {
    /// Counts an event, and keeps it for the next poll.
    pub(super) fn note(&mut self, event: Event) {
        self.tally.count(&event);
        self.outputs.push_back(Output::Event(event));
    }

    /// The slots that are due, and whether the engine starts afresh after them.
    pub(super) fn emit(&mut self, due: Due<'_>) {
        let restarts = due.restarts();
        for mut emission in due {
            let newcomers = std::mem::take(&mut emission.newcomers);
            self.outputs.push_back(Output::Emission(emission));
            newcomers.into_iter().for_each(|newcomers| self.note(Event::Newcomers(newcomers)));
        }
        if restarts {
            self.note(Event::Restarted);
        }
    }
}
