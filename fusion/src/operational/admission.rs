//! Who is let in: an identity that is heard once is neither compared with anything nor numbered, until a second report
//! agrees with the first.
//!
//! A receiver can be told any number of invented identities. A first report therefore costs a place in a table, which is
//! bounded; the second one costs a permit, and there are `max_new_per_s` a second of them, for each receiver. Identities
//! that were let in go on unhindered.
//!
//! Reports come here slot by slot, sorted by time and identity: what is decided depends on the slot and not on the order of
//! arrival.

use std::collections::{BTreeMap, VecDeque};

use super::settings::Transponder;
use super::target::SAME_NS;
use super::tracklet::TargetId;
use crate::point::Newcomers;
use crate::report::{Fix, Identity, SensorIndex};
use crate::time::{SECOND, Time};

/// Two reports of one identity agree when an aircraft could fly from one to the other: this fast, metres a second,
const FASTEST_M_S: f64 = 100.0;
/// and from where it is measured to where it is, metres.
const OFF_M: f64 = 100.0;
/// A first report waits so long for a second one, and for three periods of its receiver; an identity that was let in and has
/// fallen silent is known for as long. Nanoseconds.
const WAITS_NS: i64 = 60 * SECOND;
const WAITS_PERIODS: f64 = 3.0;
/// Permits gather for so many seconds: a service that starts into a city lets all of it in at once.
const GATHERS_S: i64 = 20;
/// Identities of a receiver that wait at most; the oldest give way.
const WAITING: usize = 1 << 16;
/// Reports of an identity that wait at most, where they do not agree; the oldest give way.
const REPORTS: usize = 4;
/// It is a flood from when more identities are new than permits would gather for, until so long after, nanoseconds.
const FLOOD_NS: i64 = 10 * SECOND;

/// Keeps who waits and who was let in.
#[derive(Debug, Default)]
pub(super) struct Admission {
    waiting: BTreeMap<Identity, Waiting>,
    /// When each was heard last that was let in.
    admitted: BTreeMap<Identity, Time>,
    receivers: BTreeMap<SensorIndex, Receiver>,
    /// The slot that is emitted.
    now: Time,
}

/// An identity that waits.
#[derive(Debug)]
struct Waiting {
    /// By when it was first heard it takes its turn among the targets.
    target: TargetId,
    /// The receiver of its first report.
    sensor: SensorIndex,
    first: Fix,
    /// Further reports that do not agree, or for which there was no permit.
    more: Vec<Fix>,
    /// Whether two reports agree.
    agrees: bool,
}

/// A transponder receiver's newcomers.
#[derive(Debug)]
struct Receiver {
    /// Who waits, by when they were first heard; those that were let in meanwhile are still among them.
    queue: VecDeque<(Time, Identity, TargetId)>,
    waiting: usize,
    permits: Permits,
    /// The measure of a flood: new identities use these up.
    usual: Permits,
    flood: Option<Flood>,
    /// New identities of the last second, by slot.
    lately: VecDeque<(Time, u32)>,
    count: Newcomers,
    /// Whether it was a flood when that was told last.
    told: bool,
}

#[derive(Clone, Copy, Debug)]
struct Flood {
    until: Time,
    most: u32,
}

/// So many a second, gathered for [`GATHERS_S`]. They are kept as the time at which all are there again.
#[derive(Clone, Copy, Debug)]
struct Permits(Time);

impl Permits {
    /// Takes one; whether there was one.
    fn take(&mut self, now: Time, per_s: u32) -> bool {
        let whole = self.0.max(now).nanos() + SECOND / i64::from(per_s.max(1));
        let is_there = whole - now.nanos() <= GATHERS_S * SECOND;
        if is_there {
            self.0 = Time::from_nanos(whole);
        }
        is_there
    }
}

/// An identity that is let in.
#[derive(Debug)]
pub(super) struct Admitted {
    /// Its target's place among the others.
    pub(super) target: TargetId,
    /// Its reports that waited and agree with the one that came; by the time at which they came.
    pub(super) waited: Vec<Fix>,
}

impl Admission {
    /// A slot begins: who has waited for too long is forgotten.
    pub(super) fn turn(&mut self, now: Time, receiver: impl Fn(SensorIndex) -> Option<Transponder>) {
        self.now = now;
        let longest = |sensor| waits_ns(receiver(sensor).as_ref());
        let Self { waiting, receivers, admitted, .. } = self;
        let mut known_ns = WAITS_NS;
        for (&sensor, of) in receivers.iter_mut() {
            let waits_ns = longest(sensor);
            known_ns = known_ns.max(waits_ns);
            while let Some(&(since, identity, target)) = of.queue.front()
                && now.nanos() - since.nanos() > waits_ns
            {
                of.queue.pop_front();
                of.forget(identity, target, waiting, false);
            }
            of.turn(now);
        }
        admitted.retain(|_, heard| now.nanos() - heard.nanos() <= known_ns);
    }

    /// An identity that has a target was heard.
    pub(super) fn note(&mut self, identity: Identity) {
        self.admitted.insert(identity, self.now);
    }

