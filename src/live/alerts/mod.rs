//! What an operator should look at: sensors that are not operational, tracks inside alert areas, aircraft that come near
//! each other, transponders that lie or fall silent, drones without one, and what is wrong with the service itself. Sans-IO:
//! `replay --alerts` raises the same.

mod areas;
mod conflicts;
mod details;
mod json;
mod operators;
mod pictured;
mod rules;
mod wording;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::health::{SensorState, SensorStatus};
use crate::current::Current;
use operators::{Basis, Operators};

use fusion::Identity;
use fusion::time::{SECOND, Time};

use areas::Approaches;

pub use crate::config::{AlertKind, Severity};
pub use areas::Ahead;
pub use details::{AreaName, Details};
pub use json::AlertJson;
pub use operators::{Acknowledged, AlertWish, NotDone, Shelved, Wanted};
pub use rules::{AlertSettings, UnknownArea};

/// Time from the start until a sensor is to be heard, nanoseconds.
const SETTLE_NS: i64 = 5 * SECOND;
/// Most ended alerts that are remembered.
const ENDED_KEPT: usize = 5_000;

/// One alert.
#[derive(Clone, Debug, PartialEq)]
pub struct Alert {
    /// Unique while the service runs.
    pub id: u64,
    /// What it is about.
    pub kind: AlertKind,
    /// How bad it is.
    pub severity: Severity,
    /// When it began.
    pub since: Time,
    /// When it ended; `None`: it lasts.
    pub until: Option<Time>,
    /// What is wrong, in words.
    pub text: String,
    /// What tells it from others of its kind: the sensor's or the track's id, the ids of both tracks and the volume, the part
    /// of the service, or the serial number and country of the transponder.
    pub subject: String,
    /// What else is known of it.
    pub details: Details,
    /// Who has seen it, as bad as it is.
    pub acknowledged: Option<Acknowledged>,
    /// Nobody is to be bothered with it.
    pub shelved: Option<Shelved>,
    /// How often it has changed since it began.
    pub revision: u32,
}

/// Something that is wrong with the service itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trouble {
    /// Which part of it.
    pub about: Cow<'static, str>,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in words.
    pub text: String,
}

impl Trouble {
    /// The clock was set back, or contradicts all sensors.
    pub const CLOCK: &str = "clock";
    /// The picture is late.
    pub const PICTURE: &str = "picture";
    /// Datagrams of sensors were lost.
    pub const INPUT: &str = "input";
    /// Datagrams could not be sent.
    pub const OUTPUT: &str = "output";
    /// Conflicts were found too late to be shown.
    pub const CONFLICTS: &str = "conflicts";
    /// Something is missing in the recording.
    pub const RECORDER: &str = "recorder";
    /// A file of `[state] dir` cannot be written.
    pub const STATE: &str = "state";
    /// A file of `[state] dir` was damaged.
    pub const DAMAGE: &str = "damage";
    /// Those of a cluster who make the picture, or the log between them.
    pub const CLUSTER: &str = "cluster";
}

/// What has become of an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It is new.
    Began,
    /// It is worse than it was, or less bad.
    Changed,
    /// It is as bad as it was, and something else is known of it.
    Amended,
    /// Somebody has seen it.
    Acknowledged,
    /// Nobody is to be bothered with it for a while.
    Shelved,
    /// That while is over.
    Unshelved,
    /// It is over.
    Ended,
}

/// What tells alerts from each other: kind, subject, and area where it is about one.
type Key = (AlertKind, String, String);

/// Keeps the alerts.
#[derive(Debug, Default)]
pub struct Alerts {
    settings: Current<AlertSettings>,
    /// Tracks that are about to enter an area.
    approaches: Approaches,
    /// Before this time sensors are not looked at, but for rival senders.
    settled: Time,
    next_id: u64,
    /// Those that last, with the last time that they held.
    lasting: BTreeMap<Key, (Alert, Time)>,
    /// The latest first.
    ended: VecDeque<Arc<Alert>>,
    /// Changes that were not taken yet, in their order.
    changes: Vec<(Change, Alert)>,
    /// The time of the last picture.
    pictured: Option<Time>,
    operators: Operators,
}

impl Alerts {
    /// No alerts yet. `started` is now.
    pub fn new(settings: impl Into<Current<AlertSettings>>, started: Time) -> Self {
        let settled = Time::from_nanos(started.nanos() + SETTLE_NS);
        Self { settings: settings.into(), settled, next_id: 1, ..Self::default() }
    }

    /// Those that last, then those that ended, the latest first.
    pub fn all(&self) -> Vec<Arc<Alert>> {
        let lasting = self.lasting.values().map(|(alert, _)| Arc::new(alert.clone()));
        let mut lasting: Vec<Arc<Alert>> = lasting.collect();
        lasting.sort_by_key(|alert| std::cmp::Reverse((alert.severity, alert.since, alert.id)));
        lasting.extend(self.ended.iter().cloned());
        lasting
    }

    /// The changes since the last call, in their order; several at once are one each.
    pub fn take_changes(&mut self) -> Vec<(Change, Alert)> {
        std::mem::take(&mut self.changes)
    }

