//! The single task that turns the content of the hub into events of the stream, once for all readers.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::broadcast;
use tokio::sync::broadcast::error::{RecvError, TryRecvError};
use tokio::time::{Instant, MissedTickBehavior};

use super::endings::Endings;
use super::event_log::StreamEvent;
use super::event_text;
use super::events::{self, Closed, Heartbeat, event};
use super::integrity::IdentityJson;
use super::sensors::SensorProperties;
use super::slot_json::SlotJson;
use super::state::ApiState;
use fusion::Identity;
use fusion::integrity::{State, Trust};
use input::json::rounded;
use picture::conflicts::{ConflictJson, Outlook};
use service::live::{
    Alert, AlertJson, PictureLateness, PublishedPicture, SensorState, Status, TrustAssessments,
};

/// Interval of heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);

pub(super) struct EventPublisher {
    state: ApiState,
    frames: broadcast::Receiver<Arc<PublishedPicture>>,
    endings: Endings,
    /// Whether the picture was last reported as late.
    reported_late: bool,
    sensors: BTreeMap<String, SensorState>,
    /// Last published state and operator verdict of each transponder.
    integrity: BTreeMap<Identity, (State, Option<Trust>)>,
    /// Last published revision of each active alert.
    alerts: BTreeMap<u64, u32>,
    /// Id of the last published alert that ended.
    ended: Option<u64>,
    /// Published alerts that have ended and wait for an acknowledgement.
    latched: BTreeSet<u64>,
}

impl EventPublisher {
    pub(super) fn new(state: ApiState) -> Self {
        // Subscribes before it reads the latest picture: none is missed, and at most one is seen twice.
        let frames = state.hub.pictures();
        let mut publisher = Self {
            state,
            frames,
            endings: Endings::default(),
            reported_late: false,
            sensors: BTreeMap::new(),
            integrity: BTreeMap::new(),
            alerts: BTreeMap::new(),
            ended: None,
            latched: BTreeSet::new(),
        };
        if let Some(frame) = publisher.state.hub.latest() {
            publisher.publish_slot(&frame);
        }
        publisher
    }

    /// Runs until the service closes, then sends what has been published and ends the streams.
    pub(super) async fn run(mut self) {
        let mut statuses = self.state.hub.statuses();
        let mut alerts = self.state.hub.alert_changes();
        let mut integrity = self.state.hub.trust_requests.changes();
        let mut outlooks = self.state.hub.conflict_reports.all();
        let mut has_integrity = true;
        if let Some(status) = self.state.hub.status() {
            self.publish_sensors(&status);
        }
        let mut heartbeat = tokio::time::interval_at(Instant::now() + HEARTBEAT, HEARTBEAT);
        heartbeat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut has_status = true;
        loop {
            tokio::select! {
                () = self.state.closed() => break,
                frame = self.frames.recv() => match frame {
                    Ok(frame) => self.publish_slot(&frame),
                    Err(RecvError::Lagged(_)) => self.state.log.push(StreamEvent::Lost),
                    Err(RecvError::Closed) => break,
                },
                changed = statuses.changed(), if has_status => {
                    has_status = changed.is_ok();
                    let status = statuses.borrow_and_update().clone();
                    if let Some(status) = status {
                        self.publish_sensors(&status);
                    }
                }
                changed = integrity.changed(), if has_integrity => {
                    has_integrity = changed.is_ok();
                    let known = integrity.borrow_and_update().clone();
                    self.publish_integrity(&known);
                }
                // The hub owns the sender, and lives as long as this task.
                Ok(()) = alerts.changed() => {
                    let alerts = alerts.borrow_and_update().clone();
                    self.publish_alerts(&alerts);
                }
                outlook = outlooks.recv() => match outlook {
                    Ok(outlook) => self.publish_conflicts(&outlook),
                    Err(RecvError::Lagged(_)) => self.state.log.push(StreamEvent::Lost),
                    Err(RecvError::Closed) => break,
                },
                _ = heartbeat.tick() => {
                    self.state.hub.recent_reports.second_passed();
                    self.publish_heartbeat();
                }
            }
        }
        loop {
            match self.frames.try_recv() {
                Ok(frame) => self.publish_slot(&frame),
                Err(TryRecvError::Lagged(_)) => self.state.log.push(StreamEvent::Lost),
                Err(TryRecvError::Empty | TryRecvError::Closed) => break,
            }
        }
        let octets = event(&self.next_id(), &Closed { reason: "the service stops" });
        self.state.log.push(StreamEvent::Closed(octets));
    }

    fn next_id(&self) -> String {
        self.state.event_id(self.state.log.next_number())
    }

