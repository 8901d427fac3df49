//! The pass that makes targets of radar tracks that are nobody's, once they are confirmed as drones.

use super::correlation::Decided;
use super::cycle::{Cycle, EARLIEST};
use super::ids::TrackletId;
use super::reacquisition::{self, Measured};
use super::targets::Targets;
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{COAST_MAX_S, CONFIRM_LOG_ODDS, INITIATION_HOLD};

/// Initiates a target, at once back to its first plot, of each radar track that is confirmed and nobody's.
pub(super) fn initiate(
    tracklets: &mut Tracklets,
    targets: &mut Targets,
    measured: &Measured,
    decided: &Decided,
    cycle: &Cycle,
) {
    let is_initiated = |tracklet: &&Tracklet| {
        let is_confirmed = tracklet.existence().log_odds() >= CONFIRM_LOG_ODDS;
        // Where one plot alone goes nobody knows.
        let is_track = tracklet.first() < tracklet.last() && tracklet.last() >= cycle.centre;
        let is_free = || match tracklet.first() < cycle.end {
            true => is_nobodys(tracklet, decided, cycle),
            false => {
                tracklet.begins_within(COAST_MAX_S, cycle)
                    && is_unclaimed(tracklet, targets, measured, decided, cycle)
            }
        };
        tracklet.target().is_none() && is_track && is_confirmed && is_free()
    };
    let new: Vec<TrackletId> = tracklets.iter().filter(is_initiated).map(|tracklet| tracklet.id).collect();
    for id in new {
        let target = targets.insert_unknown(cycle);
        targets.follow(tracklets, id, Some(target));
        targets.filter(target, EARLIEST, tracklets, cycle);
    }
}

/// Whether a track that has begun is not likely to be a transponder's, and was not lately.
fn is_nobodys(tracklet: &Tracklet, decided: &Decided, cycle: &Cycle) -> bool {
    tracklet.pairs().iter().all(|&(target, pair)| {
        let long_ago = || pair.last_likely.is_none_or(|likely| cycle.centre - likely >= INITIATION_HOLD);
        decided.are_apart(tracklet.id, target) || (pair.llr < -8.0 && long_ago())
    })
}

/// Whether a track that is still to begin could be no known target.
fn is_unclaimed(
    tracklet: &Tracklet,
    targets: &Targets,
    measured: &Measured,
    decided: &Decided,
    cycle: &Cycle,
) -> bool {
    decided.target(tracklet.id).is_none()
        && cycle.settings.radar(tracklet.key.sensor).is_some_and(|radar| {
            reacquisition::plausible(tracklet, radar, targets, measured, decided).next().is_none()
        })
}
