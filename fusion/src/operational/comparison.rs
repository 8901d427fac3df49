//! The pass that compares each radar track with the transponders near it, and with what other radars see near it.

use std::collections::BTreeSet;

use super::cycle::Cycle;
use super::ids::TargetId;
use super::mutual;
use super::settings::Radar;
use super::targets::{Target, Targets};
use super::tracklets::Tracklets;
use super::tuning::{COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS};
use crate::filter::LineOfSight;
use crate::frames::Enu;
use crate::report::Plot;
use crate::time::Time;

/// Adds the plots since the last slot to the likelihoods of each radar track with the transponders near it, once near.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    let settings = cycle.settings;
    let place = |target: &Target| Some((target.id(), target.on_curve(cycle.centre, settings)?.position));
    let mut by_east: Vec<(TargetId, Enu)> = targets.iter().filter_map(place).collect();
    by_east.sort_by(|a, b| a.1.0.x.total_cmp(&b.1.0.x));
    for tracklet in tracklets.iter_mut() {
        let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
        let Some(plot) = tracklet.nearest(cycle.centre).copied() else { continue };
        let known = tracklet.pairs().iter().map(|pair| pair.0);
        let compared: BTreeSet<TargetId> = known.chain(near(&by_east, &plot, cycle.centre, radar)).collect();
        for id in compared {
            if let Some(transponder) = targets.get(id).and_then(Target::transponder) {
                tracklet.compare(id, transponder, (cycle.previous, cycle.centre), radar, settings);
            }
        }
    }
    mutual::compare(tracklets, targets, cycle);
}

/// Gate: those of the targets that the plot could be of.
fn near<'a>(
    by_east: &'a [(TargetId, Enu)],
    plot: &Plot,
    time: Time,
    radar: &Radar,
) -> impl Iterator<Item = TargetId> + 'a {
    let away_s = plot.time.seconds_since(time).abs();
    let seen = LineOfSight::from(radar.position, plot.position);
    let bias_m = (seen.range_m * radar.errors.bias_azimuth).hypot(radar.errors.bias_range_m);
    let gate_m = GATE_M + DRONE_SPEED_MAX_M_S * away_s + GATE_SIGMAS * bias_m;
    let place = plot.position;
    let from = by_east.partition_point(|near| near.1.0.x < place.0.x - gate_m);
    by_east[from..]
        .iter()
        .take_while(move |near| near.1.0.x <= place.0.x + gate_m)
        .filter(move |near| away_s <= COMPARE_WITHIN_S && (near.1.0 - place.0).xy().norm() <= gate_m)
        .map(|near| near.0)
}
