//! Reference time: the median of the clocks of those who write into the log, so that no single clock decides. Sans-IO.
//!
//! The log stamps each message, and the writer states when it was sent. The reader compares both with a clock of its process, which is
//! never set. A message takes time and never arrives before it was sent, so the least difference over a window is the difference of two
//! clocks. The log and each gateway have a vote.

use std::collections::{BTreeMap, VecDeque};

use fusion::time::Time;
use jiff::SignedDuration;

/// A clock that is further than this from reference time is wrong.
pub const BOUND: SignedDuration = SignedDuration::from_secs(1);
/// A slot that is due earlier than this by reference time is not made, however far its sensors were heard.
pub const EARLY: SignedDuration = SignedDuration::from_millis(100);
/// No gateway keeps messages for this long.
const OLDEST: SignedDuration = SignedDuration::from_hours(24);
/// Stamps of the log never go back, unless another server leads it: this much is a step of its clock.
const STEP_NS: i64 = 100_000_000;
/// A clock is behind if all messages of so long a time say so: some that waited in a buffer are old, and right.
const LASTS_NS: i64 = 1_500_000_000;
/// Messages after which no gateway that states its name is waited for.
const NAMELESS: u32 = 32;
/// Messages in a row after which a gateway has a vote; a gap of the window ends a row. Invented names have none.
const ESTABLISHED: u32 = 8;
/// Most gateways that are known at once. Names beyond that are of no site.
const MOST: usize = 64;

/// By how much a base clock is more than another one, nanoseconds: the least within the window.
#[derive(Clone, Debug, Default)]
struct Differences {
    /// Base time and difference. Both increase: a greater difference before a lesser one is never the least again.
    least: VecDeque<(i64, i64)>,
    /// The log's stamp of the last message.
    stamp: i64,
    /// The base time since which there is a difference at all times within the window, and the other clock was not set.
    since: i64,
    /// The last times by the base and by the other clock.
    base: i64,
    last: i64,
    /// Messages in a row, until there were enough of them once.
    row: u32,
}

impl Differences {
    fn note(&mut self, (base, stamp): (i64, i64), at: i64, window: i64) {
        let (difference, most) = (base.saturating_sub(at), window.unsigned_abs());
        let is_gap = stamp.abs_diff(self.stamp) > most;
        self.expire((base, stamp), window);
        if self.least.is_empty() || at.abs_diff(self.last) > most {
            self.since = base;
        }
        if self.row == 0 || is_gap {
            self.row = if self.is_established() { self.row } else { 0 };
        }
        (self.base, self.stamp, self.last) = (base, stamp, at);
        self.row = self.row.saturating_add(1);
        while self.least.back().is_some_and(|(_, known)| *known >= difference) {
            self.least.pop_back();
        }
        self.least.push_back((base, difference));
    }

    /// Removes differences that are older than the window: by the base clock, and by the log's, because a reader that catches up
    /// reads fast.
    fn expire(&mut self, (base, stamp): (i64, i64), window: i64) {
        if stamp.abs_diff(self.stamp) > window.unsigned_abs() {
            self.least.clear();
        }
        let is_old = |(at, _): &(i64, i64)| base.abs_diff(*at) > window.unsigned_abs();
        while self.least.front().is_some_and(is_old) {
            self.least.pop_front();
        }
    }

    const fn is_established(&self) -> bool {
        self.row >= ESTABLISHED
    }

    fn least(&self) -> Option<i64> {
        self.least.front().map(|(_, difference)| *difference)
    }
}

/// Why a message is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// The gateway's clock is ahead of reference time.
    Ahead,
    /// The gateway's clock is behind.
    Behind,
    /// The slot is not over yet, or is of another day.
    Slot,
    /// The gateway has another shared configuration.
    Configuration,
}

impl Refusal {
    /// The reason in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Ahead => "its clock is ahead",
            Self::Behind => "its clock is behind",
            Self::Slot => "the slot is not over, or of another day",
            Self::Configuration => "its configuration is another one",
        }
    }
}

/// Reference time by what is read of a log.
#[derive(Clone, Debug)]
pub struct ReferenceClock {
    window: i64,
    gateways: BTreeMap<String, Differences>,
    /// The log's clock; nothing where it is the base.
    log: Differences,
    /// The clock of this process, which has a vote where the others are even; the sign of its differences.
    own: Differences,
    own_sign: i64,
    /// The base clock and the log's at the last message.
    last: Option<(i64, i64)>,
    /// How far the base clock is ahead of reference time.
    correction: i64,
}

