//! The pass that publishes: which targets, where, and under which number.

use nalgebra::Matrix2;

use super::cameras::Cameras;
use super::competitors::competitors;
use super::correlation::{Correlations, Verdict};
use super::cycle::Cycle;
use super::ids::TargetId;
use super::shared;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{COAST_MAX_S, UNSEEN_SIGMA_MAX_M};
use super::walk_off;
use crate::filter::StateEstimate;
use crate::numbering::Numbers;
use crate::point::{self, Association, Basis, Because, Point, RadarPart, Source};
use crate::report::Plot;
use crate::slots::SlotGrid;
use crate::time::{SECOND, Time};

/// The points of the slot, in order.
pub(super) fn publish(
    targets: &mut Targets,
    tracklets: &Tracklets,
    cameras: &Cameras,
    correlations: &Correlations,
    numbers: &mut Numbers,
    grid: SlotGrid,
    cycle: &Cycle,
) -> Vec<Point> {
    let Cycle { slot, centre, settings, .. } = *cycle;
    let mut competitors = competitors(tracklets, targets, correlations, cycle);
    let mut points = Vec::with_capacity(targets.as_slice().len());
    let mut returned = 0;
    let known =
        shared::map(settings.threads, targets.as_slice(), |target| Known::of(target, tracklets, cycle));
    for known in known {
        let Known { id, tracklet, plot, estimate, seen, has_radar_height, .. } = known;
        let Some(target) = targets.get_mut(id) else { continue };
        // Where no radar track took part yet, or none lately, the one that is still to begin does.
        let lately = |part: &RadarPart| centre.seconds_since(part.time) <= COAST_MAX_S;
        let ahead =
            || tracklet?.nearest(centre).filter(|_| !target.radar().is_some_and(|(part, _)| lately(&part)));
        if let Some(plot) = plot.or_else(ahead) {
            target.take_part(plot, settings);
        }
        let Some(estimate) = estimate.filter(|_| known.is_worth_showing(target)) else { continue };
        if !targets.number_transponder(id, slot, numbers, &mut returned) {
            continue;
        }
        let Some(target) = targets.get(id) else { continue };
        let because = because(target, tracklet, correlations);
        let radar = target.radar().map(|radar| radar.0);
        let Some(source) = source(target, radar, plot, because, &estimate, cycle) else { continue };
        let estimated = estimated(target, &estimate, seen, has_radar_height, cycle);
        let looked_at_by = target.looked_at_by(cameras, cycle);
        let Some(number) = targets.number(id, &source, slot) else { continue };
        points.push(Point {
            estimate: Some(estimated),
            competitors: competitors.remove(&id).unwrap_or_default(),
            cameras: looked_at_by,
            ..Point::new(number.number, estimate.position, grid.centre(number.since), source)
        });
    }
    // Stable, and each is moved but once.
    points.sort_by_cached_key(|point| (point.source.rank(), point.number));
    points
}

/// What is known of a target, whatever is known of others.
pub(super) struct Known<'a> {
    id: TargetId,
    /// Of its radar tracks the one with the plot nearest to the slot's centre, and that plot where it is there in the slot.
    pub(super) tracklet: Option<&'a Tracklet>,
    pub(super) plot: Option<&'a Plot>,
    /// Where it is, as far as its radar tracks may have walked off.
    pub(super) estimate: Option<StateEstimate>,
    /// Whether its transponder was heard around the slot.
    is_covered: bool,
    /// The last plot of its radar tracks up to the slot's end.
    pub(super) seen: Option<Time>,
    /// Whether its height is a radar's, because its transponder states none, or a coarse one.
    pub(super) has_radar_height: bool,
}

impl<'a> Known<'a> {
    pub(super) fn of(target: &Target, tracklets: &'a Tracklets, cycle: &Cycle) -> Self {
        let tracklet = nearest_track(target, tracklets, cycle);
        let here = tracklet.filter(|tracklet| walk_off::is_there(tracklet, cycle));
        let is_covered = target.is_heard(cycle);
        let mut estimate = target.estimate(cycle.centre);
        if let Some(estimate) = estimate.as_mut().filter(|_| !is_covered) {
            let otherwise_m2 =
                walk_off::of_target(target, tracklets, cycle) + target.doubted_m2(cycle.centre);
            estimate.horizontal += Matrix2::identity() * otherwise_m2;
        }
        Self {
            id: target.id(),
            tracklet,
            plot: here.and_then(|own| own.nearest(cycle.centre)),
            estimate,
            is_covered,
            has_radar_height: target.has_radar_height(tracklets, cycle),
            seen: target.followed(tracklets).filter_map(|tracklet| tracklet.last_before(cycle.end)).max(),
        }
    }

    /// Whether the target is published: what a sensor sees, however badly it is known.
    pub(super) fn is_worth_showing(&self, target: &Target) -> bool {
        self.is_covered
            || self.plot.is_some()
            || self.estimate.as_ref().is_some_and(|estimate| is_known(target, estimate))
    }
}

