//! The flags of an output: from when to when an identity was suspect or failed.

use std::collections::BTreeMap;

use fusion::integrity::Reasons;
use fusion::slots::Slot;
use fusion::time::Time;

use super::course::later;
use super::transponders::Transponder;
use crate::evaluate::types::{OutputPoint, Scoring};

/// Flags of one identity that are less than this apart are one, seconds.
const ONE_FLAG_S: f64 = 5.0;

/// A point that says that its transponder is suspect or failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Flagged {
    /// The service's number of the transponder.
    pub(super) number: u32,
    pub(super) slot: Slot,
    /// What it is of.
    pub(super) time: Time,
    /// When it was published.
    pub(super) published: Time,
    pub(super) reasons: Reasons,
}

/// A stretch of flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stretch {
    pub(super) first: Flagged,
    pub(super) last: Flagged,
    /// Everything that was said against it.
    pub(super) reasons: Reasons,
}

/// The flagged points of each transponder, by slot.
pub(super) fn by_transponder<'a>(
    output: &'a [OutputPoint],
    settings: &Scoring,
) -> BTreeMap<Transponder<'a>, Vec<Flagged>> {
    let mut flagged: BTreeMap<Transponder<'a>, Vec<Flagged>> = BTreeMap::new();
    for point in output {
        let Some((number, (state, reasons))) = point.transponder.zip(point.flags.integrity) else { continue };
        let Some(transponder) = Transponder::of(point) else { continue };
        if state.is_flagged() {
            let slot = settings.grid.of(point.time);
            let published = settings.grid.open(slot) + settings.latency;
            let flag = Flagged { number, slot, time: point.time, published, reasons };
            flagged.entry(transponder).or_default().push(flag);
        }
    }
    flagged.values_mut().for_each(|points| points.sort_by_key(|point| point.slot)); // stable
    flagged
}

/// Points that are one flag, in order.
pub(super) fn stretches(points: &[Flagged]) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for &point in points {
        match stretches.last_mut() {
            Some(stretch) if point.published < later(stretch.last.published, ONE_FLAG_S) => {
                stretch.last = point;
                stretch.reasons = stretch.reasons.or(point.reasons);
            }
            _ => stretches.push(Stretch { first: point, last: point, reasons: point.reasons }),
        }
    }
    stretches
}
