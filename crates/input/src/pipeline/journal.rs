//! Outputs for the latest input, and the counters of all inputs.

use std::collections::VecDeque;

use super::{Event, Tally};
use fusion::{Due, Emission};

/// An output for an input.
#[derive(Debug)]
pub enum Output {
    /// A slot that was due.
    Emission(Emission),
    /// An event in handling the input; already counted in the [`Tally`].
    Event(Event),
}

/// The outputs for the latest input: its due slots, and an event or two per record. The buffer is reused.
#[derive(Debug, Default)]
pub(super) struct Journal {
    pub(super) tally: Tally,
    pub(super) outputs: VecDeque<Output>,
}

impl Journal {
    /// Counts an event and queues it for the next poll.
    pub(super) fn note(&mut self, event: Event) {
        self.tally.count(&event);
        self.outputs.push_back(Output::Event(event));
    }

    /// Queues the due slots, and notes whether the engine restarts after them.
    pub(super) fn emit(&mut self, due: Due<'_>) {
        let restarts = due.restarts();
        for mut emission in due {
            let newcomers = std::mem::take(&mut emission.newcomers);
            let jumping = std::mem::take(&mut emission.jumping);
            self.outputs.push_back(Output::Emission(emission));
            newcomers.into_iter().for_each(|newcomers| self.note(Event::Newcomers(newcomers)));
            jumping.into_iter().for_each(|jumping| self.note(Event::JumpingTracks(jumping)));
        }
        if restarts {
            self.note(Event::Restarted);
        }
    }
}
