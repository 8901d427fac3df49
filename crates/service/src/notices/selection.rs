//! Selection of the alerts for a receiver. Sans-IO.

use std::collections::BTreeSet;

use crate::live::{Alert, AlertChange};
use site::config::{AlertKind, Severity};

/// Criteria of one receiver, and the alerts that it has been sent.
#[derive(Debug)]
pub(super) struct NoticeSelection {
    /// Name of the receiver: its own failure is not sent to it.
    own: String,
    /// Kinds of alerts; `None`: all.
    kinds: Option<Vec<AlertKind>>,
    min_severity: Severity,
    /// Ids of active alerts of which notices were sent.
    known: BTreeSet<u64>,
}

impl NoticeSelection {
    pub(super) fn new(own: String, kinds: Option<Vec<AlertKind>>, min_severity: Severity) -> Self {
        Self { own, kinds, min_severity, known: BTreeSet::new() }
    }

    /// Whether the receiver wants alerts of this kind.
    pub(super) fn wants(&self, alert: &Alert) -> bool {
        let is_own = alert.kind == AlertKind::Service && alert.subject == self.own;
        !is_own && self.kinds.as_ref().is_none_or(|kinds| kinds.contains(&alert.kind))
    }

    pub(super) fn is_bad_enough(&self, alert: &Alert) -> bool {
        alert.severity >= self.min_severity
    }

    /// Whether a notice of this change is sent. Of a shelved alert only the shelving and the end are sent. An alert already
    /// sent is followed also below the minimum severity. The end is sent only if an earlier notice was.
    pub(super) fn admits(&mut self, change: AlertChange, alert: &Alert) -> bool {
        if change == AlertChange::Ended {
            return self.known.remove(&alert.id);
        }
        let is_quiet = alert.shelved.is_some() && change != AlertChange::Shelved;
        let is_known = self.known.contains(&alert.id);
        let is_admitted = self.wants(alert) && !is_quiet && (is_known || self.is_bad_enough(alert));
        if is_admitted {
            self.known.insert(alert.id);
        }
        is_admitted
    }

    /// Records that the alert was not sent after all.
    pub(super) fn forget(&mut self, alert: u64) {
        self.known.remove(&alert);
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::tests::{alert, shelved};
    use super::*;

    fn selection(min_severity: Severity) -> NoticeSelection {
        NoticeSelection::new(
            "webhook:own".to_owned(),
            Some(vec![AlertKind::Service, AlertKind::Area]),
            min_severity,
        )
    }

    fn of(id: u64, severity: Severity) -> Alert {
        Alert { severity, ..Alert::clone(&alert(id)) }
    }

    #[test]
    fn alert_above_the_severity_is_sent_until_its_end() {
        let mut selection = selection(Severity::Critical);
        let (warning, critical) = (of(1, Severity::Warning), of(1, Severity::Critical));
        assert!(!selection.admits(AlertChange::Began, &warning));
        assert!(!selection.admits(AlertChange::Acknowledged, &warning));
        assert!(selection.admits(AlertChange::Changed, &critical));
        assert!(selection.admits(AlertChange::Changed, &warning));
        assert!(selection.admits(AlertChange::Ended, &warning));
        assert!(!selection.admits(AlertChange::Began, &of(2, Severity::Warning)));
        assert!(!selection.admits(AlertChange::Ended, &of(2, Severity::Warning)));
    }

    #[test]
    fn shelved_alert_sends_only_shelving_and_end() {
        let mut selection = selection(Severity::Warning);
        let (open, quiet) = (alert(1), shelved(1));
        assert!(selection.admits(AlertChange::Began, &open));
        assert!(selection.admits(AlertChange::Shelved, &quiet));
        assert!(!selection.admits(AlertChange::Changed, &quiet));
        assert!(!selection.admits(AlertChange::Acknowledged, &quiet));
        assert!(selection.admits(AlertChange::Unshelved, &open));
        assert!(selection.admits(AlertChange::Shelved, &quiet));
        assert!(selection.admits(AlertChange::Ended, &quiet));
        // The alert began while shelved, so its beginning was not sent.
        assert!(!selection.admits(AlertChange::Began, &shelved(2)));
        assert!(!selection.admits(AlertChange::Ended, &shelved(2)));
    }

    #[test]
    fn other_kinds_and_own_failure_are_not_sent() {
        let mut selection = selection(Severity::Warning);
        let service = |subject: &str| Alert {
            kind: AlertKind::Service,
            subject: subject.to_owned(),
            ..Alert::clone(&alert(3))
        };
        assert!(!selection.admits(AlertChange::Began, &service("webhook:own")));
        assert!(selection.admits(AlertChange::Began, &service("webhook:other")));
        let silent = Alert { kind: AlertKind::Silent, ..Alert::clone(&alert(4)) };
        assert!(!selection.admits(AlertChange::Began, &silent));
    }
}
