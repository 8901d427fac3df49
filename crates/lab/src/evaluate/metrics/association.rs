//! Correctness of the association of radar tracks and transponders.

use std::collections::BTreeSet;

use super::scene::StreamScene;
use super::statistics::ratio;
use crate::evaluate::scored_point::ScoredPoint;
use fusion::slots::Slot;

/// Precision: fused points whose radar track and transponder belong to one drone / all fused points. Points of seduced
/// or unlabelled tracks do not count.
pub(in crate::evaluate) fn precision<'a>(points: impl Iterator<Item = &'a ScoredPoint<'a>>) -> Option<f64> {
    let (mut right, mut all) = (0, 0);
    for paired in points.filter_map(|scored_point| scored_point.paired) {
        right += u64::from(paired);
        all += 1;
    }
    ratio(right, all)
}

/// Recall: slots with a correctly fused point / slots in which both inputs of the drone are present (its transponder
/// interpolates, and it has a plot whose track is not seduced).
pub(in crate::evaluate) fn recall(scene: &StreamScene<'_>, group: &[usize]) -> Option<f64> {
    let inputs = scene.inputs?;
    let (mut found, mut present) = (0, 0);
    for &drone in group {
        let both: BTreeSet<Slot> =
            inputs.covered[drone].intersection(&inputs.detected[drone]).copied().collect();
        let right = scene.drones[drone].iter().filter(|scored_point| scored_point.paired == Some(true));
        let right: BTreeSet<Slot> = right.map(|scored_point| scored_point.slot).collect();
        found += both.intersection(&right).count() as u64;
        present += both.len() as u64;
    }
    ratio(found, present)
}
