//! Comparison of the tracks of two radars of one aircraft without a transponder.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::{Registered, Registrations};
use crate::frames::Enu;
use crate::operational::cycle::Cycle;
use crate::operational::ids::TrackletId;
use crate::operational::places::SpatialIndex;
use crate::operational::settings::{OperationalSettings, RadarSettings};
use crate::operational::targets::{Target, Targets};
use crate::operational::tracklets::{CorrectedPlot, Tracklet, Tracklets};
use crate::operational::tuning::{BETWEEN_REPORTS_M_S2, COMPARE_WITHIN_S, SEGMENT_S, TRACK_LASTS_PERIODS};
use crate::registration::{LearntFromRadars, SharedComparison, SharedLook};
use crate::report::SensorIndex;
use crate::settings::RegistrationMode;

/// Share of the longer of two periods after which plots are compared again. In between, they would be compared with the same
/// plots of the other radar.
const AGAIN: f64 = 0.9;

/// Minimum duration of a segment at the end of a pair of tracks, seconds. The first look of a pair has most of the information.
const SHORT_S: f64 = 2.0;

/// Minimum distance of other tracks of the same radars, metres. Nearer ones may be the aircraft in place of these.
const ALONE_M: f64 = 150.0;

/// Two tracks of one aircraft, in the order of their radars.
type TrackPair = (TrackletId, TrackletId);

impl Registered {
    /// Uses what its radar learns from other radars.
    fn learn_from_radars(&mut self, learnt: Option<LearntFromRadars>) {
        if learnt != self.by_radars {
            self.by_radars = learnt;
            self.estimate();
        }
    }
}

impl Registrations {
    /// Compares the tracks of two radars that follow one aircraft without a transponder, for the plots since the last slot.
    pub(super) fn compare_radars(&mut self, tracklets: &Tracklets, targets: &Targets, cycle: &Cycle) {
        let settings = cycle.settings;
        if settings.radars().nth(1).is_none() {
            return;
        }
        let spanning = tracklets.iter().filter(|tracklet| tracklet.spans(cycle));
        let places =
            spanning.filter_map(|tracklet| Some((tracklet.nearest(cycle.centre)?.position, tracklet.id)));
        let places = &SpatialIndex::of(places);
        let mut compared: BTreeMap<TrackPair, SharedComparison> = BTreeMap::new();
        let silent = targets.iter().filter(|target| !target.is_on_curve(cycle.centre, settings));
        for (target, one, other) in silent.flat_map(|target| pairs(target, tracklets, settings)) {
            let [first, second] = [one, other].map(|tracklet| settings.radar(tracklet.key.sensor));
            let Some(radars) = first.zip(second) else { continue };
            let comparison = self.shared_tracks.remove(&(one.id, other.id));
            let mut comparison = comparison
                .unwrap_or_else(|| SharedComparison::new([radars.0.track_errors, radars.1.track_errors]));
            let again_s = AGAIN * radars.0.period_s.max(radars.1.period_s);
            let alone = is_alone(one, other, places, cycle);
            for plot in one.corrected_between(cycle.previous, cycle.centre).filter(|_| alone) {
                if comparison.newest().is_some_and(|newest| plot.plot.time.seconds_since(newest) < again_s) {
                    continue;
                }
                if let Some(look) = look(plot, other, radars, target) {
                    comparison.add(&look);
                }
            }
            self.take_segment((one.id, other.id), &mut comparison, SEGMENT_S);
            compared.insert((one.id, other.id), comparison);
        }
        for (pair, mut ended) in std::mem::replace(&mut self.shared_tracks, compared) {
            self.take_segment(pair, &mut ended, SHORT_S);
        }
        if !self.mutual.is_changed() {
            return;
        }
        let own = |sensor: SensorIndex| Some(self.radars.get(&sensor)?.own_estimate().over_ground());
        let mut learnt = self.mutual.solve(own);
        for (sensor, registered) in &mut self.radars {
            registered.learn_from_radars(learnt.remove(sensor));
        }
    }

    /// Adds the segment of a pair of tracks if it lasted for this time, seconds.
    fn take_segment(&mut self, (one, other): TrackPair, comparison: &mut SharedComparison, least_s: f64) {
        if comparison.gathered_s() >= least_s
            && let Some(sample) = comparison.take_sample()
        {
            self.mutual.add((one.track.sensor, other.track.sensor), sample);
        }
    }
}

/// The pairs of tracks of a target, of radars whose misalignment is estimated.
fn pairs<'a>(
    target: &'a Target,
    tracklets: &'a Tracklets,
    settings: &'a OperationalSettings,
) -> impl Iterator<Item = (&'a Target, &'a Tracklet, &'a Tracklet)> {
    let is_estimated = |tracklet: &&Tracklet| {
        settings.radar(tracklet.key.sensor).is_some_and(|radar| radar.registration != RegistrationMode::Off)
    };
    let mut followed: Vec<&Tracklet> = target.followed(tracklets).filter(is_estimated).collect();
    followed.sort_by_key(|tracklet| (tracklet.key.sensor, tracklet.id));
    let mut pairs = Vec::new();
    for (index, one) in followed.iter().enumerate() {
        let others = followed[index + 1..].iter().filter(|other| other.key.sensor != one.key.sensor);
        pairs.extend(others.map(|other| (target, *one, *other)));
    }
    pairs.into_iter()
}

/// Whether no other track of either radar is near two tracks.
fn is_alone(one: &Tracklet, other: &Tracklet, places: &SpatialIndex<TrackletId>, cycle: &Cycle) -> bool {
    let near =
        [one, other].into_iter().filter_map(|tracklet| tracklet.nearest(cycle.centre)).flat_map(|plot| {
            places
                .within(plot.position, ALONE_M)
                .filter(move |(place, _)| (place.0 - plot.position.0).xy().norm() <= ALONE_M)
        });
    let mut rivals = near.filter(|(_, id)| {
        let sensor = id.track.sensor;
        (sensor == one.key.sensor || sensor == other.key.sensor) && *id != one.id && *id != other.id
    });
    rivals.next().is_none()
}

/// A plot and the place of the other radar's track at its time.
fn look(
    plot: &CorrectedPlot,
    other: &Tracklet,
    radars: (&RadarSettings, &RadarSettings),
    target: &Target,
) -> Option<SharedLook> {
    let CorrectedPlot { plot, raw } = plot;
    let apart_s = COMPARE_WITHIN_S.max(TRACK_LASTS_PERIODS * radars.1.period_s);
    let (raw_there, ..) = other.raw_at(plot.time, apart_s)?;
    let (there, since_s, until_s) = other.place_at(plot.time, apart_s)?;
    let expected = target.estimate(plot.time)?;
    let origins = [radars.0.position, radars.1.position];
    let corrected = |radar: Enu, seen: Enu, place: Enu| {
        let [seen, place] = [seen, place].map(|place| place.0 - radar.0);
        Vector2::new(
            seen.xy().perp(&place.xy()).atan2(seen.xy().dot(&place.xy())),
            seen.norm() - place.norm(),
        )
    };
    Some(SharedLook {
        time: plot.time,
        radars: origins,
        plots: [plot.position, there],
        corrected: [corrected(origins[0], *raw, plot.position), corrected(origins[1], raw_there, there)],
        place: expected.position,
        velocity: expected.velocity.xy(),
        between_m: 0.5 * BETWEEN_REPORTS_M_S2 * since_s * until_s,
    })
}
