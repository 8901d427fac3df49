//! What is marked on the points of a slot.

use std::collections::BTreeMap;

use nalgebra::Matrix2;

use super::Twins;
use super::judge::Judge;
use crate::integrity::{Assessment, IntegrityRules, Reason};
use crate::operational::cycle::Cycle;
use crate::operational::targets::Targets;
use crate::operational::tracklets::Tracklets;
use crate::operational::tuning::COAST_MAX_S;
use crate::point::{Point, Source};
use crate::report::Identity;

/// Where a transponder that lies without a radar's seeing it may be: sigma of each axis over ground, metres.
const ANYWHERE_M: f64 = 150.0;
/// What is published was confirmed as a drone; it counts as one for as long as its log-odds are at least this.
const STAYS_LOG_ODDS: f64 = 1.0;

/// Whether a radar sees it now.
pub(super) fn is_seen(point: &Point, cycle: &Cycle) -> bool {
    point.source.radar().is_some_and(|part| cycle.centre.seconds_since(part.time).abs() <= COAST_MAX_S)
}

/// Marks an aircraft that only radars see: as the twin of a liar, or as one that no liar explains.
pub(super) fn note_radar_only(
    point: &mut Point,
    judges: &mut BTreeMap<Identity, Judge>,
    twins: &Twins,
    tracklets: &Tracklets,
    targets: &Targets,
    cycle: &Cycle,
) {
    let Some(key) = point.source.radar().map(|part| part.track) else { return };
    let Some(tracklet) = tracklets.with_number(key, cycle.centre, cycle.settings) else { return };
    let liar = twins.get(&tracklet.id).and_then(|twin| targets.get(twin.liar)?.identity());
    if let Some(judge) = liar.and_then(|liar| judges.get_mut(&liar)) {
        judge.set_twin_number(point.number);
    }
    point.is_unexplained = liar.is_none() && tracklet.existence().log_odds() >= STAYS_LOG_ODDS;
}

/// Marks the points of transponders, and those that are at odds with them.
pub(super) fn flag(points: &mut [Point], judges: &BTreeMap<Identity, Judge>, rules: &IntegrityRules) {
    let mut disputes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let shown: Vec<(u32, bool)> =
        points.iter().map(|point| (point.number, matches!(point.source, Source::Radar(_)))).collect();
    for point in points.iter_mut() {
        let Some(part) = point.source.transponder() else { continue };
        let Some(known) = judges.get(&part.identity).map(Judge::known) else { continue };
        point.integrity = Some(known.integrity);
        if !known.integrity.state.is_flagged() {
            continue;
        }
        if let Some(twin) = known.twin.filter(|&twin| shown.contains(&(twin, true))) {
            disputes.entry(point.number).or_default().push(twin);
            disputes.entry(twin).or_default().push(point.number);
        }
        if let Some(estimate) = point.estimate.as_mut().filter(|_| rules.accuracy) {
            let lie = lie(known);
            estimate.horizontal += lie;
            estimate.lie_m2 = lie.trace() / 2.0;
        }
    }
    for point in points {
        if let Some(others) = disputes.remove(&point.number) {
            point.is_unexplained = false;
            point.disputed = others;
        }
    }
}

/// What a flag adds to the covariance of its point: where radars see the aircraft, or anywhere around.
fn lie(known: &Assessment) -> Matrix2<f64> {
    match known.offset {
        Some((offset, covariance)) => offset * offset.transpose() + covariance,
        None if known.integrity.reasons.iter().all(|reason| reason == Reason::Velocity) => Matrix2::zeros(),
        None => Matrix2::identity() * (ANYWHERE_M * ANYWHERE_M),
    }
}
