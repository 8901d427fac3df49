//! Likelihood ratio that tracks of two radars are one aircraft, from the offset between them ([`evidence`]).
//!
//! Tracks near each other are compared if they have no transponder: the plots of the track that began later with the
//! position of the other at their times.
//!
//! A track is compared with a target through the target's tracks of other radars. Each of the target's own tracks is
//! compared with those that were there before it: if they separate, the last one leaves.

mod evidence;

pub(super) use evidence::RadarPairEvidence;
use evidence::ReferencePosition;

use super::cycle::{Cycle, EARLIEST, LATEST};
use super::ids::{TargetId, TrackletId};
use super::settings::{OperationalSettings, RadarSettings};
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    BETWEEN_REPORTS_M_S2, COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS, INITIATION_HOLD,
    TRACK_LASTS_PERIODS,
};
use crate::frames::Enu;
use crate::report::Plot;
use crate::time::Time;

/// A radar track without a transponder position, and its position in the slot.
struct PlacedTrack<'a> {
    tracklet: &'a Tracklet,
    place: Enu,
    /// Standard deviation of its plot, metres.
    sigma_m: f64,
}

/// Adds the plots since the last slot to the likelihoods of radar tracks near each other.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    let settings = cycle.settings;
    if settings.radars().nth(1).is_none() {
        return;
    }
    let mut by_east: Vec<PlacedTrack> =
        tracklets.iter().filter_map(|tracklet| placed_track(tracklet, targets, cycle)).collect();
    by_east.sort_by(|a, b| a.place.0.x.total_cmp(&b.place.0.x));
    let widest_m = by_east.iter().map(|seen| seen.sigma_m).fold(0.0, f64::max);
    let mut compared: Vec<(TrackletId, TrackletId, RadarPairEvidence)> = Vec::new();
    for seen in &by_east {
        let own = seen.tracklet;
        for other in near(&by_east, widest_m, seen) {
            let known = own.mutual_with(other.id);
            let from = if known.is_some() { cycle.previous } else { EARLIEST };
            let mut pair = known.copied().unwrap_or_default();
            add(&mut pair, own.between(from, cycle.centre), own, other, settings);
            // Also if there are no plots up to the slot: the later ones are compared separately.
            compared.push((own.id, other.id, pair));
        }
    }
    tracklets.iter_mut().for_each(|tracklet| tracklet.forget_mutual(cycle.centre + -INITIATION_HOLD));
    for (one, other, pair) in compared {
        for (of, with) in [(one, other), (other, one)] {
            if let Some(tracklet) = tracklets.get_mut(of) {
                tracklet.set_mutual(with, pair);
            }
        }
    }
}

/// Updates the likelihoods of a track handed over by another engine, with the plots since then. Pairs of tracks of the
/// same handover are updated once.
pub(super) fn catch_up(
    tracklets: &mut Tracklets,
    id: TrackletId,
    met: &[TrackletId],
    (since, until): (Time, Time),
    settings: &OperationalSettings,
) {
    let Some(own) = tracklets.get(id) else { return };
    let mut compared: Vec<(TrackletId, RadarPairEvidence)> = own.radar_pairs().to_vec();
    compared.retain(|(other, _)| *other > id || !met.contains(other));
    for (other, pair) in &mut compared {
        let Some(other) = tracklets.get(*other) else { continue };
        let (earlier, later) = if own.id < other.id { (own, other) } else { (other, own) };
        add(pair, later.between(since, until), later, earlier, settings);
    }
    for (other, pair) in compared {
        for (of, with) in [(id, other), (other, id)] {
            if let Some(tracklet) = tracklets.get_mut(of) {
                tracklet.set_mutual(with, pair);
            }
        }
    }
}

/// Likelihood of a track with the tracks of a target.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrackLikelihood {
    /// LLR including the plots after the slot: whether they stay together.
    pub(super) later: f64,
    /// LLR of the plots up to the slot, and from the later ones back to it: whether they are together.
    pub(super) around: f64,
}

/// Likelihood that a track is that target, by the target's tracks of other radars; for its own target by those that
/// were there before it. `None` without a comparison.
pub(super) fn track_likelihood(
    tracklet: &Tracklet,
    target: &Target,
    tracklets: &Tracklets,
    cycle: &Cycle,
) -> Option<TrackLikelihood> {
    let mut likelihood: Option<TrackLikelihood> = None;
    for other in target.followed(tracklets).take_while(|other| other.id != tracklet.id) {
        let Some(pair) = tracklet.mutual_with(other.id) else { continue };
        let (earlier, later) = if tracklet.id < other.id { (tracklet, other) } else { (other, tracklet) };
        let plots = later.between(cycle.centre, LATEST);
        let (mut forward, mut backward) = (*pair, RadarPairEvidence::default());
        add(&mut forward, plots.clone(), later, earlier, cycle.settings);
        add(&mut backward, plots.rev(), later, earlier, cycle.settings);
        let sum = likelihood.get_or_insert(TrackLikelihood { later: 0.0, around: 0.0 });
        sum.later += forward.llr;
        sum.around += pair.llr + backward.llr;
    }
    likelihood
}

/// LLR of two tracks by all their plots; `None` without a comparison.
pub(super) fn llr(one: &Tracklet, other: &Tracklet, settings: &OperationalSettings) -> Option<f64> {
    let (earlier, later) = if one.id < other.id { (one, other) } else { (other, one) };
    let mut pair = RadarPairEvidence::default();
    add(&mut pair, later.between(EARLIEST, LATEST), later, earlier, settings);
    (!pair.is_empty()).then_some(pair.llr)
}

