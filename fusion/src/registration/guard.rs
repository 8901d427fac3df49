//! Decides which estimate of a registration is used while the offsets that it is learnt from turn.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use serde::{Deserialize, Serialize};

use super::creep::{CreepMonitor, Trend, Turned, bin};
use super::estimate::{BiasValue, Misalignment};
use super::tracks::Registration;
use crate::report::{Host, Identity};
use crate::time::{SECOND, Time};

/// From this many deviations on the estimate from before the window is used: where no bearing is in use yet, and where one is.
const HELD_UNUSED: f64 = 2.0;
const HELD_USED: f64 = 3.0;
/// From this many on, in a window of this length, it is an alarm.
const ALARM: f64 = 5.0;
const ALARM_S: f64 = 20.0;
/// Minimum change over the window for each, radians.
const HELD_CHANGE: f64 = 0.1_f64.to_radians();
const ALARM_CHANGE: f64 = 0.3_f64.to_radians();
/// Hosts that are first heard so soon after another are no newcomers beside it, seconds.
const TOGETHER_S: f64 = 60.0;
/// A newcomer counts in full after this time, seconds.
const KNOWN_S: f64 = 600.0;
/// Number of hosts whose age is kept.
const HOSTS_MAX: usize = 256;
/// Time between two estimates that are remembered, nanoseconds, and for how long they are.
const REMEMBERED_NS: i64 = 5 * SECOND;
const FORGOTTEN_NS: i64 = 310 * SECOND;
/// Time between two copies of the registration, nanoseconds: the older one is older than any window.
const COPIED_NS: i64 = 300 * SECOND;

/// The bearing that some identities show creeps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Creep {
    /// When it was detected.
    pub time: Time,
    /// The host whose identities show it; `None`: several hosts' together.
    pub host: Option<Host>,
    /// How fast the bearing turned, radians a second.
    pub rate: f64,
    /// For how long, seconds.
    pub window_s: f64,
    /// The bearing that remains.
    pub bearing: BiasValue,
}

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Checked {
    /// The same is used as before.
    Unchanged,
    /// The estimate is held, or is not held any more.
    Changed,
    /// An alarm was raised.
    Alarm,
}

/// Keeps a registration that creeps from being used.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct CreepGuard {
    monitor: CreepMonitor,
    /// Estimates of the last minutes.
    estimates: VecDeque<(Time, Misalignment)>,
    /// Copies of the registration: the older, the newer.
    copies: VecDeque<(Time, Registration)>,
    /// The estimate that is used instead of the latest one.
    held: Option<Misalignment>,
    /// Number of the latest bin in which it was checked.
    checked: Option<i64>,
    /// When each host was first heard of.
    hosts: BTreeMap<Host, Time>,
    /// Hosts of which nothing is learnt any more.
    excluded: BTreeSet<Host>,
    alarm: Option<Creep>,
}

impl CreepGuard {
    /// A plot of an identity; whether anything may be learnt from it.
    pub(crate) fn add(&mut self, of: (Host, Identity), turned: &Turned) -> bool {
        if self.hosts.len() < HOSTS_MAX {
            self.hosts.entry(of.0).or_insert(turned.time);
        }
        self.monitor.add(of, turned)
    }

    /// How much what a host reports counts, 0 to 1. A host that came later than another that is still heard counts the more the
    /// longer it is known, and all its identities together as one.
    pub(crate) fn weight(&self, host: Host, now: Time) -> f64 {
        let identities = self.monitor.identities();
        let known = identities.keys().filter(|other| **other != host);
        let Some(oldest) = known.filter_map(|other| self.hosts.get(other)).min() else { return 1.0 };
        let since = self.hosts.get(&host).copied().unwrap_or(now);
        if since.seconds_since(*oldest) <= TOGETHER_S {
            return 1.0;
        }
        let number = identities.get(&host).copied().unwrap_or(1).max(1);
        (now.seconds_since(since) / KNOWN_S).clamp(0.0, 1.0) / number as f64
    }

    /// Whether nothing is learnt from a host.
    pub(crate) fn excludes(&self, host: Host) -> bool {
        self.excluded.contains(&host)
    }

    /// The latest alarm.
    pub(crate) fn alarm(&self) -> Option<Creep> {
        self.alarm
    }

    /// The estimate that is used: this one, or an earlier one that is held.
    pub(crate) fn used(&self, estimate: Misalignment) -> Misalignment {
        self.held.unwrap_or(estimate)
    }

    /// The registration was learnt before a restart: it is what remains in case of an alarm.
    pub(crate) fn restore(&mut self, registration: &Registration) {
        self.copies = [(Time::from_nanos(i64::MIN), registration.clone())].into();
        self.estimates = [(Time::from_nanos(i64::MIN), registration.estimate())].into();
    }

