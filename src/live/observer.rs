//! The first reader: looks at each slot for alerts, logs them, and hands slots and alerts on.

use std::time::Duration;

use tokio::sync::broadcast::error::RecvError;
use tokio::time::MissedTickBehavior;
use tracing::field::display;
use tracing::{error, info, warn};

use super::alert_desk::Asked;
use super::alerts::{Ahead, Alert, Alerts, Change, Severity};
use super::clock::now;
use super::hub::Hub;
use super::published::{Followers, PublishedPicture, Status};
use crate::state::alert_line;
use fusion::time::Time;

/// Time between two looks at whether the engine still publishes: it cannot say itself that it stands still.
const LOOK: Duration = Duration::from_millis(500);

/// Watches until the engine has ended.
pub async fn observe(hub: Hub, mut alerts: Alerts, mut followers: Followers) {
    let mut frames = hub.pictures();
    let mut outlooks = hub.outlooks.all();
    let mut statuses = hub.statuses();
    let mut wishes = hub.alert_desk.wishes().await;
    let mut look = tokio::time::interval(LOOK);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let changed = tokio::select! {
            frame = frames.recv() => match frame {
                Ok(frame) => {
                    if let Some(archive) = &mut followers.archive {
                        archive.note(&frame.picture, &hub.maker);
                    }
                    alerts.note_picture(&frame.picture, &hub.maker) | note_approaches(&mut alerts, &hub, &frame)
                }
                Err(RecvError::Lagged(slots)) => {
                    warn!(slots, "alerts and history miss slots, which were published faster than read");
                    false
                }
                Err(RecvError::Closed) => break,
            },
            outlook = outlooks.recv() => match outlook {
                Ok(outlook) => alerts.note_outlook(&outlook),
                Err(RecvError::Lagged(seconds)) => {
                    warn!(seconds, "alerts miss conflicts, which were published faster than read");
                    false
                }
                // The pictures have ended with them.
                Err(RecvError::Closed) => break,
            },
            status = statuses.changed() => {
                if status.is_err() {
                    break;
                }
                hub.set_followers_troubles(followers.troubles(now()));
                let status = statuses.borrow_and_update().clone();
                status.is_some_and(|status| {
                    note_status(&mut alerts, &status) | note_condition(&mut alerts, &hub, status.at)
                })
            }
            // The desk is the hub's, which lives as long as this does.
            Some(asked) = wishes.recv() => decide(&mut alerts, &hub, asked),
            // A replay, which has no lateness, has the times of its recording.
            _ = look.tick(), if hub.lateness().is_some() => note_condition(&mut alerts, &hub, now()),
        };
        if changed {
            for change in alerts.take_changes() {
                log(&change);
                if let Some(messenger) = &mut followers.messenger {
                    messenger.note(change.0, &change.1);
                }
            }
            hub.set_alerts(alerts.all());
        }
        if let Some(shelves) = alerts.take_shelves() {
            hub.alert_desk.keep(shelves);
        }
    }
}

/// Who is about to enter an area, by the picture of now, where one is made and still remembered.
fn note_approaches(alerts: &mut Alerts, hub: &Hub, frame: &PublishedPicture) -> bool {
    let now = frame.now.get();
    let ahead = match &now {
        Some(now) => Ahead::Now(now),
        None if hub.config.fusion.now => return false,
        None => Ahead::Lagged(&frame.picture, frame.due - frame.picture.time),
    };
    alerts.note_approaches(ahead, &hub.maker)
}

fn note_status(alerts: &mut Alerts, status: &Status) -> bool {
    alerts.note_sensors(&status.sensors, status.at) | alerts.note_registration(&status.sensors, status.at)
}

fn note_condition(alerts: &mut Alerts, hub: &Hub, at: Time) -> bool {
    alerts.note_troubles(hub.condition().troubles().iter(), at)
}

/// Does what an operator asks for; whether anything changed.
fn decide(alerts: &mut Alerts, hub: &Hub, Asked { wish, answer }: Asked) -> bool {
    // A caller that gave up has the answer that nothing was done.
    if answer.is_closed() {
        return false;
    }
    // Every time in a replay is one of the recording.
    let at = if hub.lateness().is_some() { None } else { alerts.pictured() };
    let decided = alerts.decide(&wish, at.unwrap_or_else(now));
    let is_done = decided.is_ok();
    let answered = decided.map(|(decision, alert)| {
        hub.alert_desk.record(alert_line(&decision));
        alert
    });
    // The caller may have gone this very moment.
    let _ = answer.send(answered);
    is_done
}

/// Each alert is a line of the log where it begins, changes and ends.
fn log((change, alert): &(Change, Alert)) {
    let Alert { id, kind, severity, text, since, until, acknowledged, shelved, .. } = alert;
    let kind = kind.name();
    match (change, severity) {
        (Change::Began, Severity::Critical) => error!(text, kind, id, "alert began"),
        (Change::Began, Severity::Warning) => warn!(text, kind, id, "alert began"),
        (Change::Changed, Severity::Critical) => error!(text, kind, id, "alert is critical now"),
        (Change::Changed, Severity::Warning) => warn!(text, kind, id, "alert is a warning now"),
        (Change::Amended, _) => warn!(text, kind, id, "alert changed"),
        (Change::Acknowledged, _) => {
            let (by, note) = acknowledged.as_ref().map(|seen| (&*seen.by, seen.note.as_deref())).unzip();
            info!(text, kind, id, by, note = note.flatten(), "alert acknowledged");
        }
        (Change::Shelved, _) => {
            let (by, until) = shelved.as_ref().map(|shelf| (&*shelf.by, display(shelf.until))).unzip();
            let note = shelved.as_ref().and_then(|shelf| shelf.note.as_deref());
            info!(text, kind, id, by, until, note, "alert shelved");
        }
        (Change::Unshelved, _) => info!(text, kind, id, "alert no longer shelved"),
        (Change::Ended, _) => {
            let lasted_s = until.map_or(0.0, |until| until.seconds_since(*since).max(0.0).round());
            info!(text, kind, id, lasted_s, "alert ended");
        }
    }
}
