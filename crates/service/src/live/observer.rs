//! The observer: the first reader of each slot. It raises alerts, logs them, and passes slots and alerts to the followers.

use std::time::Duration;

use tokio::sync::broadcast::error::RecvError;
use tokio::time::MissedTickBehavior;
use tracing::field::display;
use tracing::{error, info, warn};

use super::alert_requests::PendingAlertRequest;
use super::alerts::{Alert, AlertChange, AlertMonitor, PredictionPicture, Severity};
use super::hub::Hub;
use super::published::{Followers, PublishedPicture, Status};
use crate::clock::now;
use crate::state::alert_line;
use fusion::time::Time;

/// Period at which the observer checks whether the engine still publishes: a stopped engine cannot report itself.
const LOOK: Duration = Duration::from_millis(500);

/// Runs until the engine has ended.
pub async fn observe(hub: Hub, mut alerts: AlertMonitor, mut followers: Followers) {
    let mut pictures = hub.pictures();
    let mut outlooks = hub.conflict_reports.all();
    let mut statuses = hub.statuses();
    let mut requests = hub.alert_requests.pending().await;
    let mut look = tokio::time::interval(LOOK);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let changed = tokio::select! {
            published = pictures.recv() => match published {
                Ok(published) => {
                    if let Some(archive) = &mut followers.archive {
                        archive.note(&published.picture, &hub.maker);
                    }
                    alerts.note_picture(&published.picture, &hub.maker) | note_approaches(&mut alerts, &hub, &published)
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
                // The pictures have ended too.
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
            // Always open: the hub holds the other end of this queue.
            Some(request) = requests.recv() => carry_out(&mut alerts, &hub, request),
            // Not in a replay: it has no lateness, and its times are those of the recording.
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
            hub.alert_requests.keep_shelves(shelves);
        }
    }
}

/// Predicts entries into areas from the present picture, if one is made and still available, or from the published one.
fn note_approaches(alerts: &mut AlertMonitor, hub: &Hub, published: &PublishedPicture) -> bool {
    let now = published.now.get();
    let ahead = match &now {
        Some(now) => PredictionPicture::Now(now),
        None if hub.config.fusion.now => return false,
        None => PredictionPicture::Lagged(&published.picture, published.due - published.picture.time),
    };
    alerts.note_approaches(ahead, &hub.maker)
}

fn note_status(alerts: &mut AlertMonitor, status: &Status) -> bool {
    alerts.note_sensors(&status.sensors, status.at) | alerts.note_registration(&status.sensors, status.at)
}

fn note_condition(alerts: &mut AlertMonitor, hub: &Hub, at: Time) -> bool {
    alerts.note_troubles(hub.condition().troubles().iter(), at)
}

/// Carries out an operator's request. Returns whether any alert changed.
fn carry_out(
    alerts: &mut AlertMonitor,
    hub: &Hub,
    PendingAlertRequest { request, answer }: PendingAlertRequest,
) -> bool {
    // The caller timed out and reported that nothing was done.
    if answer.is_closed() {
        return false;
    }
    // A replay uses the times of its recording.
    let at = if hub.lateness().is_some() { None } else { alerts.pictured() };
    let decided = alerts.decide(&request, at.unwrap_or_else(now));
    let is_done = decided.is_ok();
    let answered = decided.map(|(decision, alert)| {
        hub.alert_requests.record(alert_line(&decision));
        alert
    });
    // Fails if the caller has gone.
    let _ = answer.send(answered);
    is_done
}

/// Logs an alert when it begins, changes or ends.
fn log((change, alert): &(AlertChange, Alert)) {
    let Alert { id, kind, severity, text, subject, since, until, acknowledged, shelved, .. } = alert;
    let kind = kind.name();
    match (change, severity) {
        (AlertChange::Began, Severity::Critical) => error!(text, kind, id, subject, "alert began"),
        (AlertChange::Began, Severity::Warning) => warn!(text, kind, id, subject, "alert began"),
        (AlertChange::Changed, Severity::Critical) => {
            error!(text, kind, id, subject, "alert is critical now");
        }
        (AlertChange::Changed, Severity::Warning) => warn!(text, kind, id, subject, "alert is a warning now"),
        (AlertChange::Amended, _) => warn!(text, kind, id, subject, "alert changed"),
        (AlertChange::Acknowledged, _) => {
            let (by, note) = acknowledged.as_ref().map(|seen| (&*seen.by, seen.note.as_deref())).unzip();
            info!(text, kind, id, subject, by, note = note.flatten(), "alert acknowledged");
        }
        (AlertChange::Shelved, _) => {
            let (by, until) = shelved.as_ref().map(|shelf| (&*shelf.by, display(shelf.until))).unzip();
            let note = shelved.as_ref().and_then(|shelf| shelf.note.as_deref());
            info!(text, kind, id, subject, by, until, note, "alert shelved");
        }
        (AlertChange::Unshelved, _) => info!(text, kind, id, subject, "alert no longer shelved"),
        (AlertChange::Ended, _) => {
            let lasted_s = until.map_or(0.0, |until| until.seconds_since(*since).max(0.0).round());
            info!(text, kind, id, subject, lasted_s, "alert ended");
        }
    }
}
