//! What is published and is no drone.

use std::collections::BTreeSet;

use super::scene::Scene;

/// Seconds of false tracks per minute of the run: distinct (source, track number, slot) times the slot's length.
pub(in crate::evaluate) fn seconds_a_minute(scene: &Scene<'_>, slot_s: f64) -> Option<f64> {
    let key = |judged: &&crate::evaluate::judged::Judged<'_>| {
        (judged.point.source, judged.point.number, judged.slot)
    };
    let distinct: BTreeSet<_> = scene.nobody.iter().map(key).collect();
    Some(distinct.len() as f64 * slot_s / scene.counted.run_minutes()?)
}
