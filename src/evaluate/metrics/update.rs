//! Probability of update.

use std::collections::BTreeSet;

use super::ratio;
use super::scene::Scene;

/// Percent of the slots that count for these drones in which the drone has at least one point (paper section 4, there
/// over a reference of 4 Hz).
pub(in crate::evaluate) fn probability_percent(scene: &Scene<'_>, group: &[usize]) -> Option<f64> {
    let updated =
        |drone: &usize| scene.drones[*drone].iter().map(|judged| judged.slot).collect::<BTreeSet<_>>();
    let updated: usize = group.iter().map(|drone| updated(drone).len()).sum();
    let slots = group.iter().map(|&drone| scene.counted.slots(drone)).sum();
    ratio(updated as u64, slots).map(|share| 100.0 * share)
}
