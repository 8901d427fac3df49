//! The pass that publishes: targets, positions, and track numbers.

use nalgebra::Matrix2;

use super::cameras::Cameras;
use super::competitors::competitors;
use super::cycle::Cycle;
use super::ids::TargetId;
use super::manual_association::{ManualAssociations, Verdict};
use super::same_aircraft::{TransponderShare, combined};
use super::shared;
use super::targets::{Target, Targets};
use super::track_drift;
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{COAST_MAX_S, UNSEEN_SIGMA_MAX_M};
use crate::filter::StateEstimate;
use crate::frames::Enu;
use crate::numbering::Numbers;
use crate::point::{
    self, Association, AssociationEvidence, Basis, Point, RadarPart, Source, TransponderPart,
};
use crate::report::Plot;
use crate::slots::SlotGrid;
use crate::time::{SECOND, Time};

/// The points of the slot, in order.
pub(super) fn publish(
    targets: &mut Targets,
    tracklets: &Tracklets,
    cameras: &Cameras,
    correlations: &ManualAssociations,
    numbers: &mut Numbers,
    grid: SlotGrid,
    cycle: &Cycle,
) -> Vec<Point> {
    let Cycle { slot, centre, settings, .. } = *cycle;
    let mut competitors = competitors(tracklets, targets, correlations, cycle);
    let mut points = Vec::with_capacity(targets.as_slice().len());
    let mut returned = 0;
    let known = shared::map(settings.threads, targets.as_slice(), |target| {
        TargetOutput::of(target, tracklets, cameras, cycle)
    });
    for own in &known {
        let &TargetOutput { id, tracklet, plot, .. } = own;
        let Some(target) = targets.get_mut(id) else { continue };
        // Without a radar track lately, the one that begins after the slot takes part.
        let lately = |part: &RadarPart| centre.seconds_since(part.time) <= COAST_MAX_S;
        let ahead =
            || tracklet?.nearest(centre).filter(|_| !target.radar().is_some_and(|(part, _)| lately(&part)));
        if let Some(plot) = plot.or_else(ahead) {
            target.set_radar_part(plot, settings);
        }
        let Some(target) = targets.get(id) else { continue };
        let companions = targets.companions(id).filter_map(|other| {
            let index = known.binary_search_by_key(&other.id(), |known| known.id).ok()?;
            Some((other, &known[index]))
        });
        let Some((position, estimated)) = published_position(target, own, companions, cycle) else {
            continue;
        };
        // A companion keeps its transponder's number while it is a target.
        if !targets.number_transponder(id, slot, numbers, &mut returned) || targets.is_companion(id) {
            continue;
        }
        let Some(target) = targets.get(id) else { continue };
        let because = because(target, tracklet, correlations);
        let radar = target.radar().map(|radar| radar.0);
        let Some(source) = source(target, radar, plot, because, position, cycle) else { continue };
        let looked_at_by = target.looked_at_by(cameras, cycle);
        let also = companion_shares(targets, target, cycle);
        let Some(number) = targets.number(id, &source, slot) else { continue };
        points.push(Point {
            estimate: Some(estimated),
            competitors: competitors.remove(&id).unwrap_or_default(),
            cameras: looked_at_by,
            also,
            ..Point::new(number.number, position, grid.centre(number.since), source)
        });
    }
    // The sort is stable, and moves each point only once.
    points.sort_by_cached_key(|point| (point.source.rank(), point.number));
    points
}

/// Data of one target, independent of other targets.
pub(super) struct TargetOutput<'a> {
    id: TargetId,
    /// The followed radar track with the plot nearest to the slot's centre.
    pub(super) tracklet: Option<&'a Tracklet>,
    pub(super) plot: Option<&'a Plot>,
    /// Position estimate; its covariance allows for a walk-off of the radar tracks.
    pub(super) estimate: Option<StateEstimate>,
    /// Whether its transponder reports around the slot.
    is_covered: bool,
    /// Time of the last plot of its radar tracks up to the slot's end.
    pub(super) seen: Option<Time>,
    /// Whether a radar provides the height, because the transponder states none or a coarse one.
    pub(super) has_radar_height: bool,
}

