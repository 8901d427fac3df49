//! Rivals: refused senders of a subject for which another sender speaks, and the datagrams that only they have sent.
//!
//! A redundant line whose copies arrive before the owner's is refused at first, too. It has sent nothing of its own as long as
//! the owner sends each of its datagrams within the time in which copies are recognised.

use std::collections::VecDeque;
use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::is_within;
use crate::pipeline::duplicates::MEMORY_NS;
use fusion::time::Time;

/// Maximum number of rivals of one subject.
pub(super) const RIVALS: usize = 8;
/// Maximum number of a rival's datagrams that are awaited from the owner at a time.
const AWAITED: usize = 256;

/// A refused sender.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rival {
    /// Latest address.
    pub(super) address: SocketAddr,
    /// Whether the contest was reported.
    pub(super) told: bool,
    /// Time of its last refused record.
    last: Time,
    /// Times of reception of its datagrams that the owner has not sent yet, oldest first.
    awaited: VecDeque<Time>,
    /// Times of the first and the last datagram that the owner did not send in time.
    own: Option<(Time, Time)>,
}

impl Rival {
    /// Time of the first datagram of its own; `None` once the last one is older than the waiting time plus `over_ns`.
    pub(super) fn own(&self, now: Time, over_ns: i64) -> Option<Time> {
        let mut late = self.awaited.iter().filter(|at| !is_within(now, **at, MEMORY_NS)).copied();
        let late = late.next().map(|first| (first, late.next_back().unwrap_or(first)));
        let first = self.own.or(late)?.0;
        let last = late.or(self.own)?.1;
        is_within(now, last, MEMORY_NS + over_ns).then_some(first)
    }

    /// Counts datagrams that the owner did not send in time, and forgets expired ones.
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

/// The rivals of a subject, the latest last.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Rivals(Vec<Rival>);

impl Rivals {
    /// The rivals.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Rival> {
        self.0.iter()
    }

    /// Keeps the rivals for which `keep` is true.
    pub(super) fn retain(&mut self, keep: impl FnMut(&Rival) -> bool) {
        self.0.retain(keep);
    }

    /// Counts datagrams that the owner did not send in time, and removes expired rivals.
    pub(super) fn settle(&mut self, now: Time, over_ns: i64) {
        self.0.iter_mut().for_each(|rival| rival.settle(now, over_ns));
        self.0.retain(|rival| is_within(now, rival.last, MEMORY_NS + over_ns));
    }

    /// Notes a refused record. `is_known` decides by the address of a rival whether it is the same sender.
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
        // All records of a datagram have one time of reception.
        if rival.awaited.back() != Some(&now) && rival.awaited.len() < AWAITED {
            rival.awaited.push_back(now);
        }
        self.0.push(rival);
    }

    /// Notes that the owner has sent the datagram that a rival sent at `at`.
    pub(super) fn excuse(&mut self, rival: SocketAddr, at: Time) {
        for known in self.0.iter_mut().filter(|known| known.address.ip() == rival.ip()) {
            known.awaited.retain(|awaited| *awaited != at);
        }
        self.0.retain(|known| !known.awaited.is_empty() || known.own.is_some());
    }

    /// Notes that the contest with this sender was reported.
    pub(super) fn tell(&mut self, address: SocketAddr) {
        self.0.iter_mut().filter(|rival| rival.address == address).for_each(|rival| rival.told = true);
    }

    /// Number of rivals.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
