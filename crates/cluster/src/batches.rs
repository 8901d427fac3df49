//! A gateway's messages: the datagrams received in each slot. Sans-IO.

use std::net::SocketAddr;

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use super::message::{GatewayInput, ReceivedDatagram};

/// Maximum size of a message's datagrams, in octets. Datagrams beyond it go into further messages of the slot.
const MAX_OCTETS: usize = 32 << 10;
/// Time from the end of a slot to its messages, so that datagrams received in the slot have left their sockets.
const CLOSING_DELAY: SignedDuration = SignedDuration::from_millis(10);
/// Number of slots after which missed slots get no messages: the gateway was suspended, and another gateway has reported them.
const MAX_MISSED_SLOTS: i64 = 8;

/// Collects received datagrams into a gateway's messages.
#[derive(Debug)]
pub struct InputBatcher {
    grid: SlotGrid,
    lines: Vec<LineBatch>,
    /// The current slot.
    slot: Slot,
}

/// Datagrams received on a line in the current slot.
#[derive(Debug)]
struct LineBatch {
    sensor: DataSource,
    to: SocketAddr,
    part: u16,
    octets: usize,
    datagrams: Vec<ReceivedDatagram>,
}

impl InputBatcher {
    /// Starts at `now`. `lines` lists for each line its first sensor and its destination address.
    pub fn new(grid: SlotGrid, lines: impl IntoIterator<Item = (DataSource, SocketAddr)>, now: Time) -> Self {
        let batch = |(sensor, to)| LineBatch { sensor, to, part: 0, octets: 0, datagrams: Vec::new() };
        Self { grid, lines: lines.into_iter().map(batch).collect(), slot: grid.of(now) }
    }

    /// Adds a datagram received on a line. Returns a message if the line's message is full.
    pub fn add(
        &mut self,
        line: usize,
        received: Time,
        from: SocketAddr,
        payload: Vec<u8>,
    ) -> Option<GatewayInput> {
        let slot = self.slot;
        let batch = self.lines.get_mut(line)?;
        let full = (batch.octets > 0 && batch.octets + payload.len() > MAX_OCTETS)
            .then(|| batch.message(slot, false));
        batch.octets += payload.len();
        batch.datagrams.push(ReceivedDatagram { received, from, to: batch.to, payload });
        full
    }

    /// Time at which the messages of the current slot are due.
    pub fn due_at(&self) -> Time {
        self.grid.open(self.slot.plus(1)) + CLOSING_DELAY
    }

    /// Returns the messages of the slots that are over by `now`. Each line has at least one message per slot, even without
    /// datagrams.
    pub fn close_slots(&mut self, now: Time) -> Vec<GatewayInput> {
        let mut ended = Vec::new();
        let latest = self.grid.of(now + -CLOSING_DELAY);
        // The clock was set back, or the gateway was suspended.
        if !(0..=MAX_MISSED_SLOTS).contains(&(latest.0 - self.slot.0)) {
            self.slot = latest.plus(-1);
        }
        while self.slot < latest {
            let slot = self.slot;
            ended.extend(self.lines.iter_mut().map(|batch| batch.message(slot, true)));
            self.slot = slot.plus(1);
        }
        ended
    }
}

impl LineBatch {
    fn message(&mut self, slot: Slot, is_last: bool) -> GatewayInput {
        let part = self.part;
        self.part = if is_last { 0 } else { part.saturating_add(1) };
        self.octets = 0;
        GatewayInput {
            origin: None,
            sensor: self.sensor,
            slot,
            part,
            is_last,
            datagrams: std::mem::take(&mut self.datagrams),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SENSORS: [DataSource; 2] = [DataSource { sac: 25, sic: 1 }, DataSource { sac: 25, sic: 2 }];

    fn at(ms: i64) -> Time {
        Time::from_nanos(1_795_168_800_000_000_000 + ms * 1_000_000)
    }

    fn batches() -> InputBatcher {
        let to = "239.1.1.1:8048".parse().unwrap();
        InputBatcher::new(SlotGrid::default(), SENSORS.map(|sensor| (sensor, to)), at(0))
    }

    fn from() -> SocketAddr {
        "127.0.0.1:5000".parse().unwrap()
    }

    #[test]
    fn slot_has_one_message_per_line_even_if_silent() {
        let mut batches = batches();
        assert_eq!(batches.add(1, at(20), from(), vec![1; 40]), None);
        assert!(batches.close_slots(at(200)).is_empty());
        let due_at = batches.due_at();
        let ended = batches.close_slots(due_at);
        assert_eq!(ended.iter().map(|input| input.sensor).collect::<Vec<_>>(), SENSORS);
        assert_eq!(ended.iter().map(|input| input.datagrams.len()).collect::<Vec<_>>(), [0, 1]);
        assert!(ended.iter().all(|input| input.is_last && input.part == 0));
        // The next end is within one slot of 0.25 s.
        assert!(
            due_at > at(0)
                && due_at <= at(260)
                && batches.due_at() == due_at + SignedDuration::from_millis(250)
        );
    }

    #[test]
    fn suspended_gateway_sends_only_the_last_ended_slot() {
        let mut batches = batches();
        batches.add(0, at(10), from(), vec![1]);
        let ended = batches.close_slots(at(60_000));
        assert_eq!(ended.len(), SENSORS.len());
        assert_eq!(ended[0].datagrams.len(), 1, "what it had heard is not lost");
        assert!(batches.close_slots(at(60_000)).is_empty());
        // After the clock is set back, slots continue from there.
        assert_eq!(batches.close_slots(at(30_000)).len(), SENSORS.len());
        assert!(batches.due_at() <= at(30_300));
    }

    proptest! {
        #[test]
        fn datagrams_are_batched_once_in_order_within_the_limit(
            sizes in prop::collection::vec((0_usize..2, 1_usize..9_000, 0_i64..90), 1..200)
        ) {
            let mut batches = batches();
            let (mut now, mut messages, mut sent) = (0, Vec::new(), [Vec::new(), Vec::new()]);
            for (index, (line, size, after)) in sizes.into_iter().enumerate() {
                now += after;
                messages.extend(batches.close_slots(at(now)));
                let mut payload = vec![0; size.max(8)];
                payload[..8].copy_from_slice(&(index as u64).to_be_bytes());
                sent[line].push(payload.clone());
                messages.extend(batches.add(line, at(now), from(), payload));
            }
            messages.extend(batches.close_slots(at(now + 600)));
            for (sensor, sent) in SENSORS.iter().zip(&sent) {
                let of = messages.iter().filter(|input| input.sensor == *sensor);
                let datagrams: Vec<&[u8]> = of.flat_map(|input| &input.datagrams).map(|datagrams| &datagrams.payload[..]).collect();
                prop_assert_eq!(&datagrams, sent);
            }
            for input in &messages {
                let octets: usize = input.datagrams.iter().map(|datagrams| datagrams.payload.len()).sum();
                prop_assert!(octets <= MAX_OCTETS);
            }
            // Each slot's parts are numbered in order, and its last part is marked.
            for sensor in SENSORS {
                let of: Vec<&GatewayInput> = messages.iter().filter(|input| input.sensor == sensor).collect();
                for pair in of.windows(2) {
                    let expected = if pair[0].is_last { (pair[0].slot.plus(1), 0) } else { (pair[0].slot, pair[0].part + 1) };
                    prop_assert_eq!((pair[1].slot, pair[1].part), expected);
                }
            }
        }
    }
}