    /// A report of an identity that has no target: whether it is let in with it. `next` is the next target's place.
    pub(super) fn offer(&mut self, fix: &Fix, settings: &Transponder, next: &mut u64) -> Option<Admitted> {
        let Self { waiting, admitted, receivers, now } = self;
        let mut place = || {
            let target = TargetId(*next);
            *next += 1;
            target
        };
        if let Some(heard) = admitted.get_mut(&fix.identity) {
            *heard = *now;
            return Some(Admitted { target: place(), waited: Vec::new() });
        }
        let of = receivers.entry(fix.sensor).or_insert_with(|| Receiver::new(fix.sensor, *now));
        let Some(waits) = waiting.get_mut(&fix.identity) else {
            let waits =
                Waiting { target: place(), sensor: fix.sensor, first: *fix, more: Vec::new(), agrees: false };
            of.hear(fix.identity, waits.target, *now, settings.max_new_per_s);
            waiting.insert(fix.identity, waits);
            if of.waiting > WAITING {
                of.crowd_out(waiting);
            }
            return None;
        };
        if let Some(same) = waits.reports().find(|report| is_same(report, fix)) {
            *same = *fix;
            return None;
        }
        let agrees = waits.reports().any(|report| agree(report, fix));
        waits.agrees |= agrees;
        if agrees && of.permits.take(*now, settings.max_new_per_s) {
            let target = waits.target;
            let sensor = waits.sensor;
            let waited = waits.reports().filter(|report| agree(report, fix)).map(|report| *report).collect();
            waiting.remove(&fix.identity);
            admitted.insert(fix.identity, *now);
            of.count.admitted += 1;
            if let Some(of) = receivers.get_mut(&sensor) {
                of.waiting -= 1;
            }
            return Some(Admitted { target, waited });
        }
        if 1 + waits.more.len() == REPORTS {
            waits.first = waits.more.remove(0);
        }
        waits.more.push(*fix);
        None
    }

    /// What became of new identities in this slot, a receiver each that had some, or that a flood begins or ends of.
    pub(super) fn take(&mut self) -> Vec<Newcomers> {
        self.receivers.iter_mut().filter_map(|(&sensor, of)| of.take(sensor)).collect()
    }
}

impl Waiting {
    fn reports(&mut self) -> impl Iterator<Item = &mut Fix> {
        std::iter::once(&mut self.first).chain(&mut self.more)
    }
}

impl Receiver {
    fn new(sensor: SensorIndex, now: Time) -> Self {
        Self {
            queue: VecDeque::new(),
            waiting: 0,
            permits: Permits(now),
            usual: Permits(now),
            flood: None,
            lately: VecDeque::new(),
            count: Newcomers::none(sensor, None),
            told: false,
        }
    }

    fn turn(&mut self, now: Time) {
        while self.lately.front().is_some_and(|(time, _)| now.nanos() - time.nanos() >= SECOND) {
            self.lately.pop_front();
        }
        self.flood = self.flood.filter(|flood| now < flood.until);
    }

    /// An identity that begins to wait.
    fn hear(&mut self, identity: Identity, target: TargetId, now: Time, per_s: u32) {
        self.queue.push_back((now, identity, target));
        self.waiting += 1;
        self.count.heard += 1;
        match self.lately.back_mut() {
            Some((time, count)) if *time == now => *count += 1,
            _ => self.lately.push_back((now, 1)),
        }
        let most = self.lately.iter().map(|(_, count)| count).sum();
        if !self.usual.take(now, per_s) {
            let until = Time::from_nanos(now.nanos() + FLOOD_NS);
            let before = self.flood.map_or(0, |flood| flood.most);
            self.flood = Some(Flood { until, most: before.max(most) });
        }
    }

    /// The oldest that still waits gives way.
    fn crowd_out(&mut self, waiting: &mut BTreeMap<Identity, Waiting>) {
        let before = self.waiting;
        while self.waiting == before
            && let Some((_, identity, target)) = self.queue.pop_front()
        {
            self.forget(identity, target, waiting, true);
        }
    }

    /// Forgets it where it still waits, and counts why.
    fn forget(
        &mut self,
        identity: Identity,
        target: TargetId,
        waiting: &mut BTreeMap<Identity, Waiting>,
        is_crowded: bool,
    ) {
        let still = waiting.get(&identity).filter(|waits| waits.target == target);
        let Some(waits) = still else { return };
        let count = match (waits.agrees, waits.more.is_empty(), is_crowded) {
            (true, ..) => &mut self.count.rate_limited,
            (false, _, true) => &mut self.count.crowded_out,
            (false, true, false) => &mut self.count.heard_once,
            (false, false, false) => &mut self.count.inconsistent,
        };
        *count += 1;
        self.waiting -= 1;
        waiting.remove(&identity);
    }

    fn take(&mut self, sensor: SensorIndex) -> Option<Newcomers> {
        let flood = self.flood.map(|flood| flood.most);
        let count = std::mem::replace(&mut self.count, Newcomers::none(sensor, None));
        let is_news = count.fates().iter().any(|&(_, count)| count > 0) || flood.is_some() != self.told;
        self.told = flood.is_some();
        is_news.then_some(Newcomers { flood, ..count })
    }
}

/// How long a receiver's identities wait, nanoseconds.
fn waits_ns(receiver: Option<&Transponder>) -> i64 {
    let period_s = receiver.map_or(0.0, |receiver| receiver.period_s);
    WAITS_NS.max((WAITS_PERIODS * period_s * SECOND as f64) as i64)
}

/// Whether they are one report, heard twice.
fn is_same(one: &Fix, other: &Fix) -> bool {
    one.time.nanos().abs_diff(other.time.nanos()) <= SAME_NS as u64
}

/// Whether an aircraft could fly from one to the other.
fn agree(one: &Fix, other: &Fix) -> bool {
    let away_m = (one.position.0 - other.position.0).norm();
    away_m <= OFF_M + FASTEST_M_S * one.time.seconds_since(other.time).abs()
}

#[cfg(test)]
mod tests;
