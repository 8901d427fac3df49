//! Datagrams held until it is known whether they end in a trailer, so that not even the first ones of a capture show it as a
//! broken block.

use std::collections::VecDeque;

use super::trailer::stream;
use super::{Contents, Datagram, Ending, TrailerRules, Trailers};

/// Limits of what is held; beyond them, the octets in question stay with their datagrams.
const MOST_DATAGRAMS: usize = 64;
const MOST_OCTETS: usize = 256 * 1024;

/// Datagrams in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Held {
    pub(super) trailers: Trailers,
    waiting: VecDeque<Waiting>,
    octets: usize,
}

#[derive(Debug)]
struct Waiting {
    datagram: Datagram,
    undecided: bool,
}

impl Held {
    pub(super) fn new(rules: TrailerRules) -> Self {
        Self { trailers: Trailers::new(rules), ..Self::default() }
    }

    /// Queues the next one as it is.
    pub(super) fn pass(&mut self, datagram: Datagram) {
        self.hold(datagram, false);
    }

    fn hold(&mut self, datagram: Datagram, undecided: bool) {
        self.octets += datagram.payload.len() + datagram.trailer.len();
        self.waiting.push_back(Waiting { datagram, undecided });
    }

    /// Queues the next one, and decides about those before it.
    pub(super) fn take(&mut self, mut datagram: Datagram) {
        if datagram.contents != Contents::Blocks {
            return self.pass(datagram);
        }
        let ending = self.trailers.see(datagram.endpoints, &datagram.payload);
        let key = stream(datagram.endpoints);
        let of_stream =
            |waiting: &&mut Waiting| waiting.undecided && stream(waiting.datagram.endpoints) == key;
        match ending {
            Ending::Undecided { alike } => {
                if alike == 1 {
                    // Another length than before, which was no trailer then.
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

    /// Decides that none of those held has a trailer.
    pub(super) fn release(&mut self) {
        self.waiting.iter_mut().for_each(|waiting| waiting.undecided = false);
    }

    /// Whether the next one can be handed out.
    pub(super) fn is_ready(&self) -> bool {
        self.waiting.front().is_some_and(|waiting| !waiting.undecided)
    }

    /// The next one.
    pub(super) fn pop(&mut self) -> Option<Datagram> {
        if !self.is_ready() {
            return None;
        }
        let Waiting { datagram, .. } = self.waiting.pop_front()?;
        self.octets -= datagram.payload.len() + datagram.trailer.len();
        Some(datagram)
    }
}

fn cut(datagram: &mut Datagram, octets: usize) {
    datagram.trailer = datagram.payload.split_off(datagram.payload.len().saturating_sub(octets));
}
