//! Integrity marks on the points of a slot.

use std::collections::BTreeMap;

use nalgebra::Matrix2;

use super::Twins;
use super::monitor::IdentityMonitor;
use crate::integrity::{Assessment, IntegrityRules, Reason};
use crate::operational::cycle::Cycle;
use crate::operational::targets::Targets;
use crate::operational::tracklets::Tracklets;
use crate::operational::tuning::COAST_MAX_S;
use crate::point::{Point, Source};
use crate::report::Identity;

/// Standard deviation of each axis over ground of a false transponder without a radar track, metres.
const ANYWHERE_M: f64 = 150.0;
/// Minimum log-odds with which a published drone still counts as one.
const STAYS_LOG_ODDS: f64 = 1.0;

/// Whether a radar detects it now.
pub(super) fn is_detected(point: &Point, cycle: &Cycle) -> bool {
    point.source.radar().is_some_and(|part| cycle.centre.seconds_since(part.time).abs() <= COAST_MAX_S)
}

/// Marks an aircraft that only radars detect: as the true position of a false transponder, or as unexplained.
pub(super) fn note_radar_only(
    point: &mut Point,
    monitors: &mut BTreeMap<Identity, IdentityMonitor>,
    twins: &Twins,
    tracklets: &Tracklets,
    targets: &Targets,
    cycle: &Cycle,
) {
    let Some(key) = point.source.radar().map(|part| part.track) else { return };
    let Some(tracklet) = tracklets.with_number(key, cycle.centre, cycle.settings) else { return };
    let liar = twins.get(&tracklet.id).and_then(|twin| targets.get(twin.liar)?.identity());
    if let Some(monitor) = liar.and_then(|liar| monitors.get_mut(&liar)) {
        monitor.set_twin_number(point.number);
    }
    point.is_unexplained = liar.is_none() && tracklet.existence().log_odds() >= STAYS_LOG_ODDS;
}

/// Marks the points of transponders, and those that dispute them.
pub(super) fn flag(
    points: &mut [Point],
    monitors: &BTreeMap<Identity, IdentityMonitor>,
    rules: &IntegrityRules,
) {
    let mut disputes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let shown: Vec<(u32, bool)> =
        points.iter().map(|point| (point.number, matches!(point.source, Source::Radar(_)))).collect();
    for point in points.iter_mut() {
        let Some(part) = point.source.transponder() else { continue };
        let Some(known) = monitors.get(&part.identity).map(IdentityMonitor::published) else { continue };
        point.integrity = Some(known.integrity);
        if !known.integrity.state.is_flagged() {
            continue;
        }
        if let Some(twin) = known.twin.filter(|&twin| shown.contains(&(twin, true))) {
            disputes.entry(point.number).or_default().push(twin);
            disputes.entry(twin).or_default().push(point.number);
        }
        if let Some(estimate) = point.estimate.as_mut().filter(|_| rules.accuracy) {
            let lie = flag_covariance(known);
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

/// Covariance added by a flag: from the radars' position of the aircraft, or a large one.
fn flag_covariance(known: &Assessment) -> Matrix2<f64> {
    match known.offset {
        Some((offset, covariance)) => offset * offset.transpose() + covariance,
        None if known.integrity.reasons.iter().all(|reason| reason == Reason::Velocity) => Matrix2::zeros(),
        None => Matrix2::identity() * (ANYWHERE_M * ANYWHERE_M),
    }
}
