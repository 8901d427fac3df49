//! How long a drone keeps its number.

use super::scene::Scene;

/// Changes of the published track number between successive points of one drone, a drone and minute.
pub(in crate::evaluate) fn changes_a_minute(scene: &Scene<'_>, group: &[usize]) -> Option<f64> {
    let changes = |drone: &usize| {
        let points = &scene.drones[*drone];
        points.windows(2).filter(|pair| pair[0].point.number != pair[1].point.number).count()
    };
    let changes: usize = group.iter().map(changes).sum();
    let minutes: f64 = group.iter().map(|&drone| scene.counted.minutes(drone)).sum();
    (minutes > 0.0).then(|| changes as f64 / minutes)
}
