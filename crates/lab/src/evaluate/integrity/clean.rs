//! False flags: flags on transponders that are not attacked.

use std::collections::BTreeMap;

use fusion::integrity::Reasons;
use fusion::time::Time;
use serde::{Serialize, Serializer};

use super::flags::{FlaggedPoint, flag_intervals};
use super::transponders::TransponderKey;
use crate::evaluate::types::OutputPoint;
use picture::Rfc3339;

/// Time that transponders reported correctly, and the flags raised during it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FalseFlagScore {
    /// Total time from each identity's first report to its last, or to the beginning of its attack, hours.
    pub identity_h: f64,
    /// Flags that begin within this time.
    pub flags: Vec<FalseFlag>,
}

/// A flag on an identity that reports correctly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FalseFlag {
    /// Number of the transponder.
    pub number: u32,
    /// Time at which the flag was first published.
    #[serde(serialize_with = "rfc3339")]
    pub from: Time,
    /// Time at which the flag was last published.
    #[serde(serialize_with = "rfc3339")]
    pub until: Time,
    /// Reasons of the flag.
    #[serde(serialize_with = "names")]
    pub reasons: Reasons,
}

impl FalseFlagScore {
    /// Counts from each transponder's reports, its flagged points, and the times from which it sends false reports.
    pub(super) fn of(
        (reports, reports_attacked): (
            &BTreeMap<TransponderKey<'_>, Vec<&OutputPoint>>,
            &BTreeMap<TransponderKey<'_>, Time>,
        ),
        (flagged, flagged_attacked): (
            &BTreeMap<TransponderKey<'_>, Vec<FlaggedPoint>>,
            &BTreeMap<TransponderKey<'_>, Time>,
        ),
    ) -> Self {
        let mut clean = Self::default();
        for (transponder, reports) in reports {
            let (Some(first), Some(last)) = (reports.first(), reports.last()) else { continue };
            let until = reports_attacked.get(transponder).map_or(last.time, |from| *from.min(&last.time));
            clean.identity_h += until.seconds_since(first.time).max(0.0) / 3600.0;
        }
        for (transponder, points) in flagged {
            let is_clean = |time: Time| flagged_attacked.get(transponder).is_none_or(|from| time < *from);
            let false_ones = flag_intervals(points).into_iter().filter(|flag| is_clean(flag.first.published));
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
