//! What a receiver hears of. Sans-IO.

use std::collections::BTreeSet;

use crate::config::{AlertKind, Severity};
use crate::live::{Alert, Change};

/// What one receiver wants, and what it has heard of.
#[derive(Debug)]
pub(super) struct Selection {
    /// Its name: that it cannot be reached is not sent to it.
    own: String,
    /// `None`: all.
    kinds: Option<Vec<AlertKind>>,
    min_severity: Severity,
    /// Ids of the alerts that last and that it was sent notices of.
    known: BTreeSet<u64>,
}

impl Selection {
    pub(super) fn new(own: String, kinds: Option<Vec<AlertKind>>, min_severity: Severity) -> Self {
        Self { own, kinds, min_severity, known: BTreeSet::new() }
    }

    /// Whether alerts like this one are its business at all.
    pub(super) fn wants(&self, alert: &Alert) -> bool {
        let is_own = alert.kind == AlertKind::Service && alert.subject == self.own;
        !is_own && self.kinds.as_ref().is_none_or(|kinds| kinds.contains(&alert.kind))
    }

    pub(super) fn is_bad_enough(&self, alert: &Alert) -> bool {
        alert.severity >= self.min_severity
    }

    /// Whether a notice of this change is sent. Of what is shelved only that it is, and its end; of what has become less bad
    /// than it wants to hear of, it hears that; and of what it never heard of, it does not hear the end.
    pub(super) fn admits(&mut self, change: Change, alert: &Alert) -> bool {
        if change == Change::Ended {
            return self.known.remove(&alert.id);
        }
        let is_quiet = alert.shelved.is_some() && change != Change::Shelved;
        let is_known = self.known.contains(&alert.id);
        let is_admitted = self.wants(alert) && !is_quiet && (is_known || self.is_bad_enough(alert));
        if is_admitted {
            self.known.insert(alert.id);
        }
        is_admitted
    }

    /// It was not told of this alert after all.
    pub(super) fn forget(&mut self, alert: u64) {
        self.known.remove(&alert);
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::tests::{alert, shelved};
    use super::*;

    fn selection(min_severity: Severity) -> Selection {
        Selection::new(
            "webhook:own".to_owned(),
            Some(vec![AlertKind::Service, AlertKind::Area]),
            min_severity,
        )
    }

    fn of(id: u64, severity: Severity) -> Alert {
        Alert { severity, ..Alert::clone(&alert(id)) }
    }

    #[test]
    fn what_becomes_bad_enough_is_heard_of_until_its_end() {
        let mut selection = selection(Severity::Critical);
        let (warning, critical) = (of(1, Severity::Warning), of(1, Severity::Critical));
        assert!(!selection.admits(Change::Began, &warning));
        assert!(!selection.admits(Change::Acknowledged, &warning));
        assert!(selection.admits(Change::Changed, &critical));
        assert!(selection.admits(Change::Changed, &warning));
        assert!(selection.admits(Change::Ended, &warning));
        assert!(!selection.admits(Change::Began, &of(2, Severity::Warning)));
        assert!(!selection.admits(Change::Ended, &of(2, Severity::Warning)));
    }

    #[test]
    fn of_what_is_shelved_only_that_it_is_and_its_end() {
        let mut selection = selection(Severity::Warning);
        let (open, quiet) = (alert(1), shelved(1));
        assert!(selection.admits(Change::Began, &open));
        assert!(selection.admits(Change::Shelved, &quiet));
        assert!(!selection.admits(Change::Changed, &quiet));
        assert!(!selection.admits(Change::Acknowledged, &quiet));
        assert!(selection.admits(Change::Unshelved, &open));
        assert!(selection.admits(Change::Shelved, &quiet));
        assert!(selection.admits(Change::Ended, &quiet));
        // It began while it was shelved: nobody heard of it.
        assert!(!selection.admits(Change::Began, &shelved(2)));
        assert!(!selection.admits(Change::Ended, &shelved(2)));
    }

    #[test]
    fn neither_other_kinds_nor_that_it_cannot_be_reached_itself() {
        let mut selection = selection(Severity::Warning);
        let service = |subject: &str| Alert {
            kind: AlertKind::Service,
            subject: subject.to_owned(),
            ..Alert::clone(&alert(3))
        };
        assert!(!selection.admits(Change::Began, &service("webhook:own")));
        assert!(selection.admits(Change::Began, &service("webhook:other")));
        let silent = Alert { kind: AlertKind::Silent, ..Alert::clone(&alert(4)) };
        assert!(!selection.admits(Change::Began, &silent));
    }
}
