//! Published tracks that are not drones.

use std::collections::BTreeSet;

use super::scene::StreamScene;

/// Seconds of false tracks per minute of the run: distinct (source, track number, slot) times the slot's length.
pub(in crate::evaluate) fn seconds_a_minute(scene: &StreamScene<'_>, slot_s: f64) -> Option<f64> {
    let key = |scored_point: &&crate::evaluate::scored_point::ScoredPoint<'_>| {
        (scored_point.point.source, scored_point.point.number, scored_point.slot)
    };
    let distinct: BTreeSet<_> = scene.without_drone.iter().map(key).collect();
    Some(distinct.len() as f64 * slot_s / scene.counted.run_minutes()?)
}