    /// Looks whether the offsets turn, once a bin. With an alarm what was learnt since is taken back.
    pub(crate) fn check(&mut self, registration: &mut Registration, now: Time) -> Checked {
        if self.checked.replace(bin(now)) == Some(bin(now)) {
            return Checked::Unchanged;
        }
        let before = self.held.is_some();
        let trends = self.monitor.look(now);
        let most = |from_s: f64, change: f64| {
            let trends = trends.iter().filter(|trend| trend.window_s >= from_s && trend.change() >= change);
            trends.max_by(|one, other| one.deviations.total_cmp(&other.deviations)).copied()
        };
        if let Some(trend) = most(ALARM_S, ALARM_CHANGE).filter(|trend| trend.deviations >= ALARM) {
            self.raise(&trend, registration, now);
            return Checked::Alarm;
        }
        let limit = if self.is_used() { HELD_USED } else { HELD_UNUSED };
        match most(0.0, HELD_CHANGE).filter(|trend| trend.deviations >= limit) {
            Some(trend) if self.held.is_none() => {
                self.held = Some(self.estimate_before(begin(&trend, now)));
            }
            Some(_) => {}
            None => self.held = None,
        }
        self.remember(registration, now);
        if before == self.held.is_some() { Checked::Unchanged } else { Checked::Changed }
    }

    /// Whether a bearing is in use.
    fn is_used(&self) -> bool {
        let latest = self.estimates.back().map(|(_, estimate)| estimate);
        self.held.as_ref().or(latest).is_some_and(|used| used.bearing.observable)
    }

    fn estimate_before(&self, begin: Time) -> Misalignment {
        let before = self.estimates.iter().rev().find(|(time, _)| *time <= begin);
        before.map_or_else(|| Registration::default().estimate(), |(_, estimate)| *estimate)
    }

    fn remember(&mut self, registration: &Registration, now: Time) {
        let passed = |since: Option<Time>, ns: i64| {
            since.is_none_or(|since| now.nanos().saturating_sub(since.nanos()) >= ns)
        };
        if self.held.is_some() {
            return;
        }
        if passed(self.estimates.back().map(|of| of.0), REMEMBERED_NS) {
            self.estimates.push_back((now, registration.estimate()));
            while self.estimates.get(1).is_some_and(|(time, _)| passed(Some(*time), FORGOTTEN_NS)) {
                self.estimates.pop_front();
            }
        }
        if passed(self.copies.back().map(|of| of.0), COPIED_NS) {
            self.copies.push_back((now, registration.clone()));
            if self.copies.len() > 2 {
                self.copies.pop_front();
            }
        }
    }

    fn raise(&mut self, trend: &Trend, registration: &mut Registration, now: Time) {
        let begin = begin(trend, now);
        let before = self.copies.iter().rev().find(|(time, _)| *time <= begin);
        *registration = before.map_or_else(Registration::default, |(_, copy)| copy.clone());
        let hosts: BTreeSet<Host> = match trend.host {
            Some(host) => [host].into(),
            None => self.monitor.identities().into_keys().collect(),
        };
        self.monitor.remove(&hosts);
        self.excluded.extend(hosts);
        self.held = None;
        self.estimates.retain(|(time, _)| *time <= begin);
        self.copies.retain(|(time, _)| *time <= begin);
        let Trend { host, rate, window_s, .. } = *trend;
        self.alarm =
            Some(Creep { time: now, host, rate, window_s, bearing: registration.estimate().bearing });
    }
}

/// When the window of a trend began.
fn begin(trend: &Trend, now: Time) -> Time {
    Time::from_nanos(now.nanos() - (trend.window_s * SECOND as f64) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * SECOND)
    }

    fn hear(guard: &mut CreepGuard, host: u64, identity: u32, seconds: i64) {
        let of = (Host(host), Identity::of_address(identity));
        let turned = Turned { time: at(seconds), begun: at(0), offset: 0.0, rate: 0.0 };
        assert!(guard.add(of, &turned));
    }

    #[test]
    fn hosts_that_come_together_count_in_full() {
        let mut guard = CreepGuard::default();
        hear(&mut guard, 1, 1, 0);
        (2..=5).for_each(|identity| hear(&mut guard, 2, identity, 50));
        assert_eq!([1, 2].map(|host| guard.weight(Host(host), at(60))), [1.0, 1.0]);
    }

    #[test]
    fn identities_of_a_later_host_count_as_one_that_grows() {
        let mut guard = CreepGuard::default();
        hear(&mut guard, 1, 1, 0);
        (2..=5).for_each(|identity| hear(&mut guard, 2, identity, 1000));
        assert_eq!(guard.weight(Host(1), at(1000)), 1.0);
        let weights = [1000, 1300, 1600, 9000].map(|seconds| guard.weight(Host(2), at(seconds)));
        assert_eq!(weights, [0.0, 0.125, 0.25, 0.25]);
    }

    #[test]
    fn a_later_host_alone_counts_in_full() {
        let mut guard = CreepGuard::default();
        hear(&mut guard, 1, 1, 0);
        let mut registration = Registration::default();
        assert_eq!(guard.check(&mut registration, at(2000)), Checked::Unchanged);
        hear(&mut guard, 2, 2, 2000);
        assert_eq!(guard.weight(Host(2), at(2000)), 1.0);
    }
}
