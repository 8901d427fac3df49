//! How often radar track and transponder were correctly associated.

use std::collections::BTreeSet;

use super::scene::Scene;
use super::statistics::ratio;
use crate::evaluate::judged::Judged;
use fusion::slots::Slot;

/// Fused points whose radar track and transponder are one drone / all fused points. Points of seduced or unlabelled
/// tracks do not count.
pub(in crate::evaluate) fn precision<'a>(points: impl Iterator<Item = &'a Judged<'a>>) -> Option<f64> {
    let (mut right, mut all) = (0, 0);
    for paired in points.filter_map(|judged| judged.paired) {
        right += u64::from(paired);
        all += 1;
    }
    ratio(right, all)
}

/// Slots with such a point / slots in which both inputs of the drone are present: its transponder interpolates, and a
/// plot of it is there whose track is not seduced.
pub(in crate::evaluate) fn recall(scene: &Scene<'_>, group: &[usize]) -> Option<f64> {
    let inputs = scene.inputs?;
    let (mut found, mut present) = (0, 0);
    for &drone in group {
        let both: BTreeSet<Slot> =
            inputs.covered[drone].intersection(&inputs.detected[drone]).copied().collect();
        let right = scene.drones[drone].iter().filter(|judged| judged.paired == Some(true));
        let right: BTreeSet<Slot> = right.map(|judged| judged.slot).collect();
        found += both.intersection(&right).count() as u64;
        present += both.len() as u64;
    }
    ratio(found, present)
}
