//! Ghosts: points of a radar alone beside a drone that is published by its transponder, so that one aircraft appears as
//! two.

use std::collections::{BTreeMap, BTreeSet};

use super::scene::StreamScene;
use crate::evaluate::nearby::Nearby;
use crate::evaluate::scored_point::{ScoredPoint, ScoringReference};
use crate::evaluate::types::PointSource;
use fusion::slots::Slot;

/// Maximum distance of a ghost from its drone, metres (3-D; horizontal if a height is unknown).
const BESIDE_M: f64 = 60.0;

/// A point beside a drone that also has its own point in the same slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::evaluate) struct Ghost {
    slot: Slot,
    number: u32,
    drone: usize,
}

/// Per drone: slots in which it has a fused point or a transponder point.
type ShownSlots = [BTreeSet<Slot>];

/// Finds the ghosts of a scene: points of a radar alone that belong to the nearby drone or to no drone, in a slot with
/// a fused or transponder point of that drone. Points that belong to another drone are not ghosts.
pub(in crate::evaluate) fn find(scene: &StreamScene<'_>, reference: ScoringReference<'_>) -> Vec<Ghost> {
    let slots = |points: &Vec<&ScoredPoint<'_>>| {
        points
            .iter()
            .filter(|scored_point| !is_radars(scored_point))
            .map(|scored_point| scored_point.slot)
            .collect()
    };
    let shown: Vec<BTreeSet<Slot>> = scene.drones.iter().map(slots).collect();
    let mut ghosts = of_drones(scene, &shown);
    ghosts.extend(of_nobody(scene, &shown, reference));
    ghosts
}

/// Ghosts from a drone's own radar tracks.
fn of_drones(scene: &StreamScene<'_>, shown: &ShownSlots) -> Vec<Ghost> {
    let mut ghosts = Vec::new();
    for (drone, points) in scene.drones.iter().enumerate() {
        let is_ghost = |scored_point: &&&ScoredPoint<'_>| {
            let is_beside = scored_point.error.is_some_and(|error| error.distance_m() <= BESIDE_M);
            is_radars(scored_point) && is_beside && shown[drone].contains(&scored_point.slot)
        };
        let ghost = |scored_point: &&ScoredPoint<'_>| Ghost {
            slot: scored_point.slot,
            number: scored_point.point.number,
            drone,
        };
        ghosts.extend(points.iter().filter(is_ghost).map(ghost));
    }
    ghosts
}

/// Ghosts from points of no drone.
fn of_nobody(scene: &StreamScene<'_>, shown: &ShownSlots, reference: ScoringReference<'_>) -> Vec<Ghost> {
    let ScoringReference { truth, grid, .. } = reference;
    let mut by_slot: BTreeMap<Slot, Vec<&ScoredPoint<'_>>> = BTreeMap::new();
    for scored_point in scene.without_drone.iter().filter(|scored_point| is_radars(scored_point)) {
        by_slot.entry(scored_point.slot).or_default().push(scored_point);
    }
    let mut ghosts = Vec::new();
    for (slot, points) in by_slot {
        let nearby = Nearby::of_truth(truth, grid.open(slot), grid.open(slot.plus(1)));
        for point in points.into_iter().map(|scored_point| scored_point.point) {
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

fn is_radars(scored_point: &ScoredPoint<'_>) -> bool {
    scored_point.point.source == PointSource::Radar
}
