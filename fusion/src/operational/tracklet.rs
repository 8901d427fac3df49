//! A radar track for as long as the radar keeps it.

use std::collections::VecDeque;

use super::existence::Existence;
use super::pairing::Evidence;
use super::settings::{Radar, Settings};
use super::target::{Target, plot_sigma_m};
use super::{DAWN, EVER, FASTEST, OFF_M};
use crate::frames::Enu;
use crate::registration::TrackComparison;
use crate::report::{Plot, RadarTrackKey};
use crate::time::Time;

/// Tells tracklets apart, also those that had one number after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct TrackletId(pub(super) u64);

/// Tells targets apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct TargetId(pub(super) u64);

/// A plot, and where the radar saw it before anything was put right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) plot: Plot,
    pub(super) raw: Enu,
}

/// The plots of one radar track without a long break.
#[derive(Clone, Debug)]
pub(super) struct Tracklet {
    pub(super) id: TrackletId,
    pub(super) key: RadarTrackKey,
    /// By time; one at least.
    plots: VecDeque<Seen>,
    /// The target it belongs to.
    pub(super) target: Option<TargetId>,
    /// What is known of it and the targets that came near; by target.
    pub(super) pairs: Vec<(TargetId, Evidence)>,
    /// Whether it is a drone, from the plots up to the last slot,
    existence: Existence,
    /// and from all of them up to that of this time.
    ahead: (Existence, Time),
    /// The last slot.
    noted: Time,
    /// What it tells of the radar's registration, as that target.
    pub(super) compared: Option<(TargetId, TrackComparison)>,
}

impl Tracklet {
    pub(super) fn new(id: TrackletId, plot: Plot, raw: Enu) -> Self {
        let plots = VecDeque::from([Seen { plot, raw }]);
        Self {
            id,
            key: plot.track,
            plots,
            target: None,
            pairs: Vec::new(),
            existence: Existence::NEW,
            ahead: (Existence::NEW, DAWN),
            noted: DAWN,
            compared: None,
        }
    }

    /// A plot: of two of one time the last received counts.
    pub(super) fn insert(&mut self, plot: Plot, raw: Enu) {
        if plot.time <= self.ahead.1 {
            // Out of its order: from the last slot anew.
            self.ahead = (self.existence, self.noted);
        }
        let index = self.from(plot.time);
        match self.plots.get_mut(index) {
            Some(same) if same.plot.time == plot.time => *same = Seen { plot, raw },
            _ => self.plots.insert(index, Seen { plot, raw }),
        }
    }

    /// Whether an aircraft could get from its plots to that one: a radar may give a number that it has taken from one to
    /// another at once.
    pub(super) fn reaches(&self, plot: &Plot, radar: &Radar) -> bool {
        self.nearest(plot.time).is_some_and(|near| {
            let flown_m = FASTEST * near.time.seconds_since(plot.time).abs();
            let off_m = OFF_M + 8.0 * plot_sigma_m(radar, near.position);
            (near.position.0 - plot.position.0).xy().norm() <= flown_m + off_m
        })
    }

    /// Forgets the plots before `time`; whether any is left.
    pub(super) fn forget_before(&mut self, time: Time) -> bool {
        while self.first() < time {
            self.plots.pop_front();
        }
        !self.plots.is_empty()
    }

    /// When the first plot was that is kept.
    pub(super) fn first(&self) -> Time {
        self.plots.front().map_or(EVER, |seen| seen.plot.time)
    }

    /// When the last was.
    pub(super) fn last(&self) -> Time {
        self.plots.back().map_or(EVER, |seen| seen.plot.time)
    }

    /// When the last plot before `time` was.
    pub(super) fn last_before(&self, time: Time) -> Option<Time> {
        Some(self.plots[self.from(time).checked_sub(1)?].plot.time)
    }

    /// The plot nearest to a time.
    pub(super) fn nearest(&self, time: Time) -> Option<&Plot> {
        let from = self.from(time);
        let beside = [from.checked_sub(1), Some(from)].into_iter().flatten();
        let beside = beside.filter_map(|index| Some(&self.plots.get(index)?.plot));
        beside.min_by_key(|plot| (plot.time.nanos() - time.nanos()).abs())
    }

    /// The index of the first plot from `time` on.
    fn from(&self, time: Time) -> usize {
        // Most often asked for is what came last.
        let is_before = |seen: &Seen| seen.plot.time < time;
        if self.plots.back().is_none_or(is_before) {
            return self.plots.len();
        }
        self.plots.partition_point(is_before)
    }

    /// Plots after `since`, up to `until`.
    pub(super) fn between(&self, since: Time, until: Time) -> impl DoubleEndedIterator<Item = &Plot> + Clone {
        self.seen_between(since, until).map(|seen| &seen.plot)
    }

    /// The same with where the radar saw them.
    pub(super) fn seen_between(
        &self,
        since: Time,
        until: Time,
    ) -> impl DoubleEndedIterator<Item = &Seen> + Clone {
        let after = |time: Time| self.from(Time::from_nanos(time.nanos().saturating_add(1)));
        let from = after(since);
        self.plots.range(from..after(until).max(from))
    }

    /// Whether it is a drone, by all that is known of it.
    pub(super) fn existence(&self) -> &Existence {
        &self.ahead.0
    }

    /// Looks at the plots that came.
    pub(super) fn look_ahead(&mut self, radar: &Radar) {
        let (existence, until) = self.ahead;
        self.ahead = (existence.with(self.between(until, EVER), radar), self.last());
    }

    /// Settles the plots up to a slot that was put out.
    pub(super) fn note(&mut self, until: Time, radar: &Radar) {
        self.existence = self.existence.with(self.between(self.noted, until), radar);
        self.noted = until;
    }

    /// What is known of it and a target.
    pub(super) fn pair(&mut self, target: TargetId) -> &mut Evidence {
        let index = self.pairs.binary_search_by_key(&target, |pair| pair.0).unwrap_or_else(|index| {
            self.pairs.insert(index, (target, Evidence::default()));
            index
        });
        &mut self.pairs[index].1
    }

    /// How surely it is that target, by the plots up to the slot; `None` where they were never compared.
    pub(super) fn score(&self, target: TargetId) -> Option<f64> {
        let index = self.pairs.binary_search_by_key(&target, |pair| pair.0).ok()?;
        self.pairs[index].1.weight()
    }

    /// What is known of it and a target that it was compared with, with the plots after `time`.
    pub(super) fn evidence_of(
        &self,
        id: TargetId,
        target: &Target,
        time: Time,
        settings: &Settings,
    ) -> Option<Evidence> {
        let radar = settings.radar(self.key.sensor)?;
        let index = self.pairs.binary_search_by_key(&id, |pair| pair.0).ok()?;
        let mut evidence = self.pairs[index].1;
        evidence.add_plots(self.between(time, EVER), target, radar, settings);
        Some(evidence)
    }
}

#[cfg(test)]
mod tests;
