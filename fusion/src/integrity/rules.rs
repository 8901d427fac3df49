//! What shows by a transponder's reports alone.

use super::Reasons;
use crate::frames::Enu;
use crate::report::{Fix, Identity};
use crate::time::Time;

/// What the rules find of an identity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Finding {
    /// Rules that make it a suspect.
    pub(crate) suspect: Reasons,
    /// Rules that are certain: it has failed.
    pub(crate) failed: Reasons,
}

/// Who fell silent at once.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Jammed {
    pub(crate) identities: Vec<Identity>,
    /// Where they were heard last.
    pub(crate) places: Vec<Enu>,
    /// The first of their last reports.
    pub(crate) since: Time,
}

/// The reports of every identity, as received, and what they show.
#[derive(Debug, Default)]
pub(crate) struct ReportRules {}

impl ReportRules {
    /// Takes the reports that came since the last slot, by time, then identity, as received: nothing is taken off their
    /// times.
    pub(crate) fn take(&mut self, _fixes: &[Fix]) {}

    /// Looks at all identities at a slot's deadline, before [`ReportRules::finding`] is asked.
    pub(crate) fn look(&mut self, _deadline: Time) {}

    /// What they show of an identity.
    pub(crate) fn finding(&self, _identity: Identity) -> Finding {
        Finding::default()
    }

    /// Whether an identity has fallen silent, and its last report.
    pub(crate) fn silent_since(&self, _identity: Identity) -> Option<Time> {
        None
    }

    /// Who fell silent at once, while it lasts.
    pub(crate) fn jammed(&self) -> Option<&Jammed> {
        None
    }
}
