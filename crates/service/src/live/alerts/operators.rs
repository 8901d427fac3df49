//! Operators' decisions about alerts: they acknowledge an alert, or shelve it, which suppresses its notifications for a
//! time.

use std::collections::BTreeMap;

use jiff::SignedDuration;

use super::{Alert, AlertChange, AlertKey, AlertKind, AlertMonitor};
use crate::state::{AlertAct, AlertDecision, alert_line};
use fusion::time::Time;

/// Maximum number of shelved alerts.
const SHELVES: usize = 1_000;

/// An operator's request about an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlertRequest {
    /// Id of the alert in the API.
    pub id: String,
    /// Requested action.
    pub action: AlertAction,
    /// Name of the operator.
    pub by: String,
    /// Operator's note.
    pub note: Option<String>,
}

/// Actions on an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlertAction {
    /// Acknowledges the alert.
    Acknowledge,
    /// Suppresses notifications of the alert for this long.
    Shelve(SignedDuration),
    /// Ends the shelving.
    Unshelve,
}

/// Reasons for refusing a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlertRequestError {
    /// The alert never existed, or is no longer kept.
    #[error("there is no such alert")]
    Unknown,
    /// The alert has ended.
    #[error("the alert has ended")]
    Ended,
    /// The alert is not shelved.
    #[error("the alert is not shelved")]
    NotShelved,
    /// The maximum number of alerts is shelved.
    #[error("as many alerts are shelved as can be ({SHELVES}); take one back first")]
    Full,
    /// The queue of requests is full.
    #[error("too many decisions about alerts wait")]
    Busy,
    /// The observer, which owns the alerts, has stopped.
    #[error("the alerts do not answer")]
    Gone,
}

/// Acknowledgement of an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Acknowledgement {
    /// Name of the operator.
    pub by: String,
    /// Time of the acknowledgement.
    pub at: Time,
    /// Operator's note.
    pub note: Option<String>,
}

/// Suppresses notifications of an alert until it expires or is unshelved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shelved {
    /// Name of the operator.
    pub by: String,
    /// Start of the shelving.
    pub at: Time,
    /// End of the shelving.
    pub until: Time,
    /// Operator's note.
    pub note: Option<String>,
}

/// Input from which alerts are derived. The order of inputs and decisions is recorded, so that a replay repeats it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum AlertInput {
    /// The picture of each slot.
    Picture,
    /// The conflicts of each second.
    Outlook,
    /// The state of sensors and service.
    Status,
}

impl AlertInput {
    const fn of(kind: AlertKind) -> Self {
        match kind {
            AlertKind::Sensor | AlertKind::Service | AlertKind::Registration => Self::Status,
            AlertKind::Conflict => Self::Outlook,
            AlertKind::Area
            | AlertKind::AreaPredicted
            | AlertKind::Integrity
            | AlertKind::Jamming
            | AlertKind::Silent
            | AlertKind::Height
            | AlertKind::Uncooperative
            | AlertKind::Emergency => Self::Picture,
        }
    }
}

/// Decisions of operators in force, and those of a recording that are still to be carried out.
#[derive(Debug, Default)]
pub(super) struct AlertDecisions {
    /// Shelved alerts, with the decision for each.
    shelves: BTreeMap<AlertKey, AlertDecision>,
    /// Whether the shelved alerts have changed since they were last taken.
    has_changed: bool,
    /// Time up to which alerts were derived, by input.
    derived: BTreeMap<AlertInput, Time>,
    /// Decisions of a recording in order, and the number carried out, by input.
    plan: BTreeMap<AlertInput, (Vec<AlertDecision>, usize)>,
}

impl AlertDecisions {
    /// Resets the state to the beginning of a recording.
    pub(super) fn rewind(&mut self) {
        self.shelves.clear();
        self.derived.clear();
        self.plan.values_mut().for_each(|(_, done)| *done = 0);
    }

    /// The shelving in force for a new alert.
    pub(super) fn shelf(&self, key: &AlertKey) -> Option<Shelved> {
        let AlertDecision { act: AlertAct::Shelved { until }, by, at, note, .. } = self.shelves.get(key)?
        else {
            return None;
        };
        Some(Shelved { by: by.clone(), at: *at, until: *until, note: note.clone() })
    }

    /// Next decision of the recording that precedes what is derived now.
    fn next(&mut self, basis: AlertInput, now: Time) -> Option<AlertDecision> {
        let (decisions, done) = self.plan.get_mut(&basis)?;
        let next = decisions.get(*done).filter(|decision| decision.after < now)?;
        *done += 1;
        Some(next.clone())
    }
}

impl AlertMonitor {
    /// Adds decisions of a recording, to be carried out at their times.
    pub fn plan(&mut self, decisions: Vec<AlertDecision>) {
        for decision in decisions {
            self.decisions.plan.entry(AlertInput::of(decision.kind)).or_default().0.push(decision);
        }
    }

    /// Restores the shelved alerts after a restart, unless they have expired.
    pub fn resume(&mut self, decisions: &[AlertDecision], now: Time) {
        let is_in_force = |act| matches!(act, AlertAct::Shelved { until } if until > now);
        decisions.iter().filter(|decision| is_in_force(decision.act)).for_each(|decision| {
            self.carry_out(decision);
        });
    }

