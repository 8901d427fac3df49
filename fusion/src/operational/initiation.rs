//! The pass that creates targets from unassigned radar tracks once they are confirmed as drones.

use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::integrity::Twins;
use super::likelihood::PairLikelihood;
use super::manual_association::DecidedPairs;
use super::radar_pairs::{self, RadarPairEvidence};
use super::reacquisition::{self, MeasuredPositions};
use super::targets::Targets;
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    CLASS_LLR_MAX, COAST_MAX_S, CONFIRM_LOG_ODDS, INITIATION_HOLD, MUTUAL_APART_LLR, MUTUAL_ASSOCIATE_LLR,
    NOBODYS_LLR,
};
use crate::report::SensorIndex;
use crate::time::Time;

/// Minimum duration of a radar track that shows the true position of a suspect transponder, to become a target,
/// seconds.
const TWIN_LASTS_S: f64 = 2.0;

/// Creates a target, with all plots back to the first, for each radar track that is confirmed and unassigned.
pub(super) fn initiate(
    tracklets: &mut Tracklets,
    targets: &mut Targets,
    measured: &MeasuredPositions,
    decided: &DecidedPairs,
    twins: &Twins,
    cycle: &Cycle,
) {
    let is_initiated = |tracklet: &&Tracklet| {
        let log_odds = tracklet.existence().log_odds();
        let is_confirmed = match twins.get(&tracklet.id) {
            Some(twin) => {
                let lasts_s = tracklet.last().seconds_since(tracklet.first());
                lasts_s >= TWIN_LASTS_S && log_odds + twin.motion.min(CLASS_LLR_MAX) >= CONFIRM_LOG_ODDS
            }
            None => log_odds >= CONFIRM_LOG_ODDS,
        };
        // The motion after a single plot is unknown.
        let is_track = tracklet.first() < tracklet.last() && tracklet.last() >= cycle.centre;
        let is_free = || match tracklet.first() < cycle.end {
            true if twins.contains_key(&tracklet.id) => true,
            true => is_unexplained(tracklet, tracklets, targets, decided, cycle),
            false => {
                tracklet.begins_within(COAST_MAX_S, cycle)
                    && is_unclaimed(tracklet, tracklets, targets, measured, decided, cycle)
            }
        };
        tracklet.target().is_none() && is_track && is_confirmed && is_free()
    };
    let new = tracklets.iter().filter(is_initiated).map(|tracklet| (tracklet.id, tracklet.key.sensor));
    let new: Vec<(TrackletId, SensorIndex)> = new.collect();
    let mut initiated: Vec<(SensorIndex, TargetId)> = Vec::new();
    for (id, sensor) in new {
        // Two radars may begin to detect a drone at the same time.
        let target = match of_other_radar(id, &initiated, tracklets, targets, cycle) {
            Some((target, llr)) if llr > MUTUAL_ASSOCIATE_LLR => target,
            Some(_) => continue,
            None => targets.insert_unknown(id, cycle),
        };
        targets.assign_track(tracklets, id, Some(target));
        initiated.push((sensor, target));
    }
}

/// Among the targets just initiated, each with its radar: the one to which this track of another radar may belong, and
/// its LLR.
fn of_other_radar(
    id: TrackletId,
    initiated: &[(SensorIndex, TargetId)],
    tracklets: &Tracklets,
    targets: &Targets,
    cycle: &Cycle,
) -> Option<(TargetId, f64)> {
    let tracklet = tracklets.get(id)?;
    let others = initiated.iter().filter(|initiated| initiated.0 != tracklet.key.sensor);
    let llr = |&(_, target): &(SensorIndex, TargetId)| {
        let followed = || targets.get(target).into_iter().flat_map(|target| target.followed(tracklets));
        if followed().any(|other| other.key.sensor == tracklet.key.sensor) {
            return None;
        }
        let llr = followed().find_map(|other| radar_pairs::llr(tracklet, other, cycle.settings))?;
        (llr > MUTUAL_APART_LLR).then_some((target, llr))
    };
    others.filter_map(llr).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Whether a track that has begun is unlikely to be of a transponder or another radar's track, and was so lately.
fn is_unexplained(
    tracklet: &Tracklet,
    tracklets: &Tracklets,
    targets: &Targets,
    decided: &DecidedPairs,
    cycle: &Cycle,
) -> bool {
    let long_ago =
        |likely: Option<Time>| likely.is_none_or(|likely| cycle.centre - likely >= INITIATION_HOLD);
    let is_apart = |&(target, pair): &(TargetId, PairLikelihood)| {
        decided.are_apart(tracklet.id, target) || (pair.llr < NOBODYS_LLR && long_ago(pair.last_likely))
    };
    let is_apart_there = |&(id, pair): &(TrackletId, RadarPairEvidence)| {
        let Some(other) =
            tracklets.get(id).filter(|other| could_be(tracklet, other, tracklets, targets, cycle))
        else {
            return true;
        };
        long_ago(pair.last_likely)
            && radar_pairs::llr(tracklet, other, cycle.settings).is_none_or(|llr| llr < MUTUAL_APART_LLR)
    };
    tracklet.pairs().iter().all(is_apart) && tracklet.radar_pairs().iter().all(is_apart_there)
}

/// Whether a track that is still to begin cannot be a known target: neither by the expected position, nor by other
/// radars' tracks.
fn is_unclaimed(
    tracklet: &Tracklet,
    tracklets: &Tracklets,
    targets: &Targets,
    measured: &MeasuredPositions,
    decided: &DecidedPairs,
    cycle: &Cycle,
) -> bool {
    let is_apart = |other: &Tracklet| {
        other.key.sensor == tracklet.key.sensor
            || !could_be(tracklet, other, tracklets, targets, cycle)
            || !radar_pairs::begins_near(tracklet, other, cycle.settings)
            || radar_pairs::llr(tracklet, other, cycle.settings).is_none_or(|llr| llr < MUTUAL_APART_LLR)
    };
    decided.target(tracklet.id).is_none()
        && tracklets.iter().all(is_apart)
        && cycle
            .settings
            .radar(tracklet.key.sensor)
            .is_some_and(|radar| !reacquisition::begins_over_one(tracklet, radar, targets, measured, decided))
}

/// Whether another radar's track is of a target that has no present track of this track's radar.
fn could_be(
    tracklet: &Tracklet,
    other: &Tracklet,
    tracklets: &Tracklets,
    targets: &Targets,
    cycle: &Cycle,
) -> bool {
    let is_taken = |followed: &Tracklet| {
        followed.key.sensor == tracklet.key.sensor && followed.last() >= cycle.centre.max(tracklet.first())
    };
    let target = other.target().and_then(|target| targets.get(target));
    target.is_some_and(|target| !target.followed(tracklets).any(is_taken))
}
