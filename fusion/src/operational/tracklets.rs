//! Radar tracks, for as long as the radar keeps them.

mod jumping;

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::by_id::ById;
use super::classes::Classes;
use super::cycle::{Cycle, EARLIEST, LATEST};
use super::existence::Existence;
use super::ids::{TargetId, TrackletId};
use super::likelihood::PairLikelihood;
use super::radar_pairs::RadarPairEvidence;
use super::settings::{OperationalSettings, RadarSettings};
use super::shared;
use super::transponder::Transponder;
use super::tuning::{
    CLASS_SETTLES_AFTER_S, DRONE_SPEED_MAX_M_S, GATE_M, INITIATION_HOLD, PAIR_LLR_MAX, TRACK_GATE_SIGMAS,
};
use crate::frames::Enu;
use crate::report::{Plot, RadarTrackKey, SensorIndex};
use crate::slots::Slot;
use crate::time::Time;

/// A plot, and its position before the correction of the radar's misalignment.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct CorrectedPlot {
    pub(super) plot: Plot,
    pub(super) raw: Enu,
}

/// Values about the plots that are needed in every slot.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Marks {
    /// Times of the first and the last plot.
    first: Time,
    last: Time,
    /// Centres of this slot and of the previous one, each with the number of plots up to it.
    centres: [(Time, usize); 2],
}

impl Marks {
    /// Notes a new plot.
    fn add_plot(&mut self, time: Time) {
        self.first = self.first.min(time);
        self.last = self.last.max(time);
        self.centres.iter_mut().filter(|centre| time <= centre.0).for_each(|centre| centre.1 += 1);
    }

    /// Notes that the first plot, which was before the slot, was removed. `first` is the time of the next one.
    fn forget_first(&mut self, first: Time) {
        self.first = first;
        self.centres.iter_mut().for_each(|centre| centre.1 = centre.1.saturating_sub(1));
    }
}

/// The plots of one radar track without a long break.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Tracklet {
    pub(super) id: TrackletId,
    pub(super) key: RadarTrackKey,
    /// The target to which it belongs.
    target: Option<TargetId>,
    /// Plots by time, at least one.
    plots: VecDeque<CorrectedPlot>,
    marks: Marks,
    /// Likelihoods with the targets that came near; by target.
    pairs: Vec<(TargetId, PairLikelihood)>,
    /// Likelihoods with tracks of other radars that came near.
    radar_pairs: Vec<(TrackletId, RadarPairEvidence)>,
    /// Evidence from the plots up to the last slot, with its centre.
    settled: (Existence, Time),
    /// Evidence from all plots, with the time of the last.
    ahead: (Existence, Time),
    /// Whether it has been counted in the class statistics.
    is_class_settled: bool,
}

impl Tracklet {
    fn new(id: TrackletId, plot: CorrectedPlot) -> Self {
        let unknown = (Existence::default(), EARLIEST);
        let (key, plots) = (plot.plot.track, VecDeque::from([plot]));
        let marks = Marks { first: plot.plot.time, last: plot.plot.time, centres: [(EARLIEST, 0); 2] };
        let (pairs, radar_pairs) = (Vec::new(), Vec::new());
        Self {
            id,
            key,
            target: None,
            plots,
            marks,
            pairs,
            radar_pairs,
            settled: unknown,
            ahead: unknown,
            is_class_settled: false,
        }
    }

    /// Adds a plot; of two with one time, the last received counts.
    fn insert(&mut self, new: CorrectedPlot) {
        let time = new.plot.time;
        if time <= self.ahead.1 {
            // Out of order: starts again from the last slot.
            self.ahead = self.settled;
        }
        let index = self.index(time);
        match self.plots.get_mut(index) {
            Some(same) if same.plot.time == time => *same = new,
            _ => {
                self.plots.insert(index, new);
                self.marks.add_plot(time);
            }
        }
    }

    /// Adds the plots after its last one from the same track of another engine.
    pub(super) fn merge(&mut self, other: Self) {
        let last = self.last();
        other.plots.into_iter().filter(|plot| plot.plot.time > last).for_each(|plot| self.insert(plot));
    }

