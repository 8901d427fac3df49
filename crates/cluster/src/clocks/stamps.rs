//! The datagrams whose timestamps a gateway reports.

use std::collections::{BTreeMap, VecDeque};

use asterix::DataSource;
use fusion::slots::Slot;
use fusion::time::Time;
use sha2::{Digest, Sha256};

use crate::message::GatewayInput;

/// Maximum number of datagrams reported per slot: 64 each second.
const MAX_PER_SLOT: usize = 16;
/// Maximum number of datagrams in a report: two seconds of busy lines.
const MAX_REPORTED: usize = 128;
/// Age after which datagrams are not reported, in slots: 10 s.
const MAX_AGE_SLOTS: u64 = 40;

/// The latest datagrams of a gateway with their timestamps. Each slot keeps those with the lowest hashes, which are the same for
/// all gateways that receive the same datagrams.
#[derive(Debug, Default)]
pub struct DatagramStamps {
    /// The current slot.
    slot: Option<Slot>,
    /// Lowest hashes of the current slot. `None` if the datagram was received twice: its copies are indistinguishable.
    lowest: BTreeMap<u64, Option<Time>>,
    known: VecDeque<(Slot, u64, Time)>,
}

impl DatagramStamps {
    /// Adds the datagrams of an input. Inputs are given slot by slot.
    pub fn note(&mut self, input: &GatewayInput) {
        if self.slot.is_some_and(|slot| slot != input.slot) {
            self.close(input.slot);
        }
        self.slot = Some(input.slot);
        for heard in &input.datagrams {
            let hash = hash(input.sensor, &heard.payload);
            self.lowest.entry(hash).and_modify(|stamp| *stamp = None).or_insert(Some(heard.received));
            if self.lowest.len() > MAX_PER_SLOT {
                self.lowest.pop_last();
            }
        }
    }

    fn close(&mut self, now: Slot) {
        let Some(slot) = self.slot else { return };
        let heard = std::mem::take(&mut self.lowest).into_iter();
        self.known.extend(heard.filter_map(|(hash, stamp)| Some((slot, hash, stamp?))));
        let too_many = self.known.len().saturating_sub(MAX_REPORTED);
        self.known.drain(..too_many);
        self.known.retain(|(slot, ..)| slot.0.abs_diff(now.0) <= MAX_AGE_SLOTS);
    }

    /// Hash and timestamp, in nanoseconds since 1970, of each datagram, the oldest first.
    pub fn recent(&self) -> Vec<(u64, i64)> {
        self.known.iter().map(|(_, hash, stamp)| (*hash, stamp.nanos())).collect()
    }
}

/// Hash by which two gateways identify a datagram: the line's sensor and the octets.
fn hash(sensor: DataSource, payload: &[u8]) -> u64 {
    let digest = Sha256::new().chain_update([sensor.sac, sensor.sic]).chain_update(payload).finalize();
    let (first, _) = digest.split_first_chunk().expect("a digest has 32 octets");
    u64::from_be_bytes(*first)
}
