//! Who is put out, and where.

use std::collections::BTreeSet;

use nalgebra::Matrix2;

use super::correlation::Verdict;
use super::settings::{Radar, Settings};
use super::target::{Target, plot_sigma_m};
use super::tracklet::Tracklet;
use super::{COAST_S, Moment, Operational};
use crate::filter::StateEstimate;
use crate::numbering::{NumberChange, Numbers};
use crate::point::{self, Association, Basis, Because, Point, RadarPart, Source, TransponderPart};
use crate::report::Plot;
use crate::slots::SlotGrid;
use crate::time::{SECOND, Time};

/// A target whose transponder is silent is put out while its place is known to this, one standard deviation, metres,
const KNOWN_M: f64 = 25.0;
/// and better by this factor than a radar would see it there: where it may turn nobody tells, and a deviation is soon too small.
const BETTER: f64 = 0.7;
/// One without, while it is known no worse than a plot by this factor
const WORSE: f64 = 1.1;
/// and this much, metres.
const WORSE_M: f64 = 10.0;

impl Operational {
    /// The points of the slot.
    pub(super) fn points(
        &mut self,
        moment: &Moment,
        grid: SlotGrid,
        settings: &Settings,
        numbers: &mut Numbers,
    ) -> Vec<Point> {
        let mut competitors = self.competitors(moment);
        let Self { targets, tracklets, by_identity, numbers_in_use, names, manual, .. } = self;
        let mut points = Vec::new();
        let mut forgotten = 0;
        for (&id, target) in targets {
            let tracklet = target.tracklet.and_then(|id| tracklets.get(&id));
            let plot = tracklet.and_then(|tracklet| now(tracklet, moment)).copied();
            // Where no radar track took part yet, the one that begins soon does.
            let soon = || tracklet?.nearest(moment.time).filter(|_| target.radar.is_none());
            if let Some(plot) = plot.as_ref().or_else(soon) {
                target.see(plot, settings);
            }
            let seen = tracklet.and_then(|tracklet| tracklet.last_before(moment.end));
            let Some(estimate) = target.estimate(moment.time) else { continue };
            let is_told = target.on_curve(moment.time, settings).is_some();
            if !is_told && !is_known(target, &estimate, settings) {
                continue;
            }
            if let Some(transponder) = &mut target.transponder {
                transponder.numbered = numbers.of(transponder.identity, moment.slot);
                if transponder.numbered.is_none() {
                    numbers.note_unnumbered();
                    continue;
                }
                // With its number goes what was made of it, but for who flies: that one's lasts as long as it does.
                for change in &numbers.changes()[forgotten..] {
                    if let NumberChange::Returned(given) = change
                        && !by_identity.contains_key(&given.identity)
                        && let Some((number, _)) = names.remove(&given.identity)
                    {
                        numbers_in_use.remove(&number);
                    }
                }
                forgotten = numbers.changes().len();
            }
            let identity = target.transponder.as_ref().map(|transponder| transponder.identity);
            let score = tracklet.and_then(|tracklet| tracklet.score(id));
            let verdict =
                tracklet.zip(identity).map(|(tracklet, identity)| manual.verdict(tracklet.id, identity));
            let because = match verdict {
                Some(Verdict::Correlated) => Because::Manual { score },
                _ => Because::Likelihood { score: score.unwrap_or(0.0) },
            };
            let source = source(target, plot.as_ref(), because, &estimate, moment, settings);
            let Some(source) = source else { continue };
            let known = identity.and_then(|identity| names.get(&identity).copied());
            let (number, since) = target.number.or(known).unwrap_or_else(|| {
                let number = first_number(&source, numbers_in_use);
                numbers_in_use.insert(number);
                (number, moment.slot)
            });
            target.number = Some((number, since));
            identity.map(|identity| names.entry(identity).or_insert((number, since)));
            points.push(Point {
                number,
                position: estimate.position,
                first_seen: grid.centre(since),
                source,
                estimate: Some(shown(target, &estimate, seen, moment, settings)),
                competitors: competitors.remove(&id).unwrap_or_default(),
            });
        }
        points.sort_by_key(|point| (point.source.rank(), point.number));
        points
    }
}

/// The plot of a radar track nearest to the slot, where the track spans it.
fn now<'a>(tracklet: &'a Tracklet, moment: &Moment) -> Option<&'a Plot> {
    (tracklet.first() < moment.end && tracklet.last() >= moment.begin)
        .then(|| tracklet.nearest(moment.time))?
}

