//! Selects the estimate of a registration that is used while its offsets rotate.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use serde::{Deserialize, Serialize};

use super::creep::{AzimuthOffset, CreepMonitor, Trend, bin};
use super::estimate::{BiasValue, Misalignment};
use super::tracks::Registration;
use crate::report::{Host, Identity};
use crate::time::{SECOND, Time};

/// Deviations of a slope above which the estimate from before its window is held, if no bearing is in use.
const HELD_UNUSED: f64 = 2.0;
/// Deviations of a slope above which the estimate from before its window is held, if a bearing is in use.
const HELD_USED: f64 = 3.0;
/// Deviations of a slope above which an alarm is raised.
const ALARM: f64 = 5.0;
/// Minimum length of a window with an alarm, seconds.
const ALARM_S: f64 = 20.0;
/// Minimum change over the window for holding the estimate, radians.
const HELD_CHANGE: f64 = 0.1_f64.to_radians();
/// Minimum change over the window for an alarm, radians.
const ALARM_CHANGE: f64 = 0.3_f64.to_radians();
/// Maximum time between the first reports of two hosts for which the later one is not a newcomer, seconds.
const TOGETHER_S: f64 = 60.0;
/// Time after which a newcomer has full weight, seconds.
const KNOWN_S: f64 = 600.0;
/// Maximum number of hosts with a stored age.
const HOSTS_MAX: usize = 256;
/// Time between two stored estimates, nanoseconds.
const REMEMBERED_NS: i64 = 5 * SECOND;
/// Age up to which estimates are stored, nanoseconds.
const FORGOTTEN_NS: i64 = 310 * SECOND;
/// Time between two copies of the registration, nanoseconds. The older copy precedes any window.
const COPIED_NS: i64 = 300 * SECOND;

/// Alarm: the bearing that some identities show rotates steadily.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Creep {
    /// Time of the detection.
    pub time: Time,
    /// Host whose identities show the rotation; `None`: several hosts together.
    pub host: Option<Host>,
    /// Rate of the bearing, radians a second.
    pub rate: f64,
    /// Length of the window, seconds.
    pub window_s: f64,
    /// Bearing after the alarm.
    pub bearing: BiasValue,
}

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GuardResult {
    /// The same estimate is used as before.
    Unchanged,
    /// The estimate is now held, or no longer held.
    Changed,
    /// An alarm was raised.
    Alarm,
}

/// Prevents the use of a registration that creeps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct CreepGuard {
    monitor: CreepMonitor,
    /// Estimates of the last minutes.
    estimates: VecDeque<(Time, Misalignment)>,
    /// Copies of the registration, the older one first.
    copies: VecDeque<(Time, Registration)>,
    /// Estimate used instead of the latest one.
    held: Option<Misalignment>,
    /// Index of the latest bin in which the registration was checked.
    checked: Option<i64>,
    /// Time of each host's first report.
    hosts: BTreeMap<Host, Time>,
    /// Hosts that are excluded from learning.
    excluded: BTreeSet<Host>,
    alarm: Option<Creep>,
}

impl CreepGuard {
    /// Adds a plot of an identity. Returns whether it may be learnt from.
    pub(crate) fn add(&mut self, of: (Host, Identity), turned: &AzimuthOffset) -> bool {
        if self.hosts.len() < HOSTS_MAX {
            self.hosts.entry(of.0).or_insert(turned.time);
        }
        self.monitor.add(of, turned)
    }

    /// Weight of a host's reports, 0 to 1. A host that first reported later than another active one gains weight with time. All
    /// its identities together count as one.
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

    /// Whether a host is excluded from learning.
    pub(crate) fn excludes(&self, host: Host) -> bool {
        self.excluded.contains(&host)
    }

    /// The latest alarm.
    pub(crate) fn alarm(&self) -> Option<Creep> {
        self.alarm
    }

    /// The estimate to use: this one, or an earlier one that is held.
    pub(crate) fn used(&self, estimate: Misalignment) -> Misalignment {
        self.held.unwrap_or(estimate)
    }

    /// Stores a restored registration as the one that remains after an alarm.
    pub(crate) fn restore(&mut self, registration: &Registration) {
        self.copies = [(Time::from_nanos(i64::MIN), registration.clone())].into();
        self.estimates = [(Time::from_nanos(i64::MIN), registration.estimate())].into();
    }

    /// Checks for rotating offsets, once per bin. An alarm undoes what was learnt since the window began.
    pub(crate) fn check(&mut self, registration: &mut Registration, now: Time) -> GuardResult {
        if self.checked.replace(bin(now)) == Some(bin(now)) {
            return GuardResult::Unchanged;
        }
        let before = self.held.is_some();
        let trends = self.monitor.trends(now);
        let most = |from_s: f64, change: f64| {
            let trends = trends.iter().filter(|trend| trend.window_s >= from_s && trend.change() >= change);
            trends.max_by(|one, other| one.deviations.total_cmp(&other.deviations)).copied()
        };
        if let Some(trend) = most(ALARM_S, ALARM_CHANGE).filter(|trend| trend.deviations >= ALARM) {
            self.raise(&trend, registration, now);
            return GuardResult::Alarm;
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
        if before == self.held.is_some() { GuardResult::Unchanged } else { GuardResult::Changed }
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

/// Beginning of the window of a trend.
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
        let turned = AzimuthOffset { time: at(seconds), begun: at(0), offset: 0.0, rate: 0.0 };
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
        assert_eq!(guard.check(&mut registration, at(2000)), GuardResult::Unchanged);
        hear(&mut guard, 2, 2, 2000);
        assert_eq!(guard.weight(Host(2), at(2000)), 1.0);
    }
}