impl<'a> TargetOutput<'a> {
    pub(super) fn of(target: &Target, tracklets: &'a Tracklets, cameras: &Cameras, cycle: &Cycle) -> Self {
        let tracklet = nearest_track(target, tracklets, cycle);
        let here = tracklet.filter(|tracklet| track_drift::is_present(tracklet, cycle));
        let is_covered = target.is_heard(cycle);
        let mut estimate = target.estimate(cycle.centre);
        if let Some(estimate) = estimate.as_mut().filter(|_| !is_covered) {
            let otherwise_m2 =
                track_drift::of_target(target, tracklets, cycle) + target.doubted_m2(cycle.centre);
            estimate.horizontal += Matrix2::identity() * otherwise_m2;
        }
        if let Some(estimate) = estimate.as_mut().filter(|_| !is_covered && target.is_last_seen_by_cameras())
            && let Some((horizontal, vertical)) =
                cameras.lasting_m2(target.id(), cycle.centre, estimate, cycle.settings)
        {
            estimate.horizontal += horizontal;
            estimate.vertical += vertical;
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

    /// Whether the target is published: a sensor sees it, however inaccurately, or its estimate is accurate enough.
    pub(super) fn is_worth_showing(&self, target: &Target) -> bool {
        self.is_covered
            || self.plot.is_some()
            || self.estimate.as_ref().is_some_and(|estimate| is_known(target, estimate))
    }
}

/// Position of an aircraft, from its target and its companions that are worth showing. `None`: none of them is.
pub(super) fn published_position<'a>(
    target: &'a Target,
    own: &'a TargetOutput<'a>,
    companions: impl Iterator<Item = (&'a Target, &'a TargetOutput<'a>)>,
    cycle: &Cycle,
) -> Option<(Enu, point::Estimate)> {
    let part = |(target, known): (&Target, &TargetOutput)| {
        let estimate = known.estimate.as_ref().filter(|_| known.is_worth_showing(target))?;
        let part = TransponderShare {
            position: estimate.position,
            estimate: estimated(target, estimate, known.seen, known.has_radar_height, cycle),
            gap_s: gap_s(target, cycle),
        };
        Some((known.is_covered, part))
    };
    let own = part((target, own));
    let mut companions = companions.peekable();
    if companions.peek().is_none() {
        // Most aircraft have at most one transponder.
        return own.map(|(_, part)| (part.position, part.estimate));
    }
    let mut parts: Vec<(bool, TransponderShare)> =
        own.into_iter().chain(companions.filter_map(part)).collect();
    if parts.iter().any(|part| part.0) {
        // Silent transponders are left out.
        parts.retain(|part| part.0);
    }
    combined(&parts.into_iter().map(|part| part.1).collect::<Vec<TransponderShare>>())
}

/// Time between the reports of a target's transponder before and after the slot's centre, seconds. Without a later report it ends
/// at the deadline.
fn gap_s(target: &Target, cycle: &Cycle) -> f64 {
    let until = cycle.deadline.max(cycle.centre);
    let silence = target.transponder().and_then(|transponder| transponder.silence(cycle.centre, until));
    silence.map_or(f64::INFINITY, |(_, gap_s)| gap_s)
}

/// The further transponders of an aircraft.
pub(super) fn companion_shares(targets: &Targets, target: &Target, cycle: &Cycle) -> Vec<TransponderPart> {
    let part = |companion: &Target| companion.transponder()?.part(cycle.end);
    targets.companions(target.id()).filter_map(part).collect()
}

/// The followed radar track with the plot nearest to the slot's centre.
fn nearest_track<'a>(target: &Target, tracklets: &'a Tracklets, cycle: &Cycle) -> Option<&'a Tracklet> {
    let away = |tracklet: &&Tracklet| {
        let plot = tracklet.nearest(cycle.centre);
        let away = plot.map(|plot| (plot.time.nanos() - cycle.centre.nanos()).abs());
        (!track_drift::is_present(tracklet, cycle), away, tracklet.key)
    };
    target.followed(tracklets).min_by_key(away)
}

/// Whether a target that no radar or transponder sees in this slot is published: with a transponder by its sigma, without one by
/// the time it has coasted.
fn is_known(target: &Target, estimate: &StateEstimate) -> bool {
    match target.transponder() {
        Some(_) => estimate.sigma_m() <= UNSEEN_SIGMA_MAX_M,
        None => coasts_s(estimate) <= COAST_MAX_S,
    }
}

/// Time from the last position measurement or to the next one, seconds; zero between two.
fn coasts_s(estimate: &StateEstimate) -> f64 {
    match (estimate.since_s, estimate.until_s) {
        (Some(_), Some(_)) => 0.0,
        (since_s, until_s) => since_s.or(until_s).unwrap_or(f64::INFINITY),
    }
}

/// Reason for the association of the radar track with the target.
pub(super) fn because(
    target: &Target,
    tracklet: Option<&Tracklet>,
    correlations: &ManualAssociations,
) -> AssociationEvidence {
    let score = tracklet.and_then(|tracklet| tracklet.pair_llr(target.id()));
    let pair = tracklet.zip(target.identity());
    match pair.map(|(tracklet, identity)| correlations.verdict(tracklet.id, identity)) {
        Some(Verdict::Correlated) => AssociationEvidence::Manual { score },
        _ => AssociationEvidence::Likelihood { score: score.unwrap_or(0.0) },
    }
}

/// Sensors that measure the aircraft now, or the last radar (`radar`). `position`: position of the aircraft.
pub(super) fn source(
    target: &Target,
    radar: Option<RadarPart>,
    plot: Option<&Plot>,
    because: AssociationEvidence,
    position: Enu,
    cycle: &Cycle,
) -> Option<Source> {
    let transponder = target.transponder().and_then(|transponder| transponder.part(cycle.end));
    let is_recent = |part: RadarPart| cycle.centre.seconds_since(part.time) <= COAST_MAX_S;
    Some(match (transponder, plot.zip(radar)) {
        (Some(transponder), Some((plot, radar))) => {
            let curve = target.on_curve(plot.time, cycle.settings);
            let stated = curve.map_or(transponder.height_measured, |curve| curve.height_measured);
            let apart = plot.position.0 - curve.map_or(position, |curve| curve.position).0;
            // An assumed height is excluded from the distance.
            let distance_m = if plot.height_measured && stated { apart.norm() } else { apart.xy().norm() };
            Source::Fused(radar, transponder, Association { distance_m, because })
        }
        (Some(transponder), None) => Source::Transponder(transponder),
        (None, None) if target.is_last_seen_by_cameras() && !radar.is_some_and(is_recent) => Source::Cameras,
        (None, _) => Source::Radar(radar?),
    })
}

/// Velocity, covariance and basis of a point. `seen`: last plot of its radar track up to the slot's end. `has_radar_height`: a
/// radar provides the height, so the transponder's bias does not affect it.
fn estimated(
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
    // A transponder's bias shifts all its reports together, and measurements relative to them.
    let bias = target.transponder().and_then(|transponder| transponder.bias(cycle.settings));
    let mut bias = bias.unwrap_or_default();
    // The part of a constant offset of its heights that is not applied affects the accuracy, too.
    let heights = target.transponder().and_then(|own| cycle.settings.heights.get(&own.identity));
    bias.vertical_m2 += heights.map_or(0.0, |heights| heights.left_m2);
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
