//! Alerts for operators: sensors that are not operational, tracks inside alert areas, conflicts between aircraft,
//! transponders that are suspect or silent, drones without a transponder, and faults of the service. Sans-IO: `replay
//! --alerts` raises the same alerts.

mod areas;
mod conflicts;
mod details;
mod json;
mod operators;
mod pictured;
mod rules;
mod situations;
mod wording;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::health::{SensorState, SensorStatus};
use super::registration::turned_camera;
use crate::current::Current;
use operators::{AlertDecisions, AlertInput};

use fusion::Identity;
use fusion::time::{SECOND, Time};

use areas::Approaches;
use situations::Situations;

pub use areas::PredictionPicture;
pub use details::{AlertDetails, AreaName};
pub use json::AlertJson;
pub use operators::{Acknowledgement, AlertAction, AlertRequest, AlertRequestError, Shelved};
pub use rules::{AlertSettings, UnknownArea};
pub use site::config::{AlertKind, Severity};

/// Time after the start in which a silent sensor raises no alert, in nanoseconds.
const SETTLE_NS: i64 = 5 * SECOND;
/// Maximum number of ended alerts kept.
const ENDED_KEPT: usize = 5_000;

/// One alert.
#[derive(Clone, Debug, PartialEq)]
pub struct Alert {
    /// Number of the alert, unique while the service runs.
    pub id: u64,
    /// Kind of the alert.
    pub kind: AlertKind,
    /// Severity.
    pub severity: Severity,
    /// Highest severity so far.
    pub worst: Severity,
    /// Start of the alert.
    pub since: Time,
    /// End of the alert; `None` while it is active.
    pub until: Option<Time>,
    /// Text of the alert.
    pub text: String,
    /// Identifies the alert within its kind: the id of the sensor or track, the ids of both tracks and the volume, the part
    /// of the service, or the serial number and country of the transponder.
    pub subject: String,
    /// Further data of the alert.
    pub details: AlertDetails,
    /// Whether the alert has ended, was critical, and waits for an operator's acknowledgement.
    pub is_latched: bool,
    /// Acknowledgement by an operator, until the severity exceeds all earlier ones.
    pub acknowledged: Option<Acknowledgement>,
    /// Suppresses notifications of the alert until it expires or is unshelved.
    pub shelved: Option<Shelved>,
    /// Number of changes since the alert began.
    pub revision: u32,
}

/// A fault of the service itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ServiceFault {
    /// Affected part of the service.
    pub about: Cow<'static, str>,
    /// Severity.
    pub severity: Severity,
    /// Text of the fault.
    pub text: String,
}

impl ServiceFault {
    /// The clock was set back, or contradicts all sensors.
    pub const CLOCK: &str = "clock";
    /// The picture is late.
    pub const PICTURE: &str = "picture";
    /// Datagrams from sensors were lost.
    pub const INPUT: &str = "input";
    /// Datagrams could not be sent.
    pub const OUTPUT: &str = "output";
    /// Conflicts were found too late to be shown.
    pub const CONFLICTS: &str = "conflicts";
    /// The recording is incomplete.
    pub const RECORDER: &str = "recorder";
    /// A file in `[state] dir` cannot be written.
    pub const STATE: &str = "state";
    /// A file in `[state] dir` was damaged.
    pub const DAMAGE: &str = "damage";
    /// Nodes or gateways of the cluster, or the log that connects them.
    pub const CLUSTER: &str = "cluster";
}

/// Change of an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlertChange {
    /// The alert is new.
    Began,
    /// Its severity has changed.
    Changed,
    /// Its data has changed, at the same severity.
    Amended,
    /// An operator has acknowledged it.
    Acknowledged,
    /// An operator has shelved it: its notifications are suppressed for some time.
    Shelved,
    /// The shelving has expired or was removed.
    Unshelved,
    /// The alert has ended.
    Ended,
}

/// Identifies an alert: its kind, its subject, and the area if it is about one.
type AlertKey = (AlertKind, String, String);

