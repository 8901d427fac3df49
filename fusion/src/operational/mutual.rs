//! Whether tracks of two radars are one aircraft: the likelihood ratio of the offset between them ([`evidence`]).
//!
//! Tracks that come near each other are compared where no transponder tells: the plots of the one that began later with the
//! place of the other at their times.
//!
//! A track is a target as far as it is one with the target's tracks of other radars. Of those that a target has, each goes by
//! those that were there before it: so where they move apart the one leaves that came last.

mod evidence;

pub(super) use evidence::Evidence;
use evidence::Reference;

use super::cycle::{Cycle, EARLIEST, LATEST};
use super::ids::{TargetId, TrackletId};
use super::settings::{Radar, Settings};
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    BETWEEN_REPORTS_M_S2, COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS, INITIATION_HOLD,
    TRACK_LASTS_PERIODS,
};
use crate::frames::Enu;
use crate::report::Plot;
use crate::time::Time;

/// A radar track of which no transponder tells, where it is in the slot.
struct Seen<'a> {
    tracklet: &'a Tracklet,
    place: Enu,
    /// How far its plot may be off, sigma in metres.
    sigma_m: f64,
}

/// Adds the plots since the last slot to the likelihoods of the radar tracks that are near each other.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    let settings = cycle.settings;
    if settings.radars().nth(1).is_none() {
        return;
    }
    let mut by_east: Vec<Seen> =
        tracklets.iter().filter_map(|tracklet| seen(tracklet, targets, cycle)).collect();
    by_east.sort_by(|a, b| a.place.0.x.total_cmp(&b.place.0.x));
    let widest_m = by_east.iter().map(|seen| seen.sigma_m).fold(0.0, f64::max);
    let mut compared: Vec<(TrackletId, TrackletId, Evidence)> = Vec::new();
    for seen in &by_east {
        let own = seen.tracklet;
        for other in near(&by_east, widest_m, seen) {
            let known = own.mutual_with(other.id);
            let from = if known.is_some() { cycle.previous } else { EARLIEST };
            let mut pair = known.copied().unwrap_or_default();
            add(&mut pair, own.between(from, cycle.centre), own, other, settings);
            // Also where there is nothing to compare up to the slot: it is looked at with what comes after that.
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

/// Takes into the likelihoods of a track that another engine knows what was seen since then; those with the others that were met
/// with it once.
pub(super) fn catch_up(
    tracklets: &mut Tracklets,
    id: TrackletId,
    met: &[TrackletId],
    (since, until): (Time, Time),
    settings: &Settings,
) {
    let Some(own) = tracklets.get(id) else { return };
    let mut compared: Vec<(TrackletId, Evidence)> = own.mutual().to_vec();
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

/// What the tracks of a target tell of another one's being part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    /// As it will be told by the plots after the slot: whether they stay together.
    pub(super) later: f64,
    /// By the plots up to the slot, and back to it by those after it: whether they are together.
    pub(super) around: f64,
}

/// How likely a track is that target, by the target's tracks of other radars; of its own target by those that were there
/// before it. `None` where there is nothing to compare.
pub(super) fn told(
    tracklet: &Tracklet,
    target: &Target,
    tracklets: &Tracklets,
    cycle: &Cycle,
) -> Option<Told> {
    let mut told: Option<Told> = None;
    for other in target.followed(tracklets).take_while(|other| other.id != tracklet.id) {
        let Some(pair) = tracklet.mutual_with(other.id) else { continue };
        let (earlier, later) = if tracklet.id < other.id { (tracklet, other) } else { (other, tracklet) };
        let plots = later.between(cycle.centre, LATEST);
        let (mut forward, mut backward) = (*pair, Evidence::default());
        add(&mut forward, plots.clone(), later, earlier, cycle.settings);
        add(&mut backward, plots.rev(), later, earlier, cycle.settings);
        let sum = told.get_or_insert(Told { later: 0.0, around: 0.0 });
        sum.later += forward.llr;
        sum.around += pair.llr + backward.llr;
    }
    told
}

/// How likely two tracks are one by all their plots; `None` where there is nothing to compare.
pub(super) fn llr(one: &Tracklet, other: &Tracklet, settings: &Settings) -> Option<f64> {
    let (earlier, later) = if one.id < other.id { (one, other) } else { (other, one) };
    let mut pair = Evidence::default();
    add(&mut pair, later.between(EARLIEST, LATEST), later, earlier, settings);
    (!pair.is_empty()).then_some(pair.llr)
}

/// How likely a track is a target by all its plots and all those of the target's tracks of other radars; `None` where there
/// is nothing to compare.
pub(super) fn llr_of_target(
    tracklet: &Tracklet,
    target: &Target,
    tracklets: &Tracklets,
    settings: &Settings,
) -> Option<f64> {
    let others = target.followed(tracklets).filter(|other| other.key.sensor != tracklet.key.sensor);
    others.filter_map(|other| llr(tracklet, other, settings)).reduce(|sum, llr| sum + llr)
}

/// Gate: whether a track begins where another radar's track is then.
pub(super) fn begins_near(tracklet: &Tracklet, other: &Tracklet, settings: &Settings) -> bool {
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

/// The targets that a track was compared with.
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
    tracklet.mutual().iter().filter_map(move |&(id, _)| target(id)).filter(move |target| {
        let is_new = !found.contains(&target.id());
        found.push(target.id());
        is_new
    })
}

fn seen<'a>(tracklet: &'a Tracklet, targets: &Targets, cycle: &Cycle) -> Option<Seen<'a>> {
    let target = tracklet.target().and_then(|id| targets.get(id));
    if target.is_some_and(|target| target.on_curve(cycle.centre, cycle.settings).is_some()) {
        return None;
    }
    let plot = tracklet.nearest(cycle.centre)?;
    let sigma_m = cycle.settings.radar(tracklet.key.sensor)?.plot_sigma_m(plot.position);
    let is_near = plot.time.seconds_since(cycle.centre).abs() <= COMPARE_WITHIN_S;
    is_near.then_some(Seen { tracklet, place: plot.position, sigma_m })
}

