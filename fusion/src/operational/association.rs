//! Which radar track is which target, and which is a new one.

use std::collections::BTreeSet;

use super::ahead::begins_within;
use super::pairing::Evidence;
use super::settings::{Radar, Settings};
use super::target::Target;
use super::tracklet::{TargetId, Tracklet, TrackletId};
use super::{COAST_S, DAWN, EVER, Moment, Operational, existence, pairing};
use crate::assignment::{Candidate, assign};
use crate::filter::{LineOfSight, StateEstimate};
use crate::frames::Enu;
use crate::report::Plot;
use crate::time::{SECOND, Time};

/// A radar track and a target become one from this logarithm of a likelihood ratio on,
pub const JOIN: f64 = 6.0;
/// or from this on if it begins where a target must be that no sensor saw for a while: then it is that one or a new one;
const FIND: f64 = 4.0;
/// they stay so above this, if no other pair is better by
pub const PART: f64 = -4.0;
/// this.
const LOYALTY: f64 = 4.0;
/// Log-odds that a radar track is a drone speak for its being any target, up to this.
pub(super) const CLASS_MOST: f64 = 4.0;
/// A radar track that was likely to be a target has most often walked off from it: it becomes none of its own for so long
/// after that, nanoseconds.
const HOLD_NS: i64 = 6 * SECOND;
/// A target that was not seen for a while is looked for as long as its place is known to this, metres.
pub(super) const LOST_M: f64 = 200.0;
/// And found within this squared distance (Mahalanobis, three dimensions).
const FOUND: f64 = 16.0;
/// Aircraft that are not one are so far apart, one standard deviation, metres: over ground, in height.
const APART_M: (f64, f64) = (300.0, 40.0);

impl Operational {
    /// Adds the plots since the last slot to what is known of each radar track and the transponders near it.
    pub(super) fn compare(&mut self, moment: &Moment, settings: &Settings) {
        let Self { targets, tracklets, .. } = self;
        let here = |(&id, target): (&TargetId, &Target)| {
            Some((id, target.on_curve(moment.time, settings)?.position))
        };
        let mut placed: Vec<(TargetId, Enu)> = targets.iter().filter_map(here).collect();
        placed.sort_by(|a, b| a.1.0.x.total_cmp(&b.1.0.x));
        for tracklet in tracklets.values_mut() {
            let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
            let Some(plot) = tracklet.nearest(moment.time).copied() else { continue };
            let known: BTreeSet<TargetId> = tracklet.pairs.iter().map(|pair| pair.0).collect();
            let near = near(&placed, &plot, moment.time, radar);
            for id in known.iter().copied().chain(near.filter(|id| !known.contains(id))) {
                let Some(target) = targets.get(&id) else { continue };
                // A target that came near only now is compared from the beginning.
                let from = if known.contains(&id) { moment.since } else { DAWN };
                let mut evidence = *tracklet.pair(id);
                evidence.add_plots(tracklet.between(from, moment.time), target, radar, settings);
                *tracklet.pair(id) = evidence;
            }
        }
    }

    /// Decides which radar track is which target, each radar by itself, each target once.
    pub(super) fn assign(&mut self, moment: &Moment, settings: &Settings) {
        let correlated = self.correlated();
        for (sensor, radar) in settings.radars() {
            let lasting_ns = ((3.0 * radar.period_s * SECOND as f64) as i64)
                .max(moment.end.nanos() - moment.begin.nanos());
            let lasts = |tracklet: &&Tracklet| {
                tracklet.key.sensor == sensor
                    && tracklet.first() < moment.end
                    && moment.time.nanos() - tracklet.last().nanos() <= lasting_ns
            };
            let lost = self.lost(moment, settings);
            let mut rows = Vec::new();
            let mut columns: Vec<TargetId> = Vec::new();
            let mut candidates: Vec<Vec<Candidate>> = Vec::new();
            for tracklet in self.tracklets.values().filter(lasts) {
                let mut row = Vec::new();
                for (target, score, found) in self.scores(tracklet, &lost, radar, moment, settings) {
                    if !correlated.leaves(tracklet, target) {
                        continue;
                    }
                    let (least, bonus) = match found {
                        _ if tracklet.target == Some(target) => (PART, LOYALTY),
                        true => (FIND, 0.0),
                        false => (JOIN, 0.0),
                    };
                    if score > least {
                        let column = column_of(target, &mut columns);
                        row.push(Candidate { column, cost: PART - bonus - score });
                    }
                }
                rows.push(tracklet.id);
                candidates.push(row);
            }
            let chosen = assign(&candidates, columns.len(), 0.0);
            for (id, column) in rows.into_iter().zip(chosen) {
                self.join(id, correlated.target(id).or(column.map(|column| columns[column])));
            }
            self.find_ahead((sensor, radar), &correlated, moment, settings);
        }
    }

