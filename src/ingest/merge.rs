//! Several captures as one stream of receptions, and the times of files that have none.

use std::collections::VecDeque;

use asterix::{Record, TimeOfDay, blocks, cat048, cat129};
use jiff::civil::Date;

use super::{Capture, Datagram, ReadError};
use crate::normalise::{nearest_day, on_day};
use crate::time::{SECOND, Time};

/// What the pipeline is handed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reception {
    /// When it was received; `None` before the first time of a file without reception times.
    pub received: Option<Time>,
    /// Which input it is from, counted from 0.
    pub input: usize,
    /// Whole datagram, or one record of a file without reception times.
    pub kind: ReceptionKind,
    /// Offset in its file of the payload's first octet.
    pub origin: u64,
    /// Data blocks.
    pub payload: Vec<u8>,
}

/// What a reception's payload is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceptionKind {
    /// A datagram as it came; redundant lines repeat it octet by octet.
    Datagram,
    /// A record in a block of its own.
    Record,
}

/// Captures merged by reception time, equal times in the order of the captures.
pub struct Merged {
    inputs: Vec<Input>,
}

struct Input {
    capture: Capture,
    clock: RawClock,
    /// Read and not handed out: the records of one data block, at most.
    ahead: VecDeque<Reception>,
}

impl Merged {
    /// `date`: the UTC day of the first record of a file without reception times.
    pub fn new(captures: Vec<Capture>, date: Date) -> Self {
        let input = |capture| Input { capture, clock: RawClock::starting_on(date), ahead: VecDeque::new() };
        Self { inputs: captures.into_iter().map(input).collect() }
    }

    /// The captures, in order.
    pub fn captures(&self) -> impl Iterator<Item = &Capture> {
        self.inputs.iter().map(|input| &input.capture)
    }
}

impl Iterator for Merged {
    type Item = Result<Reception, ReadError>;

    /// An error ends its own input only.
    fn next(&mut self) -> Option<Self::Item> {
        for (index, input) in self.inputs.iter_mut().enumerate() {
            if let Err(error) = input.fill(index) {
                return Some(Err(error));
            }
        }
        let earliest = self
            .inputs
            .iter_mut()
            .filter(|input| !input.ahead.is_empty())
            .min_by_key(|input| input.ahead.front().and_then(|reception| reception.received))?;
        earliest.ahead.pop_front().map(Ok)
    }
}

impl Input {
    /// Reads until there is something to hand out, or the end.
    fn fill(&mut self, index: usize) -> Result<(), ReadError> {
        while self.ahead.is_empty() {
            let Some(datagram) = self.capture.next().transpose()? else { break };
            match datagram.received {
                Some(_) => self.ahead.push_back(Reception {
                    received: datagram.received,
                    input: index,
                    kind: ReceptionKind::Datagram,
                    origin: datagram.origin,
                    payload: datagram.payload,
                }),
                None => self.split(&datagram, index),
            }
        }
        Ok(())
    }

    /// Each record of a file without reception times is received by itself, at its own time.
    fn split(&mut self, datagram: &Datagram, index: usize) {
        for block in blocks(&datagram.payload) {
            match block {
                Ok(block) if block.category == cat048::Record::CATEGORY => {
                    self.split_block(datagram, index, block, |record: &cat048::Record| record.time_of_day);
                }
                Ok(block) if block.category == cat129::Record::CATEGORY => {
                    self.split_block(datagram, index, block, |record: &cat129::Record| record.time_of_day);
                }
                Ok(block) => self.push(datagram, index, block.offset, block.octets.to_vec()),
                Err(fault) => {
                    self.push(datagram, index, fault.offset, datagram.payload[fault.offset..].to_vec());
                }
            }
        }
    }

    fn split_block<R: Record>(
        &mut self,
        datagram: &Datagram,
        index: usize,
        block: asterix::Block<'_>,
        time_of_day: impl Fn(&R) -> Option<TimeOfDay>,
    ) {
        // A record in a block of its own begins 3 octets after that block: so offsets stay those of the file.
        let mut reframed = |clock_at: Option<TimeOfDay>, offset: usize, octets: &[u8]| {
            self.clock.tell(clock_at);
            let length = (octets.len() + 3) as u16;
            let mut payload = vec![block.category];
            payload.extend_from_slice(&length.to_be_bytes());
            payload.extend_from_slice(octets);
            self.push(datagram, index, offset - 3, payload);
        };
        let end = block.offset + block.octets.len();
        let mut next = block.offset + 3;
        for located in block.records::<R>() {
            match located {
                Ok(located) => {
                    next = located.offset + located.length;
                    reframed(
                        time_of_day(&located.record),
                        located.offset,
                        &datagram.payload[located.offset..next],
                    );
                }
                // What is bad goes on as it is: the pipeline says what is wrong with it, and counts it.
                Err(_) => reframed(None, next, &datagram.payload[next..end]),
            }
        }
    }