    /// Whether a plot with its number belongs to it: without a break, and within the reach of a drone, since a radar
    /// may reassign a number at once.
    fn continues_with(&self, plot: &Plot, radar: &RadarSettings) -> bool {
        let track_break = radar.track_break();
        plot.time - self.last() <= track_break
            && self.first() - plot.time <= track_break
            && self.nearest(plot.time).is_some_and(|near| {
                let flown_m = DRONE_SPEED_MAX_M_S * near.time.seconds_since(plot.time).abs();
                let off_m = GATE_M + TRACK_GATE_SIGMAS * radar.plot_sigma_m(near.position);
                (near.position.0 - plot.position.0).xy().norm() <= flown_m + off_m
            })
    }

    /// Removes the plots before `time`; returns whether any is left.
    fn forget_before(&mut self, time: Time) -> bool {
        while self.first() < time {
            self.plots.pop_front();
            self.marks.forget_first(self.plots.front().map_or(LATEST, |first| first.plot.time));
        }
        !self.plots.is_empty()
    }

    /// Advances to the slot with this centre.
    fn advance(&mut self, centre: Time) {
        let [(_, mut count), _] = self.marks.centres;
        while self.plots.get(count).is_some_and(|plot| plot.plot.time <= centre) {
            count += 1;
        }
        self.marks.centres = [(centre, count), self.marks.centres[0]];
    }

    /// Whether a plot with its number at `time` would belong to another track.
    pub(super) fn has_ended(&self, time: Time, settings: &OperationalSettings) -> bool {
        settings.radar(self.key.sensor).is_none_or(|radar| time - self.last() > radar.track_break())
    }

    /// Time of the first plot that is kept.
    pub(super) fn first(&self) -> Time {
        self.marks.first
    }

    /// Time of the last plot.
    pub(super) fn last(&self) -> Time {
        self.marks.last
    }

    /// The last plot up to `time`.
    pub(super) fn last_until(&self, time: Time) -> Option<&Plot> {
        Some(&self.plots[self.count_until(time).checked_sub(1)?].plot)
    }

    /// Time of the last plot before `time`.
    pub(super) fn last_before(&self, time: Time) -> Option<Time> {
        Some(self.plots[self.index(time).checked_sub(1)?].plot.time)
    }

    /// Whether it spans the slot.
    pub(super) fn spans(&self, cycle: &Cycle) -> bool {
        self.first() < cycle.end && self.last() >= cycle.begin
    }

    /// Whether it begins after the slot, and within `seconds`.
    pub(super) fn begins_within(&self, seconds: f64, cycle: &Cycle) -> bool {
        self.first() >= cycle.end && self.first().seconds_since(cycle.end) < seconds
    }

    /// The plot nearest to a time.
    pub(super) fn nearest(&self, time: Time) -> Option<&Plot> {
        // Compares the two plots around a time, also if one of them is at that time.
        let index = self.count_until(time);
        let beside = [index.checked_sub(1), Some(index)].into_iter().flatten();
        let beside = beside.filter_map(|index| Some(&self.plots.get(index)?.plot));
        beside.min_by_key(|plot| (plot.time.nanos() - time.nanos()).abs())
    }

    /// Index of the first plot from `time` on.
    fn index(&self, time: Time) -> usize {
        let (first, last) = (self.first(), self.last());
        if last < time {
            return self.plots.len();
        }
        if time <= first {
            return 0;
        }
        // Plots are evenly spaced: the index is a step or two from the proportional one.
        let share = time.seconds_since(first) / last.seconds_since(first);
        let mut index = (share * self.plots.len() as f64) as usize;
        while self.plots.get(index).is_some_and(|plot| plot.plot.time < time) {
            index += 1;
        }
        while index > 0 && self.plots.get(index - 1).is_none_or(|plot| plot.plot.time >= time) {
            index -= 1;
        }
        index
    }

    /// Plots after `since`, up to `until`.
    pub(super) fn between(&self, since: Time, until: Time) -> impl DoubleEndedIterator<Item = &Plot> + Clone {
        self.corrected_between(since, until).map(|plot| &plot.plot)
    }

    /// Plots after `since`, up to `until`, with their positions before the correction.
    pub(super) fn corrected_between(
        &self,
        since: Time,
        until: Time,
    ) -> impl DoubleEndedIterator<Item = &CorrectedPlot> + Clone {
        self.plots.range(self.indices(since, until))
    }

    /// Indices of the plots after `since`, up to `until`.
    fn indices(&self, since: Time, until: Time) -> Range<usize> {
        let from = self.count_until(since);
        from..self.count_until(until).max(from)
    }

