//! Reading of a cell's inputs: derives reference time, and refuses messages.

use std::collections::BTreeMap;

use fusion::slots::Slot;
use fusion::time::Time;
use jiff::SignedDuration;

use super::{Cell, CellEngine};
use crate::message::{InputHeader, InputOrigin, LoggedMessage};
use crate::reference_clock::{ClockReading, InputRefusal};

/// Maximum time by which the slot of a message to the cell may be ahead. The slot is a published one, or one a few seconds ahead
/// from which the message takes effect.
const MAX_MESSAGE_LEAD: SignedDuration = SignedDuration::from_secs(30);
/// Maximum number of gateway names in the counts of refused messages.
const MAX_NAMED_GATEWAYS: usize = 64;

/// An input as read from the log.
#[derive(Clone, Debug)]
pub struct InputRecord {
    /// The log's timestamp, which is the same for every reader.
    pub stamp: Time,
    /// Time of reading.
    pub at: ClockReading,
    /// Header of the input; `None` for a message to the cell.
    pub header: Option<InputHeader>,
    /// The message, if it is addressed to this cell.
    pub logged: Option<LoggedMessage>,
    /// Whether the log held more input.
    pub has_more: bool,
}

/// Refused messages by gateway and reason: their number, and the greatest clock error, positive if the clock is ahead.
pub type InputRefusals = BTreeMap<(String, InputRefusal), (u64, SignedDuration)>;

impl<E: CellEngine> Cell<E> {
    /// Adds an input of a log whose owner decides which messages are refused. Inputs are given in order of their sequences;
    /// repeated ones are ignored.
    pub fn add_input(&mut self, sequence: u64, logged: LoggedMessage) {
        self.enqueue(sequence, logged, false);
    }

    /// Adds an input as read by a node that may own the cell. The input updates reference time. It is refused if its gateway's
    /// clock is wrong, or if its slot is not over.
    pub fn read_input(&mut self, sequence: u64, read: InputRecord) {
        let InputRecord { stamp, at, header, logged, has_more } = read;
        self.set_has_more(has_more);
        if sequence <= self.read {
            return;
        }
        let refusal = match (&header, &logged) {
            (Some(InputHeader { origin: Some(InputOrigin { gateway, config, .. }), .. }), _)
                if ![0, self.config].contains(config) && self.config != 0 =>
            {
                Some(((gateway.clone(), InputRefusal::Configuration), SignedDuration::ZERO))
            }
            (Some(header), _) => {
                let ends = self.slot_end(header.slot);
                let gateway = header.origin.as_ref().map(|origin| (origin.gateway.as_str(), origin.sent));
                let refusal = self.time.read(gateway, stamp, ends, at);
                let name = gateway.map_or("of the version before", |(name, _)| name);
                refusal.map(|(why, by)| ((name.to_owned(), why), by))
            }
            (None, Some(LoggedMessage::Message(message))) => {
                let ahead = self.slot_end(message.slot) - self.time.now(at);
                (ahead > MAX_MESSAGE_LEAD).then(|| ((message.from.to_string(), InputRefusal::Slot), ahead))
            }
            (None, _) => None,
        };
        let is_refused = refusal.is_some();
        if let Some((of, by)) = refusal.filter(|_| logged.is_some()) {
            let is_full = self.refusals.len() >= MAX_NAMED_GATEWAYS && !self.refusals.contains_key(&of);
            let of = if is_full { ("others".to_owned(), of.1) } else { of };
            let (count, most) = self.refusals.entry(of).or_default();
            *count += 1;
            if by.abs() > most.abs() {
                *most = by;
            }
        }
        logged.into_iter().for_each(|logged| self.enqueue(sequence, logged, is_refused));
    }

    fn enqueue(&mut self, sequence: u64, logged: LoggedMessage, is_refused: bool) {
        if sequence > self.read {
            self.read = sequence;
            self.inputs.push_back((sequence, logged, is_refused));
        }
    }

    /// Reference time at this node.
    pub fn now(&self, at: ClockReading) -> Time {
        self.time.now(at)
    }

    /// Takes the messages refused since the last call.
    pub fn refusals(&mut self) -> InputRefusals {
        std::mem::take(&mut self.refusals)
    }

    /// End of a slot. A slot beyond the range of [`Time`] never ends.
    fn slot_end(&self, slot: Slot) -> Time {
        let slot_ns = i64::try_from(self.grid.slot().as_nanos()).unwrap_or(i64::MAX);
        Time::from_nanos(slot.0.saturating_add(1).saturating_mul(slot_ns))
    }
}
