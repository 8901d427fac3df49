//! The one task that turns what the hub shows into the events of the stream, once for all readers.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::broadcast;
use tokio::sync::broadcast::error::{RecvError, TryRecvError};
use tokio::time::{Instant, MissedTickBehavior};

use super::endings::Endings;
use super::events::{self, Closed, Heartbeat, event};
use super::integrity::IdentityJson;
use super::log::Event;
use super::shown::Shown;
use super::sites::SensorProperties;
use super::state::ApiState;
use crate::conflicts::{ConflictJson, Outlook};
use crate::json::rounded;
use crate::live::{Alert, AlertJson, Integrities, Lateness, PublishedPicture, SensorState, Status};
use fusion::Identity;
use fusion::integrity::{State, Trust};

/// A heartbeat each second.
const HEARTBEAT: Duration = Duration::from_secs(1);

pub(super) struct Keeper {
    state: ApiState,
    frames: broadcast::Receiver<Arc<PublishedPicture>>,
    endings: Endings,
    /// Whether readers know the picture as late.
    told_late: bool,
    sensors: BTreeMap<String, SensorState>,
    /// State of each transponder as published, and what an operator says of it.
    integrity: BTreeMap<Identity, (State, Option<Trust>)>,
    /// Revision of each alert that lasts, as published, and the last one that ended.
    alerts: BTreeMap<u64, u32>,
    ended: Option<Arc<Alert>>,
}

impl Keeper {
    pub(super) fn new(state: ApiState) -> Self {
        // Subscribed before the latest one is looked at: none is missed in between, at most one comes twice.
        let frames = state.hub.pictures();
        let mut keeper = Self {
            state,
            frames,
            endings: Endings::default(),
            told_late: false,
            sensors: BTreeMap::new(),
            integrity: BTreeMap::new(),
            alerts: BTreeMap::new(),
            ended: None,
        };
        if let Some(frame) = keeper.state.hub.latest() {
            keeper.show(&frame);
        }
        keeper
    }

    /// Runs until the service closes; then shows what has been published, and ends the streams.
    pub(super) async fn run(mut self) {
        let mut statuses = self.state.hub.statuses();
        let mut alerts = self.state.hub.alert_changes();
        let mut integrity = self.state.hub.integrity.changes();
        let mut outlooks = self.state.hub.outlooks.all();
        let mut judged = true;
        if let Some(status) = self.state.hub.status() {
            self.tell(&status);
        }
        let mut heartbeat = tokio::time::interval_at(Instant::now() + HEARTBEAT, HEARTBEAT);
        heartbeat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut told = true;
        loop {
            tokio::select! {
                () = self.state.closed() => break,
                frame = self.frames.recv() => match frame {
                    Ok(frame) => self.show(&frame),
                    Err(RecvError::Lagged(_)) => self.state.log.push(Event::Lost),
                    Err(RecvError::Closed) => break,
                },
                changed = statuses.changed(), if told => {
                    told = changed.is_ok();
                    let status = statuses.borrow_and_update().clone();
                    if let Some(status) = status {
                        self.tell(&status);
                    }
                }
                changed = integrity.changed(), if judged => {
                    judged = changed.is_ok();
                    let known = integrity.borrow_and_update().clone();
                    self.judge(&known);
                }
                // Its other end is the hub's, which lives as long as this does.
                Ok(()) = alerts.changed() => {
                    let alerts = alerts.borrow_and_update().clone();
                    self.alert(&alerts);
                }
                outlook = outlooks.recv() => match outlook {
                    Ok(outlook) => self.foresee(&outlook),
                    Err(RecvError::Lagged(_)) => self.state.log.push(Event::Lost),
                    Err(RecvError::Closed) => break,
                },
                _ = heartbeat.tick() => {
                    self.state.hub.inputs.second_passed();
                    self.beat();
                }
            }
        }
        loop {
            match self.frames.try_recv() {
                Ok(frame) => self.show(&frame),
                Err(TryRecvError::Lagged(_)) => self.state.log.push(Event::Lost),
                Err(TryRecvError::Empty | TryRecvError::Closed) => break,
            }
        }
        let octets = event(&self.next_id(), &Closed { reason: "the service stops" });
        self.state.log.push(Event::Closed(octets));
    }

    fn next_id(&self) -> String {
        self.state.event_id(self.state.log.next_number())
    }