    /// Number of plots up to a time.
    fn count_until(&self, time: Time) -> usize {
        match self.marks.centres.iter().find(|centre| centre.0 == time) {
            Some(&(_, count)) => count,
            None => self.index(Time::from_nanos(time.nanos().saturating_add(1))),
        }
    }

    /// Evidence that it is a drone, from all its plots.
    pub(super) fn existence(&self) -> &Existence {
        &self.ahead.0
    }

    /// Returns the mean class probability of the plots up to the slot; once, when there are enough of them.
    pub(super) fn take_class(&mut self) -> Option<f64> {
        let (class_s, mean) = self.settled.0.class();
        let was_settled = std::mem::replace(&mut self.is_class_settled, class_s >= CLASS_SETTLES_AFTER_S);
        (self.is_class_settled && !was_settled).then_some(mean)
    }

    /// The target to which it belongs.
    pub(super) fn target(&self) -> Option<TargetId> {
        self.target
    }

    /// Sets its target, or none; returns the previous one.
    pub(super) fn replace_target(&mut self, target: Option<TargetId>) -> Option<TargetId> {
        std::mem::replace(&mut self.target, target)
    }

    /// The targets with which it was compared.
    pub(super) fn pairs(&self) -> &[(TargetId, PairLikelihood)] {
        &self.pairs
    }

    /// Likelihood with that target, from the plots up to the slot; `None` without a comparison.
    pub(super) fn pair(&self, target: TargetId) -> Option<&PairLikelihood> {
        let index = self.pairs.binary_search_by_key(&target, |pair| pair.0).ok()?;
        Some(&self.pairs[index].1)
    }

    /// LLR with that target, including the penalty.
    pub(super) fn pair_llr(&self, target: TargetId) -> Option<f64> {
        self.pair(target)?.total()
    }

    /// The tracks of other radars with which it was compared.
    pub(super) fn radar_pairs(&self) -> &[(TrackletId, RadarPairEvidence)] {
        &self.radar_pairs
    }

    /// Likelihood with a track of another radar, from the plots up to the slot.
    pub(super) fn mutual_with(&self, other: TrackletId) -> Option<&RadarPairEvidence> {
        self.radar_pairs.iter().find(|pair| pair.0 == other).map(|pair| &pair.1)
    }

    /// Sets the likelihood with another radar's track, from the plots up to the slot.
    pub(super) fn set_mutual(&mut self, other: TrackletId, pair: RadarPairEvidence) {
        match self.radar_pairs.iter_mut().find(|known| known.0 == other) {
            Some(known) => known.1 = pair,
            None => self.radar_pairs.push((other, pair)),
        }
    }

    /// Forgets the tracks with which it was not likely to be one since then.
    pub(super) fn forget_mutual(&mut self, since: Time) {
        self.radar_pairs.retain(|(_, pair)| pair.last_likely.is_some_and(|likely| likely > since));
    }

    /// Position between two plots that are at most `apart_s` apart, and the times from the first and to the second,
    /// seconds.
    pub(super) fn place_at(&self, time: Time, apart_s: f64) -> Option<(Enu, f64, f64)> {
        self.between_plots(time, apart_s, |plot| plot.plot.position)
    }

    /// Such a position before the correction.
    pub(super) fn raw_at(&self, time: Time, apart_s: f64) -> Option<(Enu, f64, f64)> {
        self.between_plots(time, apart_s, |plot| plot.raw)
    }

    fn between_plots(
        &self,
        time: Time,
        apart_s: f64,
        position: impl Fn(&CorrectedPlot) -> Enu,
    ) -> Option<(Enu, f64, f64)> {
        let after = self.index(time);
        let next = self.plots.get(after)?;
        let to = position(next);
        if next.plot.time == time {
            return Some((to, 0.0, 0.0));
        }
        let before = &self.plots[after.checked_sub(1)?];
        let (since_s, until_s) = (time.seconds_since(before.plot.time), next.plot.time.seconds_since(time));
        let (from, share) = (position(before), since_s / (since_s + until_s));
        let place = from.0 + (to.0 - from.0) * share;
        (since_s + until_s <= apart_s).then(|| (Enu::from(place), since_s, until_s))
    }

