//! What an operator should look at: sensors that are not operational, tracks inside alert areas, aircraft that come near
//! each other, transponders that lie or fall silent, drones without one, and what is wrong with the service itself. Sans-IO: `replay --alerts` raises the same.

mod conflicts;
mod details;
mod json;
mod pictured;
mod wording;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::health::{SensorState, SensorStatus};
use crate::areas::AlertAreas;
use crate::current::Current;
use fusion::time::{SECOND, Time};

pub use details::Details;
pub use json::AlertJson;

/// Time from the start until a sensor is to be heard, nanoseconds.
const SETTLE_NS: i64 = 5 * SECOND;
/// Most ended alerts that are still shown.
const ENDED_KEPT: usize = 100;

/// What an alert is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AlertKind {
    /// A sensor is not operational.
    Sensor,
    /// A track is inside an alert area.
    Area,
    /// Something is wrong with the service itself.
    Service,
    /// The alignment of a radar seems to have changed.
    Registration,
    /// A transponder may not be where it says it is, or whose.
    Integrity,
    /// Many transponders fell silent at once.
    Jamming,
    /// A transponder fell silent, and a radar still sees the aircraft.
    Silent,
    /// A drone flies without a transponder where one is to be heard.
    Uncooperative,
    /// Two aircraft come near each other.
    Conflict,
}

impl AlertKind {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Sensor,
        Self::Area,
        Self::Service,
        Self::Registration,
        Self::Integrity,
        Self::Jamming,
        Self::Silent,
        Self::Uncooperative,
        Self::Conflict,
    ];

    /// Its name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sensor => "sensor",
            Self::Area => "area",
            Self::Service => "service",
            Self::Registration => "registration",
            Self::Integrity => "integrity",
            Self::Jamming => "jamming",
            Self::Silent => "silent",
            Self::Uncooperative => "uncooperative",
            Self::Conflict => "conflict",
        }
    }
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// To look at.
    Warning,
    /// To act on.
    Critical,
}

impl Severity {
    /// Its name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Warning => "warning",
            Self::Critical => "critical",
        }
    }
}

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
    /// The sensor's, the track's or the conflict's id, the part of the service, or the serial number of the transponder.
    pub subject: String,
    /// What else is known of it.
    pub details: Details,
    /// How often it has changed since it began.
    pub revision: u32,
}

/// Something that is wrong with the service itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trouble {
    /// Which part of it.
    pub about: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in words.
    pub text: String,
}

impl Trouble {
    /// The clock was set back.
    pub const CLOCK: &str = "clock";
    /// The picture is late.
    pub const PICTURE: &str = "picture";
    /// Datagrams of sensors were lost.
    pub const INPUT: &str = "input";
    /// Datagrams could not be sent.
    pub const OUTPUT: &str = "output";
    /// Something is missing in the recording.
    pub const RECORDER: &str = "recorder";
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
    /// It is over.
    Ended,
}

/// Keeps the alerts.
#[derive(Debug, Default)]
pub struct Alerts {
    areas: Current<AlertAreas>,
    /// Before this time sensors are not looked at, but for rival senders.
    settled: Time,
    next_id: u64,
    /// Those that last, by kind, subject and area; with the last time that they held.
    lasting: BTreeMap<(AlertKind, String, String), (Alert, Time)>,
    /// The latest first.
    ended: VecDeque<Alert>,
    /// Changes that were not taken yet, in their order.
    changes: Vec<(Change, Alert)>,
    /// The time of the last picture.
    pictured: Option<Time>,
}

impl Alerts {
    /// No alerts yet; a track inside one of `areas` raises one. `started` is now.
    pub fn new(areas: impl Into<Current<AlertAreas>>, started: Time) -> Self {
        let settled = Time::from_nanos(started.nanos() + SETTLE_NS);
        Self { areas: areas.into(), settled, next_id: 1, ..Self::default() }
    }

    /// Those that last, then those that ended, the latest first.
    pub fn all(&self) -> Vec<Alert> {
        let mut lasting: Vec<Alert> = self.lasting.values().map(|(alert, _)| alert.clone()).collect();
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
        let found = sensors.iter().filter_map(|sensor| {
            let alarm = sensor.registration.as_ref()?.alarm.as_ref()?;
            Some(Found::new(&sensor.id, Severity::Warning, format!("{}: {alarm}", sensor.id)))
        });
        self.hold(AlertKind::Registration, found.collect(), now, |_, _| true)
    }

    /// Looks at what is wrong with the service; whether anything changed.
    pub fn note_troubles<'a>(&mut self, troubles: impl Iterator<Item = &'a Trouble>, now: Time) -> bool {
        let found = troubles.map(|trouble| Found::new(trouble.about, trouble.severity, trouble.text.clone()));
        self.hold(AlertKind::Service, found.collect(), now, |_, _| true)
    }

    /// Begins the alerts that are new, notes those that last, and ends those that were not found and are over by their
    /// subject and the last time that they held; whether there is anything new to show.
    fn hold(
        &mut self,
        kind: AlertKind,
        found: Vec<Found>,
        now: Time,
        is_over: impl Fn(&str, Time) -> bool,
    ) -> bool {
        let before = self.changes.len();
        let mut is_renewed = false;
        let mut current = BTreeSet::new();
        for Found { subject, area, severity, text, details } in found {
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
            let alert =
                Alert { id, kind, severity, since: now, until: None, text, subject, details, revision: 0 };
            self.next_id += 1;
            self.changes.push((Change::Began, alert.clone()));
            self.lasting.insert(key, (alert, now));
        }
        let Self { lasting, changes, ended, .. } = self;
        lasting.retain(|key, (alert, held)| {
            let lasts = key.0 != kind || current.contains(key) || !is_over(&key.1, *held);
            if !lasts {
                let alert = Alert { until: Some(now), ..alert.clone() };
                changes.push((Change::Ended, alert.clone()));
                ended.push_front(alert);
            }
            lasts
        });
        self.ended.truncate(ENDED_KEPT);
        is_renewed || self.changes.len() > before
    }
}

impl Alert {
    /// Takes over what is known now, and whether that is worth a word.
    fn renew(&mut self, severity: Severity, text: String, details: Details) -> Option<Change> {
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
}

impl Found {
    fn new(subject: &str, severity: Severity, text: String) -> Self {
        Self { subject: subject.to_owned(), area: String::new(), severity, text, details: Details::None }
    }
}

#[cfg(test)]
mod tests;
