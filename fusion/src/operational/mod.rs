//! The `operational` profile: one target an aircraft, whatever sees it, and one number for its life.
//!
//! Each slot: what came is sorted in; each radar track is compared with the transponders near it; each radar's tracks are
//! assigned to targets, one to one; radar tracks that are nobody's and likely to be drones become targets; each target's
//! measurements are filtered forward and smoothed back to the slot; whoever is known well enough is put out.
//!
//! What is decided depends on the reports received by then and not on the order in which they came.

mod admission;
mod ahead;
mod association;
mod correlation;
mod existence;
mod flight;
#[cfg(test)]
mod flown;
mod output;
mod pairing;
mod registering;
mod settings;
mod target;
mod tracklet;

use std::collections::{BTreeMap, BTreeSet};

use crate::numbering::Numbers;
use crate::point::{Newcomers, Point};
use crate::report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex};
use crate::slots::{Slot, SlotGrid};
use crate::time::{SECOND, Time};
use admission::{Admission, Admitted};
use target::Target;
use tracklet::{TargetId, Tracklet, TrackletId};

pub use association::{JOIN, PART};
pub use correlation::{
    Correlation, HeldCorrelation, NotCorrelated, ResumedCorrelation, SavedCorrelation, Verdict,
};
pub use registering::{Registered, Step};
use settings::Radar;
pub(crate) use settings::Settings;

/// A radar's track number that comes again after so long, and after five of its periods, is another track, nanoseconds.
const BREAK_NS: i64 = 5 * SECOND;
/// Plots are kept this long behind the slot that is put out, nanoseconds.
const PLOTS_NS: i64 = 12 * SECOND;
/// Reports of transponders are kept this long behind it, nanoseconds.
const FIXES_NS: i64 = 20 * SECOND;
/// A target that nothing has been heard of for so long is forgotten, nanoseconds.
const SILENT_NS: i64 = 25 * SECOND;

/// Targets, radar tracks, and what came since the last slot.
#[derive(Debug, Default)]
pub(super) struct Operational {
    plots: Vec<Plot>,
    fixes: Vec<Fix>,
    /// Who may become a target by what a transponder says.
    admission: Admission,
    tracklets: BTreeMap<TrackletId, Tracklet>,
    by_key: BTreeMap<RadarTrackKey, Vec<TrackletId>>,
    targets: BTreeMap<TargetId, Target>,
    by_identity: BTreeMap<Identity, TargetId>,
    next_tracklet: u64,
    next_target: u64,
    /// Centre of the slot before.
    settled: Option<Time>,
    numbers_in_use: BTreeSet<u32>,
    /// The number of each transponder's aircraft, and since when: it comes again with it.
    names: BTreeMap<Identity, (u32, Slot)>,
    /// How each radar is set up.
    registered: BTreeMap<SensorIndex, Registered>,
    /// What an operator has decided.
    manual: correlation::Manual,
}

/// The slot that is put out.
#[derive(Clone, Copy, Debug)]
struct Moment {
    slot: Slot,
    /// Its centre.
    time: Time,
    /// Its end.
    end: Time,
    /// Its beginning.
    begin: Time,
    /// The centre of the slot before.
    since: Time,
}

/// Earlier than everything.
const DAWN: Time = Time::from_nanos(i64::MIN);
/// Later than everything.
const EVER: Time = Time::from_nanos(i64::MAX);

/// No aircraft is faster, metres a second.
const FASTEST: f64 = 40.0;
/// And nothing is measured further off than this and some deviations of the radar's, metres.
const OFF_M: f64 = 60.0;

/// A target that only a radar sees is put out no longer than this after its last plot or before its first, seconds: where it
/// goes nobody tells.
const COAST_S: f64 = 2.0;

/// After a pause of more than this a radar's track number is another track, nanoseconds.
fn break_ns(radar: &Radar) -> i64 {
    BREAK_NS.max((5.0 * radar.period_s * SECOND as f64) as i64)
}

impl Operational {
    /// Takes a report in.
    pub(super) fn handle(&mut self, report: Report) {
        match report {
            Report::Plot(plot) => self.plots.push(plot),
            Report::Fix(fix) => self.fixes.push(fix),
        }
    }

    /// The points of the slot that is put out, in order.
    pub(super) fn emit(
        &mut self,
        slot: Slot,
        grid: SlotGrid,
        settings: &Settings,
        numbers: &mut Numbers,
    ) -> Vec<Point> {
        let time = grid.centre(slot);
        let before = grid.centre(slot.plus(-1));
        let moment = Moment {
            slot,
            time,
            begin: grid.open(slot),
            end: grid.open(slot.plus(1)),
            since: self.settled.unwrap_or(before),
        };
        let settings = &self.registered_settings(settings);
        self.admission.turn(time, |sensor| settings.transponder(sensor).copied());
        self.sort_in(settings);
        self.forget(time);
        self.end_correlations(time, settings);
        self.compare(&moment, settings);
        self.assign(&moment, settings);
        self.register(&moment, settings);
        self.begin(&moment, settings);
        self.filter(&moment, settings);
        let points = self.points(&moment, grid, settings, numbers);
        for target in self.targets.values_mut() {
            target.filter.forget_before(time);
        }
        for tracklet in self.tracklets.values_mut() {
            if let Some(radar) = settings.radar(tracklet.key.sensor) {
                tracklet.note(time, radar);
            }
        }
        self.settled = Some(time);
        points
    }

