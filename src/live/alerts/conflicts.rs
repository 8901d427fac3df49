//! Alerts of conflicts: a warning is one, a violation is critical, an advisory is on the map alone.

use super::wording::approaching;
use super::{AlertKind, Alerts, Basis, Details, Found, Severity};
use crate::conflicts::{Conflict, Outlook};
use fusion::conflicts::Level;

impl Alerts {
    /// Looks at what was found in a second; whether there is anything new to show.
    pub fn note_outlook(&mut self, outlook: &Outlook) -> bool {
        self.derive(Basis::Outlook, outlook.time);
        let found: Vec<Found> = outlook.conflicts.iter().filter_map(raised).collect();
        self.hold(AlertKind::Conflict, found, outlook.time, |_, _| true)
    }
}

fn raised(conflict: &Conflict) -> Option<Found> {
    let severity = match conflict.level()? {
        Level::Advisory => return None,
        Level::Warning => Severity::Warning,
        Level::Violation => Severity::Critical,
    };
    let (id, tracks, volume) = (conflict.found.id?, conflict.tracks.clone(), conflict.volume.clone());
    let details = Details::Conflict { id, tracks, volume };
    Some(Found {
        details,
        transponders: conflict.trusted.to_vec(),
        places: conflict.cpa.map(|(place, _)| (place.longitude_deg(), place.latitude_deg())).to_vec(),
        ..Found::new(&subject(conflict), severity, approaching(conflict))
    })
}

/// What tells a conflict from all others, also in another run of the service: both tracks and the volume.
fn subject(conflict: &Conflict) -> String {
    let [a, b] = &conflict.tracks;
    let (first, second) = if a < b { (a, b) } else { (b, a) };
    format!("{first} {second} {}", conflict.volume)
}
