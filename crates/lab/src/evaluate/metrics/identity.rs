//! Stability of a drone's track number.

use std::collections::{BTreeMap, BTreeSet};

use super::scene::StreamScene;
use super::statistics::ratio;
use crate::evaluate::scored_point::ScoredPoint;
use fusion::slots::Slot;
use fusion::time::Time;

/// Changes of the published track number between successive points of a drone, per drone and minute.
///
/// If several points have the same time, the one with the previous number is followed, if there is one. So a drone with
/// two radar tracks does not change its number twice per slot.
pub(in crate::evaluate) fn changes_a_minute(scene: &StreamScene<'_>, group: &[usize]) -> Option<f64> {
    let changes: usize = group.iter().map(|&drone| changes(&scene.drones[drone]).len()).sum();
    let minutes: f64 = group.iter().map(|&drone| scene.counted.minutes(drone)).sum();
    (minutes > 0.0).then(|| changes as f64 / minutes)
}

/// Share of the drones' counted slots in which a drone has points under more than one number, percent.
pub(in crate::evaluate) fn two_numbers_percent(scene: &StreamScene<'_>, group: &[usize]) -> Option<f64> {
    let with_two = |drone: &usize| {
        let mut numbers: BTreeMap<Slot, BTreeSet<u32>> = BTreeMap::new();
        for scored_point in &scene.drones[*drone] {
            numbers.entry(scored_point.slot).or_default().insert(scored_point.point.number);
        }
        numbers.values().filter(|numbers| numbers.len() > 1).count() as u64
    };
    let slots = group.iter().map(|&drone| scene.counted.slots(drone)).sum();
    ratio(group.iter().map(with_two).sum(), slots).map(|share| 100.0 * share)
}

/// Times at which the followed number changes; `points` are in order of time.
pub(crate) fn changes(points: &[&ScoredPoint<'_>]) -> Vec<Time> {
    let mut followed = None;
    let mut changes = Vec::new();
    for moment in points.chunk_by(|a, b| a.point.time == b.point.time) {
        let is_there = |number| moment.iter().any(|scored_point| scored_point.point.number == number);
        if !followed.is_some_and(is_there) {
            changes.extend(followed.map(|_| moment[0].point.time));
            followed = Some(moment[0].point.number);
        }
    }
    changes
}
