//! The alert `jamming`: its delay, and false alerts.

use std::collections::BTreeSet;

use fusion::time::Time;
use serde::Serialize;

use super::attacks::{Attack, AttackKind};
use crate::evaluate::types::Scoring;

/// Minimum number of transponders jammed at the same time.
const JAMMED: usize = 3;

/// A line written by `replay --alerts`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlertLine {
    /// Id, the same from the line that raises the alert to the line that ends it.
    pub id: String,
    /// Kind of alert.
    pub kind: String,
    /// Time since which the alert is raised: the centre of a slot.
    pub since: Time,
    /// Time at which the alert ended; `None` if it is still raised.
    pub until: Option<Time>,
    /// Whether it is critical at this line.
    pub is_critical: bool,
    /// Ids of the tracks that it is about.
    pub tracks: Vec<String>,
    /// Serial number of the transponder that it is about.
    pub identity: Option<String>,
    /// Name of the area that it is about.
    pub area: Option<String>,
    /// Text of the alert.
    pub text: String,
}

/// Score of alerts of kind `jamming`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct JammingScore {
    /// Number of jammed transponders.
    pub jammed: usize,
    /// Time from the moment when three transponders are jammed to the publication of the alert, seconds; `None`: no
    /// alert, or fewer than three jammed at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Number of alerts raised while fewer than three transponders were jammed.
    pub false_alerts: usize,
}

impl JammingScore {
    pub(super) fn of(alerts: &[AlertLine], attacks: &[Attack], settings: &Scoring) -> Self {
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
