//! The pass that compares each radar track with the transponders near it.

use super::cycle::Cycle;
use super::ids::TargetId;
use super::places::Places;
use super::settings::Radar;
use super::targets::{Target, Targets};
use super::tracklets::Tracklets;
use super::tuning::{COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS};
use crate::filter::LineOfSight;
use crate::report::Plot;
use crate::time::Time;

/// Adds the plots since the last slot to the likelihoods of each radar track with the transponders near it, once near.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    let settings = cycle.settings;
    let place = |target: &Target| Some((target.on_curve(cycle.centre, settings)?.position, target.id()));
    let places = Places::of(targets.iter().filter_map(place));
    let mut compared: Vec<TargetId> = Vec::new();
    for tracklet in tracklets.iter_mut() {
        let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
        let Some(plot) = tracklet.nearest(cycle.centre).copied() else { continue };
        compared.clear();
        compared.extend(tracklet.pairs().iter().map(|pair| pair.0));
        compared.extend(near(&places, &plot, cycle.centre, radar));
        compared.sort_unstable();
        compared.dedup();
        for &id in &compared {
            if let Some(transponder) = targets.get(id).and_then(Target::transponder) {
                tracklet.compare(id, transponder, (cycle.previous, cycle.centre), radar, settings);
            }
        }
    }
}

/// Gate: those of the targets that the plot could be of.
fn near(places: &Places<TargetId>, plot: &Plot, time: Time, radar: &Radar) -> impl Iterator<Item = TargetId> {
    let away_s = plot.time.seconds_since(time).abs();
    let seen = LineOfSight::from(radar.position, plot.position);
    let bias_m = (seen.range_m * radar.errors.bias_azimuth).hypot(radar.errors.bias_range_m);
    let gate_m = GATE_M + DRONE_SPEED_MAX_M_S * away_s + GATE_SIGMAS * bias_m;
    let place = plot.position;
    places
        .within(place, if away_s <= COMPARE_WITHIN_S { gate_m } else { 0.0 })
        .filter(move |near| away_s <= COMPARE_WITHIN_S && (near.0.0 - place.0).xy().norm() <= gate_m)
        .map(|near| near.1)
}