/// Of the radar tracks that a target is followed by, the one with the plot nearest to the slot's centre.
fn nearest_track<'a>(target: &Target, tracklets: &'a Tracklets, cycle: &Cycle) -> Option<&'a Tracklet> {
    let away = |tracklet: &&Tracklet| {
        let plot = tracklet.nearest(cycle.centre);
        let away = plot.map(|plot| (plot.time.nanos() - cycle.centre.nanos()).abs());
        (!walk_off::is_there(tracklet, cycle), away, tracklet.key)
    };
    target.followed(tracklets).min_by_key(away)
}

/// Whether a target that no sensor sees in this slot is known well enough to be published: with a transponder by its sigma,
/// without one by how long it coasts.
fn is_known(target: &Target, estimate: &StateEstimate) -> bool {
    let coasts_s = match (estimate.since_s, estimate.until_s) {
        (Some(_), Some(_)) => 0.0,
        (since_s, until_s) => since_s.or(until_s).unwrap_or(0.0),
    };
    match target.transponder() {
        Some(_) => estimate.sigma_m() <= UNSEEN_SIGMA_MAX_M,
        None => target.radar().is_some() && coasts_s <= COAST_MAX_S,
    }
}

/// Why the radar track is this target.
pub(super) fn because(target: &Target, tracklet: Option<&Tracklet>, correlations: &Correlations) -> Because {
    let score = tracklet.and_then(|tracklet| tracklet.pair_llr(target.id()));
    let pair = tracklet.zip(target.identity());
    match pair.map(|(tracklet, identity)| correlations.verdict(tracklet.id, identity)) {
        Some(Verdict::Correlated) => Because::Manual { score },
        _ => Because::Likelihood { score: score.unwrap_or(0.0) },
    }
}

/// Who takes part now; where nobody does, who did last (`radar`).
pub(super) fn source(
    target: &Target,
    radar: Option<RadarPart>,
    plot: Option<&Plot>,
    because: Because,
    estimate: &StateEstimate,
    cycle: &Cycle,
) -> Option<Source> {
    let transponder = target.transponder().and_then(|transponder| transponder.part(cycle.end));
    Some(match (transponder, plot.zip(radar)) {
        (Some(transponder), Some((plot, radar))) => {
            let curve = target.on_curve(plot.time, cycle.settings);
            let stated = curve.map_or(transponder.height_measured, |curve| curve.height_measured);
            let apart = plot.position.0 - curve.map_or(estimate.position, |curve| curve.position).0;
            // An assumed height is no part of a distance.
            let distance_m = if plot.height_measured && stated { apart.norm() } else { apart.xy().norm() };
            Source::Fused(radar, transponder, Association { distance_m, because })
        }
        (Some(transponder), None) => Source::Transponder(transponder),
        (None, _) => Source::Radar(radar?),
    })
}

/// How it moves, and what its place rests on. `seen`: the last plot of its radar track up to the slot's end;
/// `has_radar_height`: its height is a radar's, which the bias of a transponder does not move.
pub(super) fn estimated(
    target: &Target,
    estimate: &StateEstimate,
    seen: Option<Time>,
    has_radar_height: bool,
    cycle: &Cycle,
) -> point::Estimate {
    let half_s = cycle.end.seconds_since(cycle.begin) / 2.0;
    let filtered = estimate
        .since_s
        .map(|since_s| Time::from_nanos(cycle.centre.nanos() - (since_s * SECOND as f64).round() as i64));
    let in_slot = |away_s: f64| away_s <= half_s;
    let is_measured = seen.is_some_and(|time| time >= cycle.begin)
        || estimate.since_s.is_some_and(in_slot)
        || estimate.until_s.is_some_and(in_slot);
    // A transponder's bias moves all its reports alike, and what is measured against them.
    let bias = target.transponder().and_then(|transponder| transponder.bias(cycle.settings));
    let mut bias = bias.unwrap_or_default();
    if has_radar_height {
        bias.vertical_m2 = 0.0;
    }
    let along = estimate.velocity.xy();
    point::Estimate {
        velocity: estimate.velocity,
        horizontal: estimate.horizontal
            + Matrix2::identity() * bias.horizontal_m2
            + along * along.transpose() * bias.time_s2,
        vertical_m2: estimate.vertical
            + bias.vertical_m2
            + estimate.velocity.z * estimate.velocity.z * bias.time_s2,
        velocity_covariance: estimate.velocity_covariance,
        position_velocity: estimate.position_velocity,
        height_climb: estimate.height_climb,
        climb_m2s2: estimate.climb,
        lie_m2: 0.0,
        basis: match (estimate.since_s, estimate.until_s) {
            _ if is_measured => Basis::Measured,
            (Some(_), Some(_)) => Basis::Interpolated,
            _ => Basis::Extrapolated,
        },
        last_measurement: seen.max(filtered),
    }
}
