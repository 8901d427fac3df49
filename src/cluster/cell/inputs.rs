//! A cell's reading of the input: it gives reference time, and messages that an owner refuses.

use std::collections::BTreeMap;

use fusion::slots::Slot;
use fusion::time::Time;
use jiff::SignedDuration;

use super::{Cell, Fusing};
use crate::cluster::message::{Header, Logged, Origin};
use crate::cluster::reference_clock::{Moment, Refusal};

/// A letter is written with a slot that is published, or with one a few seconds ahead from which it holds.
const LETTERS_AHEAD: SignedDuration = SignedDuration::from_secs(30);
/// Most names of gateways in what is said of refused messages.
const NAMED: usize = 64;

/// A message of the input, as it was read.
#[derive(Clone, Debug)]
pub struct Read {
    /// When the log stamped it: the same for all who read it.
    pub stamp: Time,
    /// When it was read.
    pub at: Moment,
    /// Its header; `None`: it is a letter.
    pub header: Option<Header>,
    /// The message, if it is for this cell.
    pub logged: Option<Logged>,
    /// Whether the log held more.
    pub has_more: bool,
}

/// Messages that were refused: of which gateway and why, how many, and the greatest error of a clock, positive where it is ahead.
pub type Refusals = BTreeMap<(String, Refusal), (u64, SignedDuration)>;

impl<E: Fusing> Cell<E> {
    /// A message of the input, in order of its sequence, of a log whose owner says what is refused; again is as good as once.
    pub fn input(&mut self, sequence: u64, logged: Logged) {
        self.queue(sequence, logged, false);
    }

    /// The same, as a node reads it that may own the cell: it says what time it is, and is refused where its gateway's clock is
    /// wrong, or its slot is not over.
    pub fn read(&mut self, sequence: u64, read: Read) {
        let Read { stamp, at, header, logged, has_more } = read;
        self.more(has_more);
        if sequence <= self.read {
            return;
        }
        let refusal = match (&header, &logged) {
            (Some(Header { origin: Some(Origin { gateway, config, .. }), .. }), _)
                if ![0, self.config].contains(config) && self.config != 0 =>
            {
                Some(((gateway.clone(), Refusal::Configuration), SignedDuration::ZERO))
            }
            (Some(header), _) => {
                let ends = self.ends(header.slot);
                let gateway = header.origin.as_ref().map(|origin| (origin.gateway.as_str(), origin.sent));
                let refusal = self.time.read(gateway, stamp, ends, at);
                let name = gateway.map_or("of the version before", |(name, _)| name);
                refusal.map(|(why, by)| ((name.to_owned(), why), by))
            }
            (None, Some(Logged::Letter(letter))) => {
                let ahead = self.ends(letter.slot) - self.time.now(at);
                (ahead > LETTERS_AHEAD).then(|| ((letter.from.to_string(), Refusal::Slot), ahead))
            }
            (None, _) => None,
        };
        let is_refused = refusal.is_some();
        if let Some((of, by)) = refusal.filter(|_| logged.is_some()) {
            let is_full = self.refusals.len() >= NAMED && !self.refusals.contains_key(&of);
            let of = if is_full { ("others".to_owned(), of.1) } else { of };
            let (count, most) = self.refusals.entry(of).or_default();
            *count += 1;
            if by.abs() > most.abs() {
                *most = by;
            }
        }
        logged.into_iter().for_each(|logged| self.queue(sequence, logged, is_refused));
    }

    fn queue(&mut self, sequence: u64, logged: Logged, is_refused: bool) {
        if sequence > self.read {
            self.read = sequence;
            self.inputs.push_back((sequence, logged, is_refused));
        }
    }

    /// Reference time at this node.
    pub fn now(&self, at: Moment) -> Time {
        self.time.now(at)
    }

    /// The messages refused since the last call.
    pub fn refusals(&mut self) -> Refusals {
        std::mem::take(&mut self.refusals)
    }

    /// The end of a slot. What is beyond all time never ends.
    fn ends(&self, slot: Slot) -> Time {
        let slot_ns = i64::try_from(self.grid.slot().as_nanos()).unwrap_or(i64::MAX);
        Time::from_nanos(slot.0.saturating_add(1).saturating_mul(slot_ns))
    }
}
