//! How stable a drone's track number is.

use std::collections::{BTreeMap, BTreeSet};

use super::scene::Scene;
use super::statistics::ratio;
use crate::evaluate::judged::Judged;
use fusion::slots::Slot;

/// Changes of the published track number between successive points of a drone, per drone and minute.
///
/// Of several points with the same time the one with the previous number is followed, if there is one: a drone with two
/// radar tracks does not change its number twice per slot.
pub(in crate::evaluate) fn changes_a_minute(scene: &Scene<'_>, group: &[usize]) -> Option<f64> {
    let changes: usize = group.iter().map(|&drone| changes(&scene.drones[drone])).sum();
    let minutes: f64 = group.iter().map(|&drone| scene.counted.minutes(drone)).sum();
    (minutes > 0.0).then(|| changes as f64 / minutes)
}

/// Share of the drones' counted slots in which a drone has points under more than one number, percent.
pub(in crate::evaluate) fn two_numbers_percent(scene: &Scene<'_>, group: &[usize]) -> Option<f64> {
    let with_two = |drone: &usize| {
        let mut numbers: BTreeMap<Slot, BTreeSet<u32>> = BTreeMap::new();
        for judged in &scene.drones[*drone] {
            numbers.entry(judged.slot).or_default().insert(judged.point.number);
        }
        numbers.values().filter(|numbers| numbers.len() > 1).count() as u64
    };
    let slots = group.iter().map(|&drone| scene.counted.slots(drone)).sum();
    ratio(group.iter().map(with_two).sum(), slots).map(|share| 100.0 * share)
}

/// Changes of the number that is followed; `points` are in order of time.
fn changes(points: &[&Judged<'_>]) -> usize {
    let mut followed = None;
    let mut changes = 0;
    for moment in points.chunk_by(|a, b| a.point.time == b.point.time) {
        let is_there = |number| moment.iter().any(|judged| judged.point.number == number);
        if !followed.is_some_and(is_there) {
            changes += usize::from(followed.is_some());
            followed = Some(moment[0].point.number);
        }
    }
    changes
}
