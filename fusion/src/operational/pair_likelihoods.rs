//! The pass that compares each radar track with the transponders near it, and with the tracks of other radars near it.

use super::cycle::Cycle;
use super::ids::TargetId;
use super::places::SpatialIndex;
use super::radar_pairs;
use super::settings::RadarSettings;
use super::shared;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS};
use crate::filter::LineOfSight;
use crate::report::Plot;
use crate::time::Time;

/// Adds the plots since the last slot to the likelihoods of each radar track with the transponders that are or were
/// near it.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    let settings = cycle.settings;
    let place = |target: &Target| Some((target.on_curve(cycle.centre, settings)?.position, target.id()));
    let places = SpatialIndex::of(targets.iter().filter_map(place));
    shared::on_parts(settings.threads, tracklets.as_mut_slice(), |tracklets| {
        let mut room = ComparisonBuffers::default();
        tracklets.iter_mut().for_each(|tracklet| compare_one(tracklet, targets, &places, cycle, &mut room));
    });
    radar_pairs::compare(tracklets, targets, cycle);
}

/// Buffers that are reused for each radar track.
#[derive(Default)]
struct ComparisonBuffers {
    near: Vec<TargetId>,
    compared: Vec<TargetId>,
}

fn compare_one(
    tracklet: &mut Tracklet,
    targets: &Targets,
    places: &SpatialIndex<TargetId>,
    cycle: &Cycle,
    ComparisonBuffers { near, compared }: &mut ComparisonBuffers,
) {
    let Cycle { previous, centre, settings, .. } = *cycle;
    let Some(radar) = settings.radar(tracklet.key.sensor) else { return };
    let Some(plot) = tracklet.nearest(centre).copied() else { return };
    near.clear();
    near.extend(self::near(places, &plot, centre, radar));
    // The track's own target is compared at any distance.
    let is_heard = |id: &TargetId| targets.get(*id).is_some_and(|own| own.is_on_curve(centre, settings));
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

/// Gate: the targets to which the plot may belong. It is longer across the line of sight, like the radar's bias.
fn near(
    places: &SpatialIndex<TargetId>,
    plot: &Plot,
    time: Time,
    radar: &RadarSettings,
) -> impl Iterator<Item = TargetId> {
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
        let radar = RadarSettings::from(&crate::settings::Radar::default());
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
            near(&SpatialIndex::of([(place, TargetId::nth(0))].into_iter()), &plot, time, &radar)
                .next()
                .is_some()
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