    fn publish_slot(&mut self, frame: &Arc<PublishedPicture>) {
        let (log, hub) = (&self.state.log, &self.state.hub);
        let (_, before) = log.latest();
        if before.as_ref().is_some_and(|before| before.frame.seq >= frame.seq) {
            return;
        }
        let head = event_text::head(&self.next_id(), events::TRACKS);
        let slot = Arc::new(SlotJson::new(frame, hub, before.as_deref(), head));
        let ended = self.endings.note(slot.time(), slot.default_tracks());
        let time = slot.time();
        self.state.note_slot();
        self.state.trails().note(time, slot.default_tracks());
        let is_back = before.is_some_and(|before| time < before.time());
        self.state.log.push(if is_back { StreamEvent::Back(slot) } else { StreamEvent::Slot(slot) });
        if !ended.is_empty() {
            let octets = events::ended(&self.next_id(), time, &ended);
            self.state.log.push(StreamEvent::Ended(octets));
        }
        // A late picture must not count as current, not even until the next second.
        let is_late = self.state.hub.lateness().is_some_and(|lateness| lateness.is_late());
        if is_late != self.reported_late {
            self.publish_heartbeat();
        }
    }

    fn publish_heartbeat(&mut self) {
        let (_, latest) = self.state.log.latest();
        let late = self.state.hub.lateness().filter(PictureLateness::is_late);
        let data = Heartbeat {
            time: latest.as_ref().map(|slot| slot.time().into()),
            seq: latest.as_ref().map_or(0, |slot| slot.frame.seq),
            latency_s: latest.as_ref().map(|slot| slot.latency_s()),
            late_s: late.map(|lateness| rounded(lateness.late.as_secs_f64(), 1)),
        };
        self.reported_late = late.is_some();
        self.state.log.push(StreamEvent::Broadcast(event(&self.next_id(), &data)));
    }

    /// Publishes the sensors whose state changed.
    fn publish_sensors(&mut self, status: &Status) {
        for (index, sensor) in status.sensors.iter().enumerate() {
            let before = self.sensors.insert(sensor.id.clone(), sensor.state);
            // The normal state at the start is not an event.
            if before == Some(sensor.state) || before.is_none() && sensor.state == SensorState::Operational {
                continue;
            }
            if let Some(configured) = self.state.hub.config.sensors.get(index) {
                let properties = SensorProperties::new(configured, Some(sensor));
                let octets = event(&self.next_id(), &properties);
                self.state.log.push(StreamEvent::Sensor(index, octets));
            }
        }
    }

    /// Publishes the transponders whose state changed.
    fn publish_integrity(&mut self, known: &TrustAssessments) {
        let latest = self.state.log.latest().1;
        let mut states = BTreeMap::new();
        for assessment in &known.assessments {
            let identity = assessment.identity;
            let now = (assessment.integrity.state, known.word(identity).map(|held| held.word.trust));
            states.insert(identity, now);
            // The default state at the start is not an event.
            if self.integrity.get(&identity).copied().unwrap_or_default() != now {
                let data = IdentityJson::new(assessment, known, &self.state.hub, latest.as_deref());
                self.state.log.push(StreamEvent::Broadcast(event(&self.next_id(), &data)));
            }
        }
        self.integrity = states;
    }

    /// Publishes conflicts whose level changed, and warnings every second.
    fn publish_conflicts(&self, outlook: &Outlook) {
        for conflict in &outlook.news {
            let octets = event(&self.next_id(), &ConflictJson::from(conflict));
            self.state.log.push(StreamEvent::Broadcast(octets));
        }
    }

    /// Publishes alerts that began, changed or ended.
    fn publish_alerts(&mut self, alerts: &[Arc<Alert>]) {
        let publish = |alert: &Alert| {
            let octets = event(&self.next_id(), &AlertJson::from(alert));
            self.state.log.push(StreamEvent::Broadcast(octets));
        };
        let (ended, lasting): (Vec<_>, Vec<_>) = alerts.iter().partition(|alert| alert.until.is_some());
        for alert in &lasting {
            if self.alerts.get(&alert.id) != Some(&alert.revision) {
                publish(alert);
            }
        }
        // The latest alerts come first.
        let known = self.ended;
        let news = ended.iter().take_while(|alert| known.is_none_or(|known| known != alert.id));
        news.for_each(|alert| publish(alert));
        let released = ended.iter().filter(|alert| !alert.is_latched && self.latched.contains(&alert.id));
        released.for_each(|alert| publish(alert));
        self.latched = ended.iter().filter(|alert| alert.is_latched).map(|alert| alert.id).collect();
        self.ended = ended.first().map(|alert| alert.id);
        self.alerts = lasting.iter().map(|alert| (alert.id, alert.revision)).collect();
    }
}
