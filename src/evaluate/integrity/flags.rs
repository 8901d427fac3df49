//! The flags of an output: from when to when an identity was suspect or failed.

use std::collections::BTreeMap;

use fusion::integrity::Reasons;
use fusion::slots::Slot;
use fusion::time::Time;

use super::course::later;
use crate::evaluate::types::{OutputPoint, Scoring};

/// Flags of one identity that are less than this apart are one, seconds.
const ONE_FLAG_S: f64 = 5.0;

/// A point that says that its transponder is suspect or failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Flagged {
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

/// The flagged points of each transponder number, by slot.
pub(super) fn by_number(output: &[OutputPoint], settings: &Scoring) -> BTreeMap<u32, Vec<Flagged>> {
    let mut flagged: BTreeMap<u32, Vec<Flagged>> = BTreeMap::new();
    for point in output {
        let Some((number, (state, reasons))) = point.transponder.zip(point.flags.integrity) else { continue };
        if state.is_flagged() {
            let slot = settings.grid.of(point.time);
            let published = settings.grid.open(slot) + settings.latency;
            flagged.entry(number).or_default().push(Flagged { slot, time: point.time, published, reasons });
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
