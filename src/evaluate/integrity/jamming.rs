//! The alert `jamming`: how soon it is raised, and how often for nothing.

use std::collections::BTreeSet;

use fusion::time::Time;
use serde::Serialize;

use super::attacks::{Attack, AttackKind};
use crate::evaluate::types::Scoring;

/// So many transponders have to be jammed at a time.
const JAMMED: usize = 3;

/// A line of `replay --alerts`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alert {
    /// The same from the line with which it is raised to that with which it ends.
    pub id: String,
    /// What it is about.
    pub kind: String,
    /// Since when it is raised: the centre of a slot.
    pub since: Time,
    /// Until when, where it has ended.
    pub until: Option<Time>,
}

/// What became of alerts of kind `jamming`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Jamming {
    /// How many transponders are jammed.
    pub jammed: usize,
    /// From when three of them are jammed to the publication of the alert, seconds; `None`: there is none, or fewer are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Alerts raised while fewer than three were.
    pub false_alerts: usize,
}

impl Jamming {
    pub(super) fn of(alerts: &[Alert], attacks: &[Attack], settings: &Scoring) -> Self {
        let jammed: Vec<&Attack> =
            attacks.iter().filter(|attack| attack.kind == AttackKind::Jammed).collect();
        let at_a_time =
            |time: Time| jammed.iter().filter(|attack| (attack.from..=attack.until).contains(&time)).count();
        let mut begins: Vec<Time> = jammed.iter().map(|attack| attack.from).collect();
        begins.sort();
        let begin = begins.into_iter().find(|&begin| at_a_time(begin) >= JAMMED);
        let mut seen = BTreeSet::new();
        let raised = alerts.iter().filter(|alert| alert.kind == "jamming" && seen.insert(&alert.id));
        let (mut delay_s, mut false_alerts) = (None, 0);
        for alert in raised {
            let published = settings.grid.open(settings.grid.of(alert.since)) + settings.latency;
            match begin {
                Some(begin) if published >= begin && at_a_time(alert.since.max(begin)) >= JAMMED => {
                    delay_s.get_or_insert(published.seconds_since(begin));
                }
                _ => false_alerts += 1,
            }
        }
        Self { jammed: jammed.len(), delay_s, false_alerts }
    }
}
