//! The first reader: watches each slot for alerts and hands it to the history.

use tokio::sync::broadcast::error::RecvError;
use tracing::{info, warn};

use super::alerts::Alerts;
use super::hub::Hub;
use crate::store::Historian;

/// Watches until the engine has ended.
pub async fn observe(hub: Hub, mut alerts: Alerts, mut historian: Option<Historian>) {
    let mut frames = hub.frames();
    let mut statuses = hub.statuses();
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
                    warn!("the history and the alerts miss {slots} slots: the machine is too busy");
                    false
                }
                Err(RecvError::Closed) => break,
            },
            status = statuses.changed() => {
                if status.is_err() {
                    break;
                }
                let status = statuses.borrow_and_update().clone();
                status.is_some_and(|status| alerts.note_sensors(&status.sensors, status.at))
            }
        };
        if changed {
            let all = alerts.all();
            if let Some(alert) = all.iter().max_by_key(|alert| alert.until.unwrap_or(alert.since)) {
                info!("alert {}: {}", if alert.until.is_some() { "ended" } else { "began" }, alert.text);
            }
            hub.set_alerts(all);
        }
    }
}
