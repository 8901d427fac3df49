//! Reference time: the median of the clocks of the log and the gateways, so that no single clock decides. Sans-IO.
//!
//! The log stamps each message, and the sender states the time of sending. The reader compares both with a clock of its process,
//! which is never set. A message takes time and never arrives before it was sent, so the least difference over a window is the
//! difference of the two clocks. The log and each gateway have a vote.

use std::collections::{BTreeMap, VecDeque};

use fusion::time::Time;
use jiff::SignedDuration;

/// Error above which a clock is wrong.
pub const BOUND: SignedDuration = SignedDuration::from_secs(1);
/// Maximum time by which a slot is made before it is due by reference time, even if all its sensors have reported.
pub const EARLY: SignedDuration = SignedDuration::from_millis(100);
/// Age above which a slot is refused. No gateway keeps messages for this long.
const MAX_SLOT_AGE: SignedDuration = SignedDuration::from_hours(24);
/// Backward step of the log's timestamps that means that another server leads it, in nanoseconds.
const LOG_STEP_NS: i64 = 100_000_000;
/// Time for which all messages of a gateway have to show that its clock is behind, in nanoseconds. Single messages that waited in
/// a buffer are old and correct.
const BEHIND_AFTER_NS: i64 = 1_500_000_000;
/// Number of messages after which reference time is used even if no gateway states its name.
const NAMELESS_MESSAGES: u32 = 32;
/// Number of consecutive messages after which a gateway has a vote, so that invented names have none. A gap longer than the
/// window restarts the count.
const ESTABLISHED_MESSAGES: u32 = 8;
/// Maximum number of gateways known at once. A site has fewer.
const MAX_GATEWAYS: usize = 64;

/// Difference of a base clock minus another clock, in nanoseconds: the least within the window.
#[derive(Clone, Debug, Default)]
struct Differences {
    /// Base time, the log's timestamp, and the difference. Base times and differences increase: a greater difference before a
    /// lesser one is never the least again.
    least: VecDeque<(i64, i64, i64)>,
    /// The log's timestamp of the last message.
    stamp: i64,
    /// Base time since when there has always been a difference within the window, and the other clock was not set.
    since: i64,
    /// The last times by the base clock and by the other clock.
    base: i64,
    last: i64,
    /// Number of consecutive messages, until the gateway is established.
    consecutive: u32,
}

impl Differences {
    fn note(&mut self, (base, stamp): (i64, i64), at: i64, window: i64) {
        let (difference, most) = (base.saturating_sub(at), window.unsigned_abs());
        let is_gap = stamp.abs_diff(self.stamp) > most;
        self.expire((base, stamp), window);
        if self.least.is_empty() || at.abs_diff(self.last) > most {
            self.since = base;
        }
        if self.consecutive == 0 || is_gap {
            self.consecutive = if self.is_established() { self.consecutive } else { 0 };
        }
        (self.base, self.stamp, self.last) = (base, stamp, at);
        self.consecutive = self.consecutive.saturating_add(1);
        while self.least.back().is_some_and(|(.., known)| *known >= difference) {
            self.least.pop_back();
        }
        self.least.push_back((base, stamp, difference));
    }

    /// Removes differences that are older than the window. Their age counts by the base clock and by the log's, because a reader
    /// that catches up reads minutes of messages within a moment.
    fn expire(&mut self, (base, stamp): (i64, i64), window: i64) {
        let is_old = |(read, stamped, _): &(i64, i64, i64)| {
            base.abs_diff(*read).max(stamp.abs_diff(*stamped)) > window.unsigned_abs()
        };
        while self.least.front().is_some_and(is_old) {
            self.least.pop_front();
        }
    }

    const fn is_established(&self) -> bool {
        self.consecutive >= ESTABLISHED_MESSAGES
    }

    fn least(&self) -> Option<i64> {
        self.least.front().map(|(.., difference)| *difference)
    }
}

/// Reason why a message is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InputRefusal {
    /// The gateway's clock is ahead of reference time.
    Ahead,
    /// The gateway's clock is behind.
    Behind,
    /// The slot is not over yet, or is of another day.
    Slot,
    /// The gateway has another shared configuration.
    Configuration,
}

