//! What operators do about alerts: they acknowledge that they have seen one, and shelve what nobody is to be bothered with.

use std::collections::BTreeMap;

use jiff::SignedDuration;

use super::{Alert, AlertKind, Alerts, Change, Key};
use crate::state::{AlertAct, AlertDecision, alert_line};
use fusion::time::Time;

/// Most that is shelved at a time.
const SHELVES: usize = 1_000;

/// What an operator asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlertWish {
    /// Id of the alert, as readers know it.
    pub id: String,
    /// What is to be done about it.
    pub wanted: Wanted,
    /// Who asks.
    pub by: String,
    /// What he says to it.
    pub note: Option<String>,
}

/// What can be done about an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// It is seen.
    Acknowledge,
    /// It bothers nobody for this long.
    Shelve(SignedDuration),
    /// It does again.
    Unshelve,
}

/// Why nothing is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotDone {
    /// It never was, or is forgotten.
    #[error("there is no such alert")]
    Unknown,
    /// It is over.
    #[error("the alert has ended")]
    Ended,
    /// There is nothing to take back.
    #[error("the alert is not shelved")]
    NotShelved,
    /// There are too many.
    #[error("as many alerts are shelved as can be ({SHELVES}); take one back first")]
    Full,
    /// Too many wait.
    #[error("too many decisions about alerts wait")]
    Busy,
    /// Nobody looks after alerts any more.
    #[error("the alerts do not answer")]
    Gone,
}

/// That somebody has seen an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Acknowledged {
    /// Who.
    pub by: String,
    /// When.
    pub at: Time,
    /// What he says to it.
    pub note: Option<String>,
}

/// That nobody is to be bothered with an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shelved {
    /// Who says so.
    pub by: String,
    /// Since when.
    pub at: Time,
    /// Until when.
    pub until: Time,
    /// What he says to it.
    pub note: Option<String>,
}

/// What alerts are derived from; a decision has its place between two of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Basis {
    /// Each slot's picture.
    Picture,
    /// The conflicts of each second.
    Outlook,
    /// The state of sensors and service.
    Status,
}

impl Basis {
    const fn of(kind: AlertKind) -> Self {
        match kind {
            AlertKind::Sensor | AlertKind::Service | AlertKind::Registration => Self::Status,
            AlertKind::Conflict => Self::Outlook,
            AlertKind::Area
            | AlertKind::AreaPredicted
            | AlertKind::Integrity
            | AlertKind::Jamming
            | AlertKind::Silent
            | AlertKind::Uncooperative
            | AlertKind::Emergency => Self::Picture,
        }
    }
}

/// What operators have decided, and will decide where that is known from a recording.
#[derive(Debug, Default)]
pub(super) struct Operators {
    /// What is shelved, by the decision.
    shelves: BTreeMap<Key, AlertDecision>,
    /// Whether that is news to whoever keeps it.
    is_news: bool,
    /// Up to when alerts have been derived.
    derived: BTreeMap<Basis, Time>,
    /// Decisions of a recording, in the order in which they count, and how many have been carried out.
    plan: BTreeMap<Basis, (Vec<AlertDecision>, usize)>,
}

impl Operators {
    /// As at the beginning of a recording.
    pub(super) fn rewind(&mut self) {
        self.shelves.clear();
        self.derived.clear();
        self.plan.values_mut().for_each(|(_, done)| *done = 0);
    }

    /// What holds for a new alert.
    pub(super) fn shelf(&self, key: &Key) -> Option<Shelved> {
        let AlertDecision { act: AlertAct::Shelved { until }, by, at, note, .. } = self.shelves.get(key)?
        else {
            return None;
        };
        Some(Shelved { by: by.clone(), at: *at, until: *until, note: note.clone() })
    }

    /// The next decision of the recording that counts before what is derived now.
    fn next(&mut self, basis: Basis, now: Time) -> Option<AlertDecision> {
        let (decisions, done) = self.plan.get_mut(&basis)?;
        let next = decisions.get(*done).filter(|decision| decision.after < now)?;
        *done += 1;
        Some(next.clone())
    }
}

impl Alerts {
    /// Decisions that are made when their time comes: those of a recording.
    pub fn plan(&mut self, decisions: Vec<AlertDecision>) {
        for decision in decisions {
            self.operators.plan.entry(Basis::of(decision.kind)).or_default().0.push(decision);
        }
    }

    /// What was shelved before a restart, as far as it still is.
    pub fn resume(&mut self, decisions: &[AlertDecision], now: Time) {
        let is_in_force = |act| matches!(act, AlertAct::Shelved { until } if until > now);
        decisions.iter().filter(|decision| is_in_force(decision.act)).for_each(|decision| {
            self.carry_out(decision);
        });
    }