    /// The targets that a radar track could be, and how likely it is each of them: logarithms of likelihood ratios.
    fn scores(
        &self,
        tracklet: &Tracklet,
        lost: &[(TargetId, StateEstimate)],
        radar: &Radar,
        moment: &Moment,
        settings: &Settings,
    ) -> Vec<(TargetId, f64, bool)> {
        let existence = tracklet.existence();
        if existence.is_none() {
            return Vec::new();
        }
        let class = existence.log_odds().min(CLASS_MOST);
        let compared = tracklet.pairs.iter().filter_map(|(id, evidence)| {
            let is_own = tracklet.target == Some(*id);
            let so_far = evidence.score + class - evidence.strain;
            if so_far + pairing::MOST <= if is_own { PART } else { JOIN } {
                return None; // whatever the plots ahead tell
            }
            let mut later = Evidence::default();
            let plots = tracklet.between(moment.time, EVER).rev();
            later.add_plots(plots, &self.targets[id], radar, settings);
            Some((*id, evidence.score + later.score + class - evidence.strain.max(later.strain), false))
        });
        let mut scores: Vec<(TargetId, f64, bool)> = compared.collect();
        let is_compared = |id: TargetId| tracklet.pairs.binary_search_by_key(&id, |pair| pair.0).is_ok();
        match tracklet.target {
            // Nothing to compare it with: it stays what it is.
            Some(own) if !is_compared(own) => scores.push((own, 0.0, false)),
            Some(_) => {}
            None => {
                let plot = tracklet.nearest(moment.time);
                for (id, estimate) in lost {
                    if let Some(found) = plot.and_then(|plot| found_again(plot, estimate, radar)) {
                        // What was known of the two before it was lost counts as well.
                        scores.retain(|compared| compared.0 != *id);
                        scores.push((*id, tracklet.score(*id).unwrap_or(0.0) + found + class, true));
                    }
                }
            }
        }
        scores
    }

    /// Targets that no sensor tells of now, where they must be.
    fn lost(&self, moment: &Moment, settings: &Settings) -> Vec<(TargetId, StateEstimate)> {
        let lost = self.targets.iter().filter(|(id, _)| self.is_lost(**id, moment, settings));
        lost.filter_map(|(&id, target)| Some((id, target.estimate(moment.time)?)))
            .filter(|(_, estimate)| estimate.sigma_m() < LOST_M)
            .collect()
    }

    /// Whether no sensor tells of it now.
    pub(super) fn is_lost(&self, id: TargetId, moment: &Moment, settings: &Settings) -> bool {
        let target = &self.targets[&id];
        let seen = target.tracklet.and_then(|id| self.tracklets.get(&id));
        seen.is_none_or(|tracklet| tracklet.last() < moment.time)
            && target.on_curve(moment.time, settings).is_none()
    }

    /// Makes the radar track part of that target, or of none.
    pub(super) fn join(&mut self, id: TrackletId, target: Option<TargetId>) {
        let Some(tracklet) = self.tracklets.get_mut(&id) else { return };
        let before = std::mem::replace(&mut tracklet.target, target);
        if before == target {
            return;
        }
        let mut number = None;
        if let Some(before) = before
            && let Some(left) = self.targets.get_mut(&before).filter(|left| left.tracklet == Some(id))
        {
            left.tracklet = None;
            // A target that was this radar track alone has turned out to be another one, which takes its number over.
            if left.transponder.is_none() && target.is_some() {
                number = left.number;
                self.targets.remove(&before);
            }
        }
        if let Some(target) = target.and_then(|id| self.targets.get_mut(&id)) {
            target.tracklet = Some(id);
            let identity = target.transponder.as_ref().map(|transponder| transponder.identity);
            let known = identity.and_then(|identity| self.names.get(&identity));
            // Who comes back has the number that it had before.
            if target.number.is_none() && known.is_none() {
                target.number = number.take();
            }
        }
        number.map(|(number, _)| self.numbers_in_use.remove(&number));
    }

