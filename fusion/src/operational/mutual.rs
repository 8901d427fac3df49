//! Whether tracks of two radars are one aircraft: the likelihood ratio of the offset between them.
//!
//! Each track is compared with the targets that other radars see near it, where no transponder tells: with the place of
//! another radar's track at the time of each plot. In range and azimuth of its own radar the offset is that one's bias less
//! the other's, which the axes of the other radar spread over both.
//!
//! Of a target's tracks each is compared with those that were there before it: so where they move apart the one leaves that
//! came last.

use super::cycle::{Cycle, EARLIEST, LATEST};
use super::ids::TargetId;
use super::likelihood::{PairLikelihood, Reference};
use super::settings::{Radar, Settings};
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    BETWEEN_REPORTS_M_S2, COMPARE_WITHIN_S, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS, INITIATION_HOLD,
    TRACK_LASTS_PERIODS,
};
use crate::frames::Enu;
use crate::report::{Plot, SensorIndex};
use crate::time::Time;

/// A target that radars see and no transponder tells of, where it is in the slot.
struct Seen<'a> {
    target: &'a Target,
    place: Enu,
    /// How far the plot may be off, sigma in metres.
    sigma_m: f64,
}

/// Adds the plots since the last slot to the likelihoods of each radar track with the targets near it that other radars see.
pub(super) fn compare(tracklets: &mut Tracklets, targets: &Targets, cycle: &Cycle) {
    if cycle.settings.radars().nth(1).is_none() {
        return;
    }
    let mut by_east: Vec<Seen> = targets.iter().filter_map(|target| seen(target, tracklets, cycle)).collect();
    by_east.sort_by(|a, b| a.place.0.x.total_cmp(&b.place.0.x));
    let widest_m = by_east.iter().map(|seen| seen.sigma_m).fold(0.0, f64::max);
    let compared = |tracklet: &Tracklet| {
        let radar = cycle.settings.radar(tracklet.key.sensor)?;
        let mut near = near(&by_east, widest_m, tracklet, radar, cycle);
        near.sort_by_key(|target| target.id());
        let lately = tracklet.mutual().iter().filter(|(id, pair)| {
            let likely = |time| cycle.centre - time < INITIATION_HOLD;
            let is_kept = pair.last_likely.is_some_and(likely) && !is_told(*id, targets, cycle);
            is_kept && near.iter().all(|target| target.id() != *id)
        });
        let mut mutual: Vec<(TargetId, PairLikelihood)> = lately.copied().collect();
        for target in near {
            let known = tracklet.mutual_with(target.id());
            let from = if known.is_some() { cycle.previous } else { EARLIEST };
            let mut pair = known.copied().unwrap_or_default();
            let plots = tracklet.between(from, cycle.centre);
            add(&mut pair, plots, tracklet, target, tracklets, cycle.settings);
            if pair.total().is_some() {
                mutual.push((target.id(), pair));
            }
        }
        mutual.sort_by_key(|pair| pair.0);
        Some(mutual)
    };
    let compared: Vec<_> = tracklets.iter().map(compared).collect();
    for (tracklet, mutual) in tracklets.iter_mut().zip(compared) {
        tracklet.set_mutual(mutual.unwrap_or_default());
    }
}

/// How likely a track is that target by all plots, also those after the slot; `None` where they were not compared.
pub(super) fn llr(tracklet: &Tracklet, target: &Target, tracklets: &Tracklets, cycle: &Cycle) -> Option<f64> {
    let so_far = *tracklet.mutual_with(target.id())?;
    let mut ahead = PairLikelihood::default();
    let plots = tracklet.between(cycle.centre, LATEST).rev();
    add(&mut ahead, plots, tracklet, target, tracklets, cycle.settings);
    Some(so_far.llr + ahead.llr - so_far.bias_penalty.max(ahead.bias_penalty))
}

/// The same of a target that has begun just now.
pub(super) fn llr_of_new(
    tracklet: &Tracklet,
    target: &Target,
    tracklets: &Tracklets,
    settings: &Settings,
) -> Option<f64> {
    let mut pair = PairLikelihood::default();
    add(&mut pair, tracklet.between(EARLIEST, LATEST), tracklet, target, tracklets, settings);
    pair.total()
}

