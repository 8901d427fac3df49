//! Admission of transponder identities. An identity with only one report is neither compared with anything nor
//! numbered, until a second report agrees with the first.
//!
//! Any number of invented identities can be transmitted to a receiver. A first report therefore only takes an entry in
//! a table, which is bounded. The second takes a permit; each receiver has `max_new_per_s` per second. Admitted
//! identities are not limited.
//!
//! Reports are offered slot by slot, sorted by time and identity: decisions depend on the slot, not on the order of
//! arrival.

use std::collections::{BTreeMap, VecDeque};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::ids::TargetId;
use super::settings::{ReceiverSettings, periods};
use super::tuning::{
    ADMISSION_CREWED_SPEED_MAX_M_S, ADMISSION_GATE_M, ADMISSION_SPEED_MAX_M_S, ADMISSION_WAIT,
    ADMISSION_WAIT_PERIODS, FLOOD_LASTS, PERMITS_ACCUMULATE_S, SAME_REPORT, WAITING_MAX, WAITING_REPORTS_MAX,
};
use crate::point::Newcomers;
use crate::report::{AircraftKind, Fix, Identity, SensorIndex};
use crate::time::{SECOND, Time};

/// Waiting and admitted identities.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Admission {
    waiting: BTreeMap<Identity, WaitingIdentity>,
    /// Time of the last report of each admitted identity.
    admitted: BTreeMap<Identity, Time>,
    receivers: BTreeMap<SensorIndex, ReceiverAdmission>,
    /// Centre of the slot being decided.
    now: Time,
}

/// An identity that waits for admission.
#[derive(Debug, Serialize, Deserialize)]
struct WaitingIdentity {
    /// Identifier of its target, which orders targets by their first report.
    target: TargetId,
    /// The receiver of its first report.
    sensor: SensorIndex,
    first: Fix,
    /// Further reports that do not agree, or for which there was no permit.
    more: Vec<Fix>,
    /// Whether two reports agree.
    agrees: bool,
}

/// New identities of a transponder receiver.
#[derive(Debug, Serialize, Deserialize)]
struct ReceiverAdmission {
    /// Identities by the time of their first report, including some that have been admitted since.
    queue: VecDeque<(Time, Identity, TargetId)>,
    waiting: usize,
    permits: AdmissionPermits,
    /// Permits for a usual rate of new identities; a flood begins when they are used up.
    usual: AdmissionPermits,
    flood: Option<IdentityFlood>,
    /// Numbers of new identities in the slots of the last second.
    lately: VecDeque<(Time, u32)>,
    count: Newcomers,
    /// Whether a flood was in progress at the last report of counts.
    is_flood_reported: bool,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct IdentityFlood {
    until: Time,
    most: u32,
}

/// `per_s` permits per second, accumulated over [`PERMITS_ACCUMULATE_S`]; stored as the time at which all are available
/// again.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct AdmissionPermits(Time);

impl AdmissionPermits {
    /// Uses a permit; returns whether one was available.
    fn use_permit(&mut self, now: Time, per_s: u32) -> bool {
        let whole = self.0.max(now).nanos() + SECOND / i64::from(per_s.max(1));
        let is_present = whole - now.nanos() <= PERMITS_ACCUMULATE_S * SECOND;
        if is_present {
            self.0 = Time::from_nanos(whole);
        }
        is_present
    }
}

/// An identity that is admitted.
#[derive(Debug)]
pub(super) struct AdmittedIdentity {
    /// Identifier of its target.
    pub(super) target: TargetId,
    /// Its waiting reports that agree with the new one, in order of reception.
    pub(super) waited: Vec<Fix>,
}

impl Admission {
    /// Starts a slot: forgets identities that have waited too long.
    pub(super) fn begin_slot(
        &mut self,
        now: Time,
        receiver: impl Fn(SensorIndex) -> Option<ReceiverSettings>,
    ) {
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
            of.begin_slot(now);
        }
        admitted.retain(|_, heard| now - *heard <= known);
    }

    /// Notes a report of an identity that has a target.
    pub(super) fn refresh(&mut self, identity: Identity) {
        self.admitted.insert(identity, self.now);
    }

    /// Admits an identity that another engine has admitted; returns the reports that waited here.
    pub(super) fn admit(&mut self, identity: Identity) -> Vec<Fix> {
        self.admitted.insert(identity, self.now);
        let Some(waits) = self.waiting.remove(&identity) else { return Vec::new() };
        if let Some(of) = self.receivers.get_mut(&waits.sensor) {
            of.waiting -= 1;
            of.count.admitted += 1;
        }
        [waits.first].into_iter().chain(waits.more).collect()
    }

