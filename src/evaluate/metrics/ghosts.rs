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

/// Per drone: the slots in which it has a fused or a transponder's point.
type Shown = [BTreeSet<Slot>];

/// The ghosts among the points of a scene: points of a radar alone that belong to the drone beside, or to nobody, where a
/// fused or a transponder's point of that drone is out in the slot. What belongs to another drone is that drone's.
pub(in crate::evaluate) fn find(scene: &Scene<'_>, reference: Reference<'_>) -> Vec<Ghost> {
    let slots = |points: &Vec<&Judged<'_>>| {
        points.iter().filter(|judged| !is_radars(judged)).map(|judged| judged.slot).collect()
    };
    let shown: Vec<BTreeSet<Slot>> = scene.drones.iter().map(slots).collect();
    let mut ghosts = of_drones(scene, &shown);
    ghosts.extend(of_nobody(scene, &shown, reference));
    ghosts
}

/// Points of a drone's own radar tracks.
fn of_drones(scene: &Scene<'_>, shown: &Shown) -> Vec<Ghost> {
    let mut ghosts = Vec::new();
    for (drone, points) in scene.drones.iter().enumerate() {
        let is_ghost = |judged: &&&Judged<'_>| {
            let is_beside = judged.error.is_some_and(|error| error.distance_m() <= BESIDE_M);
            is_radars(judged) && is_beside && shown[drone].contains(&judged.slot)
        };
        let ghost = |judged: &&Judged<'_>| Ghost { slot: judged.slot, number: judged.point.number, drone };
        ghosts.extend(points.iter().filter(is_ghost).map(ghost));
    }
    ghosts
}

/// Points of birds and the like.
fn of_nobody(scene: &Scene<'_>, shown: &Shown, reference: Reference<'_>) -> Vec<Ghost> {
    let Reference { truth, grid, .. } = reference;
    let mut by_slot: BTreeMap<Slot, Vec<&Judged<'_>>> = BTreeMap::new();
    for judged in scene.nobody.iter().filter(|judged| is_radars(judged)) {
        by_slot.entry(judged.slot).or_default().push(judged);
    }
    let mut ghosts = Vec::new();
    for (slot, points) in by_slot {
        let nearby = Nearby::of_truth(truth, grid.open(slot), grid.open(slot.plus(1)));
        for point in points.into_iter().map(|judged| judged.point) {
            let is_beside = |drone: &usize| {
                let place = truth.tracks()[*drone].at(point.time);
                let distance_m = place.map(|place| point.place.offset_from(&place).distance_m());
                shown[*drone].contains(&slot) && distance_m.is_some_and(|distance_m| distance_m <= BESIDE_M)
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
