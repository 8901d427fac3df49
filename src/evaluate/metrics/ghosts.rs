//! Points of a radar alone beside a drone that is published by its transponder: one aircraft shown as two.

use std::collections::{BTreeMap, BTreeSet};

use super::scene::Scene;
use crate::evaluate::judged::{Judged, Reference};
use crate::evaluate::nearby::Nearby;
use crate::evaluate::types::PointSource;
use fusion::slots::Slot;

/// A ghost is so near to its drone at most, metres (3-D; horizontal where a height is not known).
const BESIDE_M: f64 = 60.0;

/// A point beside a drone that has one of its own in the same slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::evaluate) struct Ghost {
    slot: Slot,
    number: u32,
    drone: usize,
}

/// The ghosts among the points of a scene: points of a radar alone that belong to the drone beside, or to none, where a
/// fused or a transponder's point of that drone is out in the slot. What belongs to another drone is that drone's.
pub(in crate::evaluate) fn find(scene: &Scene<'_>, reference: Reference<'_>) -> Vec<Ghost> {
    let Reference { truth, grid, .. } = reference;
    let own: Vec<BTreeSet<Slot>> = scene
        .drones
        .iter()
        .map(|points| points.iter().filter(|judged| !is_radars(judged)).map(|judged| judged.slot).collect())
        .collect();
    let mut ghosts = Vec::new();
    for (drone, points) in scene.drones.iter().enumerate() {
        let beside = points.iter().filter(|judged| is_radars(judged) && own[drone].contains(&judged.slot));
        let beside = beside.filter(|judged| judged.error.is_some_and(|error| error.distance_m() <= BESIDE_M));
        ghosts.extend(beside.map(|judged| Ghost { slot: judged.slot, number: judged.point.number, drone }));
    }
    let mut nobodys: BTreeMap<Slot, Vec<&Judged<'_>>> = BTreeMap::new();
    for judged in scene.nobody.iter().filter(|judged| is_radars(judged)) {
        nobodys.entry(judged.slot).or_default().push(judged);
    }
    for (slot, points) in nobodys {
        let nearby = Nearby::of_truth(truth, grid.open(slot), grid.open(slot.plus(1)));
        for point in points.into_iter().map(|judged| judged.point) {
            let is_beside = |drone: &usize| {
                let place = truth.tracks()[*drone].at(point.time);
                let distance_m = place.map(|place| point.place.offset_from(&place).distance_m());
                own[*drone].contains(&slot) && distance_m.is_some_and(|distance_m| distance_m <= BESIDE_M)
            };
            let beside = nearby.within(point.place, BESIDE_M).filter(is_beside);
            ghosts.extend(beside.map(|drone| Ghost { slot, number: point.number, drone }));
        }
    }
    ghosts
}

/// Seconds of ghosts beside these drones per minute of the run: distinct (track number, slot) times the slot's length.
pub(in crate::evaluate) fn seconds_a_minute(
    ghosts: &[Ghost],
    group: &[usize],
    slot_s: f64,
    run_minutes: Option<f64>,
) -> Option<f64> {
    let group: BTreeSet<usize> = group.iter().copied().collect();
    let beside = ghosts.iter().filter(|ghost| group.contains(&ghost.drone));
    let distinct: BTreeSet<_> = beside.map(|ghost| (ghost.slot, ghost.number)).collect();
    Some(distinct.len() as f64 * slot_s / run_minutes?)
}

fn is_radars(judged: &Judged<'_>) -> bool {
    judged.point.source == PointSource::Radar
}
