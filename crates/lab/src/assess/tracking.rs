//! Continuity of tracks: changes and swaps of numbers, false tracks, time to the first point.

use std::collections::BTreeMap;

use super::bootstrap::{BlockSums, Estimator, add};
use super::scene::AssessmentScene;
use super::subject::{AssessedSubject, SubjectKind};
use super::types::{AssessmentFigure, FigureTable};
use crate::evaluate::{ScoredPoint, changes};
use fusion::time::{SECOND, Time};
use input::statistics::quantile;

/// Silence after which a number is another track, nanoseconds.
const SAME_TRACK_NS: i64 = 25 * SECOND;

/// Figures on a subject's tracks.
pub(super) fn tracking(scene: &AssessmentScene<'_>, subject: &AssessedSubject<'_>) -> FigureTable {
    let key = |name: &str| subject.figure_key(&format!("tracking.{name}"));
    let by_drone = subject.by_drone(scene);
    let tracks = tracks(subject);
    let mut figures = Vec::new();
    let mut rate = |name: &str, label: &str, unit, digits, sums: &BlockSums| {
        let name = (key(name), label);
        figures.push(AssessmentFigure::estimated(name, (unit, digits), Estimator::Rate, sums, scene.seed));
    };
    let mut changed = scene.flown(60.0, |drone| subject.covers(scene, drone));
    for (drone, points) in by_drone.iter().enumerate() {
        for time in changes(points) {
            add(&mut changed, scene.block(drone, time), 1.0, 0.0);
        }
    }
    rate("changes", "changes of an aircraft's number, an aircraft-minute", "1/min", 3, &changed);
    let mut swapped = scene.flown(3600.0, |drone| subject.covers(scene, drone));
    for (drone, time) in tracks.iter().flat_map(|track| swaps(track)) {
        add(&mut swapped, scene.block(drone, time), 1.0, 0.0);
    }
    rate("swaps", "swaps: a number passes to another aircraft, an aircraft-hour", "1/h", 2, &swapped);
    // Two aircraft swap in series, and their blocks are not independent: an interval would be too narrow.
    if let Some(swaps) = figures.last_mut() {
        *swaps = AssessmentFigure { interval: None, blocks: None, ..swaps.clone() };
    }
    let mut rate = |name: &str, label: &str, unit, digits, sums: &BlockSums| {
        let name = (key(name), label);
        figures.push(AssessmentFigure::estimated(name, (unit, digits), Estimator::Rate, sums, scene.seed));
    };
    if scene.is_truth() {
        let mut false_tracks = scene.run_time(3600.0);
        let mut false_time = scene.run_time(60.0);
        for track in &tracks {
            let foreign = track.iter().filter(|point| point.drone.is_none()).count();
            if 2 * foreign > track.len() {
                add(&mut false_tracks, scene.block_of_run(track[0].point.time), 1.0, 0.0);
            }
        }
        rate("false", "false tracks, an hour", "1/h", 1, &false_tracks);
        if subject.kind == SubjectKind::Picture {
            let slot_s = scene.grid.slot_s();
            let slots: std::collections::BTreeSet<_> = (subject.scored.iter())
                .filter(|point| point.drone.is_none())
                .map(|point| (point.point.source, point.point.number, point.slot))
                .collect();
            for (_, _, slot) in slots {
                add(&mut false_time, scene.block_of_run(scene.grid.centre(slot)), slot_s, 0.0);
            }
            let name = (key("false-time"), "time of false tracks, seconds a minute");
            figures.push(AssessmentFigure::estimated(
                name,
                ("s/min", 2),
                Estimator::Mean,
                &false_time,
                scene.seed,
            ));
        }
    }
    let mut firsts: Vec<f64> =
        (scene.drones()).filter_map(|drone| until_first(scene, drone, &by_drone[drone])).collect();
    firsts.sort_by(f64::total_cmp);
    let with_slots = scene
        .drones()
        .filter(|&drone| scene.counted.slots(drone) > 0 && subject.covers(scene, drone))
        .count() as u64;
    let mut plain = |name: &str, label: &str, unit, digits, value, count| {
        figures.push(AssessmentFigure::plain(key(name), label, unit, digits, value).with_count(count));
    };
    let found = firsts.len() as f64;
    plain("found", "aircraft with a point", "", 0, Some(found), with_slots);
    plain("first", "time to the first point, median", "s", 2, quantile(&firsts, 0.5), firsts.len() as u64);
    plain(
        "first-longest",
        "time to the first point, longest",
        "s",
        2,
        firsts.last().copied(),
        firsts.len() as u64,
    );
    FigureTable { title: subject.title.clone(), figures }
}

/// Tracks: points of one number, in order of time, without a silence.
fn tracks<'s, 'a>(subject: &'s AssessedSubject<'a>) -> Vec<Vec<&'s ScoredPoint<'a>>> {
    let mut numbers: BTreeMap<u32, Vec<&ScoredPoint<'a>>> = BTreeMap::new();
    for point in &subject.scored {
        numbers.entry(point.point.number).or_default().push(point);
    }
    let mut tracks = Vec::new();
    for mut points in numbers.into_values() {
        points.sort_by_key(|point| point.point.time);
        let is_same = |a: &&ScoredPoint<'_>, b: &&ScoredPoint<'_>| {
            b.point.time.nanos() - a.point.time.nanos() <= SAME_TRACK_NS
        };
        tracks.extend(points.chunk_by(is_same).map(<[_]>::to_vec));
    }
    tracks
}

/// Aircraft to which the track passes from another, and times. Points of no aircraft are passed over.
fn swaps(track: &[&ScoredPoint<'_>]) -> Vec<(usize, Time)> {
    let owners = track.iter().filter_map(|point| Some((point.drone?, point.point.time)));
    let owners: Vec<(usize, Time)> = owners.collect();
    owners.windows(2).filter(|pair| pair[0].0 != pair[1].0).map(|pair| pair[1]).collect()
}

/// Seconds from the first slot of an aircraft that counts to its first point.
fn until_first(scene: &AssessmentScene<'_>, drone: usize, points: &[&ScoredPoint<'_>]) -> Option<f64> {
    let (from, _) = scene.spans(drone).next()?;
    Some(points.first()?.point.time.seconds_since(from))
}
