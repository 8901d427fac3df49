//! What an operator should look at: sensors that are not operational, tracks inside alert areas, and what is wrong with the
//! service itself. Sans-IO.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::health::{SensorState, SensorStatus};
use crate::areas::AlertAreas;
use crate::current::Current;
use crate::picture::{MAX_ACCURACY_M, Picture, PictureMaker, PictureTrack};
use fusion::time::{SECOND, Time};

/// A track has left an area when it was not seen inside for this long, nanoseconds: it may flicker at the edge, or be
/// missed by the radar.
const LEFT_NS: u64 = 3 * SECOND as u64;
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
}

impl AlertKind {
    /// Its name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sensor => "sensor",
            Self::Area => "area",
            Self::Service => "service",
            Self::Registration => "registration",
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
#[derive(Clone, Debug, PartialEq, Eq)]
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
    /// The sensor's or the track's id, or the part of the service.
    pub subject: String,
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

    /// Looks at a slot's tracks; whether anything changed.
    pub fn note_picture(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let (now, areas) = (picture.time, self.areas.get());
        // A replay went back: what was wrong later is not wrong yet.
        let went_back = self.pictured.replace(now).is_some_and(|before| now < before);
        if went_back {
            self.lasting.clear();
            self.ended.clear();
            self.changes.clear();
        }
        let mut found = Vec::new();
        for track in picture.within(MAX_ACCURACY_M) {
            let place = &track.position;
            for area in areas.around(place.longitude_deg(), place.latitude_deg()) {
                let id = maker.track_id(track);
                let text = format!("{} is inside {area}", described(track, &id));
                let (area, severity) = (area.to_owned(), Severity::Warning);
                found.push(Found { area, ..Found::new(&id, severity, text) });
            }
        }
        let has_left = |_: &str, held: Time| now.nanos().abs_diff(held.nanos()) > LEFT_NS;
        went_back | self.hold(AlertKind::Area, found, now, has_left)
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
    /// subject and the last time that they held; whether one began, ended, or got better or worse.
    fn hold(
        &mut self,
        kind: AlertKind,
        found: Vec<Found>,
        now: Time,
        is_over: impl Fn(&str, Time) -> bool,
    ) -> bool {
        let before = self.changes.len();
        let mut current = BTreeSet::new();
        for Found { subject, area, severity, text } in found {
            let key = (kind, subject, area);
            current.insert(key.clone());
            if let Some((alert, held)) = self.lasting.get_mut(&key) {
                let changed = alert.severity != severity;
                (alert.severity, alert.text, *held) = (severity, text, now);
                if changed {
                    self.changes.push((Change::Changed, alert.clone()));
                }
                continue;
            }
            let (id, subject) = (self.next_id, key.1.clone());
            let alert = Alert { id, kind, severity, since: now, until: None, text, subject };
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
        self.changes.len() > before
    }
}

/// What an alert is raised for.
struct Found {
    subject: String,
    /// The alert area; empty where it is about none.
    area: String,
    severity: Severity,
    text: String,
}

impl Found {
    fn new(subject: &str, severity: Severity, text: String) -> Self {
        Self { subject: subject.to_owned(), area: String::new(), severity, text }
    }
}

/// `fused track 60000 (U-60000), serial 1596F3A2`: what is on the screen, and what its owner can be asked about.
fn described(track: &PictureTrack, id: &str) -> String {
    let serial = track
        .point
        .source
        .transponder()
        .map(|part| format!(", serial {}", part.identity.serial().escape_ascii()));
    format!("{} track {} ({id}){}", track.source_name(), track.point.number, serial.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor(state: SensorState, reason: &str) -> SensorStatus {
        SensorStatus {
            id: "north".to_owned(),
            state,
            reasons: vec![reason.to_owned()],
            last_seen: None,
            accepted: 0,
            rate_hz: 0.0,
            clock_offset_s: None,
            refused: BTreeMap::new(),
            contested: Vec::new(),
            registration: None,
            types: Vec::new(),
            lines: Vec::new(),
        }
    }

    #[test]
    fn a_replay_that_goes_back_knows_no_later_alerts() {
        let site = include_str!("../../testdata/demo/site.toml");
        let config = crate::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        let pipeline = crate::pipeline::Pipeline::new(&config, crate::areas::Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        let at = |second: i64| Time::from_nanos(second * SECOND);
        let picture =
            |second| Picture { slot: fusion::slots::Slot(4 * second), time: at(second), tracks: vec![], concerns: vec![] };
        let mut alerts = Alerts::new(AlertAreas::default(), at(-10));
        assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(20)));
        assert!(!alerts.note_picture(&picture(20), &maker) && !alerts.note_picture(&picture(21), &maker));
        assert_eq!(alerts.all().len(), 1);
        assert!(alerts.note_picture(&picture(5), &maker));
        assert_eq!(alerts.all(), []);
        assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(7)), "anew");
    }

