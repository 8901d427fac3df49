//! The one task that turns what the hub shows into the events of the stream, once for all readers.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::sync::broadcast::error::{RecvError, TryRecvError};
use tokio::sync::{broadcast, watch};
use tokio::time::{Instant, MissedTickBehavior};

use super::endings::{Endings, ended_event, event};
use super::log::Event;
use super::shown::Shown;
use super::{ApiState, sites};
use crate::live::{Frame, SensorState, SensorStatus, Status};
use crate::time::Time;

/// A heartbeat each second.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// A sensor that is not operational.
#[derive(Clone, Debug, PartialEq)]
pub struct Alert {
    /// Degraded or out.
    pub state: SensorState,
    /// Since when.
    pub since: Time,
    /// Why.
    pub reasons: Vec<String>,
}

pub(super) struct Keeper {
    state: ApiState,
    frames: broadcast::Receiver<Arc<Frame>>,
    endings: Endings,
    sensors: BTreeMap<String, SensorState>,
}

impl Keeper {
    pub(super) fn new(state: ApiState) -> Self {
        // Subscribed before the latest one is looked at: none is missed in between, at most one comes twice.
        let frames = state.hub().frames();
        let mut keeper = Self { state, frames, endings: Endings::default(), sensors: BTreeMap::new() };
        if let Some(frame) = keeper.state.hub().latest() {
            keeper.show(&frame);
        }
        keeper
    }

    /// Until the service is told to close: then what has been published is shown, and the streams end.
    pub(super) async fn run(mut self, mut closing: watch::Receiver<bool>) {
        let mut statuses = self.state.hub().statuses();
        if let Some(status) = self.state.hub().status() {
            self.tell(&status);
        }
        let mut heartbeat = tokio::time::interval_at(Instant::now() + HEARTBEAT, HEARTBEAT);
        heartbeat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut told = true;
        loop {
            tokio::select! {
                // Whoever dropped the other end wants it closed, too.
                _ = closing.wait_for(|closing| *closing) => break,
                frame = self.frames.recv() => match frame {
                    Ok(frame) => self.show(&frame),
                    Err(RecvError::Lagged(_)) => self.state.log().push(Event::Lost),
                    Err(RecvError::Closed) => break,
                },
                changed = statuses.changed(), if told => {
                    told = changed.is_ok();
                    let status = statuses.borrow_and_update().clone();
                    if let Some(status) = status {
                        self.tell(&status);
                    }
                }
                _ = heartbeat.tick() => self.beat(),
            }
        }
        loop {
            match self.frames.try_recv() {
                Ok(frame) => self.show(&frame),
                Err(TryRecvError::Lagged(_)) => self.state.log().push(Event::Lost),
                Err(TryRecvError::Empty | TryRecvError::Closed) => break,
            }
        }
        let data = json!({ "reason": "the service stops" });
        let octets = event(&self.next_id(), "closed", &data);
        self.state.log().push(Event::Closed(octets));
    }

    fn next_id(&self) -> String {
        self.state.event_id(self.state.log().next_number())
    }

    fn show(&mut self, frame: &Arc<Frame>) {
        let (log, hub) = (self.state.log(), self.state.hub());
        if log.latest().1.is_some_and(|latest| latest.frame.seq >= frame.seq) {
            return;
        }
        let head = format!("id: {}\nevent: tracks\ndata: ", self.next_id());
        let shown = Arc::new(Shown::new(frame, &hub.maker, &hub.config.site.name, &head));
        let ended = self.endings.note(shown.time(), shown.pieces.iter());
        let time = shown.time();
        self.state.note_slot();
        self.state.log().push(Event::Slot(shown));
        if !ended.is_empty() {
            let octets = ended_event(&self.next_id(), time, &ended);
            self.state.log().push(Event::Ended(octets));
        }
    }

    fn beat(&self) {
        let (_, latest) = self.state.log().latest();
        let data = match latest {
            Some(shown) => json!({
                "time": shown.time().to_string(),
                "seq": shown.frame.seq,
                "latency_s": shown.latency_s(),
            }),
            None => json!({ "seq": 0 }),
        };
        self.state.log().push(Event::Told(event(&self.next_id(), "heartbeat", &data)));
    }

    /// Sensors whose state changed.
    fn tell(&mut self, status: &Status) {
        for (index, sensor) in status.sensors.iter().enumerate() {
            let before = self.sensors.insert(sensor.id.clone(), sensor.state);
            if before == Some(sensor.state) {
                self.state.update_alert(sensor);
                continue;
            }
            let alert = self.state.set_alert(sensor, status.at);
            // What is as it should be from the start is no news.
            if before.is_none() && sensor.state == SensorState::Operational {
                continue;
            }
            if let Some(configured) = self.state.hub().config.sensors.get(index) {
                let properties = sites::sensor_properties(configured, sensor);
                self.push("sensor", &properties);
            }
            let mut data = alert_json(&sensor.id, alert.as_ref(), status.at);
            if alert.is_none() {
                data["cleared"] = json!(status.at.to_string());
            }
            self.push("alert", &data);
        }
    }

    fn push(&self, name: &str, data: &Value) {
        let octets = event(&self.next_id(), name, data);
        self.state.log().push(Event::Told(octets));
    }
}

/// An alert as it is told; one that is over where there is none.
pub(super) fn alert_json(sensor: &str, alert: Option<&Alert>, now: Time) -> Value {
    let mut data = json!({
        "id": format!("sensor-{sensor}"),
        "kind": "sensor",
        "sensor": sensor,
        "active": alert.is_some(),
        "time": now.to_string(),
    });
    if let Some(alert) = alert {
        data["severity"] = json!(if alert.state == SensorState::Outage { "critical" } else { "warning" });
        data["state"] = json!(alert.state.name());
        data["reasons"] = json!(alert.reasons);
        data["since"] = json!(alert.since.to_string());
    }
    data
}

impl Alert {
    /// Of a sensor, where it is not operational.
    pub(super) fn of(sensor: &SensorStatus, since: Time) -> Option<Self> {
        (sensor.state != SensorState::Operational).then(|| Self {
            state: sensor.state,
            since,
            reasons: sensor.reasons.clone(),
        })
    }
}
