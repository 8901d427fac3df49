//! Holds datagrams until it is known whether they end in a trailer, so that the first ones of a capture are not reported as
//! broken blocks.

use std::collections::VecDeque;

use super::trailer::stream;
use super::{CapturedDatagram, Ending, PayloadKind, TrailerRules, Trailers};

/// Limits of the held datagrams; beyond them, the undecided octets stay with their datagrams.
const MOST_DATAGRAMS: usize = 64;
const MOST_OCTETS: usize = 256 * 1024;

/// Datagrams in the order of the file.
#[derive(Debug, Default)]
pub(super) struct TrailerBuffer {
    pub(super) trailers: Trailers,
    waiting: VecDeque<BufferedDatagram>,
    octets: usize,
}

#[derive(Debug)]
struct BufferedDatagram {
    datagram: CapturedDatagram,
    undecided: bool,
}

impl TrailerBuffer {
    pub(super) fn new(rules: TrailerRules) -> Self {
        Self { trailers: Trailers::new(rules), ..Self::default() }
    }

    /// Queues the next datagram unchanged.
    pub(super) fn pass(&mut self, datagram: CapturedDatagram) {
        self.hold(datagram, false);
    }

    fn hold(&mut self, datagram: CapturedDatagram, undecided: bool) {
        self.octets += datagram.payload.len() + datagram.trailer.len();
        self.waiting.push_back(BufferedDatagram { datagram, undecided });
    }

    /// Queues the next datagram, and decides on earlier ones.
    pub(super) fn take(&mut self, mut datagram: CapturedDatagram) {
        if datagram.contents != PayloadKind::Blocks {
            return self.pass(datagram);
        }
        let ending = self.trailers.examine(datagram.endpoints, &datagram.payload);
        let key = stream(datagram.endpoints);
        let of_stream =
            |waiting: &&mut BufferedDatagram| waiting.undecided && stream(waiting.datagram.endpoints) == key;
        match ending {
            Ending::Undecided { alike } => {
                if alike == 1 {
                    // The length differs from the one before, so that one was not a trailer.
                    self.waiting.iter_mut().filter(of_stream).for_each(|other| other.undecided = false);
                }
                self.hold(datagram, true);
                if self.waiting.len() > MOST_DATAGRAMS || self.octets > MOST_OCTETS {
                    self.release();
                }
            }
            Ending::Trailer(octets) => {
                let mut count = 0;
                for other in self.waiting.iter_mut().filter(of_stream) {
                    other.undecided = false;
                    cut(&mut other.datagram, octets);
                    count += 1;
                }
                self.trailers.count(key, octets, count);
                cut(&mut datagram, octets);
                self.pass(datagram);
            }
            Ending::Block => {
                self.waiting.iter_mut().filter(of_stream).for_each(|other| other.undecided = false);
                self.pass(datagram);
            }
        }
    }

    /// Decides that none of the held datagrams has a trailer.
    pub(super) fn release(&mut self) {
        self.waiting.iter_mut().for_each(|waiting| waiting.undecided = false);
    }

    /// Whether the next datagram is decided.
    pub(super) fn is_ready(&self) -> bool {
        self.waiting.front().is_some_and(|waiting| !waiting.undecided)
    }

    /// The next decided datagram.
    pub(super) fn pop(&mut self) -> Option<CapturedDatagram> {
        if !self.is_ready() {
            return None;
        }
        let BufferedDatagram { datagram, .. } = self.waiting.pop_front()?;
        self.octets -= datagram.payload.len() + datagram.trailer.len();
        Some(datagram)
    }
}

fn cut(datagram: &mut CapturedDatagram, octets: usize) {
    datagram.trailer = datagram.payload.split_off(datagram.payload.len().saturating_sub(octets));
}
