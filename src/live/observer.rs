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
                let history = historian.as_ref().and_then(Historian::trouble);
                status.is_some_and(|status| {
                    let troubles = status.troubles.iter().chain(&history);
                    alerts.note_sensors(&status.sensors, status.at)
                        | alerts.note_registration(&status.sensors, status.at)
                        | alerts.note_troubles(troubles, status.at)
                })
            }
        };
        if changed {
            if let Some(alert) = alerts.latest() {
                info!("alert {}: {}", if alert.until.is_some() { "ended" } else { "began" }, alert.text);
            }
            hub.set_alerts(alerts.all());
        }
    }
}
