//! A cheap engine whose picture is a hash of all that it has handled, and of the position of the slots in between.

use std::collections::{BTreeSet, VecDeque};

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use serde::{Deserialize, Serialize};

use super::world::{Engine, Feed, LASTS_MS};
use crate::cell::CellEngine;
use crate::message::ReceivedDatagram;
use crate::region::{CellMessage, CellMessageContent};
use site::territory::CellName;

/// Number of slots from a slot's opening to its due time.
const LATENCY: i64 = 25;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Toy {
    hash: u64,
    known: BTreeSet<Vec<u8>>,
    next: Option<Slot>,
    made: VecDeque<(Slot, Vec<u8>)>,
    /// Messages to itself, recent ones, and the slots of those that it has read.
    messages: Vec<CellMessage>,
    recent: VecDeque<CellMessage>,
    read: BTreeSet<Slot>,
}

fn grid() -> SlotGrid {
    SlotGrid::default()
}

impl Toy {
    fn mix(&mut self, octets: &[u8]) {
        for octet in octets {
            self.hash = (self.hash ^ u64::from(*octet)).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(7);
        }
    }
}

impl Engine for Toy {
    fn new() -> Self {
        Self::default()
    }

    fn written(&self) -> Vec<u8> {
        postcard::to_stdvec(self).unwrap()
    }

    fn read(octets: &[u8]) -> Self {
        postcard::from_bytes(octets).unwrap()
    }
}

/// Two sensors, each with four datagrams a slot.
pub(super) fn feed() -> Feed {
    let sent =
        |(at_ms, sic): (i64, u8)| (at_ms, DataSource { sac: 25, sic }, format!("{sic} {at_ms}").into_bytes());
    (20..LASTS_MS).step_by(60).flat_map(|at_ms| [(at_ms, 1), (at_ms, 2)]).map(sent).collect()
}

impl CellEngine for Toy {
    fn receive(&mut self, datagram: &ReceivedDatagram, at: Time) {
        self.next.get_or_insert(grid().of(at).plus(1 - LATENCY));
        if self.known.insert(datagram.payload.clone()) {
            self.mix(&datagram.payload);
        }
    }

    fn tick(&mut self, now: Time) {
        while let Some(due) = self.next_due().filter(|due| *due <= now) {
            let slot = grid().of(due).plus(-LATENCY);
            self.mix(&slot.0.to_be_bytes());
            self.made.push_back((slot, self.hash.to_be_bytes().to_vec()));
            self.next = Some(slot.plus(1));
        }
    }

    fn next_due(&self) -> Option<Time> {
        Some(grid().open(self.next?.plus(LATENCY)))
    }

    /// Content and order of the messages change the hash.
    fn handle_message(&mut self, message: &CellMessage) {
        if self.read.insert(message.slot) {
            self.mix(&message.body());
        }
    }

    fn recent_messages(&self) -> Vec<CellMessage> {
        self.recent.iter().cloned().collect()
    }

    fn take_messages(&mut self) -> Vec<CellMessage> {
        std::mem::take(&mut self.messages)
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        let (slot, picture) = self.made.pop_front()?;
        let name = CellName::new("toy").unwrap();
        let content = CellMessageContent::Reject { id: format!("{:x}", self.hash) };
        self.messages = vec![CellMessage { from: name.clone(), to: name, slot, index: 0, content }];
        self.recent.extend(self.messages.clone());
        while self.recent.front().is_some_and(|message| message.slot < slot.plus(-80)) {
            self.recent.pop_front();
        }
        Some((slot, picture))
    }
}