impl InputRefusal {
    /// The reason in words.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Ahead => "its clock is ahead",
            Self::Behind => "its clock is behind",
            Self::Slot => "the slot is not over, or of another day",
            Self::Configuration => "its configuration is another one",
        }
    }
}

/// Reference time, derived from the messages read of a log.
#[derive(Clone, Debug)]
pub struct ReferenceClock {
    window: i64,
    gateways: BTreeMap<String, Differences>,
    /// The log's clock; empty if it is the base clock.
    log: Differences,
    /// The clock of this process, which has a vote if the number of other votes is even; and the sign of its differences.
    own: Differences,
    own_sign: i64,
    /// The base clock and the log's clock at the last message.
    last: Option<(i64, i64)>,
    /// Time by which the base clock is ahead of reference time, in nanoseconds.
    correction: i64,
}

impl ReferenceClock {
    /// Creates a clock that compares over this window.
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

    /// Notes a message of a gateway: the log's timestamp, and the sending time by the gateway's clock. The log's clock is the
    /// base.
    pub fn note(&mut self, gateway: &str, stamp: Time, sent: Time) {
        let (stamp, sent) = (stamp.nanos(), sent.nanos());
        self.step(stamp, gateway, stamp.saturating_sub(sent));
        self.note_gateway(gateway, (stamp, stamp), sent);
    }

    /// Notes a message with a clock that is never set as the base. The log has a vote like the gateways.
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
        if !self.gateways.contains_key(gateway) && self.gateways.len() >= MAX_GATEWAYS {
            let least = self.gateways.iter().min_by_key(|(_, known)| (known.is_established(), known.stamp));
            let oldest = least.map(|(name, _)| name.clone());
            oldest.into_iter().for_each(|name| _ = self.gateways.remove(&name));
        }
        self.gateways.entry(gateway.to_owned()).or_default().note(at, sent, self.window);
        self.vote();
    }

    /// Notes the clock of this process when it read a message without delay.
    pub fn note_read(&mut self, stamp: Time, read: Time) {
        // Reading takes time, too, so the greatest difference counts: the least with the opposite sign.
        let (stamp, read) = (stamp.nanos(), read.nanos());
        self.own_sign = -1;
        self.own.note((stamp, stamp), stamp.saturating_sub(read.saturating_sub(stamp)), self.window);
        self.vote();
    }

    /// Notes the clock of this process when it sent a message.
    pub fn note_sent(&mut self, stamp: Time, sent: Time) {
        self.own_sign = 1;
        self.own.note((stamp.nanos(), stamp.nanos()), sent.nanos(), self.window);
        self.vote();
    }

    /// Discards the differences of this process's clock after it was set.
    pub fn forget(&mut self, own_gateway: &str) {
        self.gateways.get_mut(own_gateway).into_iter().for_each(|known| known.least.clear());
        self.own.least.clear();
    }

    /// Handles a backward step of the log's clock, for example when another server leads it: discards the known differences.
    fn step(&mut self, stamp: i64, gateway: &str, difference: i64) {
        if let Some((before, _)) = self.last
            && stamp < before - LOG_STEP_NS
        {
            // The step is this gateway's change of difference: the gateway's own clock cannot turn back the log's.
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
        // Gateways with only a few messages have no vote. Before any gateway is established this process's clock decides; with
        // one report a second, all gateways vote.
        let is_any = self.gateways.values().any(Differences::is_established);
        if !is_any && self.log.consecutive > 0 {
            return;
        }
        let voters = self.gateways.values().filter(|known| known.is_established() || !is_any);
        let mut votes: Vec<i64> = voters.filter_map(Differences::least).collect();
        if votes.is_empty() {
            // No gateway has reported: keep the correction.
            return;
        }
        votes.push(self.log.least().unwrap_or_default());
        if votes.len().is_multiple_of(2) {
            votes.extend(self.own.least().map(|difference| self.own_sign.saturating_mul(difference)));
        }
        votes.sort_unstable();
        let upper = votes[votes.len() / 2];
        let lower = votes[(votes.len() - 1) / 2];
        // The middle two may differ: take the one nearer to the previous correction, at the start the log's.
        let is_upper = upper.abs_diff(self.correction) < lower.abs_diff(self.correction);
        self.correction = if is_upper { upper } else { lower };
    }

    /// Time by which a gateway's clock is ahead of reference time, negative if it is behind, by its messages within the window.
    pub fn ahead(&self, gateway: &str) -> Option<SignedDuration> {
        let least = self.gateways.get(gateway)?.least()?;
        Some(SignedDuration::from_nanos(self.correction.saturating_sub(least)))
    }

    /// Time by which the clock of this process is ahead of reference time, negative if it is behind.
    pub fn own_ahead(&self) -> Option<SignedDuration> {
        let difference = self.own_sign.saturating_mul(self.own.least()?);
        Some(SignedDuration::from_nanos(self.correction.saturating_sub(difference)))
    }

    /// Reference time at a base time, once a gateway has reported.
    pub fn at(&self, base: Time) -> Option<Time> {
        self.last.map(|_| base + -SignedDuration::from_nanos(self.correction))
    }

    /// Reason to refuse the message that was noted last, and the size of the error. `ends` is the end of its slot, `now` is
    /// reference time.
    fn refusal(
        &self,
        gateway: &str,
        sent: Time,
        ends: Time,
        now: Time,
    ) -> Option<(InputRefusal, SignedDuration)> {
        // A message cannot have been sent after it arrived.
        if sent - now > BOUND {
            return Some((InputRefusal::Ahead, sent - now));
        }
        if ends - now > BOUND || now - ends > MAX_SLOT_AGE {
            return Some((InputRefusal::Slot, ends - now));
        }
        let known = self.gateways.get(gateway)?;
        let ahead = self.ahead(gateway)?;
        (ahead < -BOUND && known.base.saturating_sub(known.since) >= BEHIND_AFTER_NS)
            .then_some((InputRefusal::Behind, ahead))
    }
}

