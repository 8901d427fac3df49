//! Flags on transponders that do not lie.

use std::collections::BTreeMap;

use fusion::integrity::Reasons;
use fusion::time::Time;
use serde::{Serialize, Serializer};

use super::flags::{Flagged, stretches};
use super::transponders::Transponder;
use crate::evaluate::types::OutputPoint;
use crate::picture::Rfc3339;

/// How long identities did not lie, and how often one was flagged all the same.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Clean {
    /// From each identity's first report to its last, or to the beginning of its attack, hours.
    pub identity_h: f64,
    /// The flags that begin within that.
    pub flags: Vec<FalseFlag>,
}

/// A flag on an identity that does not lie.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FalseFlag {
    /// The number of the transponder.
    pub number: u32,
    /// When it was first published.
    #[serde(serialize_with = "rfc3339")]
    pub from: Time,
    /// When it was last published.
    #[serde(serialize_with = "rfc3339")]
    pub until: Time,
    /// What was said.
    #[serde(serialize_with = "names")]
    pub reasons: Reasons,
}

impl Clean {
    /// Each transponder's reports, and its flagged points; beside them, from when on it lies.
    pub(super) fn of(
        (reports, reports_lie): (
            &BTreeMap<Transponder<'_>, Vec<&OutputPoint>>,
            &BTreeMap<Transponder<'_>, Time>,
        ),
        (flagged, flagged_lie): (&BTreeMap<Transponder<'_>, Vec<Flagged>>, &BTreeMap<Transponder<'_>, Time>),
    ) -> Self {
        let mut clean = Self::default();
        for (transponder, reports) in reports {
            let (Some(first), Some(last)) = (reports.first(), reports.last()) else { continue };
            let until = reports_lie.get(transponder).map_or(last.time, |from| *from.min(&last.time));
            clean.identity_h += until.seconds_since(first.time).max(0.0) / 3600.0;
        }
        for (transponder, points) in flagged {
            let is_clean = |time: Time| flagged_lie.get(transponder).is_none_or(|from| time < *from);
            let false_ones = stretches(points).into_iter().filter(|flag| is_clean(flag.first.published));
            clean.flags.extend(false_ones.map(|flag| FalseFlag {
                number: flag.first.number,
                from: flag.first.published,
                until: flag.last.published,
                reasons: flag.reasons,
            }));
        }
        clean
    }
}

fn rfc3339<S: Serializer>(time: &Time, to: S) -> Result<S::Ok, S::Error> {
    Rfc3339(*time).serialize(to)
}

fn names<S: Serializer>(reasons: &Reasons, to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(reasons.iter().map(fusion::integrity::Reason::name))
}