/// All active and recently ended alerts.
#[derive(Debug, Default)]
pub struct AlertMonitor {
    settings: Current<AlertSettings>,
    /// Tracks that are about to enter an area.
    approaches: Approaches,
    /// Time before which sensors raise no alert, except for contested senders.
    settled: Time,
    next_id: u64,
    /// Active alerts, with the last time at which the cause was present.
    lasting: BTreeMap<AlertKey, (Alert, Time)>,
    /// Text of each active alert for the time after its cause is gone, in the past tense.
    pasts: BTreeMap<AlertKey, String>,
    /// Last name of each transponder that was in a picture in the last ten minutes, with the time of the picture.
    names: BTreeMap<Identity, (String, Time)>,
    /// Situations of aircraft in conflict.
    situations: Situations,
    /// Ended alerts, the latest first.
    ended: VecDeque<Arc<Alert>>,
    /// Changes not taken yet, in order.
    changes: Vec<(AlertChange, Alert)>,
    /// Time of the last picture.
    pictured: Option<Time>,
    decisions: AlertDecisions,
}

impl AlertMonitor {
    /// Starts without alerts. `started` is the present time.
    pub fn new(settings: impl Into<Current<AlertSettings>>, started: Time) -> Self {
        let settled = Time::from_nanos(started.nanos() + SETTLE_NS);
        Self { settings: settings.into(), settled, next_id: 1, ..Self::default() }
    }

    /// All alerts: the active ones, then the ended ones, the latest first.
    pub fn all(&self) -> Vec<Arc<Alert>> {
        let lasting = self.lasting.values().map(|(alert, _)| Arc::new(alert.clone()));
        let mut lasting: Vec<Arc<Alert>> = lasting.collect();
        lasting.sort_by_key(|alert| std::cmp::Reverse((alert.severity, alert.since, alert.id)));
        lasting.extend(self.ended.iter().cloned());
        lasting
    }

    /// Changes since the last call, in order.
    pub fn take_changes(&mut self) -> Vec<(AlertChange, Alert)> {
        std::mem::take(&mut self.changes)
    }

    /// Updates the alerts about sensors. Returns whether any changed.
    pub fn note_sensors(&mut self, sensors: &[SensorStatus], now: Time) -> bool {
        self.derive(AlertInput::Status, now);
        let is_settled = now >= self.settled;
        let is_wrong = |sensor: &SensorStatus| sensor.state != SensorState::Operational;
        // A contested sender is reported at once, also right after the start.
        let is_due = |sensor: &&SensorStatus| {
            is_wrong(sensor) && !sensor.is_awaited() && (is_settled || !sensor.contested.is_empty())
        };
        let found = sensors.iter().filter(is_due);
        let found = found.map(|sensor| {
            let is_out = sensor.state == SensorState::Outage;
            let severity = if is_out { Severity::Critical } else { Severity::Warning };
            let text = format!("{} {}: {}", sensor.id, sensor.state.name(), sensor.reasons.join("; "));
            AlertCause { past: text.clone(), ..AlertCause::new(&sensor.id, severity, text) }
        });
        let works = |subject: &str, _| !sensors.iter().any(|sensor| sensor.id == subject && is_wrong(sensor));
        self.hold(AlertKind::Sensor, found.collect(), now, works)
    }

    /// Updates the alerts about the radars' registration and the cameras' orientation. Returns whether any changed.
    pub fn note_registration(&mut self, sensors: &[SensorStatus], now: Time) -> bool {
        self.derive(AlertInput::Status, now);
        let found = sensors.iter().filter_map(|sensor| {
            let registered = sensor.registration.as_ref().and_then(|registration| registration.alarm.clone());
            let alarm = registered.or_else(|| turned_camera(sensor.orientation.as_ref()?, now))?;
            let text = format!("{}: {alarm}", sensor.id);
            Some(AlertCause { past: text.clone(), ..AlertCause::new(&sensor.id, Severity::Warning, text) })
        });
        self.hold(AlertKind::Registration, found.collect(), now, |_, _| true)
    }