impl ReferenceClock {
    /// Clocks are compared over this time.
    pub fn new(window: SignedDuration) -> Self {
        Self {
            window: nanos(window),
            gateways: BTreeMap::new(),
            log: Differences::default(),
            own: Differences::default(),
            own_sign: 1,
            last: None,
            correction: 0,
        }
    }

    /// A message of a gateway: when the log stamped it, and when the gateway sent it by its own clock. The log's clock is the base.
    pub fn note(&mut self, gateway: &str, stamp: Time, sent: Time) {
        let (stamp, sent) = (stamp.nanos(), sent.nanos());
        self.step(stamp, gateway, stamp.saturating_sub(sent));
        self.note_gateway(gateway, (stamp, stamp), sent);
    }

    /// The same with a clock that is never set as the base: the log has a vote like the gateways.
    fn note_steady(&mut self, gateway: Option<(&str, i64)>, (steady, stamp): (i64, i64), own: i64) {
        if self.last.is_none() {
            self.correction = steady.saturating_sub(own);
        }
        self.log.note((steady, stamp), stamp, self.window);
        self.own.note((steady, stamp), own, self.window);
        match gateway {
            Some((gateway, sent)) => self.note_gateway(gateway, (steady, stamp), sent),
            None => self.last = Some((steady, stamp)),
        }
    }

    fn note_gateway(&mut self, gateway: &str, at: (i64, i64), sent: i64) {
        self.last = Some(at);
        if !self.gateways.contains_key(gateway) && self.gateways.len() >= MOST {
            let least = self.gateways.iter().min_by_key(|(_, known)| (known.is_established(), known.stamp));
            let oldest = least.map(|(name, _)| name.clone());
            oldest.into_iter().for_each(|name| _ = self.gateways.remove(&name));
        }
        self.gateways.entry(gateway.to_owned()).or_default().note(at, sent, self.window);
        self.vote();
    }

    /// The clock of this process, as it read a message at once.
    pub fn note_read(&mut self, stamp: Time, read: Time) {
        // Reading takes time, too, so the greatest difference counts: the least with the other sign.
        let (stamp, read) = (stamp.nanos(), read.nanos());
        self.own_sign = -1;
        self.own.note((stamp, stamp), stamp.saturating_sub(read.saturating_sub(stamp)), self.window);
        self.vote();
    }

    /// The clock of this process, as it sent a message.
    pub fn note_sent(&mut self, stamp: Time, sent: Time) {
        self.own_sign = 1;
        self.own.note((stamp.nanos(), stamp.nanos()), sent.nanos(), self.window);
        self.vote();
    }

    /// The clock of this process was set: what it said before is of another clock.
    pub fn forget(&mut self, own_gateway: &str) {
        self.gateways.get_mut(own_gateway).into_iter().for_each(|known| known.least.clear());
        self.own.least.clear();
    }

    /// The log's clock may have gone back, as where a server with another clock leads it now: what was known is of another clock.
    fn step(&mut self, stamp: i64, gateway: &str, difference: i64) {
        if let Some((before, _)) = self.last
            && stamp < before - STEP_NS
        {
            // By as much as this gateway's difference says: its own clock cannot turn back the log's.
            if let Some(known) = self.gateways.get(gateway).and_then(Differences::least) {
                self.correction = self.correction.saturating_add(difference.saturating_sub(known));
            }
            self.gateways.values_mut().for_each(|known| known.least.clear());
            self.own.least.clear();
        }
    }

