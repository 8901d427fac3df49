//! An engine that is cheap, and forgets nothing: its picture is a hash of all that it has handled, and where the slots fell.

use std::collections::{BTreeSet, VecDeque};

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use serde::{Deserialize, Serialize};

use super::world::{Engine, Feed, LASTS_MS};
use crate::cluster::cell::Fusing;
use crate::cluster::message::Heard;
use crate::cluster::region::{Letter, Word};
use crate::territory::CellName;

/// Slots from a slot's opening to when it is due.
const LATENCY: i64 = 25;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Toy {
    hash: u64,
    known: BTreeSet<Vec<u8>>,
    next: Option<Slot>,
    made: VecDeque<(Slot, Vec<u8>)>,
    /// Its letters to itself, and the slots of those that it has read.
    letters: Vec<Letter>,
    recent: VecDeque<Letter>,
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

impl Fusing for Toy {
    fn receive(&mut self, heard: &Heard, at: Time) {
        self.next.get_or_insert(grid().of(at).plus(1 - LATENCY));
        if self.known.insert(heard.payload.clone()) {
            self.mix(&heard.payload);
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

    /// What it reads counts, and where it reads it.
    fn letter(&mut self, letter: &Letter) {
        if self.read.insert(letter.slot) {
            self.mix(&letter.body());
        }
    }

    fn recent_letters(&self) -> Vec<Letter> {
        self.recent.iter().cloned().collect()
    }

    fn letters(&mut self) -> Vec<Letter> {
        std::mem::take(&mut self.letters)
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        let (slot, picture) = self.made.pop_front()?;
        let name = CellName::new("toy").unwrap();
        let word = Word::Unknown { id: format!("{:x}", self.hash) };
        self.letters = vec![Letter { from: name.clone(), to: name, slot, index: 0, word }];
        self.recent.extend(self.letters.clone());
        while self.recent.front().is_some_and(|letter| letter.slot < slot.plus(-80)) {
            self.recent.pop_front();
        }
        Some((slot, picture))
    }
}