    /// Looks at the sensors; whether anything changed.
    pub fn note_sensors(&mut self, sensors: &[SensorStatus], now: Time) -> bool {
        self.derive(Basis::Status, now);
        let is_settled = now >= self.settled;
        let is_wrong = |sensor: &SensorStatus| sensor.state != SensorState::Operational;
        // What two senders say needs no time to settle.
        let found = sensors.iter().filter(|one| is_wrong(one) && (is_settled || !one.contested.is_empty()));
        let found = found.map(|sensor| {
            let is_out = sensor.state == SensorState::Outage;
            let severity = if is_out { Severity::Critical } else { Severity::Warning };
            let text = format!("{} {}: {}", sensor.id, sensor.state.name(), sensor.reasons.join("; "));
            Found::new(&sensor.id, severity, text)
        });
        let works = |subject: &str, _| !sensors.iter().any(|sensor| sensor.id == subject && is_wrong(sensor));
        self.hold(AlertKind::Sensor, found.collect(), now, works)
    }

    /// Looks at the radars' alignment; whether anything changed.
    pub fn note_registration(&mut self, sensors: &[SensorStatus], now: Time) -> bool {
        self.derive(Basis::Status, now);
        let found = sensors.iter().filter_map(|sensor| {
            let alarm = sensor.registration.as_ref()?.alarm.as_ref()?;
            Some(Found::new(&sensor.id, Severity::Warning, format!("{}: {alarm}", sensor.id)))
        });
        self.hold(AlertKind::Registration, found.collect(), now, |_, _| true)
    }

    /// Looks at what is wrong with the service; whether anything changed.
    pub fn note_troubles<'a>(&mut self, troubles: impl Iterator<Item = &'a Trouble>, now: Time) -> bool {
        self.derive(Basis::Status, now);
        let found =
            troubles.map(|trouble| Found::new(&trouble.about, trouble.severity, trouble.text.clone()));
        self.hold(AlertKind::Service, found.collect(), now, |_, _| true)
    }

    /// Begins the alerts that are new and that the rules admit, notes those that last, and ends those that were not found and
    /// are over by their subject and the last time that they held, for longer than they are held; whether there is anything
    /// new to show.
    fn hold(
        &mut self,
        kind: AlertKind,
        found: Vec<Found>,
        now: Time,
        is_over: impl Fn(&str, Time) -> bool,
    ) -> bool {
        let settings = self.settings.get();
        let before = self.changes.len();
        self.unshelve(kind, now);
        let mut is_renewed = false;
        let mut current = BTreeSet::new();
        for Found { subject, area, severity, text, details, .. } in
            found.into_iter().filter(|found| settings.admits(kind, found))
        {
            let severity = settings.severity(kind, severity);
            let key = (kind, subject, area);
            current.insert(key.clone());
            if let Some((alert, held)) = self.lasting.get_mut(&key) {
                *held = now;
                is_renewed |= alert.details != details;
                if let Some(change) = alert.renew(severity, text, details) {
                    self.changes.push((change, alert.clone()));
                }
                continue;
            }
            let (id, subject) = (self.next_id, key.1.clone());
            let alert = Alert {
                id,
                kind,
                severity,
                since: now,
                until: None,
                text,
                subject,
                details,
                acknowledged: None,
                shelved: self.operators.shelf(&key),
                revision: 0,
            };
            self.next_id += 1;
            self.changes.push((Change::Began, alert.clone()));
            self.lasting.insert(key, (alert, now));
        }
        let hold_ns = settings.hold_ns(kind);
        // Without a hold also where the clock has not moved.
        let is_gone = |held: Time| hold_ns == 0 || now.nanos().abs_diff(held.nanos()) > hold_ns;
        self.end(kind, now, |key, held| !current.contains(key) && is_gone(held) && is_over(&key.1, held));
        is_renewed || self.changes.len() > before
    }

    /// Ends the alerts of a kind that are over, by what they are about and the last time that they held.
    fn end(&mut self, kind: AlertKind, now: Time, is_over: impl Fn(&Key, Time) -> bool) {
        let Self { lasting, changes, ended, .. } = self;
        lasting.retain(|key, (alert, held)| {
            let lasts = key.0 != kind || !is_over(key, *held);
            if !lasts {
                let alert = Alert { until: Some(now), ..alert.clone() };
                changes.push((Change::Ended, alert.clone()));
                ended.push_front(Arc::new(alert));
            }
            lasts
        });
        self.ended.truncate(ENDED_KEPT);
    }
}

impl Alert {
    /// Its id as readers know it.
    pub fn name(&self) -> String {
        format!("{}-{}", self.kind.name(), self.id)
    }

    /// Takes over what is known now, and whether that is worth a word.
    fn renew(&mut self, severity: Severity, text: String, details: Details) -> Option<Change> {
        // Who has seen it has not seen it as bad as this.
        self.acknowledged.take_if(|_| severity > self.severity);
        let change = if self.severity != severity {
            Some(Change::Changed)
        } else {
            self.details.are_news_to(&details).then_some(Change::Amended)
        };
        (self.severity, self.text, self.details) = (severity, text, details);
        self.revision += u32::from(change.is_some());
        change
    }
}

/// What an alert is raised for.
struct Found {
    subject: String,
    /// The alert area; empty where it is about none.
    area: String,
    severity: Severity,
    text: String,
    details: Details,
    /// Of the aircraft that it is about, which a rule may allow; `None`: one without a transponder.
    transponders: Vec<Option<Identity>>,
    /// Where it is, longitude and latitude in degrees.
    places: Vec<(f64, f64)>,
}

impl Found {
    fn new(subject: &str, severity: Severity, text: String) -> Self {
        let (subject, area) = (subject.to_owned(), String::new());
        let (details, transponders, places) = (Details::None, Vec::new(), Vec::new());
        Self { subject, area, severity, text, details, transponders, places }
    }
}

#[cfg(test)]
mod tests;