    /// Carries out an operator's request. Returns the decision for the recording, and the alert after it.
    ///
    /// # Errors
    /// There is no such active alert, or the action does not apply to it.
    pub fn decide(
        &mut self,
        request: &AlertRequest,
        now: Time,
    ) -> Result<(AlertDecision, Alert), AlertRequestError> {
        let AlertRequest { id, action, by, note } = request;
        let lasting = self.lasting.values().map(|(alert, _)| alert);
        let mut all = lasting.chain(self.ended.iter().map(|alert| &**alert));
        let alert = all.find(|alert| alert.name() == *id).ok_or(AlertRequestError::Unknown)?;
        // A latched alert can still be acknowledged.
        if alert.until.is_some() && !(alert.is_latched && *action == AlertAction::Acknowledge) {
            return Err(AlertRequestError::Ended);
        }
        let (kind, subject, area) = (&alert.kind, &alert.subject, alert.details.area());
        let at = whole_milliseconds(now);
        let act = match action {
            AlertAction::Acknowledge => AlertAct::Acknowledged,
            AlertAction::Shelve(_) if self.decisions.shelves.len() >= SHELVES && alert.shelved.is_none() => {
                return Err(AlertRequestError::Full);
            }
            AlertAction::Shelve(span) => AlertAct::Shelved { until: whole_milliseconds(at + *span) },
            AlertAction::Unshelve if alert.shelved.is_none() => return Err(AlertRequestError::NotShelved),
            AlertAction::Unshelve => AlertAct::Unshelved,
        };
        let decision = AlertDecision {
            kind: *kind,
            subject: subject.clone(),
            area: area.to_owned(),
            act,
            by: by.clone(),
            at,
            note: note.clone(),
            after: self.decisions.derived.get(&AlertInput::of(*kind)).copied().unwrap_or_default(),
        };
        let alert = self.carry_out(&decision).ok_or(AlertRequestError::Ended)?;
        let ended = self.ended.iter().find(|ended| ended.name() == *id);
        let alert = ended.map_or(alert, |ended| (**ended).clone());
        Ok((decision, alert))
    }

    /// Time of the last picture.
    pub fn pictured(&self) -> Option<Time> {
        self.pictured
    }

    /// Lines of the shelved alerts, if they have changed since the last call.
    pub fn take_shelves(&mut self) -> Option<String> {
        let has_changed = std::mem::take(&mut self.decisions.has_changed);
        has_changed.then(|| self.decisions.shelves.values().map(alert_line).collect())
    }

    /// Carries out the recorded decisions that precede an input of this time; called before alerts are derived from it.
    pub(super) fn derive(&mut self, basis: AlertInput, now: Time) {
        while let Some(decision) = self.decisions.next(basis, now) {
            self.carry_out(&decision);
        }
        self.decisions.derived.insert(basis, now);
    }

    /// Ends the shelvings that have expired.
    pub(super) fn unshelve(&mut self, kind: AlertKind, now: Time) {
        let is_over = |act| matches!(act, AlertAct::Shelved { until } if until <= now);
        let over = |(key, decision): (&AlertKey, &AlertDecision)| {
            (key.0 == kind && is_over(decision.act)).then(|| key.clone())
        };
        let over: Vec<AlertKey> = self.decisions.shelves.iter().filter_map(over).collect();
        for key in over {
            self.decisions.shelves.remove(&key);
            self.decisions.has_changed = true;
            self.mark(&key, AlertChange::Unshelved, |alert| alert.shelved = None);
        }
    }

    /// Carries out a decision; returns the alert after it, if it is active or was latched.
    fn carry_out(&mut self, decision: &AlertDecision) -> Option<Alert> {
        let AlertDecision { kind, subject, area, act, by, at, note, .. } = decision;
        let key = (*kind, subject.clone(), area.clone());
        match act {
            AlertAct::Acknowledged => {
                let seen = Acknowledgement { by: by.clone(), at: *at, note: note.clone() };
                // An ended alert about the same is covered too.
                let ended = self.unlatch(&key, Some(&seen));
                let change = AlertChange::Acknowledged;
                self.changes.extend(ended.iter().map(|alert| (change, alert.clone())));
                self.mark(&key, change, |alert| alert.acknowledged = Some(seen)).or(ended)
            }
            AlertAct::Shelved { .. } => {
                self.decisions.shelves.insert(key.clone(), decision.clone());
                self.decisions.has_changed = true;
                let shelf = self.decisions.shelf(&key);
                self.mark(&key, AlertChange::Shelved, |alert| alert.shelved = shelf)
            }
            AlertAct::Unshelved => {
                self.decisions.shelves.remove(&key);
                self.decisions.has_changed = true;
                self.mark(&key, AlertChange::Unshelved, |alert| alert.shelved = None)
            }
        }
    }

    /// Changes an active alert.
    fn mark(&mut self, key: &AlertKey, change: AlertChange, mark: impl FnOnce(&mut Alert)) -> Option<Alert> {
        let (alert, _) = self.lasting.get_mut(key)?;
        mark(alert);
        alert.revision += 1;
        self.changes.push((change, alert.clone()));
        Some(alert.clone())
    }
}

/// Truncates to the precision of the recording, so that live and replay use the same time.
fn whole_milliseconds(time: Time) -> Time {
    const MILLISECOND: i64 = 1_000_000;
    Time::from_nanos(time.nanos().div_euclid(MILLISECOND) * MILLISECOND)
}