    fn push(&mut self, datagram: &Datagram, index: usize, offset: usize, payload: Vec<u8>) {
        self.ahead.push_back(Reception {
            received: self.clock.running,
            input: index,
            kind: ReceptionKind::Record,
            origin: datagram.origin + offset as u64,
            payload,
        });
    }
}

/// The reception times of a file that has none: the running maximum of its report times.
///
/// A report more than a minute away does not move the time, unless three in a row agree within a minute: then it moves
/// there with the third. (The pipeline drops the strays: they are in the future, or late.)
#[derive(Clone, Debug)]
struct RawClock {
    /// At the start of the day of the first record.
    midnight: Option<Time>,
    running: Option<Time>,
    /// Successive reports that are more than a minute ahead, or more than a minute behind; at most two.
    astray: VecDeque<Time>,
}

/// How far a report may be from the running time, and strays from each other, nanoseconds.
const ASTRAY_NS: i64 = 60 * SECOND;

impl RawClock {
    fn starting_on(date: Date) -> Self {
        Self { midnight: Time::midnight(date), running: None, astray: VecDeque::new() }
    }

    /// The next record's time of day, if it has one that a day has.
    fn tell(&mut self, time_of_day: Option<TimeOfDay>) {
        let Some(count) = time_of_day.map(TimeOfDay::count) else { return };
        let Some(running) = self.running else {
            self.running = self.midnight.and_then(|midnight| on_day(count, midnight));
            return;
        };
        let Some(time) = nearest_day(count, running) else { return };
        let apart = |a: Time, b: Time| (a.nanos() - b.nanos()).abs();
        if apart(time, running) <= ASTRAY_NS {
            self.astray.clear();
            self.running = Some(running.max(time));
            return;
        }
        let same_side = |stray: &Time| (*stray > running) == (time > running);
        if !self.astray.iter().all(same_side) {
            self.astray.clear();
        }
        self.astray.push_back(time);
        if self.astray.len() == 3 {
            let agree = self.astray.iter().all(|&a| self.astray.iter().all(|&b| apart(a, b) <= ASTRAY_NS));
            if agree {
                self.running = Some(time);
                self.astray.clear();
            } else {
                self.astray.pop_front();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock_after(seconds: &[f64]) -> Vec<f64> {
        let mut clock = RawClock::starting_on(jiff::civil::date(1970, 1, 1));
        let tell = |&second: &f64| {
            clock.tell(TimeOfDay::from_count((second * 128.0) as u32));
            clock.running.unwrap().as_seconds()
        };
        seconds.iter().map(tell).collect()
    }

    #[test]
    fn the_first_record_falls_on_the_given_day_and_later_ones_on_the_nearest() {
        assert_eq!(clock_after(&[0.0, 1.0]), [0.0, 1.0]);
        assert_eq!(clock_after(&[86_400.0, 1.0]), [86_400.0, 86_401.0]);
        assert_eq!(clock_after(&[86_390.0, 5.0, 86_399.0, 6.0]), [86_390.0, 86_405.0, 86_405.0, 86_406.0]);
    }

    #[test]
    fn a_stray_does_not_move_the_time_and_three_that_agree_do() {
        assert_eq!(clock_after(&[100.0, 500.0, 101.0, 500.0, 501.0]), [100.0, 100.0, 101.0, 101.0, 101.0]);
        assert_eq!(clock_after(&[100.0, 500.0, 510.0, 520.0, 101.0]), [100.0, 100.0, 100.0, 520.0, 520.0]);
        assert_eq!(clock_after(&[900.0, 500.0, 510.0, 520.0, 521.0]), [900.0, 900.0, 900.0, 520.0, 521.0]);
        // Three that do not agree, and three of which one is on the other side.
        assert_eq!(clock_after(&[100.0, 500.0, 900.0, 510.0, 520.0, 530.0]).last(), Some(&530.0));
        assert_eq!(clock_after(&[500.0, 900.0, 100.0, 901.0, 902.0]).last(), Some(&500.0));
    }

    #[test]
    fn what_no_day_has_is_no_time() {
        assert_eq!(clock_after(&[100.0, 86_401.0]), [100.0, 100.0]);
    }
}
