//! Senders that are refused because another one speaks for their subject, and what each has brought of its own.
//!
//! A line whose copies come before those of the owner is refused at first, too. It has brought nothing of its own as long as
//! the owner brings each of its datagrams within the time in which copies are recognised.

use std::collections::VecDeque;
use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::is_within;
use crate::pipeline::duplicates::MEMORY_NS;
use fusion::time::Time;

/// Most refused senders of one subject that are distinguished.
pub(super) const RIVALS: usize = 8;
/// Most datagrams of a rival that are awaited from the owner at a time.
const AWAITED: usize = 256;

/// A sender that was refused.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rival {
    /// Its latest address.
    pub(super) address: SocketAddr,
    /// Whether the contest was reported.
    pub(super) told: bool,
    /// Its last refused record.
    last: Time,
    /// Receptions of its datagrams that the owner has not brought yet, oldest first.
    awaited: VecDeque<Time>,
    /// The first and the last datagram that the owner has not brought in time.
    own: Option<(Time, Time)>,
}

impl Rival {
    /// The first datagram of its own, while its last one is younger than `over_ns` beyond the time in which it was awaited.
    pub(super) fn own(&self, now: Time, over_ns: i64) -> Option<Time> {
        let mut late = self.awaited.iter().filter(|at| !is_within(now, **at, MEMORY_NS)).copied();
        let late = late.next().map(|first| (first, late.next_back().unwrap_or(first)));
        let first = self.own.or(late)?.0;
        let last = late.or(self.own)?.1;
        is_within(now, last, MEMORY_NS + over_ns).then_some(first)
    }

    /// Counts what was awaited for too long, and forgets what is over.
    fn settle(&mut self, now: Time, over_ns: i64) {
        while let Some(&at) = self.awaited.front().filter(|at| !is_within(now, **at, MEMORY_NS)) {
            self.own = Some((self.own.map_or(at, |(first, _)| first), at));
            self.awaited.pop_front();
        }
        if self.own.is_some_and(|(_, last)| !is_within(now, last, MEMORY_NS + over_ns)) {
            (self.own, self.told) = (None, false);
        }
    }
}

/// The refused senders of a subject, the latest last.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Rivals(Vec<Rival>);

impl Rivals {
    /// Each of them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Rival> {
        self.0.iter()
    }

    /// Keeps those that are still rivals.
    pub(super) fn retain(&mut self, keep: impl FnMut(&Rival) -> bool) {
        self.0.retain(keep);
    }

    /// Counts what was awaited for too long, and forgets what is over.
    pub(super) fn settle(&mut self, now: Time, over_ns: i64) {
        self.0.iter_mut().for_each(|rival| rival.settle(now, over_ns));
        self.0.retain(|rival| is_within(now, rival.last, MEMORY_NS + over_ns));
    }

    /// A record was refused; `is_known` tells by its address whether a rival is the same sender.
    pub(super) fn refuse(
        &mut self,
        from: SocketAddr,
        now: Time,
        over_ns: i64,
        is_known: impl Fn(SocketAddr) -> bool,
    ) {
        let known = self.0.iter().position(|rival| is_known(rival.address));
        let new = || Rival { address: from, told: false, last: now, awaited: VecDeque::new(), own: None };
        let mut rival = known.map_or_else(new, |index| self.0.remove(index));
        if self.0.len() == RIVALS {
            self.0.remove(0);
        }
        rival.settle(now, over_ns);
        (rival.address, rival.last) = (from, now);
        // The records of one datagram come at one time.
        if rival.awaited.back() != Some(&now) && rival.awaited.len() < AWAITED {
            rival.awaited.push_back(now);
        }
        self.0.push(rival);
    }

    /// The owner has brought the datagram that a rival brought at `at`.
    pub(super) fn excuse(&mut self, rival: SocketAddr, at: Time) {
        for known in self.0.iter_mut().filter(|known| known.address.ip() == rival.ip()) {
            known.awaited.retain(|awaited| *awaited != at);
        }
        self.0.retain(|known| !known.awaited.is_empty() || known.own.is_some());
    }

    /// The contest with this sender was reported.
    pub(super) fn tell(&mut self, address: SocketAddr) {
        self.0.iter_mut().filter(|rival| rival.address == address).for_each(|rival| rival.told = true);
    }

    /// Number of senders that are distinguished.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
