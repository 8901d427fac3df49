//! What a gateway hears, slot by slot. Sans-IO.

use std::net::SocketAddr;

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use super::message::{Heard, Input};

/// Most octets of datagrams in a message; what a slot has more is in further ones.
const FULL: usize = 32 << 10;
/// A slot is over this much later than its end: what was received in it has come out of its socket by then.
const GRACE: SignedDuration = SignedDuration::from_millis(10);
/// Slots after which nobody is told that nothing was heard: the gateway stood still, and another one has said it.
const STALE: i64 = 8;

/// The messages of a gateway.
#[derive(Debug)]
pub struct Batches {
    grid: SlotGrid,
    lines: Vec<Batch>,
    /// The slot that is being heard.
    slot: Slot,
}

/// What was heard on a line.
#[derive(Debug)]
struct Batch {
    sensor: DataSource,
    to: SocketAddr,
    part: u16,
    octets: usize,
    heard: Vec<Heard>,
}

impl Batches {
    /// Of lines, each with the (first) sensor on it and the address that it is sent to; from `now` on.
    pub fn new(grid: SlotGrid, lines: impl IntoIterator<Item = (DataSource, SocketAddr)>, now: Time) -> Self {
        let batch = |(sensor, to)| Batch { sensor, to, part: 0, octets: 0, heard: Vec::new() };
        Self { grid, lines: lines.into_iter().map(batch).collect(), slot: grid.of(now) }
    }

    /// A datagram on a line; a message where that is full now.
    pub fn hear(&mut self, line: usize, received: Time, from: SocketAddr, payload: Vec<u8>) -> Option<Input> {
        let slot = self.slot;
        let batch = self.lines.get_mut(line)?;
        let full =
            (batch.octets > 0 && batch.octets + payload.len() > FULL).then(|| batch.message(slot, false));
        batch.octets += payload.len();
        batch.heard.push(Heard { received, from, to: batch.to, payload });
        full
    }

    /// When the slot that is being heard is over.
    pub fn ends(&self) -> Time {
        self.grid.open(self.slot.plus(1)) + GRACE
    }

    /// The messages of the slots that are over by `now`, of each line one at least: that it was heard until then.
    pub fn end(&mut self, now: Time) -> Vec<Input> {
        let mut ended = Vec::new();
        let latest = self.grid.of(now + -GRACE);
        // Also where the clock was set back.
        if !(0..=STALE).contains(&(latest.0 - self.slot.0)) {
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

impl Batch {
    fn message(&mut self, slot: Slot, is_last: bool) -> Input {
        let part = self.part;
        self.part = if is_last { 0 } else { part.saturating_add(1) };
        self.octets = 0;
        Input {
            origin: None,
            sensor: self.sensor,
            slot,
            part,
            is_last,
            heard: std::mem::take(&mut self.heard),
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

    fn batches() -> Batches {
        let to = "239.1.1.1:8048".parse().unwrap();
        Batches::new(SlotGrid::default(), SENSORS.map(|sensor| (sensor, to)), at(0))
    }

    fn from() -> SocketAddr {
        "127.0.0.1:5000".parse().unwrap()
    }

    #[test]
    fn a_slot_is_a_message_of_each_line_also_where_it_was_silent() {
        let mut batches = batches();
        assert_eq!(batches.hear(1, at(20), from(), vec![1; 40]), None);
        assert!(batches.end(at(200)).is_empty());
        let ends = batches.ends();
        let ended = batches.end(ends);
        assert_eq!(ended.iter().map(|input| input.sensor).collect::<Vec<_>>(), SENSORS);
        assert_eq!(ended.iter().map(|input| input.heard.len()).collect::<Vec<_>>(), [0, 1]);
        assert!(ended.iter().all(|input| input.is_last && input.part == 0));
        // Within one slot of 0.25 s, and it goes on with the next.
        assert!(ends > at(0) && ends <= at(260) && batches.ends() == ends + SignedDuration::from_millis(250));
    }

    #[test]
    fn whoever_stood_still_tells_only_what_is_over_now() {
        let mut batches = batches();
        batches.hear(0, at(10), from(), vec![1]);
        let ended = batches.end(at(60_000));
        assert_eq!(ended.len(), SENSORS.len());
        assert_eq!(ended[0].heard.len(), 1, "what it had heard is not lost");
        assert!(batches.end(at(60_000)).is_empty());
        // The clock is set back: from there on.
        assert_eq!(batches.end(at(30_000)).len(), SENSORS.len());
        assert!(batches.ends() <= at(30_300));
    }

    proptest! {
        #[test]
        fn all_that_is_heard_is_in_one_message_in_order_and_none_is_large(
            sizes in prop::collection::vec((0_usize..2, 1_usize..9_000, 0_i64..90), 1..200)
        ) {
            let mut batches = batches();
            let (mut now, mut messages, mut sent) = (0, Vec::new(), [Vec::new(), Vec::new()]);
            for (index, (line, size, after)) in sizes.into_iter().enumerate() {
                now += after;
                messages.extend(batches.end(at(now)));
                let mut payload = vec![0; size.max(8)];
                payload[..8].copy_from_slice(&(index as u64).to_be_bytes());
                sent[line].push(payload.clone());
                messages.extend(batches.hear(line, at(now), from(), payload));
            }
            messages.extend(batches.end(at(now + 600)));
            for (sensor, sent) in SENSORS.iter().zip(&sent) {
                let of = messages.iter().filter(|input| input.sensor == *sensor);
                let heard: Vec<&[u8]> = of.flat_map(|input| &input.heard).map(|heard| &heard.payload[..]).collect();
                prop_assert_eq!(&heard, sent);
            }
            for input in &messages {
                let octets: usize = input.heard.iter().map(|heard| heard.payload.len()).sum();
                prop_assert!(octets <= FULL);
            }
            // Each slot has its parts, and one of them is the last.
            for sensor in SENSORS {
                let of: Vec<&Input> = messages.iter().filter(|input| input.sensor == sensor).collect();
                for pair in of.windows(2) {
                    let expected = if pair[0].is_last { (pair[0].slot.plus(1), 0) } else { (pair[0].slot, pair[0].part + 1) };
                    prop_assert_eq!((pair[1].slot, pair[1].part), expected);
                }
            }
        }
    }
}
