//! Alerts about conflicts: one for each situation. A warning raises a warning, a violation a critical alert; an advisory is shown
//! on the map only.

use super::situations::{Situation, pair_ids};
use super::wording::{approaching, cluster, passed};
use super::{AlertCause, AlertDetails, AlertInput, AlertKind, AlertMonitor, AlertSettings, Severity};
use conflict::Level;
use fusion::Identity;
use picture::conflicts::{Conflict, Outlook};

impl AlertMonitor {
    /// Raises and ends conflict alerts from one second's evaluation. Returns whether any alert changed.
    pub fn note_outlook(&mut self, outlook: &Outlook) -> bool {
        let (kind, now) = (AlertKind::Conflict, outlook.time);
        self.derive(AlertInput::Outlook, now);
        let settings = self.settings.get();
        let mut conflicts: Vec<&Conflict> =
            outlook.conflicts.iter().filter(|conflict| is_raised(conflict, &settings)).collect();
        conflicts.sort_by(|one, other| {
            let by_level = other.level().cmp(&one.level());
            let by_distance = one.closeness().total_cmp(&other.closeness());
            by_level.then(by_distance).then_with(|| pair_ids(one).cmp(&pair_ids(other)))
        });
        let (found, merged) = self.situations.assign(&conflicts, now, settings.hold_ns(kind));
        let before = self.changes.len();
        for parts in merged {
            let [part, whole] = parts.map(|subject| (kind, subject, String::new()));
            self.absorb((&part, &whole), now);
        }
        let causes = found
            .iter()
            .filter_map(|(subject, conflicts)| cause(subject, self.situations.get(subject)?, conflicts));
        let causes: Vec<AlertCause> = causes.collect();
        self.hold(kind, causes, now, |_, _| true) || self.changes.len() > before
    }
}

/// Whether a conflict raises an alert by itself. The alert about a lying transponder covers the conflicts of its false position.
fn is_raised(conflict: &Conflict, settings: &AlertSettings) -> bool {
    let is_lie = conflict.failed.iter().flatten().any(|&liar| settings.reports_lies(liar));
    conflict.found.id.is_some()
        && conflict.level() >= Some(Level::Warning)
        && !is_lie
        && settings.admits(AlertKind::Conflict, &limited(conflict))
}

/// The cause as far as rules limit it.
fn limited(conflict: &Conflict) -> AlertCause {
    AlertCause {
        transponders: transponders(conflict),
        places: places(conflict),
        ..AlertCause::new("", Severity::Warning, String::new())
    }
}

/// Cause of the alert of a situation with these conflicts, the worst first.
fn cause(subject: &str, situation: &Situation, conflicts: &[&Conflict]) -> Option<AlertCause> {
    let worst = conflicts.first()?;
    let severity = match worst.level()? {
        Level::Violation => Severity::Critical,
        Level::Advisory | Level::Warning => Severity::Warning,
    };
    let closest = &situation.closest;
    let text = approaching(worst, &situation.closest_of(&pair_ids(worst)).pair);
    let mut names: Vec<String> = conflicts.iter().flat_map(|conflict| conflict.names.clone()).collect();
    names.sort();
    names.dedup();
    let text = if names.len() > 2 { cluster(&names, &text) } else { text };
    let details = AlertDetails::Conflict {
        id: worst.found.id?,
        tracks: situation.tracks(worst),
        volume: worst.volume.clone(),
        closest: closest.pair.clone(),
        endangered: situation.endangered.len(),
        is_entered: conflicts.iter().any(|conflict| conflict.is_seen() && conflict.is_entered()),
    };
    Some(AlertCause {
        past: passed(&closest.names, &closest.volume, &closest.pair),
        details,
        transponders: transponders(worst),
        places: places(worst),
        ..AlertCause::new(subject, severity, text)
    })
}

fn transponders(conflict: &Conflict) -> Vec<Option<Identity>> {
    conflict.trusted.to_vec()
}

/// Longitudes and latitudes of the closest point, degrees.
fn places(conflict: &Conflict) -> Vec<(f64, f64)> {
    conflict.cpa.map(|(place, _)| (place.longitude_deg(), place.latitude_deg())).to_vec()
}