/// LLR of a track and a target by all plots of the track and of the target's tracks of other radars; `None` without a
/// comparison.
pub(super) fn llr_of_target(
    tracklet: &Tracklet,
    target: &Target,
    tracklets: &Tracklets,
    settings: &OperationalSettings,
) -> Option<f64> {
    let others = target.followed(tracklets).filter(|other| other.key.sensor != tracklet.key.sensor);
    others.filter_map(|other| llr(tracklet, other, settings)).reduce(|sum, llr| sum + llr)
}

/// Gate: whether a track begins near another radar's track.
pub(super) fn begins_near(tracklet: &Tracklet, other: &Tracklet, settings: &OperationalSettings) -> bool {
    let is_near = || {
        let plot = tracklet.nearest(tracklet.first())?;
        let there = other.nearest(plot.time)?;
        let away_s = plot.time.seconds_since(there.time).abs();
        let sigma_m = |plot: &Plot| Some(settings.radar(plot.track.sensor)?.plot_sigma_m(plot.position));
        let gate_m =
            GATE_M + DRONE_SPEED_MAX_M_S * away_s + GATE_SIGMAS * sigma_m(plot)?.hypot(sigma_m(there)?);
        let away_m = (plot.position.0 - there.position.0).xy().norm();
        Some(away_s <= COMPARE_WITHIN_S && away_m <= gate_m)
    };
    tracklet.key.sensor != other.key.sensor && is_near().unwrap_or(false)
}

/// The targets with which a track was compared.
pub(super) fn targets<'a>(
    tracklet: &'a Tracklet,
    tracklets: &'a Tracklets,
    targets: &'a Targets,
) -> impl Iterator<Item = &'a Target> {
    let target = |id: TrackletId| {
        let target = targets.get(tracklets.get(id)?.target()?)?;
        target.is_followed_by(id).then_some(target)
    };
    let mut found: Vec<TargetId> = Vec::new();
    tracklet.radar_pairs().iter().filter_map(move |&(id, _)| target(id)).filter(move |target| {
        let is_new = !found.contains(&target.id());
        found.push(target.id());
        is_new
    })
}

fn placed_track<'a>(tracklet: &'a Tracklet, targets: &Targets, cycle: &Cycle) -> Option<PlacedTrack<'a>> {
    let target = tracklet.target().and_then(|id| targets.get(id));
    if target.is_some_and(|target| target.is_on_curve(cycle.centre, cycle.settings)) {
        return None;
    }
    let plot = tracklet.nearest(cycle.centre)?;
    let sigma_m = cycle.settings.radar(tracklet.key.sensor)?.plot_sigma_m(plot.position);
    let is_near = plot.time.seconds_since(cycle.centre).abs() <= COMPARE_WITHIN_S;
    is_near.then_some(PlacedTrack { tracklet, place: plot.position, sigma_m })
}

/// Gate: the tracks of other radars, begun earlier, that may be one with a track.
fn near<'a>(
    by_east: &'a [PlacedTrack<'a>],
    widest_m: f64,
    seen: &'a PlacedTrack,
) -> impl Iterator<Item = &'a Tracklet> {
    let gate_m = |other_m: f64| {
        GATE_M + DRONE_SPEED_MAX_M_S * COMPARE_WITHIN_S + GATE_SIGMAS * seen.sigma_m.hypot(other_m)
    };
    let PlacedTrack { tracklet, place, .. } = *seen;
    let from = by_east.partition_point(|other| other.place.0.x < place.0.x - gate_m(widest_m));
    by_east[from..]
        .iter()
        .take_while(move |other| other.place.0.x <= place.0.x + gate_m(widest_m))
        .filter(move |other| {
            other.tracklet.key.sensor != tracklet.key.sensor
                && other.tracklet.id < tracklet.id
                && (other.place.0 - place.0).xy().norm() <= gate_m(other.sigma_m)
        })
        .map(|other| other.tracklet)
}

/// Adds the plots of a track at times with a position of the other.
fn add<'a>(
    pair: &mut RadarPairEvidence,
    plots: impl Iterator<Item = &'a Plot>,
    own: &Tracklet,
    other: &Tracklet,
    settings: &OperationalSettings,
) {
    let radar = |tracklet: &Tracklet| settings.radar(tracklet.key.sensor);
    let Some((own, radar)) = radar(own).zip(radar(other)) else { return };
    for plot in plots {
        if let Some(reference) = reference(other, radar, plot.time) {
            pair.add(plot, &reference, own);
        }
    }
}

/// Position of another radar's track at a time.
fn reference(tracklet: &Tracklet, radar: &RadarSettings, time: Time) -> Option<ReferencePosition> {
    let apart_s = COMPARE_WITHIN_S.max(TRACK_LASTS_PERIODS * radar.period_s);
    let (position, since_s, until_s) = tracklet.place_at(time, apart_s)?;
    let between_m = 0.5 * BETWEEN_REPORTS_M_S2 * since_s * until_s;
    let height_measured = tracklet.nearest(time).is_some_and(|plot| plot.height_measured);
    Some(ReferencePosition {
        position,
        height_measured,
        between_m,
        radar: radar.position,
        errors: radar.errors,
    })
}
