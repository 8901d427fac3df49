//! Radar tracks that begin soon, and whose they are.
//!
//! What is put out is six seconds old, so a radar track that begins some seconds later is known by now. Its plots tell where
//! its aircraft is in this slot, as those of one that has just ended do.

use super::association::{CLASS_MOST, LOST_M, PART, column_of, found_again};
use super::correlation::Decided;
use super::settings::{Radar, Settings};
use super::target::{Target, plot_sigma_m};
use super::tracklet::{TargetId, Tracklet, TrackletId};
use super::{FASTEST, Moment, OFF_M, Operational};
use crate::assignment::{Candidate, assign};
use crate::report::{Plot, SensorIndex};

/// A radar track is looked at that begins within this, seconds.
const SOON_S: f64 = 4.0;
/// It is a target that no sensor tells of now from this logarithm of a likelihood ratio on: less than what one that has begun
/// needs, as there is no target left that it could be.
const FIND_AHEAD: f64 = 3.0;
/// It could be a target from this on.
const COULD_BE: f64 = 0.0;

/// Whether it begins after the slot, and within so many seconds.
pub(super) fn begins_within(seconds: f64, tracklet: &Tracklet, moment: &Moment) -> bool {
    tracklet.first() >= moment.end && tracklet.first().seconds_since(moment.end) < seconds
}

impl Operational {
    /// Decides which of a radar's tracks that begin soon are targets that no sensor tells of now.
    pub(super) fn find_ahead(
        &mut self,
        (sensor, radar): (SensorIndex, &Radar),
        correlated: &Decided,
        moment: &Moment,
        settings: &Settings,
    ) {
        let soon =
            |tracklet: &&Tracklet| tracklet.key.sensor == sensor && begins_within(SOON_S, tracklet, moment);
        let mut taken = Vec::new();
        let mut rows: Vec<TrackletId> = Vec::new();
        let mut columns: Vec<TargetId> = Vec::new();
        let mut candidates: Vec<Vec<Candidate>> = Vec::new();
        for tracklet in self.tracklets.values().filter(soon) {
            if let Some(own) = tracklet.target {
                if self.targets.get(&own).is_none_or(|own| own.tracklet != Some(tracklet.id)) {
                    taken.push(tracklet.id);
                }
                continue;
            }
            let mut row = Vec::new();
            for (id, score) in self.claims(tracklet, radar, correlated, moment) {
                if !self.is_lost(id, moment, settings) {
                    row.clear();
                    break;
                }
                if score > FIND_AHEAD {
                    row.push(Candidate { column: column_of(id, &mut columns), cost: PART - score });
                }
            }
            if !row.is_empty() {
                rows.push(tracklet.id);
                candidates.push(row);
            }
        }
        let chosen = assign(&candidates, columns.len(), 0.0);
        for id in taken {
            self.join(id, None);
        }
        for (id, column) in rows.into_iter().zip(chosen) {
            if let Some(column) = column {
                self.join(id, Some(columns[column]));
            }
        }
    }

    /// The targets that a radar track that begins soon is likely to be, by where they are when it begins, and how likely it is
    /// each: logarithms of likelihood ratios. The nearest first.
    pub(super) fn claims<'a>(
        &'a self,
        tracklet: &'a Tracklet,
        radar: &'a Radar,
        correlated: &'a Decided,
        moment: &Moment,
    ) -> impl Iterator<Item = (TargetId, f64)> + 'a {
        let log_odds = tracklet.existence().log_odds();
        let first = tracklet.nearest(moment.time).filter(|_| log_odds > 0.0);
        let near = first
            .into_iter()
            .flat_map(|first| self.near_at(first, radar).into_iter().map(move |id| (first, id)));
        near.filter_map(move |(first, id)| {
            let there = self.targets[&id].estimate(first.time).filter(|there| there.sigma_m() < LOST_M)?;
            let found = correlated.leaves(tracklet, id).then(|| found_again(first, &there, radar))??;
            let score = tracklet.score(id).unwrap_or(0.0) + found + log_odds.min(CLASS_MOST);
            (score > COULD_BE).then_some((id, score))
        })
    }

    /// The targets that could be where a plot is: by where they were measured last, the nearest first.
    fn near_at(&self, plot: &Plot, radar: &Radar) -> Vec<TargetId> {
        let off_m = OFF_M + 4.0 * plot_sigma_m(radar, plot.position);
        let near = |(&id, target): (&TargetId, &Target)| {
            let newest = target.filter.newest()?;
            let flown_m = FASTEST * plot.time.seconds_since(newest.time).abs();
            let away_m = (plot.position.0 - newest.position.0).xy().norm();
            (away_m <= flown_m + off_m).then_some((away_m, id))
        };
        let mut near: Vec<(f64, TargetId)> = self.targets.iter().filter_map(near).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable
        near.into_iter().map(|(_, id)| id).collect()
    }
}

#[cfg(test)]
mod tests;