fn nanos(duration: SignedDuration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

/// The clocks of a process, read together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockReading {
    /// Time since the process started, by a clock that is never set.
    pub steady: SignedDuration,
    /// The machine's clock, which may be wrong.
    pub wall: Time,
}

/// Window of the comparison. A gateway sends four messages a second on each line.
const COMPARISON_WINDOW: SignedDuration = SignedDuration::from_secs(2);

/// Reference time at a process that reads the inputs.
#[derive(Clone, Debug)]
pub struct NodeTime(ReferenceClock);

impl Default for NodeTime {
    fn default() -> Self {
        Self(ReferenceClock::new(COMPARISON_WINDOW))
    }
}

impl NodeTime {
    /// Notes a message of a slot that ends at `ends`. Returns the reason to refuse it, and the size of the error. `gateway` is
    /// the sender with the sending time; `None` if not stated, as by version 0.6.0.
    pub fn read(
        &mut self,
        gateway: Option<(&str, Time)>,
        stamp: Time,
        ends: Time,
        at: ClockReading,
    ) -> Option<(InputRefusal, SignedDuration)> {
        let (steady, wall) = (nanos(at.steady), at.wall.nanos());
        let of = gateway.map(|(gateway, sent)| (gateway, sent.nanos()));
        self.0.note_steady(of, (steady, stamp.nanos()), wall);
        // Version 0.6.0 sent a message when its slot was over.
        let (gateway, sent) = gateway.unwrap_or(("", ends));
        self.0.refusal(gateway, sent, ends, self.now(at))
    }

    /// Reference time; the machine's clock until a message was read.
    pub fn now(&self, at: ClockReading) -> Time {
        self.0.at(Time::from_nanos(nanos(at.steady))).unwrap_or(at.wall)
    }

    /// Whether reference time rests on more than the machine's clock, which takes a few messages. If no gateway states its name,
    /// that clock is used.
    pub fn is_settled(&self) -> bool {
        let is_heard = self.0.gateways.values().any(Differences::is_established);
        self.0.last.is_none() || is_heard || self.0.log.consecutive >= NAMELESS_MESSAGES
    }
}

#[cfg(test)]
mod tests;
