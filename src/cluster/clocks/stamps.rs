//! Which datagrams a gateway says when it heard.

use std::collections::{BTreeMap, VecDeque};

use asterix::DataSource;
use fusion::slots::Slot;
use fusion::time::Time;
use sha2::{Digest, Sha256};

use crate::cluster::message::Input;

/// Of each slot so many are said: 64 a second.
const OF_A_SLOT: usize = 16;
/// As many are said at once: two seconds of busy lines.
const SAID: usize = 128;
/// Nobody is told of older ones, slots: 10 s.
const OLD: u64 = 40;

/// The latest datagrams of a gateway with their stamps: of each slot those with the lowest hashes, which are the same ones for
/// all gateways that hear the same.
#[derive(Debug, Default)]
pub struct Stamps {
    /// The slot that is being heard.
    slot: Option<Slot>,
    /// Its lowest hashes. `None`: heard twice, so that nobody knows which is which.
    lowest: BTreeMap<u64, Option<Time>>,
    known: VecDeque<(Slot, u64, Time)>,
}

impl Stamps {
    /// Takes note of what was heard; slot by slot.
    pub fn note(&mut self, input: &Input) {
        if self.slot.is_some_and(|slot| slot != input.slot) {
            self.close(input.slot);
        }
        self.slot = Some(input.slot);
        for heard in &input.heard {
            let hash = hash(input.sensor, &heard.payload);
            self.lowest.entry(hash).and_modify(|stamp| *stamp = None).or_insert(Some(heard.received));
            if self.lowest.len() > OF_A_SLOT {
                self.lowest.pop_last();
            }
        }
    }

    fn close(&mut self, now: Slot) {
        let Some(slot) = self.slot else { return };
        let heard = std::mem::take(&mut self.lowest).into_iter();
        self.known.extend(heard.filter_map(|(hash, stamp)| Some((slot, hash, stamp?))));
        let too_many = self.known.len().saturating_sub(SAID);
        self.known.drain(..too_many);
        self.known.retain(|(slot, ..)| slot.0.abs_diff(now.0) <= OLD);
    }

    /// Hash and stamp, nanoseconds since 1970, of each, the oldest first.
    pub fn said(&self) -> Vec<(u64, i64)> {
        self.known.iter().map(|(_, hash, stamp)| (*hash, stamp.nanos())).collect()
    }
}

/// What two gateways know a datagram by: the line's sensor and the octets.
fn hash(sensor: DataSource, payload: &[u8]) -> u64 {
    let digest = Sha256::new().chain_update([sensor.sac, sensor.sic]).chain_update(payload).finalize();
    let (first, _) = digest.split_first_chunk().expect("a digest has 32 octets");
    u64::from_be_bytes(*first)
}