fn is_told(id: TargetId, targets: &Targets, cycle: &Cycle) -> bool {
    targets.get(id).is_some_and(|target| target.on_curve(cycle.centre, cycle.settings).is_some())
}

fn seen<'a>(target: &'a Target, tracklets: &Tracklets, cycle: &Cycle) -> Option<Seen<'a>> {
    if target.on_curve(cycle.centre, cycle.settings).is_some() {
        return None;
    }
    let of_track = |tracklet: &Tracklet| {
        let plot = nearest(tracklet, cycle.centre)?;
        let sigma_m = cycle.settings.radar(tracklet.key.sensor)?.plot_sigma_m(plot.position);
        Some(Seen { target, place: plot.position, sigma_m })
    };
    target.followed(tracklets).find_map(of_track)
}

/// The plot nearest to a time, not far from it.
fn nearest(tracklet: &Tracklet, time: Time) -> Option<&Plot> {
    let plot = tracklet.nearest(time)?;
    (plot.time.seconds_since(time).abs() <= COMPARE_WITHIN_S).then_some(plot)
}

/// Gate: the targets that a track could be, its own among them.
fn near<'a>(
    by_east: &[Seen<'a>],
    widest_m: f64,
    tracklet: &Tracklet,
    radar: &Radar,
    cycle: &Cycle,
) -> Vec<&'a Target> {
    let Some(plot) = nearest(tracklet, cycle.centre) else { return Vec::new() };
    let gate_m = |other_m: f64| {
        let sigma_m = radar.plot_sigma_m(plot.position).hypot(other_m);
        GATE_M + DRONE_SPEED_MAX_M_S * COMPARE_WITHIN_S + GATE_SIGMAS * sigma_m
    };
    let place = plot.position.0;
    let from = by_east.partition_point(|seen| seen.place.0.x < place.x - gate_m(widest_m));
    by_east[from..]
        .iter()
        .take_while(|seen| seen.place.0.x <= place.x + gate_m(widest_m))
        .filter(|seen| {
            let is_own = tracklet.target() == Some(seen.target.id());
            is_own || (seen.place.0 - place).xy().norm() <= gate_m(seen.sigma_m)
        })
        .map(|seen| seen.target)
        .collect()
}

/// Takes in plots of a track where another radar's track of the target tells where that was.
fn add<'a>(
    pair: &mut PairLikelihood,
    plots: impl Iterator<Item = &'a Plot>,
    tracklet: &Tracklet,
    target: &Target,
    tracklets: &Tracklets,
    settings: &Settings,
) {
    let Some(radar) = settings.radar(tracklet.key.sensor) else { return };
    let others: Vec<(&Tracklet, &Radar)> = target
        .followed(tracklets)
        .take_while(|other| other.id != tracklet.id)
        .filter(|other| other.key.sensor != tracklet.key.sensor)
        .filter_map(|other| Some((other, settings.radar(other.key.sensor)?)))
        .collect();
    if others.is_empty() {
        return;
    }
    let referred = plots.filter_map(|plot| {
        let reference = others.iter().find_map(|(other, radar)| reference(other, radar, plot.time))?;
        Some((plot, reference))
    });
    pair.add_mutual(referred, radar);
}

/// Where another radar's track was.
fn reference(tracklet: &Tracklet, radar: &Radar, time: Time) -> Option<Reference> {
    let apart_s = COMPARE_WITHIN_S.max(TRACK_LASTS_PERIODS * radar.period_s);
    let (position, since_s, until_s) = tracklet.place_at(time, apart_s)?;
    let between_m = 0.5 * BETWEEN_REPORTS_M_S2 * since_s * until_s;
    // Of its neighbours one at least measured the height as it does all.
    let height_measured = tracklet.nearest(time).is_some_and(|plot| plot.height_measured);
    Some(Reference { position, height_measured, between_m, radar: radar.position, errors: radar.errors })
}

/// Whether another track of that radar is the target's now.
pub(super) fn is_taken(target: &Target, sensor: SensorIndex, tracklets: &Tracklets, cycle: &Cycle) -> bool {
    target.followed(tracklets).any(|other| other.key.sensor == sensor && other.last() >= cycle.centre)
}
