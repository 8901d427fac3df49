//! GOSPA: A. S. Rahmathullah, A. F. Garcia-Fernandez, L. Svensson, *Generalized optimal sub-pattern assignment metric*,
//! Fusion 2017, with p = 2 and alpha = 2.

use std::collections::BTreeMap;

use super::scene::StreamScene;
use crate::evaluate::nearby::Nearby;
use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::scored_point::ScoredPoint;
use crate::evaluate::truth::Truth;
use crate::evaluate::types::{GospaParts, OutputPoint, PointSource};
use fusion::assignment::{Candidate, assign};
use fusion::slots::{Slot, SlotGrid};

/// Cut-off c, metres.
pub(in crate::evaluate) const CUT_OFF_M: f64 = 50.0;
/// GOSPA is computed in each slot whose number is a multiple of this: once per second.
const EVERY_SLOTS: i64 = 4;

/// A truth and a point that are nearer to each other than the cut-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Index of the truth.
    pub truth: usize,
    /// Index of the point.
    pub point: usize,
    /// Distance between them, metres.
    pub distance_m: f64,
}

/// GOSPA at one time, and its components.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gospa {
    /// The metric: sqrt(localisation + c²/2 · (missed + unmatched points)), metres.
    pub value_m: f64,
    /// Sum of the squared distances of the matched pairs, square metres.
    pub localisation_m2: f64,
    /// Number of truths with a point.
    pub matched: usize,
    /// Number of truths without a point.
    pub missed: usize,
    /// Number of points without a truth.
    pub unmatched: usize,
}

/// GOSPA (p = 2, alpha = 2) of `truths` truths and `points` points; `near` holds all pairs closer than `cut_off_m`. The
/// result is exact: a pair at the cut-off costs c², as much as leaving both unmatched, so pairs beyond it cannot help.
pub fn gospa(truths: usize, points: usize, near: &[Near], cut_off_m: f64) -> Gospa {
    let mut candidates = vec![Vec::new(); truths];
    for &Near { truth, point, distance_m } in near {
        candidates[truth].push(Candidate { column: point, cost: distance_m.powi(2) });
    }
    // An unmatched truth and an unmatched point cost c²/2 each.
    let columns = assign(&candidates, points, cut_off_m.powi(2));
    let mut parts = Gospa { missed: truths, unmatched: points, ..Gospa::default() };
    for (candidates, column) in candidates.iter().zip(columns) {
        let pair = column.and_then(|column| candidates.iter().find(|pair| pair.column == column));
        if let Some(pair) = pair {
            parts.localisation_m2 += pair.cost;
            parts.matched += 1;
        }
    }
    parts.missed -= parts.matched;
    parts.unmatched -= parts.matched;
    let alone = (parts.missed + parts.unmatched) as f64;
    parts.value_m = (parts.localisation_m2 + 0.5 * cut_off_m.powi(2) * alone).sqrt();
    parts
}

/// Mean over the slots of the run whose number is a multiple of 4; slots with neither truth nor points are omitted.
pub(in crate::evaluate) fn mean(
    scene: &StreamScene<'_>,
    truth: &Truth,
    grid: SlotGrid,
) -> Option<(f64, GospaParts)> {
    let (first, last) = scene.counted.run()?;
    let by_slot = points_by_slot(scene);
    let (mut sum_m, mut slots, mut total) = (0.0, 0_u32, Gospa::default());
    let first = first.0 + (-first.0).rem_euclid(EVERY_SLOTS);
    for slot in (first..=last.0).step_by(EVERY_SLOTS as usize).map(Slot) {
        let drones = (0..scene.drones.len()).filter(|&drone| scene.counted.contains(drone, slot));
        let truths: Vec<GeodeticPlace> =
            drones.filter_map(|drone| truth.tracks()[drone].at(grid.centre(slot))).collect();
        let points = by_slot.get(&slot).map_or(&[][..], Vec::as_slice);
        if truths.is_empty() && points.is_empty() {
            continue;
        }
        let one = gospa(truths.len(), points.len(), &near(&truths, points), CUT_OFF_M);
        sum_m += one.value_m;
        slots += 1;
        total.localisation_m2 += one.localisation_m2;
        total.matched += one.matched;
        total.missed += one.missed;
        total.unmatched += one.unmatched;
    }
    let slots = (slots > 0).then(|| f64::from(slots))?;
    let parts = GospaParts {
        slots: slots as u64,
        localisation_rms_m: (total.matched > 0)
            .then(|| (total.localisation_m2 / total.matched as f64).sqrt()),
        matched: total.matched as f64 / slots,
        missed: total.missed as f64 / slots,
        unmatched: total.unmatched as f64 / slots,
    };
    Some((sum_m / slots, parts))
}

fn near(truths: &[GeodeticPlace], points: &[&OutputPoint]) -> Vec<Near> {
    let nearby = Nearby::of_places(truths);
    let mut near = Vec::new();
    for (point, at) in points.iter().map(|point| point.place).enumerate() {
        let of_point = nearby.within(at, CUT_OFF_M).filter_map(|truth| {
            let distance_m = at.offset_from(&truths[truth]).distance_m();
            (distance_m < CUT_OFF_M).then_some(Near { truth, point, distance_m })
        });
        near.extend(of_point);
    }
    near
}

/// Points of each slot that is used; if a track has several in a slot (plots of a fast radar), the latest.
fn points_by_slot<'a>(scene: &StreamScene<'a>) -> BTreeMap<Slot, Vec<&'a OutputPoint>> {
    type TrackKey<'a> = (PointSource, u32, Option<&'a str>);
    let mut latest: BTreeMap<Slot, BTreeMap<TrackKey<'a>, &'a OutputPoint>> = BTreeMap::new();
    let all = scene.drones.iter().flatten().chain(&scene.without_drone);
    for &ScoredPoint { point, slot, .. } in all.filter(|scored_point| scored_point.slot.0 % EVERY_SLOTS == 0)
    {
        let track = (point.source, point.number, point.sensor.as_deref());
        let kept = latest.entry(*slot).or_default().entry(track).or_insert(point);
        if kept.time <= point.time {
            *kept = point;
        }
    }
    latest.into_iter().map(|(slot, points)| (slot, points.into_values().collect())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(truth: usize, point: usize, distance_m: f64) -> Near {
        Near { truth, point, distance_m }
    }

    #[test]
    fn localisation_missed_and_false() {
        // 3² + 4² for the pairs, 50²/2 for one truth and two points alone.
        let score = gospa(3, 4, &[near(0, 0, 3.0), near(1, 2, 4.0)], 50.0);
        assert_eq!((score.matched, score.missed, score.unmatched, score.localisation_m2), (2, 1, 2, 25.0));
        assert!((score.value_m - (25.0_f64 + 3.0 * 1250.0).sqrt()).abs() < 1e-12);
        assert_eq!(gospa(0, 0, &[], 50.0), Gospa::default());
    }

    #[test]
    fn nearest_pair_is_split_if_the_sum_is_lower() {
        // 10² + 12² is less than 1² + 40².
        let score =
            gospa(2, 2, &[near(0, 0, 1.0), near(0, 1, 10.0), near(1, 0, 12.0), near(1, 1, 40.0)], 50.0);
        assert_eq!((score.matched, score.localisation_m2), (2, 244.0));
        // 45² + 45² is more than 1² and two alone: 1 + 2500.
        let score = gospa(2, 2, &[near(0, 0, 1.0), near(0, 1, 45.0), near(1, 0, 45.0)], 50.0);
        assert_eq!((score.matched, score.missed, score.unmatched, score.localisation_m2), (1, 1, 1, 1.0));
    }
}
