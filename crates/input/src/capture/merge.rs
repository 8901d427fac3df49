//! Merges captures into one stream of receptions, and gives times to files that have none.

use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;

use asterix::{Block, DataSource, Record, TimeOfDay, blocks, cat015, cat021, cat048, cat129};
use jiff::civil::Date;

use super::clock::{DayClock, RawClock};
use super::{Capture, CapturedDatagram, PayloadKind, ReadError};
use fusion::time::Time;

/// Input of the pipeline: a datagram or record, with its time of reception.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reception {
    /// Time of reception; `None` before the first time in a file without reception times.
    pub received: Option<Time>,
    /// Index of the input.
    pub input: usize,
    /// Sender, if known.
    pub from: Option<SocketAddr>,
    /// Kind of payload.
    pub kind: ReceptionKind,
    /// Offset in its file of the payload's first octet.
    pub origin: u64,
    /// Data blocks.
    pub payload: Vec<u8>,
}

/// Kind of a reception's payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceptionKind {
    /// A datagram; redundant lines repeat it octet by octet.
    Datagram,
    /// A record of a file without reception times, in its own block.
    Record,
}

/// Captures merged by reception time, equal times in the order of the captures.
pub struct MergedCaptures {
    inputs: Vec<MergeInput>,
    editions: SenderEditions,
    destination: Option<SocketAddr>,
}

/// Edition of CAT021 by sender, if configured.
type SenderEditions = BTreeMap<DataSource, cat021::Edition>;

struct MergeInput {
    capture: Capture,
    clock: RawClock,
    day_clock: DayClock,
    /// Data read ahead: at most the records of one data block, each with its destination, if known.
    ahead: VecDeque<(Reception, Option<SocketAddr>)>,
}

impl MergedCaptures {
    /// `date` is the UTC day of the first record of a file without dates.
    pub fn new(captures: Vec<Capture>, date: Date) -> Self {
        let input = |capture| MergeInput {
            capture,
            clock: RawClock::starting_on(date),
            day_clock: DayClock::starting_on(date),
            ahead: VecDeque::new(),
        };
        Self {
            inputs: captures.into_iter().map(input).collect(),
            editions: SenderEditions::new(),
            destination: None,
        }
    }

    /// Sets the editions of CAT021 for these senders; others use the default.
    pub fn with_editions(self, editions: SenderEditions) -> Self {
        Self { editions, ..self }
    }

    /// The captures, in order.
    pub fn captures(&self) -> impl Iterator<Item = &Capture> {
        self.inputs.iter().map(|input| &input.capture)
    }

    /// Destination address of the latest reception, if known.
    pub fn destination(&self) -> Option<SocketAddr> {
        self.destination
    }
}

impl Iterator for MergedCaptures {
    type Item = Result<Reception, ReadError>;

    /// An error ends only its own input.
    fn next(&mut self) -> Option<Self::Item> {
        let Self { inputs, editions, .. } = self;
        for (index, input) in inputs.iter_mut().enumerate() {
            if let Err(error) = input.fill(index, editions) {
                return Some(Err(error));
            }
        }
        let earliest = self
            .inputs
            .iter_mut()
            .filter(|input| !input.ahead.is_empty())
            .min_by_key(|input| input.ahead.front().and_then(|(reception, _)| reception.received))?;
        let (reception, destination) = earliest.ahead.pop_front()?;
        self.destination = destination;
        Some(Ok(reception))
    }
}

impl MergeInput {
    /// Reads until data is ahead, or to the end.
    fn fill(&mut self, index: usize, editions: &SenderEditions) -> Result<(), ReadError> {
        while self.ahead.is_empty() {
            let Some(mut datagram) = self.capture.next().transpose()? else { break };
            // The capture counts these octets.
            if datagram.contents == PayloadKind::Unframed {
                continue;
            }
            let on_its_day = datagram.since_midnight.and_then(|nanos| self.day_clock.tell(nanos));
            match datagram.received.or(on_its_day) {
                Some(received) => {
                    self.clock.set(received);
                    let payload = std::mem::take(&mut datagram.payload);
                    self.push(ReceptionKind::Datagram, &datagram, index, 0, payload);
                }
                None => self.split(&datagram, index, editions),
            }
        }
        Ok(())
    }

    /// Splits a block of a file without reception times: each record is received at its own time.
    fn split(&mut self, datagram: &CapturedDatagram, index: usize, editions: &SenderEditions) {
        for block in blocks(&datagram.payload) {
            match block {
                Ok(block) if block.category == cat048::Record::CATEGORY => {
                    self.split_block::<cat048::Record>(datagram, index, block, ());
                }
                Ok(block) if block.category == cat129::Record::CATEGORY => {
                    self.split_block::<cat129::Record>(datagram, index, block, ());
                }
                Ok(block) if block.category == cat015::Record::CATEGORY => {
                    self.split_block::<cat015::Record>(datagram, index, block, ());
                }
                Ok(block) if block.category == cat021::Record::CATEGORY => {
                    let edition = block
                        .first_source()
                        .and_then(|source| editions.get(&source).copied())
                        .unwrap_or_default();
                    self.split_block::<cat021::Record>(datagram, index, block, edition);
                }
                Ok(block) => {
                    self.push(ReceptionKind::Record, datagram, index, block.offset, block.octets.to_vec());
                }
                Err(fault) => {
                    self.push(
                        ReceptionKind::Record,
                        datagram,
                        index,
                        fault.offset,
                        datagram.payload[fault.offset..].to_vec(),
                    );
                }
            }
        }
    }

    fn split_block<R: Record>(
        &mut self,
        datagram: &CapturedDatagram,
        index: usize,
        block: Block<'_>,
        edition: R::Edition,
    ) {
        // A record in its own block begins 3 octets after that block; so offsets stay those of the file.
        let mut reframed = |clock_at: Option<TimeOfDay>, offset: usize, octets: &[u8]| {
            self.clock.tell(clock_at);
            let length = (octets.len() + 3) as u16;
            let mut payload = vec![block.category];
            payload.extend_from_slice(&length.to_be_bytes());
            payload.extend_from_slice(octets);
            self.push(ReceptionKind::Record, datagram, index, offset - 3, payload);
        };
        let end = block.offset + block.octets.len();
        let mut next = block.offset + 3;
        for located in block.records_in::<R>(edition) {
            match located {
                Ok(located) => {
                    next = located.offset + located.length;
                    let octets = &datagram.payload[located.offset..next];
                    reframed(located.record.time_of_day(), located.offset, octets);
                }
                // A bad record is passed on unchanged: the pipeline reports and counts it.
                Err(_) => reframed(None, next, &datagram.payload[next..end]),
            }
        }
    }

    fn push(
        &mut self,
        kind: ReceptionKind,
        datagram: &CapturedDatagram,
        index: usize,
        offset: usize,
        payload: Vec<u8>,
    ) {
        let reception = Reception {
            received: self.clock.running(),
            input: index,
            from: datagram.endpoints.map(|endpoints| endpoints.source),
            kind,
            origin: datagram.origin + offset as u64,
            payload,
        };
        self.ahead.push_back((reception, datagram.endpoints.map(|endpoints| endpoints.destination)));
    }
}
