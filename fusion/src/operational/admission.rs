//! Admission of transponder identities: one that is heard once is neither compared with anything nor numbered, until a
//! second report agrees with the first.
//!
//! A receiver can be told any number of invented identities. A first report therefore costs a place in a table, which is
//! bounded; the second costs a permit, of which each receiver has `max_new_per_s` per second. Identities once admitted go on
//! unhindered.
//!
//! Reports come here slot by slot, sorted by time and identity: what is decided depends on the slot, not on the order of
//! arrival.

use std::collections::{BTreeMap, VecDeque};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::ids::TargetId;
use super::settings::{Transponder, periods};
use super::tuning::{
    ADMISSION_CREWED_SPEED_MAX_M_S, ADMISSION_GATE_M, ADMISSION_SPEED_MAX_M_S, ADMISSION_WAIT,
    ADMISSION_WAIT_PERIODS, FLOOD_LASTS, PERMITS_ACCUMULATE_S, SAME_REPORT, WAITING_MAX, WAITING_REPORTS_MAX,
};
use crate::point::Newcomers;
use crate::report::{AircraftKind, Fix, Identity, SensorIndex};
use crate::time::{SECOND, Time};

/// Who waits, and who was admitted.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Admission {
    waiting: BTreeMap<Identity, Waiting>,
    /// When each was last heard that was admitted.
    admitted: BTreeMap<Identity, Time>,
    receivers: BTreeMap<SensorIndex, Receiver>,
    /// The slot that is emitted.
    now: Time,
}

/// A waiting identity.
#[derive(Debug, Serialize, Deserialize)]
struct Waiting {
    /// Its place among the targets, by when it was first heard.
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
#[derive(Debug, Serialize, Deserialize)]
struct Receiver {
    /// By when they were first heard; those that were admitted meanwhile are still among them.
    queue: VecDeque<(Time, Identity, TargetId)>,
    waiting: usize,
    permits: Permits,
    /// It is a flood once new identities have used these up.
    usual: Permits,
    flood: Option<Flood>,
    /// New identities of the last second, by slot.
    lately: VecDeque<(Time, u32)>,
    count: Newcomers,
    /// Whether it was a flood when that was told last.
    told: bool,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Flood {
    until: Time,
    most: u32,
}

/// `per_s` permits per second, accumulated for [`PERMITS_ACCUMULATE_S`]; kept as the time at which all are there again.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Permits(Time);

impl Permits {
    /// Takes one; whether there was one.
    fn take(&mut self, now: Time, per_s: u32) -> bool {
        let whole = self.0.max(now).nanos() + SECOND / i64::from(per_s.max(1));
        let is_there = whole - now.nanos() <= PERMITS_ACCUMULATE_S * SECOND;
        if is_there {
            self.0 = Time::from_nanos(whole);
        }
        is_there
    }
}

/// An identity that is admitted.
#[derive(Debug)]
pub(super) struct Admitted {
    /// Its place among the targets.
    pub(super) target: TargetId,
    /// Its reports that waited and agree with the one that came; by the time at which they came.
    pub(super) waited: Vec<Fix>,
}

impl Admission {
    /// A slot begins: identities that have waited for too long are forgotten.
    pub(super) fn turn(&mut self, now: Time, receiver: impl Fn(SensorIndex) -> Option<Transponder>) {
        self.now = now;
        let longest = |sensor| wait(receiver(sensor).as_ref());
        let Self { waiting, receivers, admitted, .. } = self;
        let mut known = ADMISSION_WAIT;
        for (&sensor, of) in receivers.iter_mut() {
            let wait = longest(sensor);
            known = known.max(wait);
            while let Some(&(since, identity, target)) = of.queue.front()
                && now - since > wait
            {
                of.queue.pop_front();
                of.forget(identity, target, waiting, false);
            }
            of.turn(now);
        }
        admitted.retain(|_, heard| now - *heard <= known);
    }

    /// An identity that has a target was heard.
    pub(super) fn refresh(&mut self, identity: Identity) {
        self.admitted.insert(identity, self.now);
    }

    /// Another engine has admitted an identity; the reports that waited here.
    pub(super) fn admit(&mut self, identity: Identity) -> Vec<Fix> {
        self.admitted.insert(identity, self.now);
        let Some(waits) = self.waiting.remove(&identity) else { return Vec::new() };
        if let Some(of) = self.receivers.get_mut(&waits.sensor) {
            of.waiting -= 1;
            of.count.admitted += 1;
        }
        [waits.first].into_iter().chain(waits.more).collect()
    }

    /// A report of an identity that has no target: whether it is admitted with it. `target`: what its target is called that begins
    /// with this report.
    pub(super) fn offer(&mut self, fix: &Fix, settings: &Transponder, target: TargetId) -> Option<Admitted> {
        let Self { waiting, admitted, receivers, now } = self;
        if let Some(heard) = admitted.get_mut(&fix.identity) {
            *heard = *now;
            return Some(Admitted { target, waited: Vec::new() });
        }
        let of = receivers.entry(fix.sensor).or_insert_with(|| Receiver::new(fix.sensor, *now));
        let Some(waits) = waiting.get_mut(&fix.identity) else {
            let waits = Waiting { target, sensor: fix.sensor, first: *fix, more: Vec::new(), agrees: false };
            of.enqueue(fix.identity, waits.target, *now, settings.max_new_per_s);
            waiting.insert(fix.identity, waits);
            if of.waiting > WAITING_MAX {
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
        if 1 + waits.more.len() == WAITING_REPORTS_MAX {
            waits.first = waits.more.remove(0);
        }
        waits.more.push(*fix);
        None
    }

    /// Fates of new identities in this slot, per receiver that had some or whose flood began or ended.
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
        while self.lately.front().is_some_and(|(time, _)| now - *time >= SignedDuration::from_secs(1)) {
            self.lately.pop_front();
        }
        self.flood = self.flood.filter(|flood| now < flood.until);
    }

    /// A new identity, which begins to wait.
    fn enqueue(&mut self, identity: Identity, target: TargetId, now: Time, per_s: u32) {
        self.queue.push_back((now, identity, target));
        self.waiting += 1;
        self.count.heard += 1;
        match self.lately.back_mut() {
            Some((time, count)) if *time == now => *count += 1,
            _ => self.lately.push_back((now, 1)),
        }
        let most = self.lately.iter().map(|(_, count)| count).sum();
        if !self.usual.take(now, per_s) {
            let until = now + FLOOD_LASTS;
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

/// How long a receiver's identities wait.
fn wait(receiver: Option<&Transponder>) -> SignedDuration {
    let period_s = receiver.map_or(0.0, |receiver| receiver.period_s);
    ADMISSION_WAIT.max(periods(ADMISSION_WAIT_PERIODS, period_s))
}

/// Whether they are one report, heard twice.
fn is_same(one: &Fix, other: &Fix) -> bool {
    (one.time - other.time).abs() <= SAME_REPORT
}

/// Whether an aircraft could fly from one to the other.
fn agree(one: &Fix, other: &Fix) -> bool {
    let away_m = (one.position.0 - other.position.0).norm();
    let speed_m_s = match other.aircraft.kind {
        AircraftKind::Crewed => ADMISSION_CREWED_SPEED_MAX_M_S,
        AircraftKind::Unmanned | AircraftKind::Vehicle => ADMISSION_SPEED_MAX_M_S,
    };
    away_m <= ADMISSION_GATE_M + speed_m_s * one.time.seconds_since(other.time).abs()
}

#[cfg(test)]
mod tests;
