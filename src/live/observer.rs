//! The first reader: watches each slot for alerts, tells the log of them, and hands the slots to the history.

use std::time::Duration;

use tokio::sync::broadcast::error::RecvError;
use tokio::time::MissedTickBehavior;
use tracing::{error, info, warn};

use super::alerts::{Alert, Alerts, Change, Severity};
use super::clock::now;
use super::hub::{Hub, Status};
use crate::history::Historian;
use fusion::time::Time;

/// How often it is looked whether the engine still publishes: it cannot say itself that it stands still.
const LOOK: Duration = Duration::from_millis(500);

/// Watches until the engine has ended.
pub async fn observe(hub: Hub, mut alerts: Alerts, mut historian: Option<Historian>) {
    let mut frames = hub.frames();
    let mut statuses = hub.statuses();
    let mut look = tokio::time::interval(LOOK);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let changed = tokio::select! {
            frame = frames.recv() => match frame {
                Ok(frame) => {
                    if let Some(historian) = &mut historian {
                        historian.note(&frame.picture, &hub.maker);
                    }
                    alerts.note_picture(&frame.picture, &hub.maker)
                }
                Err(RecvError::Lagged(slots)) => {
                    warn!("the history and the alerts miss {slots} slots: these were published faster than read");
                    false
                }
                Err(RecvError::Closed) => break,
            },
            status = statuses.changed() => {
                if status.is_err() {
                    break;
                }
                hub.set_history_trouble(historian.as_ref().and_then(Historian::trouble));
                let status = statuses.borrow_and_update().clone();
                status.is_some_and(|status| {
                    note_status(&mut alerts, &status) | note_condition(&mut alerts, &hub, status.at)
                })
            }
            // A replay, which has no lateness, has the times of its recording.
            _ = look.tick(), if hub.lateness().is_some() => note_condition(&mut alerts, &hub, now()),
        };
        if changed {
            alerts.take_changes().iter().for_each(tell);
            hub.set_alerts(alerts.all());
        }
    }
}

fn note_status(alerts: &mut Alerts, status: &Status) -> bool {
    alerts.note_sensors(&status.sensors, status.at) | alerts.note_registration(&status.sensors, status.at)
}

fn note_condition(alerts: &mut Alerts, hub: &Hub, at: Time) -> bool {
    alerts.note_troubles(hub.condition().troubles().iter(), at)
}

/// Each alert is a line of the log where it begins, changes and ends.
fn tell((change, alert): &(Change, Alert)) {
    let Alert { severity, text, since, until, .. } = alert;
    match (change, severity) {
        (Change::Began, Severity::Critical) => error!("alert began: {text}"),
        (Change::Began, Severity::Warning) => warn!("alert began: {text}"),
        (Change::Changed, Severity::Critical) => error!("alert is critical now: {text}"),
        (Change::Changed, Severity::Warning) => warn!("alert is a warning now: {text}"),
        (Change::Ended, _) => {
            let lasted_s = until.map_or(0.0, |until| until.seconds_since(*since).max(0.0));
            info!("alert ended after {lasted_s:.0} s: {text}");
        }
    }
}
