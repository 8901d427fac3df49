//! Flags of an output: intervals in which an identity was suspect or failed.

use std::collections::BTreeMap;

use fusion::integrity::Reasons;
use fusion::slots::Slot;
use fusion::time::Time;

use super::course::later;
use super::transponders::TransponderKey;
use crate::evaluate::types::{OutputPoint, Scoring};

/// Flags of one identity less than this apart are one flag, seconds.
const ONE_FLAG_S: f64 = 5.0;

/// A point whose transponder is suspect or failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FlaggedPoint {
    /// The service's number of the transponder.
    pub(super) number: u32,
    pub(super) slot: Slot,
    /// Time of applicability of the point.
    pub(super) time: Time,
    /// Time of publication.
    pub(super) published: Time,
    pub(super) reasons: Reasons,
}

/// An interval of flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FlagInterval {
    pub(super) first: FlaggedPoint,
    pub(super) last: FlaggedPoint,
    /// All reasons within the interval.
    pub(super) reasons: Reasons,
}

/// Flagged points of each transponder, by slot.
pub(super) fn by_transponder<'a>(
    output: &'a [OutputPoint],
    settings: &Scoring,
) -> BTreeMap<TransponderKey<'a>, Vec<FlaggedPoint>> {
    let mut flagged: BTreeMap<TransponderKey<'a>, Vec<FlaggedPoint>> = BTreeMap::new();
    for point in output {
        let Some((number, (state, reasons))) = point.transponder.zip(point.flags.integrity) else { continue };
        let Some(transponder) = TransponderKey::of(point) else { continue };
        if state.is_flagged() {
            let slot = settings.grid.of(point.time);
            let published = settings.grid.open(slot) + settings.latency;
            let flag = FlaggedPoint { number, slot, time: point.time, published, reasons };
            flagged.entry(transponder).or_default().push(flag);
        }
    }
    flagged.values_mut().for_each(|points| points.sort_by_key(|point| point.slot)); // stable
    flagged
}

/// Groups flagged points, in order, into flags.
pub(super) fn flag_intervals(points: &[FlaggedPoint]) -> Vec<FlagInterval> {
    let mut flag_intervals: Vec<FlagInterval> = Vec::new();
    for &point in points {
        match flag_intervals.last_mut() {
            Some(stretch) if point.published < later(stretch.last.published, ONE_FLAG_S) => {
                stretch.last = point;
                stretch.reasons = stretch.reasons.or(point.reasons);
            }
            _ => flag_intervals.push(FlagInterval { first: point, last: point, reasons: point.reasons }),
        }
    }
    flag_intervals
}