/// How far a plot of the radar that sees that place best may be off, metres: of each axis in the mean.
fn seen_to_m(estimate: &StateEstimate, settings: &Settings) -> f64 {
    let of = |(_, radar): (_, &Radar)| plot_sigma_m(radar, estimate.position);
    settings.radars().map(of).fold(f64::INFINITY, f64::min)
}

fn is_known(target: &Target, estimate: &StateEstimate, settings: &Settings) -> bool {
    let limit_m = match (&target.transponder, target.radar) {
        (Some(_), _) => KNOWN_M.min(BETTER * seen_to_m(estimate, settings)),
        (None, Some((_, plot_m))) => WORSE * plot_m + WORSE_M,
        (None, None) => 0.0,
    };
    let coasts_s = match (estimate.since_s, estimate.until_s) {
        (Some(_), Some(_)) => 0.0,
        (since_s, until_s) => since_s.or(until_s).unwrap_or(0.0),
    };
    let is_lost = target.transponder.is_none() && coasts_s > COAST_S;
    estimate.sigma_m() <= limit_m && !is_lost
}

/// Who takes part now; where nobody does, who did last. `because`: why the radar track is this target.
fn source(
    target: &Target,
    plot: Option<&Plot>,
    because: Because,
    estimate: &StateEstimate,
    moment: &Moment,
    settings: &Settings,
) -> Option<Source> {
    let radar: Option<RadarPart> = target.radar.map(|(part, _)| part);
    let transponder: Option<TransponderPart> =
        target.transponder.as_ref().and_then(|transponder| transponder.part(moment.end));
    Some(match (transponder, plot.zip(radar)) {
        (Some(transponder), Some((plot, radar))) => {
            let curve = target.on_curve(plot.time, settings).map(|curve| curve.position);
            let distance_m = (plot.position.0 - curve.unwrap_or(estimate.position).0).norm();
            Source::Fused(radar, transponder, Association { distance_m, because })
        }
        (Some(transponder), None) => Source::Transponder(transponder),
        (None, _) => Source::Radar(radar?),
    })
}

/// How it moves, and what its place rests on. `seen`: the last plot of its radar track up to the slot's end.
fn shown(
    target: &Target,
    estimate: &StateEstimate,
    seen: Option<Time>,
    moment: &Moment,
    settings: &Settings,
) -> point::Estimate {
    let half_s = moment.end.seconds_since(moment.begin) / 2.0;
    let filtered = estimate
        .since_s
        .map(|since_s| Time::from_nanos(moment.time.nanos() - (since_s * SECOND as f64).round() as i64));
    let in_slot = |away_s: f64| away_s <= half_s;
    let is_measured = seen.is_some_and(|time| time >= moment.begin)
        || estimate.since_s.is_some_and(in_slot)
        || estimate.until_s.is_some_and(in_slot);
    // What lasts of a transponder's error moves all its reports alike, and what is measured against them.
    let lasting = target.lasting(settings);
    let along = estimate.velocity.xy();
    point::Estimate {
        velocity: estimate.velocity,
        horizontal: estimate.horizontal
            + Matrix2::identity() * lasting.horizontal_m2
            + along * along.transpose() * lasting.time_s2,
        vertical_m2: estimate.vertical
            + lasting.vertical_m2
            + estimate.velocity.z * estimate.velocity.z * lasting.time_s2,
        velocity_covariance: estimate.velocity_covariance,
        basis: match (estimate.since_s, estimate.until_s) {
            _ if is_measured => Basis::Measured,
            (Some(_), Some(_)) => Basis::Interpolated,
            _ => Basis::Extrapolated,
        },
        last_measurement: seen.max(filtered),
    }
}

/// The number that a target gets with its first point, and keeps.
fn first_number(source: &Source, in_use: &BTreeSet<u32>) -> u32 {
    let number = match source {
        Source::Fused(radar, transponder, _) => transponder.number * 10_000 + u32::from(radar.track.number),
        Source::Transponder(transponder) => transponder.number * 10_000,
        Source::Radar(radar) => radar.track.number.into(),
    };
    // A radar's numbers, 0 to 4095, come again; those of targets do not while they last.
    let free = |number: &u32| !in_use.contains(number);
    Some(number).filter(free).or_else(|| (4096..).find(free)).unwrap_or(number)
}