    /// Compares the plots up to `until` with a transponder: those after `since`, or all if it was not compared before.
    pub(super) fn compare(
        &mut self,
        target: TargetId,
        transponder: &Transponder,
        (since, until): (Time, Time),
        radar: &RadarSettings,
        settings: &OperationalSettings,
    ) {
        let (index, from) = match self.pairs.binary_search_by_key(&target, |pair| pair.0) {
            Ok(index) => (index, since),
            Err(index) => {
                self.pairs.insert(index, (target, PairLikelihood::default()));
                (index, EARLIEST)
            }
        };
        let plots = self.plots.range(self.indices(from, until)).map(|plot| &plot.plot);
        self.pairs[index].1.add_plots(plots, transponder, radar, settings);
    }

    /// Sets its likelihood with a target, as handed over by another engine.
    pub(super) fn set_known_pair(&mut self, target: TargetId, pair: PairLikelihood) {
        match self.pairs.binary_search_by_key(&target, |pair| pair.0) {
            Ok(index) => self.pairs[index].1 = pair,
            Err(index) => self.pairs.insert(index, (target, pair)),
        }
    }

    /// Removes the pairs with targets that are not in `near`, which is sorted, if their evidence is entirely negative
    /// and was so for a while at `time`. A target that comes near again is compared with all the plots again.
    pub(super) fn end_pairs(&mut self, near: &[TargetId], time: Time) {
        let own = self.target;
        self.pairs.retain(|(target, pair)| {
            let was_likely = pair.last_likely.is_some_and(|likely| time - likely < INITIATION_HOLD);
            let is_open = pair.total().is_none_or(|total| total > -PAIR_LLR_MAX);
            is_open || was_likely || own == Some(*target) || near.binary_search(target).is_ok()
        });
    }
}

/// All tracklets.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Tracklets {
    all: ById<TrackletId, Tracklet>,
    by_key: BTreeMap<RadarTrackKey, Vec<TrackletId>>,
    /// Tracklets that were dropped last, in order.
    ended: Vec<TrackletId>,
}

impl Tracklets {
    pub(super) fn get(&self, id: TrackletId) -> Option<&Tracklet> {
        self.all.get(id)
    }