    /// Does what an operator asks for at a time; the decision for the record, and the alert as it is then.
    ///
    /// # Errors
    /// There is no such alert that lasts, or that cannot be done about it.
    pub fn decide(&mut self, wish: &AlertWish, now: Time) -> Result<(AlertDecision, Alert), NotDone> {
        let AlertWish { id, wanted, by, note } = wish;
        let lasting = self.lasting.iter().find(|(_, (alert, _))| alert.name() == *id);
        let Some(((kind, subject, area), (alert, _))) = lasting else {
            let has_ended = self.ended.iter().any(|alert| alert.name() == *id);
            return Err(if has_ended { NotDone::Ended } else { NotDone::Unknown });
        };
        let at = whole_milliseconds(now);
        let act = match wanted {
            Wanted::Acknowledge => AlertAct::Acknowledged,
            Wanted::Shelve(_) if self.operators.shelves.len() >= SHELVES && alert.shelved.is_none() => {
                return Err(NotDone::Full);
            }
            Wanted::Shelve(span) => AlertAct::Shelved { until: whole_milliseconds(at + *span) },
            Wanted::Unshelve if alert.shelved.is_none() => return Err(NotDone::NotShelved),
            Wanted::Unshelve => AlertAct::Unshelved,
        };
        let decision = AlertDecision {
            kind: *kind,
            subject: subject.clone(),
            area: area.clone(),
            act,
            by: by.clone(),
            at,
            note: note.clone(),
            after: self.operators.derived.get(&Basis::of(*kind)).copied().unwrap_or_default(),
        };
        let alert = self.carry_out(&decision).ok_or(NotDone::Ended)?;
        Ok((decision, alert))
    }

    /// The time of the last picture.
    pub fn pictured(&self) -> Option<Time> {
        self.pictured
    }

    /// The lines of what is shelved, where that has changed since the last call.
    pub fn take_shelves(&mut self) -> Option<String> {
        let is_news = std::mem::take(&mut self.operators.is_news);
        is_news.then(|| self.operators.shelves.values().map(alert_line).collect())
    }

    /// Alerts are about to be derived from something of that time: what was decided before comes first.
    pub(super) fn derive(&mut self, basis: Basis, now: Time) {
        while let Some(decision) = self.operators.next(basis, now) {
            self.carry_out(&decision);
        }
        self.operators.derived.insert(basis, now);
    }

    /// What was shelved until now bothers again.
    pub(super) fn unshelve(&mut self, kind: AlertKind, now: Time) {
        let is_over = |act| matches!(act, AlertAct::Shelved { until } if until <= now);
        let over = |(key, decision): (&Key, &AlertDecision)| {
            (key.0 == kind && is_over(decision.act)).then(|| key.clone())
        };
        let over: Vec<Key> = self.operators.shelves.iter().filter_map(over).collect();
        for key in over {
            self.operators.shelves.remove(&key);
            self.operators.is_news = true;
            self.mark(&key, Change::Unshelved, |alert| alert.shelved = None);
        }
    }

    /// Does it; the alert as it is then, where it lasts.
    fn carry_out(&mut self, decision: &AlertDecision) -> Option<Alert> {
        let AlertDecision { kind, subject, area, act, by, at, note, .. } = decision;
        let key = (*kind, subject.clone(), area.clone());
        match act {
            AlertAct::Acknowledged => {
                let seen = Acknowledged { by: by.clone(), at: *at, note: note.clone() };
                self.mark(&key, Change::Acknowledged, |alert| alert.acknowledged = Some(seen))
            }
            AlertAct::Shelved { .. } => {
                self.operators.shelves.insert(key.clone(), decision.clone());
                self.operators.is_news = true;
                let shelf = self.operators.shelf(&key);
                self.mark(&key, Change::Shelved, |alert| alert.shelved = shelf)
            }
            AlertAct::Unshelved => {
                self.operators.shelves.remove(&key);
                self.operators.is_news = true;
                self.mark(&key, Change::Unshelved, |alert| alert.shelved = None)
            }
        }
    }

    /// Changes an alert that lasts.
    fn mark(&mut self, key: &Key, change: Change, mark: impl FnOnce(&mut Alert)) -> Option<Alert> {
        let (alert, _) = self.lasting.get_mut(key)?;
        mark(alert);
        alert.revision += 1;
        self.changes.push((change, alert.clone()));
        Some(alert.clone())
    }
}

/// As times are written: what is recorded is what holds.
fn whole_milliseconds(time: Time) -> Time {
    const MILLISECOND: i64 = 1_000_000;
    Time::from_nanos(time.nanos().div_euclid(MILLISECOND) * MILLISECOND)
}
