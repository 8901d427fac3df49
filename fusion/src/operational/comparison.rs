//! The pass that compares each radar track with the transponders near it, and with what other radars see near it.

use super::cycle::Cycle;
use super::ids::TargetId;
use super::mutual;
use super::places::Places;
use super::settings::Radar;
use super::shared;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS};
use crate::filter::LineOfSight;
use crate::report::Plot;
use crate::time::Time;

/// Adds the plots since the last slot to the likelihoods of each radar track with the transponders near it, once near.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    let settings = cycle.settings;
    let place = |target: &Target| Some((target.on_curve(cycle.centre, settings)?.position, target.id()));
    let places = Places::of(targets.iter().filter_map(place));
    shared::on_parts(settings.threads, tracklets.as_mut_slice(), |tracklets| {
        let mut room = Room::default();
        tracklets.iter_mut().for_each(|tracklet| compare_one(tracklet, targets, &places, cycle, &mut room));
    });
    mutual::compare(tracklets, targets, cycle);
}

/// Lists that are used again for each radar track.
#[derive(Default)]
struct Room {
    near: Vec<TargetId>,
    compared: Vec<TargetId>,
}

fn compare_one(
    tracklet: &mut Tracklet,
    targets: &Targets,
    places: &Places<TargetId>,
    cycle: &Cycle,
    Room { near, compared }: &mut Room,
) {
    let Cycle { previous, centre, settings, .. } = *cycle;
    let Some(radar) = settings.radar(tracklet.key.sensor) else { return };
    let Some(plot) = tracklet.nearest(centre).copied() else { return };
    near.clear();
    near.extend(self::near(places, &plot, centre, radar));
    // What it is taken for is looked at wherever that is.
    let is_heard =
        |id: &TargetId| targets.get(*id).is_some_and(|own| own.on_curve(centre, settings).is_some());
    if let Some(own) = tracklet.target().filter(|own| !near.contains(own)).filter(is_heard) {
        near.push(own);
    }
    near.sort_unstable();
    compared.clear();
    compared.extend(tracklet.pairs().iter().map(|pair| pair.0));
    compared.extend(&*near);
    compared.sort_unstable();
    compared.dedup();
    for &mut id in compared {
        if let Some(transponder) = targets.get(id).and_then(Target::transponder) {
            tracklet.compare(id, transponder, (previous, centre), radar, settings);
        }
    }
    tracklet.end_pairs(near, centre);
}

/// Gate: those of the targets that the plot could be of. It is long across the line of sight, as the radar's bias is.
fn near(places: &Places<TargetId>, plot: &Plot, time: Time, radar: &Radar) -> impl Iterator<Item = TargetId> {
    let away_s = plot.time.seconds_since(time).abs();
    let seen = LineOfSight::from(radar.position, plot.position);
    let flown_m = GATE_M + DRONE_SPEED_MAX_M_S * away_s;
    let outward_m = flown_m + GATE_SIGMAS * radar.errors.bias_range_m;
    let across_m = flown_m + GATE_SIGMAS * seen.range_m * radar.errors.bias_azimuth;
    let place = plot.position;
    places
        .within(place, if away_s <= COMPARE_WITHIN_S { outward_m.hypot(across_m) } else { 0.0 })
        .filter(move |near| {
            let apart = (near.0.0 - place.0).xy();
            away_s <= COMPARE_WITHIN_S
                && seen.outward.dot(&apart).abs() <= outward_m
                && seen.clockwise.dot(&apart).abs() <= across_m
        })
        .map(|near| near.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Enu;
    use crate::report::{RadarTrackKey, SensorIndex};

    #[test]
    fn the_gate_is_long_across_the_line_of_sight_and_short_along_it() {
        let radar = Radar::from(&crate::settings::Radar::default());
        let time = Time::default();
        let plot = Plot {
            track: RadarTrackKey { sensor: SensorIndex(0), number: 1 },
            time,
            position: Enu::new(0.0, 5000.0, 100.0),
            height_measured: true,
            slant_range_m: 5000.0,
            uav_probability: None,
            velocity: None,
        };
        let is_near = |east_m: f64, north_m: f64| {
            let place = Enu::new(east_m, 5000.0 + north_m, 100.0);
            near(&Places::of([(place, TargetId::nth(0))].into_iter()), &plot, time, &radar).next().is_some()
        };
        let along_m = GATE_M + GATE_SIGMAS * radar.errors.bias_range_m;
        let across_m = GATE_M + GATE_SIGMAS * 5000.0 * radar.errors.bias_azimuth;
        assert!(across_m > along_m + 100.0);
        for sign in [-1.0, 1.0] {
            assert!(is_near(sign * (across_m - 1.0), 0.0) && !is_near(sign * (across_m + 1.0), 0.0));
            assert!(is_near(0.0, sign * (along_m - 1.0)) && !is_near(0.0, sign * (along_m + 1.0)));
        }
    }
}
