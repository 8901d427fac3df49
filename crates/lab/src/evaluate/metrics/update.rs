//! Probability of update.

use std::collections::BTreeSet;

use super::scene::StreamScene;
use super::statistics::ratio;
use crate::evaluate::scored_point::ScoredPoint;

/// Maximum distance from the true position at which a point counts as near, metres: the cut-off of GOSPA.
const NEAR_M: f64 = 50.0;

/// Share of the drones' counted slots with at least one point, percent (section 4 of the paper, which uses 4 Hz).
pub(in crate::evaluate) fn probability_percent(scene: &StreamScene<'_>, group: &[usize]) -> Option<f64> {
    let updated = |drone: &usize| {
        scene.drones[*drone].iter().map(|scored_point| scored_point.slot).collect::<BTreeSet<_>>()
    };
    let updated: usize = group.iter().map(|drone| updated(drone).len()).sum();
    let slots = group.iter().map(|&drone| scene.counted.slots(drone)).sum();
    ratio(updated as u64, slots).map(|share| 100.0 * share)
}

/// [`probability_percent`] over the slots in which an equipped drone's transponder interpolates (`covered`), or over
/// its other slots. `None` without a capture or without such slots.
pub(in crate::evaluate) fn probability_percent_where(
    scene: &StreamScene<'_>,
    group: &[usize],
    covered: bool,
) -> Option<f64> {
    share_percent(scene, group, covered, |_| true)
}

/// Among the slots in which an equipped drone's transponder does not interpolate: share with a point within [`NEAR_M`]
/// of the drone, percent.
pub(in crate::evaluate) fn gap_near_percent(scene: &StreamScene<'_>, group: &[usize]) -> Option<f64> {
    share_percent(scene, group, false, |scored_point| {
        scored_point.error.is_some_and(|error| error.distance_m() <= NEAR_M)
    })
}

/// Share of the covered or of the other slots of equipped drones that have a point for which `passes` holds, percent.
fn share_percent(
    scene: &StreamScene<'_>,
    group: &[usize],
    covered: bool,
    passes: impl Fn(&ScoredPoint<'_>) -> bool,
) -> Option<f64> {
    let inputs = scene.inputs?;
    let (mut updated, mut slots) = (0, 0);
    for &drone in group.iter().filter(|&&drone| inputs.equipped[drone]) {
        // All covered slots count: points elsewhere were dropped.
        let spoken = inputs.covered[drone].len() as u64;
        slots += if covered { spoken } else { scene.counted.slots(drone) - spoken };
        let of_kind = scene.drones[drone]
            .iter()
            .filter(|scored_point| passes(scored_point))
            .map(|scored_point| scored_point.slot);
        let of_kind = of_kind.filter(|&slot| inputs.is_covered(drone, slot) == Some(covered));
        updated += of_kind.collect::<BTreeSet<_>>().len() as u64;
    }
    ratio(updated, slots).map(|share| 100.0 * share)
}