    #[test]
    fn a_sensor_that_fails_and_comes_back_is_one_alert() {
        let at = |second: i64| Time::from_nanos(second * SECOND);
        let mut alerts = Alerts::new(AlertAreas::default(), at(-10));
        assert!(!alerts.note_sensors(&[sensor(SensorState::Outage, "not heard yet")], at(-6)));
        assert!(!alerts.note_sensors(&[sensor(SensorState::Operational, "")], at(1)));
        assert!(alerts.note_sensors(&[sensor(SensorState::Degraded, "late")], at(2)));
        assert!(
            !alerts.note_sensors(&[sensor(SensorState::Degraded, "later")], at(3)),
            "the same, in other words"
        );
        assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(4)), "worse");
        let told = alerts.all();
        assert_eq!((told.len(), told[0].severity, told[0].since), (1, Severity::Critical, at(2)));
        assert_eq!(told[0].text, "north outage: silent");
        assert!(alerts.note_sensors(&[sensor(SensorState::Operational, "")], at(5)));
        assert_eq!(alerts.all()[0].until, Some(at(5)));
        assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(6)));
        assert_eq!(alerts.all().iter().map(|alert| alert.id).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn each_of_two_that_begin_or_end_at_once_is_a_change() {
        let at = |second: i64| Time::from_nanos(second * SECOND);
        let mut alerts = Alerts::new(AlertAreas::default(), at(-10));
        let south = |state| SensorStatus { id: "south".to_owned(), ..sensor(state, "silent") };
        let both = |state| [sensor(state, "silent"), south(state)];
        let mut changes = |state, second| {
            alerts.note_sensors(&both(state), at(second));
            let changes = alerts.take_changes();
            changes.into_iter().map(|(change, alert)| (change, alert.subject)).collect::<Vec<_>>()
        };
        for (state, second, change) in [
            (SensorState::Degraded, 1, Change::Began),
            (SensorState::Outage, 2, Change::Changed),
            (SensorState::Operational, 3, Change::Ended),
        ] {
            let told = ["north", "south"].map(|id| (change, id.to_owned()));
            assert_eq!(changes(state, second), told);
            assert_eq!(changes(state, second), [], "told once");
        }
    }

    #[test]
    fn trouble_of_the_service_is_an_alert_for_as_long_as_it_lasts() {
        let at = |second: i64| Time::from_nanos(second * SECOND);
        let mut alerts = Alerts::new(AlertAreas::default(), at(0));
        let full = Trouble { about: "recorder", severity: Severity::Warning, text: "full".to_owned() };
        assert!(!alerts.note_troubles(std::iter::empty(), at(1)));
        assert!(alerts.note_troubles([&full].into_iter(), at(2)));
        assert!(!alerts.note_troubles([&full].into_iter(), at(3)));
        let [alert] = &alerts.all()[..] else { panic!("{:?}", alerts.all()) };
        assert_eq!((alert.kind.name(), alert.subject.as_str(), alert.since), ("service", "recorder", at(2)));
        // Its end is reported also where the clock has stepped back.
        assert!(alerts.note_troubles(std::iter::empty(), at(-3600)));
        let (change, over) = alerts.take_changes().pop().unwrap();
        assert_eq!((change, over.until), (Change::Ended, Some(at(-3600))));
    }
}