    /// Brings what came to where it belongs.
    fn sort_in(&mut self, settings: &Settings) {
        self.plots.sort_by_key(|plot| (plot.time, plot.track));
        for plot in std::mem::take(&mut self.plots) {
            let sensor = plot.track.sensor;
            let Some(radar) = settings.radar(sensor) else { continue };
            let raw = plot.position;
            let plot = self.registered.get(&sensor).map_or(plot, |radar_is| radar_is.correct(plot, radar));
            let break_ns = break_ns(radar);
            let ids = self.by_key.entry(plot.track).or_default();
            let belongs = |id: &&TrackletId| {
                self.tracklets.get(id).is_some_and(|tracklet| {
                    plot.time.nanos() - tracklet.last().nanos() <= break_ns
                        && tracklet.first().nanos() - plot.time.nanos() <= break_ns
                        && tracklet.reaches(&plot, radar)
                })
            };
            match ids.iter().rev().find(belongs) {
                Some(id) => {
                    self.tracklets.entry(*id).and_modify(|tracklet| tracklet.insert(plot, raw));
                }
                None => {
                    let id = TrackletId(self.next_tracklet);
                    self.next_tracklet += 1;
                    ids.push(id);
                    self.tracklets.insert(id, Tracklet::new(id, plot, raw));
                }
            }
        }
        for tracklet in self.tracklets.values_mut() {
            if let Some(radar) = settings.radar(tracklet.key.sensor) {
                tracklet.look_ahead(radar);
            }
        }
        self.fixes.sort_by_key(|fix| (fix.time, fix.identity));
        for mut fix in std::mem::take(&mut self.fixes) {
            let Some(receiver) = settings.transponder(fix.sensor) else { continue };
            let delay_s = receiver.delay_s.unwrap_or(0.0);
            fix.time = Time::from_nanos(fix.time.nanos() - (delay_s * SECOND as f64).round() as i64);
            let known = self.by_identity.get(&fix.identity).and_then(|id| self.targets.get_mut(id));
            if let Some(target) = known {
                self.admission.note(fix.identity);
                target.hear(fix);
                continue;
            }
            let admitted = self.admission.offer(&fix, receiver, &mut self.next_target);
            let Some(Admitted { target: id, waited }) = admitted else { continue };
            let mut target = Target::new(fix.time, settings);
            waited.into_iter().chain([fix]).for_each(|fix| target.hear(fix));
            self.by_identity.insert(fix.identity, id);
            self.targets.insert(id, target);
        }
    }

    /// A slot behind the last report of all passes.
    pub(super) fn pass(&mut self, time: Time, settings: &Settings) {
        self.admission.turn(time, |sensor| settings.transponder(sensor).copied());
    }

    /// What became of new identities in the slot that was published.
    pub(crate) fn take_newcomers(&mut self) -> Vec<Newcomers> {
        self.admission.take()
    }

    fn forget(&mut self, time: Time) {
        let before = |by_ns: i64| Time::from_nanos(time.nanos() - by_ns);
        let Self { tracklets, targets, by_key, by_identity, numbers_in_use, registered, .. } = self;
        tracklets.retain(|id, tracklet| {
            let is_left = tracklet.forget_before(before(PLOTS_NS));
            if !is_left
                && let Some((_, along)) = &mut tracklet.compared
                && let Some(registered) = registered.get_mut(&tracklet.key.sensor)
            {
                registered.take(along);
            }
            if !is_left && let Some(ids) = by_key.get_mut(&tracklet.key) {
                ids.retain(|known| known != id);
                if ids.is_empty() {
                    by_key.remove(&tracklet.key);
                }
            }
            is_left
        });
        targets.retain(|_, target| {
            target.tracklet = target.tracklet.filter(|id| tracklets.contains_key(id));
            let heard = target.forget_before(before(FIXES_NS));
            let is_left = heard >= before(SILENT_NS) || target.tracklet.is_some();
            if !is_left {
                match &target.transponder {
                    Some(transponder) => _ = by_identity.remove(&transponder.identity),
                    None => _ = target.number.map(|(number, _)| numbers_in_use.remove(&number)),
                }
            }
            is_left
        });
        for tracklet in tracklets.values_mut() {
            tracklet.pairs.retain(|(id, _)| targets.contains_key(id));
            tracklet.target = tracklet.target.filter(|id| targets.contains_key(id));
        }
    }

    /// Brings each target's filter to what is known now.
    fn filter(&mut self, moment: &Moment, settings: &Settings) {
        let Self { targets, tracklets, .. } = self;
        for (&id, target) in targets {
            let tracklet = target.tracklet.and_then(|id| tracklets.get(&id));
            target.measure(id, (moment.since, moment.time), tracklet, settings);
        }
    }
}
