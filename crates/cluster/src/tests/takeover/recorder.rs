//! An engine whose picture shows which inputs were handled before which slot.

use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use crate::cell::CellEngine;
use crate::message::{LoggedMessage, ReceivedDatagram};
use crate::region::{CellMessage, CellMessageContent};
use site::territory::CellName;

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Recorder {
    /// Number of slots made.
    slots: i64,
    /// Inputs and slots in the order of handling.
    history: Vec<u8>,
    made: Option<(Slot, Vec<u8>)>,
}

/// Stands for a slot in the history.
const SLOT: u8 = u8::MAX;

/// Slots of a minute: an owner's waits end before the next slot is due.
pub(super) fn grid() -> SlotGrid {
    SlotGrid::new(SignedDuration::from_secs(60))
}

/// The input with this sequence.
pub(super) fn input(sequence: u64) -> LoggedMessage {
    let name = CellName::new("c").expect("a name");
    let index = u16::try_from(sequence).expect("a model has few inputs");
    let content = CellMessageContent::RequestBlock;
    LoggedMessage::Message(Box::new(CellMessage {
        from: name.clone(),
        to: name,
        slot: Slot(0),
        index,
        content,
    }))
}

impl CellEngine for Recorder {
    fn receive(&mut self, _: &ReceivedDatagram, _: Time) {
        unreachable!("the inputs of the model are messages")
    }

    fn handle_message(&mut self, message: &CellMessage) {
        self.history.push(message.index as u8);
    }

    fn tick(&mut self, now: Time) {
        if self.next_due().is_some_and(|due| due <= now) {
            self.history.push(SLOT);
            self.made = Some((Slot(self.slots), self.history.clone()));
            self.slots += 1;
        }
    }

    fn next_due(&self) -> Option<Time> {
        Some(grid().open(Slot(self.slots + 1)))
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        self.made.take()
    }
}

impl Recorder {
    /// Number of slots made.
    pub(super) const fn slots(&self) -> i64 {
        self.slots
    }

    /// The picture of a slot that is made after this input, by an engine that handles every input.
    pub(super) fn expected(&mut self, slot: Slot, after_input: u64) -> Option<Vec<u8>> {
        let handled = self.history.iter().filter(|entry| **entry != SLOT).count() as u64;
        for sequence in handled + 1..=after_input {
            self.history.push(sequence as u8);
        }
        self.tick(self.next_due()?);
        self.poll().filter(|(made, _)| *made == slot).map(|(_, picture)| picture)
    }
}