    /// Updates the alerts about the service. Returns whether any changed.
    pub fn note_troubles<'a>(&mut self, troubles: impl Iterator<Item = &'a ServiceFault>, now: Time) -> bool {
        self.derive(AlertInput::Status, now);
        let found = troubles.map(|trouble| AlertCause {
            past: trouble.text.clone(),
            ..AlertCause::new(&trouble.about, trouble.severity, trouble.text.clone())
        });
        self.hold(AlertKind::Service, found.collect(), now, |_, _| true)
    }

    /// Raises the alerts that are new and admitted by the rules, and refreshes those that are still found. Ends an alert
    /// that was not found once its hold time has passed and `is_over`, given the subject and the last time found, returns
    /// `true`. Returns whether any alert changed.
    fn hold(
        &mut self,
        kind: AlertKind,
        found: Vec<AlertCause>,
        now: Time,
        is_over: impl Fn(&str, Time) -> bool,
    ) -> bool {
        let settings = self.settings.get();
        let before = self.changes.len();
        self.unshelve(kind, now);
        let mut is_renewed = false;
        let mut current = BTreeSet::new();
        for AlertCause { subject, area, severity, text, past, details, .. } in
            found.into_iter().filter(|found| settings.admits(kind, found))
        {
            let severity = settings.severity(kind, severity);
            let key = (kind, subject, area);
            current.insert(key.clone());
            if let Some((alert, held)) = self.lasting.get_mut(&key) {
                *held = now;
                // An ended alert states the worst that was; that of a conflict is its closest approach.
                if !past.is_empty() && (severity >= alert.worst || kind == AlertKind::Conflict) {
                    self.pasts.insert(key.clone(), past);
                }
                let revision = alert.revision;
                is_renewed |= alert.details != details;
                let change = alert.renew(severity, text, details);
                is_renewed |= alert.revision != revision;
                let news = change.map(|change| (change, alert.clone()));
                let is_critical = alert.severity == Severity::Critical;
                if news.is_some() && is_critical {
                    self.unlatch(&key, None);
                }
                self.changes.extend(news);
                continue;
            }
            if !past.is_empty() {
                self.pasts.insert(key.clone(), past);
            }
            let (id, subject) = (self.next_id, key.1.clone());
            let alert = Alert {
                id,
                kind,
                severity,
                worst: severity,
                since: now,
                until: None,
                text,
                subject,
                details,
                is_latched: false,
                acknowledged: None,
                shelved: self.decisions.shelf(&key),
                revision: 0,
            };
            self.next_id += 1;
            if severity == Severity::Critical {
                self.unlatch(&key, None);
            }
            self.changes.push((AlertChange::Began, alert.clone()));
            self.lasting.insert(key, (alert, now));
        }
        let hold_ns = settings.hold_ns(kind);
        // Without a hold time the alert ends even if the clock has not advanced.
        let is_gone = |held: Time| hold_ns == 0 || now.nanos().abs_diff(held.nanos()) > hold_ns;
        self.end(kind, now, |key, held| !current.contains(key) && is_gone(held) && is_over(&key.1, held));
        is_renewed |= self.put_in_the_past(kind, |key, held| !current.contains(key) && is_over(&key.1, held));
        is_renewed || self.changes.len() > before
    }

    /// Words the alerts that are only held: their cause is gone. Returns whether any text changed.
    fn put_in_the_past(&mut self, kind: AlertKind, is_gone: impl Fn(&AlertKey, Time) -> bool) -> bool {
        let mut has_changed = false;
        let Self { lasting, pasts, .. } = self;
        for (key, (alert, held)) in
            lasting.iter_mut().filter(|(key, (_, held))| key.0 == kind && is_gone(key, *held))
        {
            let Some(past) = pasts.get(key) else { continue };
            let text = format!("{past}, last at {}", wording::at(*held));
            if alert.text != text {
                alert.text = text;
                alert.revision += 1;
                has_changed = true;
            }
        }
        has_changed
    }

    /// Removes the latch of the ended alerts with this key: an operator has acknowledged them, or an alert with this key is
    /// critical again. Returns the latest of them.
    fn unlatch(&mut self, key: &AlertKey, seen: Option<&Acknowledgement>) -> Option<Alert> {
        let mut latest = None;
        let (kind, subject, _) = key;
        for alert in self.ended.iter_mut().filter(|alert| alert.is_latched && alert.kind == *kind) {
            if alert.subject != *subject || alert.details.area() != key.2 {
                continue;
            }
            let alert = Arc::make_mut(alert);
            alert.is_latched = false;
            alert.acknowledged = seen.cloned();
            alert.revision += 1;
            latest.get_or_insert_with(|| alert.clone());
        }
        latest
    }

    /// Ends the alert of a situation that became part of another: that one continues it.
    fn absorb(&mut self, (part, whole): (&AlertKey, &AlertKey), now: Time) {
        let Some((alert, _)) = self.lasting.remove(part) else { return };
        self.pasts.remove(part);
        let into = self.lasting.get_mut(whole).map(|(into, _)| {
            if alert.is_awaiting_operator() {
                into.acknowledged = None;
            }
            into.worst = into.worst.max(alert.worst);
            into.name()
        });
        let text = match into {
            Some(into) => format!("part of {into} since {}", wording::at(now)),
            None => alert.text,
        };
        let alert = Alert { until: Some(now), text, ..alert };
        self.changes.push((AlertChange::Ended, alert.clone()));
        self.ended.push_front(Arc::new(alert));
    }

    /// Ends the alerts of a kind for which `is_over`, given the key and the last time found, returns `true`.
    fn end(&mut self, kind: AlertKind, now: Time, is_over: impl Fn(&AlertKey, Time) -> bool) {
        let Self { lasting, changes, ended, pasts, .. } = self;
        lasting.retain(|key, (alert, held)| {
            let lasts = key.0 != kind || !is_over(key, *held);
            if !lasts {
                let past = pasts.remove(key);
                let is_latched = alert.is_awaiting_operator();
                let text = match past {
                    Some(past) => format!("{past}; over since {}", wording::at(*held)),
                    None => alert.text.clone(),
                };
                let alert = Alert { until: Some(now), text, is_latched, ..alert.clone() };
                changes.push((AlertChange::Ended, alert.clone()));
                ended.push_front(Arc::new(alert));
            }
            lasts
        });
        self.ended.truncate(ENDED_KEPT);
    }
}

