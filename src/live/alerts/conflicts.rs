//! Alerts of conflicts: a warning is one, a violation is critical, an advisory is on the map alone.

use super::wording::approaching;
use super::{AlertKind, Alerts, Details, Found, Severity};
use crate::conflicts::{Conflict, Outlook};
use fusion::conflicts::Level;

impl Alerts {
    /// Looks at what was found in a second; whether there is anything new to show.
    pub fn note_outlook(&mut self, outlook: &Outlook) -> bool {
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
    let details = Details::Conflict { tracks: conflict.tracks.clone(), volume: conflict.volume.clone() };
    Some(Found { details, ..Found::new(&subject(conflict)?, severity, approaching(conflict)) })
}

/// What tells a conflict from all others.
fn subject(conflict: &Conflict) -> Option<String> {
    Some(format!("C-{} {}", conflict.found.id?, conflict.volume))
}
