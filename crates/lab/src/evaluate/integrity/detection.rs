//! Detection of each attack by the flags of the output.

use fusion::integrity::{Reason, Reasons};
use fusion::time::Time;
use serde::{Serialize, Serializer};

use super::attacks::{Attack, AttackKind};
use super::course::AttackCourse;
use super::flags::FlaggedPoint;
use super::shown::FlaggedCoverage;
use picture::Rfc3339;

/// An attack and its detection.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttackDetection {
    /// Id of the drone.
    pub id: String,
    /// Number of its transponder.
    pub number: u32,
    /// Kind of attack.
    #[serde(serialize_with = "kind_name")]
    pub kind: AttackKind,
    /// Time from which delays count: the time stamp of the first false report, or for a drift the time when its offset
    /// passes 40 m. `None`: there is no such time, and the attack does not count.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "rfc3339")]
    pub begin: Option<Time>,
    /// Number of distinct seconds with a plot of the drone, of a track that is not seduced, while plots count.
    pub seen_s: usize,
    /// Whether `seen_s` is large enough for detection by radar.
    pub is_observable: bool,
    /// Whether a silence of more than 8 s prevents rules on the transponder's reports alone from detecting the attack
    /// in time.
    pub is_silent: bool,
    /// Time from `begin` to the first flag, seconds; negative if a drift was flagged before delays count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// First flag with each reason: time since `begin`, seconds.
    #[serde(serialize_with = "by_reason")]
    pub reasons: Vec<(Reason, f64)>,
    /// Output for the drone while its transponder is flagged.
    pub shown: FlaggedCoverage,
}

impl AttackDetection {
    /// Detection of `attack`, from the flagged points of its number, by slot.
    pub(super) fn new(
        attack: &Attack,
        course: &AttackCourse,
        flagged: &[FlaggedPoint],
        shown: FlaggedCoverage,
    ) -> Self {
        // A drift sends false positions before delays count.
        let attack_begins = match attack.kind {
            AttackKind::Drift => Some(attack.from),
            _ => course.begin,
        };
        let during: Vec<&FlaggedPoint> = flagged
            .iter()
            .filter(|flag| {
                attack_begins.is_some_and(|attack_begins| flag.published >= attack_begins)
                    && flag.time < attack.until
            })
            .collect();
        let delay_s = |flag: &&FlaggedPoint| Some(flag.published.seconds_since(course.begin?));
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

    /// Delay of the first flag with this reason, seconds.
    pub fn delay_by_s(&self, reason: Reason) -> Option<f64> {
        self.reasons.iter().find(|(of, _)| *of == reason).map(|(_, delay_s)| *delay_s)
    }

    /// Delay of the first flag that identifies the attack, or for a drift of the first flag, seconds.
    pub fn named_delay_s(&self) -> Option<f64> {
        match self.kind.reason() {
            Some(reason) => self.delay_by_s(reason),
            None => self.delay_s,
        }
    }

    /// All reasons that were published for the transponder.
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
