//! What the flags say of each attack.

use fusion::integrity::{Reason, Reasons};
use fusion::time::Time;
use serde::{Serialize, Serializer};

use super::attacks::{Attack, AttackKind};
use super::course::Course;
use super::flags::Flagged;
use super::shown::Shown;
use crate::picture::Rfc3339;

/// An attack, and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Detection {
    /// The drone's id.
    pub id: String,
    /// The number of its transponder.
    pub number: u32,
    /// What was done.
    #[serde(serialize_with = "kind_name")]
    pub kind: AttackKind,
    /// From when delays count: the stamp of the first lying report; of a drift when its offset passes 40 m. `None`: it never
    /// came so far, and does not count.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "rfc3339")]
    pub begin: Option<Time>,
    /// Distinct seconds with a plot of the drone, of a track that had not walked off, while they count.
    pub seen_s: usize,
    /// Whether these are enough for a radar to find it.
    pub is_observable: bool,
    /// Whether a silence of the transponder of more than 8 s keeps rules on its reports alone from finding it in time.
    pub is_silent: bool,
    /// Seconds from there to the first flag; below 0 where a drift was flagged before it counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// The first flag with each reason: seconds from there.
    #[serde(serialize_with = "by_reason")]
    pub reasons: Vec<(Reason, f64)>,
    /// What the output shows of the drone while its transponder is flagged.
    pub shown: Shown,
}

impl Detection {
    /// `flagged`: the flagged points of its number, by slot.
    pub(super) fn new(attack: &Attack, course: &Course, flagged: &[Flagged], shown: Shown) -> Self {
        // A drift lies before it counts.
        let lies = match attack.kind {
            AttackKind::Drift => Some(attack.from),
            _ => course.begin,
        };
        let during: Vec<&Flagged> = flagged
            .iter()
            .filter(|flag| lies.is_some_and(|lies| flag.published >= lies) && flag.time < attack.until)
            .collect();
        let delay_s = |flag: &&Flagged| Some(flag.published.seconds_since(course.begin?));
        let first_with = |reason: Reason| {
            let first = during.iter().copied().find(|flag| flag.reasons.contains(reason))?;
            Some((reason, delay_s(&first)?))
        };
        Self {
            id: attack.id.clone(),
            number: attack.number,
            kind: attack.kind,
            begin: course.begin,
            seen_s: course.seen_s,
            is_observable: course.is_observable(),
            is_silent: course.is_silent,
            delay_s: during.first().and_then(delay_s),
            reasons: Reason::ALL.into_iter().filter_map(first_with).collect(),
            shown,
        }
    }

    /// Seconds to the first flag with this reason.
    pub fn delay_by_s(&self, reason: Reason) -> Option<f64> {
        self.reasons.iter().find(|(of, _)| *of == reason).map(|(_, delay_s)| *delay_s)
    }

    /// Seconds to the first flag that names what was done; of a drift to the first flag.
    pub fn named_delay_s(&self) -> Option<f64> {
        match self.kind.reason() {
            Some(reason) => self.delay_by_s(reason),
            None => self.delay_s,
        }
    }

    /// Everything that was said against it.
    pub fn said(&self) -> Reasons {
        self.reasons.iter().map(|(reason, _)| *reason).collect()
    }
}

fn kind_name<S: Serializer>(kind: &AttackKind, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(kind.name())
}

fn rfc3339<S: Serializer>(time: &Option<Time>, to: S) -> Result<S::Ok, S::Error> {
    time.map(Rfc3339).serialize(to)
}

fn by_reason<S: Serializer>(reasons: &[(Reason, f64)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(reasons.iter().map(|(reason, delay_s)| (reason.name(), delay_s)))
}