    /// Radar tracks that are no known target become one as soon as they are likely to be drones.
    pub(super) fn begin(&mut self, moment: &Moment, settings: &Settings) {
        let correlated = self.correlated();
        let long_ago = |likely: Time| moment.time.nanos() - likely.nanos() >= HOLD_NS;
        let is_nobodys = |tracklet: &Tracklet| {
            tracklet.pairs.iter().all(|&(id, evidence)| {
                correlated.are_apart(tracklet.id, id)
                    || (evidence.score < 0.0 && evidence.likely.is_none_or(long_ago))
            })
        };
        let is_unclaimed = |tracklet: &Tracklet| {
            correlated.target(tracklet.id).is_none()
                && settings
                    .radar(tracklet.key.sensor)
                    .is_some_and(|radar| self.claims(tracklet, radar, &correlated, moment).next().is_none())
        };
        let begins = |tracklet: &&Tracklet| {
            let is_drone = tracklet.existence().log_odds() >= existence::CONFIRMED;
            // Where one plot alone goes nobody knows.
            let is_track = tracklet.first() < tracklet.last() && tracklet.last() >= moment.time;
            let is_free = || match tracklet.first() < moment.end {
                true => is_nobodys(tracklet),
                false => begins_within(COAST_S, tracklet, moment) && is_unclaimed(tracklet),
            };
            tracklet.target.is_none() && is_track && is_drone && is_free()
        };
        let new: Vec<TrackletId> =
            self.tracklets.values().filter(begins).map(|tracklet| tracklet.id).collect();
        for id in new {
            let target = TargetId(self.next_target);
            self.next_target += 1;
            self.targets.insert(target, Target::new(moment.time, settings));
            self.join(id, Some(target));
            // From the beginning of the radar track.
            let tracklet = self.tracklets.get(&id);
            self.targets
                .entry(target)
                .and_modify(|new| new.measure(target, (DAWN, moment.time), tracklet, settings));
        }
    }
}

/// The column of a target in an assignment; one that has none gets the next.
pub(super) fn column_of(target: TargetId, columns: &mut Vec<TargetId>) -> usize {
    columns.iter().position(|&known| known == target).unwrap_or_else(|| {
        columns.push(target);
        columns.len() - 1
    })
}

/// Those of the targets, which stand by east, that the plot could be of.
fn near<'a>(
    placed: &'a [(TargetId, Enu)],
    plot: &Plot,
    time: Time,
    radar: &Radar,
) -> impl Iterator<Item = TargetId> + 'a {
    let away_s = plot.time.seconds_since(time).abs();
    let seen = LineOfSight::from(radar.position, plot.position);
    let spread_m = (seen.range_m * radar.errors.bias_azimuth).hypot(radar.errors.bias_range_m);
    // The drone's and the plot's own errors, what it flies meanwhile, and four deviations of the radar's.
    let gate_m = 60.0 + 40.0 * away_s + 4.0 * spread_m;
    let place = plot.position;
    let from = placed.partition_point(|near| near.1.0.x < place.0.x - gate_m);
    placed[from..]
        .iter()
        .take_while(move |near| near.1.0.x <= place.0.x + gate_m)
        .filter(move |near| away_s <= 2.0 && (near.1.0 - place.0).xy().norm() <= gate_m)
        .map(|near| near.0)
}

/// How likely a radar track is a target that was not seen for a while, against its being another one: logarithm.
pub(super) fn found_again(plot: &Plot, estimate: &StateEstimate, radar: &Radar) -> Option<f64> {
    let errors = &radar.errors;
    let seen = LineOfSight::from(radar.position, plot.position);
    let spread = estimate.horizontal
        + seen.spread(
            errors.bias_range_m.hypot(errors.noise_range_m),
            errors.bias_azimuth.hypot(errors.noise_azimuth),
        );
    let apart = plot.position.0 - estimate.position.0;
    let mut distance = (apart.xy().transpose() * spread.try_inverse()? * apart.xy()).x;
    let mut score = -0.5 * spread.determinant().ln() + 2.0 * APART_M.0.ln();
    if plot.height_measured {
        let spread = estimate.vertical + errors.bias_height_m.powi(2) + errors.noise_height_m.powi(2);
        distance += apart.z * apart.z / spread;
        score += -0.5 * spread.ln() + APART_M.1.ln();
    }
    (distance < FOUND).then_some(score - 0.5 * distance)
}
