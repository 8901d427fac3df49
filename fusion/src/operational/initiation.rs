//! The pass that makes targets of radar tracks that are nobody's, once they are confirmed as drones.

use super::correlation::Decided;
use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::integrity::Twins;
use super::likelihood::PairLikelihood;
use super::mutual::{self, Evidence};
use super::reacquisition::{self, Measured};
use super::targets::Targets;
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    CLASS_LLR_MAX, COAST_MAX_S, CONFIRM_LOG_ODDS, INITIATION_HOLD, MUTUAL_APART_LLR, MUTUAL_ASSOCIATE_LLR,
    NOBODYS_LLR,
};
use crate::report::SensorIndex;
use crate::time::Time;

/// What a radar sees where a suspect transponder is not is an aircraft as soon as it lasts this long, seconds.
const TWIN_LASTS_S: f64 = 2.0;

/// Initiates a target, at once back to its first plot, of each radar track that is confirmed and nobody's.
pub(super) fn initiate(
    tracklets: &mut Tracklets,
    targets: &mut Targets,
    measured: &Measured,
    decided: &Decided,
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
        // Where one plot alone goes nobody knows.
        let is_track = tracklet.first() < tracklet.last() && tracklet.last() >= cycle.centre;
        let is_free = || match tracklet.first() < cycle.end {
            true if twins.contains_key(&tracklet.id) => true,
            true => is_nobodys(tracklet, tracklets, targets, decided, cycle),
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
        // Two radars may begin to see a drone at once.
        let target = match of_other_radar(id, &initiated, tracklets, targets, cycle) {
            Some((target, llr)) if llr > MUTUAL_ASSOCIATE_LLR => target,
            Some(_) => continue,
            None => targets.insert_unknown(id, cycle),
        };
        targets.follow(tracklets, id, Some(target));
        initiated.push((sensor, target));
    }
}

/// Which of the targets that have just been initiated, each with the radar that did, this track of another one could be, and
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
        let llr = followed().find_map(|other| mutual::llr(tracklet, other, cycle.settings))?;
        (llr > MUTUAL_APART_LLR).then_some((target, llr))
    };
    others.filter_map(llr).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Whether a track that has begun is not likely to be a transponder's or another radar's, and was not lately.
fn is_nobodys(
    tracklet: &Tracklet,
    tracklets: &Tracklets,
    targets: &Targets,
    decided: &Decided,
    cycle: &Cycle,
) -> bool {
    let long_ago =
        |likely: Option<Time>| likely.is_none_or(|likely| cycle.centre - likely >= INITIATION_HOLD);
    let is_apart = |&(target, pair): &(TargetId, PairLikelihood)| {
        decided.are_apart(tracklet.id, target) || (pair.llr < NOBODYS_LLR && long_ago(pair.last_likely))
    };
    let is_apart_there = |&(id, pair): &(TrackletId, Evidence)| {
        let Some(other) =
            tracklets.get(id).filter(|other| could_be(tracklet, other, tracklets, targets, cycle))
        else {
            return true;
        };
        long_ago(pair.last_likely)
            && mutual::llr(tracklet, other, cycle.settings).is_none_or(|llr| llr < MUTUAL_APART_LLR)
    };
    tracklet.pairs().iter().all(is_apart) && tracklet.mutual().iter().all(is_apart_there)
}

/// Whether a track that is still to begin could be no known target: not where that must be, nor what other radars see of it.
fn is_unclaimed(
    tracklet: &Tracklet,
    tracklets: &Tracklets,
    targets: &Targets,
    measured: &Measured,
    decided: &Decided,
    cycle: &Cycle,
) -> bool {
    let is_apart = |other: &Tracklet| {
        other.key.sensor == tracklet.key.sensor
            || !could_be(tracklet, other, tracklets, targets, cycle)
            || !mutual::begins_near(tracklet, other, cycle.settings)
            || mutual::llr(tracklet, other, cycle.settings).is_none_or(|llr| llr < MUTUAL_APART_LLR)
    };
    decided.target(tracklet.id).is_none()
        && tracklets.iter().all(is_apart)
        && cycle
            .settings
            .radar(tracklet.key.sensor)
            .is_some_and(|radar| !reacquisition::begins_over_one(tracklet, radar, targets, measured, decided))
}

/// Whether another radar's track is of a target that no other track of this one's radar is now.
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