/// Gate: the tracks of other radars that a track could be one with, of those that began before it.
fn near<'a>(by_east: &'a [Seen<'a>], widest_m: f64, seen: &'a Seen) -> impl Iterator<Item = &'a Tracklet> {
    let gate_m = |other_m: f64| {
        GATE_M + DRONE_SPEED_MAX_M_S * COMPARE_WITHIN_S + GATE_SIGMAS * seen.sigma_m.hypot(other_m)
    };
    let Seen { tracklet, place, .. } = *seen;
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

/// Takes in plots of a track where another one tells where it was.
fn add<'a>(
    pair: &mut Evidence,
    plots: impl Iterator<Item = &'a Plot>,
    own: &Tracklet,
    other: &Tracklet,
    settings: &Settings,
) {
    let radar = |tracklet: &Tracklet| settings.radar(tracklet.key.sensor);
    let Some((own, radar)) = radar(own).zip(radar(other)) else { return };
    for plot in plots {
        if let Some(reference) = reference(other, radar, plot.time) {
            pair.add(plot, &reference, own);
        }
    }
}

/// Where another radar's track was.
fn reference(tracklet: &Tracklet, radar: &Radar, time: Time) -> Option<Reference> {
    let apart_s = COMPARE_WITHIN_S.max(TRACK_LASTS_PERIODS * radar.period_s);
    let (position, since_s, until_s) = tracklet.place_at(time, apart_s)?;
    let between_m = 0.5 * BETWEEN_REPORTS_M_S2 * since_s * until_s;
    let height_measured = tracklet.nearest(time).is_some_and(|plot| plot.height_measured);
    Some(Reference { position, height_measured, between_m, radar: radar.position, errors: radar.errors })
}