    /// Offers a report of an identity without a target; returns whether the identity is admitted. `target` is the
    /// identifier of a target that begins with this report.
    pub(super) fn offer(
        &mut self,
        fix: &Fix,
        settings: &ReceiverSettings,
        target: TargetId,
    ) -> Option<AdmittedIdentity> {
        let Self { waiting, admitted, receivers, now } = self;
        if let Some(heard) = admitted.get_mut(&fix.identity) {
            *heard = *now;
            return Some(AdmittedIdentity { target, waited: Vec::new() });
        }
        let of = receivers.entry(fix.sensor).or_insert_with(|| ReceiverAdmission::new(fix.sensor, *now));
        let Some(waits) = waiting.get_mut(&fix.identity) else {
            let waits =
                WaitingIdentity { target, sensor: fix.sensor, first: *fix, more: Vec::new(), agrees: false };
            of.enqueue(fix.identity, waits.target, *now, settings.max_new_per_s);
            waiting.insert(fix.identity, waits);
            if of.waiting > WAITING_MAX {
                of.evict_oldest(waiting);
            }
            return None;
        };
        if let Some(same) = waits.reports().find(|report| is_same(report, fix)) {
            *same = *fix;
            return None;
        }
        let agrees = waits.reports().any(|report| agree(report, fix));
        waits.agrees |= agrees;
        if agrees && of.permits.use_permit(*now, settings.max_new_per_s) {
            let target = waits.target;
            let sensor = waits.sensor;
            let waited = waits.reports().filter(|report| agree(report, fix)).map(|report| *report).collect();
            waiting.remove(&fix.identity);
            admitted.insert(fix.identity, *now);
            of.count.admitted += 1;
            if let Some(of) = receivers.get_mut(&sensor) {
                of.waiting -= 1;
            }
            return Some(AdmittedIdentity { target, waited });
        }
        if 1 + waits.more.len() == WAITING_REPORTS_MAX {
            waits.first = waits.more.remove(0);
        }
        waits.more.push(*fix);
        None
    }

    /// Counts of new identities in this slot, for each receiver that had some or whose flood began or ended.
    pub(super) fn take_counts(&mut self) -> Vec<Newcomers> {
        self.receivers.iter_mut().filter_map(|(&sensor, of)| of.take_counts(sensor)).collect()
    }
}

impl WaitingIdentity {
    fn reports(&mut self) -> impl Iterator<Item = &mut Fix> {
        std::iter::once(&mut self.first).chain(&mut self.more)
    }
}

impl ReceiverAdmission {
    fn new(sensor: SensorIndex, now: Time) -> Self {
        Self {
            queue: VecDeque::new(),
            waiting: 0,
            permits: AdmissionPermits(now),
            usual: AdmissionPermits(now),
            flood: None,
            lately: VecDeque::new(),
            count: Newcomers::none(sensor, None),
            is_flood_reported: false,
        }
    }

    fn begin_slot(&mut self, now: Time) {
        while self.lately.front().is_some_and(|(time, _)| now - *time >= SignedDuration::from_secs(1)) {
            self.lately.pop_front();
        }
        self.flood = self.flood.filter(|flood| now < flood.until);
    }

    /// Adds a new identity, which begins to wait.
    fn enqueue(&mut self, identity: Identity, target: TargetId, now: Time, per_s: u32) {
        self.queue.push_back((now, identity, target));
        self.waiting += 1;
        self.count.heard += 1;
        match self.lately.back_mut() {
            Some((time, count)) if *time == now => *count += 1,
            _ => self.lately.push_back((now, 1)),
        }
        let most = self.lately.iter().map(|(_, count)| count).sum();
        if !self.usual.use_permit(now, per_s) {
            let until = now + FLOOD_LASTS;
            let before = self.flood.map_or(0, |flood| flood.most);
            self.flood = Some(IdentityFlood { until, most: before.max(most) });
        }
    }

    /// Discards the identity that has waited longest.
    fn evict_oldest(&mut self, waiting: &mut BTreeMap<Identity, WaitingIdentity>) {
        let before = self.waiting;
        while self.waiting == before
            && let Some((_, identity, target)) = self.queue.pop_front()
        {
            self.forget(identity, target, waiting, true);
        }
    }

    /// Discards an identity if it still waits, and counts the reason.
    fn forget(
        &mut self,
        identity: Identity,
        target: TargetId,
        waiting: &mut BTreeMap<Identity, WaitingIdentity>,
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

    fn take_counts(&mut self, sensor: SensorIndex) -> Option<Newcomers> {
        let flood = self.flood.map(|flood| flood.most);
        let count = std::mem::replace(&mut self.count, Newcomers::none(sensor, None));
        let is_news =
            count.fates().iter().any(|&(_, count)| count > 0) || flood.is_some() != self.is_flood_reported;
        self.is_flood_reported = flood.is_some();
        is_news.then_some(Newcomers { flood, ..count })
    }
}

/// Maximum waiting time of a receiver's identities.
fn wait(receiver: Option<&ReceiverSettings>) -> SignedDuration {
    let period_s = receiver.map_or(0.0, |receiver| receiver.period_s);
    ADMISSION_WAIT.max(periods(ADMISSION_WAIT_PERIODS, period_s))
}

/// Whether both are one report that was received twice.
fn is_same(one: &Fix, other: &Fix) -> bool {
    (one.time - other.time).abs() <= SAME_REPORT
}

/// Whether an aircraft could fly from one position to the other.
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
