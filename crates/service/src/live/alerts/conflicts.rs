//! Alerts about conflicts. A warning raises a warning, a violation a critical alert; an advisory is shown on the map only.

use super::wording::approaching;
use super::{AlertCause, AlertDetails, AlertInput, AlertKind, AlertMonitor, Severity};
use fusion::conflicts::Level;
use picture::conflicts::{Conflict, Outlook};

impl AlertMonitor {
    /// Raises and ends conflict alerts from one second's evaluation. Returns whether any alert changed.
    pub fn note_outlook(&mut self, outlook: &Outlook) -> bool {
        self.derive(AlertInput::Outlook, outlook.time);
        let found: Vec<AlertCause> = outlook.conflicts.iter().filter_map(raised).collect();
        self.hold(AlertKind::Conflict, found, outlook.time, |_, _| true)
    }
}

fn raised(conflict: &Conflict) -> Option<AlertCause> {
    let severity = match conflict.level()? {
        Level::Advisory => return None,
        Level::Warning => Severity::Warning,
        Level::Violation => Severity::Critical,
    };
    let (id, tracks, volume) = (conflict.found.id?, conflict.tracks.clone(), conflict.volume.clone());
    let details = AlertDetails::Conflict { id, tracks, volume };
    Some(AlertCause {
        details,
        transponders: conflict.trusted.to_vec(),
        places: conflict.cpa.map(|(place, _)| (place.longitude_deg(), place.latitude_deg())).to_vec(),
        ..AlertCause::new(&subject(conflict), severity, approaching(conflict))
    })
}

/// Identifies a conflict across runs of the service: both tracks and the volume.
fn subject(conflict: &Conflict) -> String {
    let [a, b] = &conflict.tracks;
    let (first, second) = if a < b { (a, b) } else { (b, a) };
    format!("{first} {second} {}", conflict.volume)
}