    fn vote(&mut self) {
        let Some(at) = self.last else { return };
        let window = self.window;
        self.gateways.values_mut().chain([&mut self.own]).for_each(|known| known.expire(at, window));
        // Names that were heard once or twice have no vote. Before any gateway has one, this process's clock decides; where words come
        // once a second all vote.
        let is_any = self.gateways.values().any(Differences::is_established);
        if !is_any && self.log.row > 0 {
            return;
        }
        let voters = self.gateways.values().filter(|known| known.is_established() || !is_any);
        let mut votes: Vec<i64> = voters.filter_map(Differences::least).collect();
        if votes.is_empty() {
            // No gateway was heard: the correction stays.
            return;
        }
        votes.push(self.log.least().unwrap_or_default());
        if votes.len().is_multiple_of(2) {
            votes.extend(self.own.least().map(|difference| self.own_sign.saturating_mul(difference)));
        }
        votes.sort_unstable();
        let upper = votes[votes.len() / 2];
        let lower = votes[(votes.len() - 1) / 2];
        // The middle two may differ: the one nearer to the correction so far is taken; at the beginning the log.
        let is_upper = upper.abs_diff(self.correction) < lower.abs_diff(self.correction);
        self.correction = if is_upper { upper } else { lower };
    }

    /// How far a gateway's clock is ahead of reference time, negative where it is behind; by its messages within the window.
    pub fn ahead(&self, gateway: &str) -> Option<SignedDuration> {
        let least = self.gateways.get(gateway)?.least()?;
        Some(SignedDuration::from_nanos(self.correction.saturating_sub(least)))
    }

    /// The same of the clock of this process.
    pub fn own_ahead(&self) -> Option<SignedDuration> {
        let difference = self.own_sign.saturating_mul(self.own.least()?);
        Some(SignedDuration::from_nanos(self.correction.saturating_sub(difference)))
    }

    /// Reference time by the base clock, once a gateway was heard.
    pub fn at(&self, base: Time) -> Option<Time> {
        self.last.map(|_| base + -SignedDuration::from_nanos(self.correction))
    }

    /// Why a message is not to be used, which was noted last, and by how much it is wrong; `ends` is the end of its slot, `now`
    /// reference time.
    fn refusal(&self, gateway: &str, sent: Time, ends: Time, now: Time) -> Option<(Refusal, SignedDuration)> {
        // It cannot have been sent after it arrived.
        if sent - now > BOUND {
            return Some((Refusal::Ahead, sent - now));
        }
        if ends - now > BOUND || now - ends > OLDEST {
            return Some((Refusal::Slot, ends - now));
        }
        let known = self.gateways.get(gateway)?;
        let ahead = self.ahead(gateway)?;
        (ahead < -BOUND && known.base.saturating_sub(known.since) >= LASTS_NS)
            .then_some((Refusal::Behind, ahead))
    }
}

fn nanos(duration: SignedDuration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

/// The clocks of a process, read together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// Since the process began, by a clock that is never set.
    pub steady: SignedDuration,
    /// By the clock of the machine, which may be wrong.
    pub wall: Time,
}

/// Clocks are compared over this time: a gateway sends four messages a second and line.
const COMPARED: SignedDuration = SignedDuration::from_secs(2);

/// Reference time at a process that reads the input.
#[derive(Clone, Debug)]
pub struct NodeTime(ReferenceClock);

impl Default for NodeTime {
    fn default() -> Self {
        Self(ReferenceClock::new(COMPARED))
    }
}

impl NodeTime {
    /// A message was read, of a slot that ends then: why it is not to be used, and by how much it is wrong. `gateway`: who sent it,
    /// and when; `None`: not stated, as by the version before.
    pub fn read(
        &mut self,
        gateway: Option<(&str, Time)>,
        stamp: Time,
        ends: Time,
        at: Moment,
    ) -> Option<(Refusal, SignedDuration)> {
        let (steady, wall) = (nanos(at.steady), at.wall.nanos());
        let of = gateway.map(|(gateway, sent)| (gateway, sent.nanos()));
        self.0.note_steady(of, (steady, stamp.nanos()), wall);
        // A message of the version before was sent when its slot was over.
        let (gateway, sent) = gateway.unwrap_or(("", ends));
        self.0.refusal(gateway, sent, ends, self.now(at))
    }

    /// Reference time; by the machine's own clock while nothing was read.
    pub fn now(&self, at: Moment) -> Time {
        self.0.at(Time::from_nanos(nanos(at.steady))).unwrap_or(at.wall)
    }

    /// Whether it is more than the machine's own clock: not after a few messages. Where no gateway states its name, that clock is all.
    pub fn is_settled(&self) -> bool {
        let is_heard = self.0.gateways.values().any(Differences::is_established);
        self.0.last.is_none() || is_heard || self.0.log.row >= NAMELESS
    }
}

#[cfg(test)]
mod tests;