    fn show(&mut self, frame: &Arc<PublishedPicture>) {
        let (log, hub) = (&self.state.log, &self.state.hub);
        let (_, before) = log.latest();
        if before.as_ref().is_some_and(|before| before.frame.seq >= frame.seq) {
            return;
        }
        let head = events::head(&self.next_id(), events::TRACKS);
        let shown = Arc::new(Shown::new(frame, hub, before.as_deref(), head));
        let ended = self.endings.note(shown.time(), shown.usual());
        let time = shown.time();
        self.state.note_slot();
        self.state.trails().note(time, shown.usual());
        let is_back = before.is_some_and(|before| time < before.time());
        self.state.log.push(if is_back { Event::Back(shown) } else { Event::Slot(shown) });
        if !ended.is_empty() {
            let octets = events::ended(&self.next_id(), time, &ended);
            self.state.log.push(Event::Ended(octets));
        }
        // Not even until the next second is a late picture taken for one of now.
        let is_late = self.state.hub.lateness().is_some_and(|lateness| lateness.is_late());
        if is_late != self.told_late {
            self.beat();
        }
    }

    fn beat(&mut self) {
        let (_, latest) = self.state.log.latest();
        let late = self.state.hub.lateness().filter(Lateness::is_late);
        let data = Heartbeat {
            time: latest.as_ref().map(|shown| shown.time().into()),
            seq: latest.as_ref().map_or(0, |shown| shown.frame.seq),
            latency_s: latest.as_ref().map(|shown| shown.latency_s()),
            late_s: late.map(|lateness| rounded(lateness.late.as_secs_f64(), 1)),
        };
        self.told_late = late.is_some();
        self.state.log.push(Event::Told(event(&self.next_id(), &data)));
    }

    /// Sensors whose state changed.
    fn tell(&mut self, status: &Status) {
        for (index, sensor) in status.sensors.iter().enumerate() {
            let before = self.sensors.insert(sensor.id.clone(), sensor.state);
            // What is as it should be from the start is no news.
            if before == Some(sensor.state) || before.is_none() && sensor.state == SensorState::Operational {
                continue;
            }
            if let Some(configured) = self.state.hub.config.sensors.get(index) {
                let properties = SensorProperties::new(configured, Some(sensor));
                let octets = event(&self.next_id(), &properties);
                self.state.log.push(Event::Sensor(index, octets));
            }
        }
    }

    /// Transponders whose state changed.
    fn judge(&mut self, known: &Integrities) {
        let latest = self.state.log.latest().1;
        let mut states = BTreeMap::new();
        for assessment in &known.assessments {
            let identity = assessment.identity;
            let now = (assessment.integrity.state, known.word(identity).map(|held| held.word.trust));
            states.insert(identity, now);
            // What is as it is from the start is no news.
            if self.integrity.get(&identity).copied().unwrap_or_default() != now {
                let data = IdentityJson::new(assessment, known, &self.state.hub, latest.as_deref());
                self.state.log.push(Event::Told(event(&self.next_id(), &data)));
            }
        }
        self.integrity = states;
    }

    /// Conflicts whose level changed, and each second those that are warned of.
    fn foresee(&self, outlook: &Outlook) {
        for conflict in &outlook.news {
            let octets = event(&self.next_id(), &ConflictJson::from(conflict));
            self.state.log.push(Event::Told(octets));
        }
    }

    /// Alerts that began, changed or ended.
    fn alert(&mut self, alerts: &[Arc<Alert>]) {
        let tell = |alert: &Alert| {
            let octets = event(&self.next_id(), &AlertJson::from(alert));
            self.state.log.push(Event::Told(octets));
        };
        let (ended, lasting): (Vec<_>, Vec<_>) = alerts.iter().partition(|alert| alert.until.is_some());
        for alert in &lasting {
            if self.alerts.get(&alert.id) != Some(&alert.revision) {
                tell(alert);
            }
        }
        // The latest are the first.
        let known = self.ended.clone();
        let news =
            ended.iter().take_while(|alert| known.as_ref().is_none_or(|known| !Arc::ptr_eq(known, alert)));
        news.for_each(|alert| tell(alert));
        self.ended = ended.first().map(|&alert| alert.clone());
        self.alerts = lasting.iter().map(|alert| (alert.id, alert.revision)).collect();
    }
}