impl Alert {
    /// Id of the alert in the API.
    pub fn name(&self) -> String {
        format!("{}-{}", self.kind.name(), self.id)
    }

    /// Whether it was critical, and no operator has acknowledged or shelved it.
    fn is_awaiting_operator(&self) -> bool {
        self.worst == Severity::Critical && self.acknowledged.is_none() && self.shelved.is_none()
    }

    /// Updates severity, text and data. Returns the change if it is worth reporting.
    fn renew(&mut self, severity: Severity, text: String, details: AlertDetails) -> Option<AlertChange> {
        // An acknowledgement does not cover a higher severity, nor further aircraft in danger. It covers a severity that comes
        // and goes.
        let is_covered = severity <= self.worst && !self.details.is_wider(&details);
        self.acknowledged.take_if(|_| !is_covered);
        self.worst = self.worst.max(severity);
        let change = if self.severity != severity {
            Some(AlertChange::Changed)
        } else {
            self.details.are_news_to(&details).then_some(AlertChange::Amended)
        };
        // Distances and times in a text are those of the last second.
        let is_reworded =
            matches!(self.kind, AlertKind::Conflict | AlertKind::AreaPredicted) && self.text != text;
        (self.severity, self.text, self.details) = (severity, text, details);
        self.revision += u32::from(change.is_some() || is_reworded);
        change
    }
}

/// Cause of an alert.
struct AlertCause {
    subject: String,
    /// Name of the alert area; empty if the alert is not about an area.
    area: String,
    severity: Severity,
    text: String,
    /// The text once the cause is gone, without a time; empty: the text stays as it is.
    past: String,
    details: AlertDetails,
    /// Transponders of the aircraft concerned, which a rule may exempt; `None` for an aircraft without one.
    transponders: Vec<Option<Identity>>,
    /// Positions concerned: longitude and latitude, in degrees.
    places: Vec<(f64, f64)>,
}

impl AlertCause {
    fn new(subject: &str, severity: Severity, text: String) -> Self {
        let (subject, area) = (subject.to_owned(), String::new());
        let (details, transponders, places) = (AlertDetails::None, Vec::new(), Vec::new());
        Self { subject, area, severity, text, past: String::new(), details, transponders, places }
    }
}

#[cfg(test)]
mod tests;