    pub(super) fn get_mut(&mut self, id: TrackletId) -> Option<&mut Tracklet> {
        self.all.get_mut(id)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Tracklet> {
        self.all.values().iter()
    }

    /// Tracklets of one radar, in the order in which they began.
    pub(super) fn of_radar(&self, sensor: SensorIndex) -> impl Iterator<Item = &Tracklet> {
        let of = |number| RadarTrackKey { sensor, number };
        let ids = self.by_key.range(of(u16::MIN)..=of(u16::MAX)).flat_map(|(_, ids)| ids);
        let mut ids: Vec<TrackletId> = ids.copied().collect();
        ids.sort_unstable();
        ids.into_iter().filter_map(|id| self.all.get(id))
    }

    /// All tracklets, in the order in which they began.
    pub(super) fn as_slice(&self) -> &[Tracklet] {
        self.all.values()
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Tracklet> {
        self.all.values_mut().iter_mut()
    }

    /// All tracklets, in the order in which they began.
    pub(super) fn as_mut_slice(&mut self) -> &mut [Tracklet] {
        self.all.values_mut()
    }

    /// Adds a plot, received in this slot, to its tracklet, or to a new one. Returns whether it was added: if too many tracks
    /// begin under its number, it is not.
    pub(super) fn insert(&mut self, plot: Plot, raw: Enu, slot: Slot, radar: &RadarSettings) -> bool {
        let new = CorrectedPlot { plot, raw };
        let ids = self.by_key.entry(plot.track).or_default();
        let continues = |id: &&TrackletId| {
            self.all.get(**id).is_some_and(|tracklet| tracklet.continues_with(&plot, radar))
        };
        match ids.iter().rev().find(continues) {
            Some(&id) => {
                if let Some(tracklet) = self.all.get_mut(id) {
                    tracklet.insert(new);
                }
            }
            None => {
                if jumping::is_jumping(ids, slot) {
                    return false;
                }
                let named = |nth| TrackletId { slot, time: plot.time, track: plot.track, nth };
                let id = (0..).map(named).find(|id| !ids.contains(id)).expect("few begin at once");
                ids.push(id);
                self.all.insert(id, Tracklet::new(id, new));
            }
        }
        true
    }

    /// Removes and returns the tracklets that are the same track as this one of another engine.
    pub(super) fn take_same(&mut self, other: &Tracklet, radar: &RadarSettings) -> Vec<Tracklet> {
        let Self { all, by_key, .. } = self;
        let Some(ids) = by_key.get_mut(&other.key) else { return Vec::new() };
        let is_same = |id: &TrackletId| {
            let first = all.get(*id).and_then(|tracklet| tracklet.plots.front());
            *id == other.id || first.is_some_and(|first| other.continues_with(&first.plot, radar))
        };
        let same: Vec<TrackletId> = ids.extract_if(.., |id| is_same(id)).collect();
        same.into_iter().filter_map(|id| all.remove(id)).collect()
    }

    /// Inserts a tracklet handed over by another engine.
    pub(super) fn insert_handover(&mut self, tracklet: Tracklet) {
        let ids = self.by_key.entry(tracklet.key).or_default();
        ids.retain(|id| *id != tracklet.id);
        ids.push(tracklet.id);
        ids.sort_unstable();
        self.all.insert(tracklet.id, tracklet);
    }

    /// Adds the new plots to the evidence on each tracklet's class and motion.
    pub(super) fn update_evidence(&mut self, classes: &Classes, settings: &OperationalSettings) {
        shared::on_each(settings.threads, self.all.values_mut(), |tracklet| {
            if let Some(radar) = settings.radar(tracklet.key.sensor) {
                let last = tracklet.last();
                let new = tracklet.indices(tracklet.ahead.1, last);
                let (existence, until) = &mut tracklet.ahead;
                existence.add(tracklet.plots.range(new).map(|plot| &plot.plot), radar);
                existence.classify(classes.of(tracklet.key.sensor));
                *until = last;
            }
        });
    }

    /// Advances to the slot with this centre.
    pub(super) fn advance(&mut self, centre: Time) {
        self.iter_mut().for_each(|tracklet| tracklet.advance(centre));
    }

    /// Settles the plots up to a published slot.
    pub(super) fn finalise(&mut self, until: Time, settings: &OperationalSettings) {
        shared::on_each(settings.threads, self.all.values_mut(), |tracklet| {
            if let Some(radar) = settings.radar(tracklet.key.sensor) {
                let new = tracklet.indices(tracklet.settled.1, until);
                let (existence, since) = &mut tracklet.settled;
                existence.add(tracklet.plots.range(new).map(|plot| &plot.plot), radar);
                *since = until;
            }
        });
    }

    /// Removes plots before `time`, and drops the tracklets without other plots. Also drops tracklets of numbers that jump, and
    /// returns these.
    pub(super) fn forget_before(&mut self, time: Time) -> Vec<TrackletId> {
        let jumping = self.jumping();
        let Self { all, by_key, ended, .. } = self;
        ended.clear();
        all.retain(|id, tracklet| {
            let is_left = tracklet.forget_before(time) && jumping.binary_search(&id).is_err();
            if !is_left {
                ended.push(id);
                if let Some(ids) = by_key.get_mut(&tracklet.key) {
                    ids.retain(|&known| known != id);
                    if ids.is_empty() {
                        by_key.remove(&tracklet.key);
                    }
                }
            }
            is_left
        });
        jumping
    }

    /// Tracklets that were dropped when plots were last removed.
    pub(super) fn ended(&self) -> &[TrackletId] {
        &self.ended
    }

    /// Forgets targets that have been dropped.
    pub(super) fn forget_targets(&mut self, is_left: impl Fn(&TargetId) -> bool) {
        for tracklet in self.iter_mut() {
            tracklet.pairs.retain(|(id, _)| is_left(id));
            tracklet.target = tracklet.target.filter(&is_left);
        }
    }

    /// The radar track with this number in the slot with this centre; otherwise one that begins later.
    pub(super) fn with_number(
        &self,
        key: RadarTrackKey,
        time: Time,
        settings: &OperationalSettings,
    ) -> Option<&Tracklet> {
        let tracklets = self.by_key.get(&key)?.iter().filter_map(|&id| self.all.get(id));
        let lasting = tracklets.filter(|tracklet| !tracklet.has_ended(time, settings));
        lasting.max_by_key(|tracklet| match tracklet.first() <= time {
            true => (true, tracklet.last().nanos()),
            false => (false, -tracklet.first().nanos()),
        })
    }
}

#[cfg(test)]
mod tests;
