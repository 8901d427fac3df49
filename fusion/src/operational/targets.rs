//! Targets: aircraft with the sensors that see them.

mod together;

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::aircraft_class::AircraftClass;
use super::by_id::ById;
use super::cameras::Cameras;
use super::cycle::{Cycle, EARLIEST, LATEST};
use super::ids::{Begun, TargetId, TrackletId};
use super::likelihood::PairLikelihood;
use super::measured::{height_by_radar, measured_by_radar, measured_by_transponder};
use super::reacquisition_doubt::Doubt;
use super::settings::{OperationalSettings, RadarSettings};
use super::shared;
use super::track_numbers::{TrackNumber, TrackNumbers};
use super::tracklets::{Tracklet, Tracklets};
use super::transponder::{CurvePosition, Transponder};
use super::transponder_types::TransponderTypes;
use super::tuning::{RADAR_HEIGHT_S, TARGET_SILENT_MAX, TRANSPONDER_SILENT_S};
use crate::filter::{By, Measurement, StateEstimate, TargetFilter};
use crate::numbering::{NumberChange, Numbers};
use crate::point::{CameraPart, RadarPart, Source};
use crate::report::{CameraTrackKey, Fix, Identity, Plot, SensorIndex};
use crate::slots::Slot;
use crate::time::Time;
use together::Membership;

/// An aircraft.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Target {
    id: TargetId,
    transponder: Option<Transponder>,
    /// Radar tracks of this target, at most one per radar, in order of association.
    followed: Vec<(SensorIndex, TrackletId)>,
    /// Latest contribution of a radar, and the sigma of its plot, metres.
    radar: Option<(RadarPart, f64)>,
    filter: TargetFilter,
    number: Option<TrackNumber>,
    class: AircraftClass,
    /// Doubt whether the radar tracks followed since the transponder's last report belong to this aircraft.
    doubt: Option<Doubt>,
    /// Time of the newest measurement.
    newest: Time,
}

impl Target {
    fn new(id: TargetId, newest: Time, settings: &OperationalSettings) -> Self {
        let filter = TargetFilter::new(&settings.motion, settings.radars().count());
        Self {
            id,
            transponder: None,
            followed: Vec::new(),
            radar: None,
            filter,
            number: None,
            class: AircraftClass::default(),
            doubt: None,
            newest,
        }
    }

    pub(super) fn id(&self) -> TargetId {
        self.id
    }

    pub(super) fn transponder(&self) -> Option<&Transponder> {
        self.transponder.as_ref()
    }

    pub(super) fn identity(&self) -> Option<Identity> {
        self.transponder.as_ref().map(|transponder| transponder.identity)
    }

    /// Radar tracks of this target, at most one per radar, in order of association.
    pub(super) fn followed<'a>(
        &self,
        tracklets: &'a Tracklets,
    ) -> impl Iterator<Item = &'a Tracklet> + use<'a, '_> {
        self.followed.iter().filter_map(|&(_, id)| tracklets.get(id))
    }

    /// Whether the target follows this radar track.
    pub(super) fn is_followed_by(&self, id: TrackletId) -> bool {
        self.followed.iter().any(|followed| followed.1 == id)
    }

    /// Track number under which the target is published.
    pub(super) fn number(&self) -> Option<TrackNumber> {
        self.number
    }

    pub(super) fn radar(&self) -> Option<(RadarPart, f64)> {
        self.radar
    }

    /// LLR of the class that a radar track is this aircraft. Without a transponder, doubt that the track is a drone counts
    /// against it.
    pub(super) fn class_llr(&self, tracklet: &Tracklet) -> f64 {
        let is_drone = match self.transponder {
            Some(_) => 0.0,
            None => tracklet.existence().log_odds().min(0.0),
        };
        self.class.llr(tracklet) + is_drone
    }

    /// Variance added to the position on each axis over ground, m², because the radar tracks may be another aircraft.
    pub(super) fn doubted_m2(&self, time: Time) -> f64 {
        self.doubt.map_or(0.0, |doubt| doubt.variance_m2(time))
    }

    /// Finalises the state up to the slot, which is published.
    fn finalise(&mut self, tracklets: &Tracklets, cycle: &Cycle) {
        let Cycle { centre, previous, .. } = *cycle;
        self.filter.forget_before(centre);
        let is_heard = |doubt: &Doubt| {
            let since = self.transponder.as_ref().and_then(|own| own.after(doubt.since()).first());
            since.is_some_and(|fix| fix.time <= centre)
        };
        self.doubt = self.doubt.filter(|doubt| !is_heard(doubt));
        for tracklet in self.followed.iter().filter_map(|&(_, id)| tracklets.get(id)) {
            let is_now = tracklet.first() <= centre && tracklet.last() >= centre;
            if is_now && (self.transponder.is_none() || was_likely(tracklet, self.id)) {
                self.class.update(tracklet, centre.seconds_since(previous));
            }
        }
    }

    /// Continues a target of another engine: sets its number, and adds the reports that are newer.
    pub(super) fn resume(&mut self, mut fixes: Vec<Fix>, number: Option<TrackNumber>) {
        self.number = number;
        fixes.sort_by_key(|fix| fix.time);
        let heard = self.transponder.as_ref().and_then(Transponder::last_heard);
        fixes.retain(|fix| heard.is_some_and(|heard| fix.time > heard));
        fixes.into_iter().for_each(|fix| self.insert(fix));
    }

    /// Adds a report of the transponder.
    pub(super) fn insert(&mut self, fix: Fix) {
        self.newest = self.newest.max(fix.time);
        self.transponder.get_or_insert_with(|| Transponder::new(&fix)).insert(fix);
    }

    /// Sets the radar's contribution to the published slot.
    pub(super) fn set_radar_part(&mut self, plot: &Plot, settings: &OperationalSettings) {
        let Some(radar) = settings.radar(plot.track.sensor) else { return };
        self.radar = Some((RadarPart::from(plot), radar.plot_sigma_m(plot.position)));
    }

    /// Position according to the transponder.
    pub(super) fn on_curve(&self, time: Time, settings: &OperationalSettings) -> Option<CurvePosition> {
        self.transponder.as_ref()?.on_curve(time, settings)
    }

    /// Whether the transponder has a position at a time.
    pub(super) fn is_on_curve(&self, time: Time, settings: &OperationalSettings) -> bool {
        self.transponder.as_ref().is_some_and(|transponder| transponder.is_on_curve(time, settings))
    }

    /// Whether the transponder reports around the slot, or is not yet known to be silent.
    pub(super) fn is_heard(&self, cycle: &Cycle) -> bool {
        let Some(transponder) = &self.transponder else { return false };
        let since = |last: Time| cycle.silent_s(last) <= TRANSPONDER_SILENT_S;
        transponder.is_on_curve(cycle.centre, cycle.settings)
            || transponder.last_until(cycle.centre).is_some_and(since)
    }

    /// Whether cameras have begun it, and no other sensor has seen it since.
    pub(super) fn is_of_cameras_alone(&self) -> bool {
        matches!(self.id.begun, Begun::Cameras(..)) && self.transponder.is_none() && self.followed.is_empty()
    }

    /// Whether a camera made the last measurement.
    pub(super) fn is_last_seen_by_cameras(&self) -> bool {
        self.last_measurement().is_some_and(|last| matches!(last.by, By::Camera { .. }))
    }

    /// Estimate of the filter.
    pub(super) fn estimate(&self, time: Time) -> Option<StateEstimate> {
        self.filter.at(time)
    }

    /// Whether one of the reports that shape the transponder's curve at `time` was a jump.
    pub(super) fn jumps_at(&self, time: Time) -> bool {
        let shaped = self.transponder.as_ref().and_then(|own| own.shaped_at(time));
        shaped.is_some_and(|(from, until)| self.filter.has_jumped(from, until))
    }

    /// The last measurement.
    pub(super) fn last_measurement(&self) -> Option<&Measurement> {
        self.filter.newest()
    }

    /// Whether no sensor sees the target at the slot.
    pub(super) fn is_unseen(&self, tracklets: &Tracklets, cycle: &Cycle) -> bool {
        self.followed(tracklets).all(|tracklet| tracklet.last() < cycle.centre)
            && !self.is_on_curve(cycle.centre, cycle.settings)
    }

    /// Whether a new track of this radar could be the target: no track of this radar follows it now, and its transponder is
    /// silent.
    pub(super) fn is_open_to(&self, sensor: SensorIndex, tracklets: &Tracklets, cycle: &Cycle) -> bool {
        self.followed(tracklets)
            .all(|tracklet| tracklet.key.sensor != sensor || tracklet.last() < cycle.centre)
            && !self.is_on_curve(cycle.centre, cycle.settings)
    }

    /// Updates the filter with all measurements. The state up to `since` is final.
    fn filter(&mut self, since: Time, tracklets: &Tracklets, cameras: &Cameras, cycle: &Cycle) {
        let settings = cycle.settings;
        let mut measurements: Vec<Measurement> = Vec::new();
        // A new target has no final state, however long its transponder's first report has waited or its radar track has lasted.
        let is_new = self.filter.newest().is_none();
        let settled = if is_new { EARLIEST } else { since };
        let since = if self.transponder.is_none() { settled } else { since };
        if let Some(transponder) = &self.transponder {
            let fixes = transponder.after(settled).iter();
            let has_radar_height = self.has_radar_height(tracklets, cycle);
            let measured = |fix: &Fix| measured_by_transponder(fix, transponder, has_radar_height, settings);
            measurements.extend(fixes.filter_map(measured));
        }
        for tracklet in self.followed(tracklets) {
            let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
            // Computed on demand, because few plots are used.
            let pair = OnceCell::new();
            let pair = || *pair.get_or_init(|| self.pair_ahead(tracklet, radar, cycle));
            let silence = |time| self.transponder.as_ref()?.silence(time, tracklet.last());
            let lacks_height = self.transponder.as_ref().is_some_and(Transponder::lacks_height);
            let is_silent = |transponder: &Transponder| {
                transponder.is_silent_within(since, tracklet.last(), TRANSPONDER_SILENT_S)
            };
            if !lacks_height && !self.transponder.as_ref().is_none_or(is_silent) {
                continue; // none of its plots is used
            }
            measurements.extend(tracklet.between(since, LATEST).filter_map(|plot| {
                let silence = silence(plot.time);
                let is_used = silence.is_none_or(|(_, silent_s)| silent_s > TRANSPONDER_SILENT_S);
                match is_used {
                    true => Some(measured_by_radar(plot, tracklet.id, radar, silence.map(|s| s.0), pair())),
                    false => (lacks_height && plot.height_measured).then(|| height_by_radar(plot, radar)),
                }
            }));
        }
        // Bearings of one camera cannot start a filter.
        if !is_new || matches!(self.id.begun, Begun::Cameras(..)) {
            measurements.extend(self.bearings(cameras, settled, settings).map(|(_, look)| look));
        }
        // Measurements of one time: the transponder first, then radars in their order.
        measurements.sort_by_key(|measurement| (measurement.time, measurement.sensor()));
        self.filter.measure(settled, &measurements);
        self.newest = self.newest.max(self.filter.newest().map_or(self.newest, |newest| newest.time));
    }

    /// Whether a radar measures the height of an aircraft whose transponder states none, or a coarse one.
    pub(super) fn has_radar_height(&self, tracklets: &Tracklets, cycle: &Cycle) -> bool {
        let since = cycle.begin + jiff::SignedDuration::from_secs_f64(-RADAR_HEIGHT_S);
        self.transponder.as_ref().is_some_and(Transponder::lacks_height)
            && self
                .followed(tracklets)
                .any(|tracklet| tracklet.between(since, LATEST).any(|plot| plot.height_measured))
    }

    /// Bearings of cameras after `since`, while the transponder is silent.
    fn bearings<'a>(
        &'a self,
        cameras: &'a Cameras,
        since: Time,
        settings: &'a OperationalSettings,
    ) -> impl Iterator<Item = (CameraTrackKey, Measurement)> + 'a {
        let silent = |time| self.transponder.as_ref()?.silence(time, time).map(|(_, silent_s)| silent_s);
        let is_used = move |time| silent(time).is_none_or(|silent_s| silent_s > TRANSPONDER_SILENT_S);
        let crossing = move |time| cameras.crossing_of(self.id, time, settings);
        let place_at = move |time| self.estimate(time).or_else(|| crossing(time));
        cameras.of(self.id(), since, place_at, settings).filter(move |(_, look)| is_used(look.time))
    }

    /// Camera tracks that contribute bearings, each with the time of its latest one up to the slot's end.
    pub(super) fn looked_at_by(&self, cameras: &Cameras, cycle: &Cycle) -> Vec<CameraPart> {
        let mut parts: Vec<CameraPart> = Vec::new();
        let looks = self.bearings(cameras, EARLIEST, cycle.settings);
        for (track, Measurement { time, .. }) in looks.filter(|(_, look)| look.time <= cycle.end) {
            match parts.last_mut().filter(|part| part.track == track) {
                Some(part) => part.time = time,
                None => parts.push(CameraPart { track, time }),
            }
        }
        parts
    }

    /// Likelihood of the target and a tracklet, including the plots after the slot.
    fn pair_ahead(
        &self,
        tracklet: &Tracklet,
        radar: &RadarSettings,
        cycle: &Cycle,
    ) -> Option<PairLikelihood> {
        let mut pair = *tracklet.pair(self.id)?;
        let plots = tracklet.between(cycle.centre, LATEST);
        pair.add_plots(plots, self.transponder.as_ref()?, radar, cycle.settings);
        Some(pair)
    }
}

/// All targets.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Targets {
    all: ById<TargetId, Target>,
    by_identity: BTreeMap<Identity, TargetId>,
    numbers: TrackNumbers,
    /// Targets of aircraft with several transponders, one per transponder.
    together: BTreeMap<TargetId, Membership>,
}

impl Targets {
    pub(super) fn get(&self, id: TargetId) -> Option<&Target> {
        self.all.get(id)
    }

    pub(super) fn get_mut(&mut self, id: TargetId) -> Option<&mut Target> {
        self.all.get_mut(id)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Target> {
        self.all.values().iter()
    }

    /// All targets, in order of creation.
    pub(super) fn as_slice(&self) -> &[Target] {
        self.all.values()
    }

    pub(super) fn of_identity(&self, identity: Identity) -> Option<TargetId> {
        self.by_identity.get(&identity).copied()
    }

    /// Identities of all targets.
    pub(super) fn identities(&self) -> impl Iterator<Item = Identity> {
        self.by_identity.keys().copied()
    }

    /// Creates a target from a transponder's reports.
    pub(super) fn insert_transponder(
        &mut self,
        id: TargetId,
        waited: Vec<Fix>,
        fix: Fix,
        settings: &OperationalSettings,
    ) {
        let mut target = Target::new(id, fix.time, settings);
        waited.into_iter().chain([fix]).for_each(|fix| target.insert(fix));
        self.by_identity.insert(fix.identity, id);
        self.all.insert(id, target);
    }

    /// Creates a target from a radar track, without further data.
    pub(super) fn insert_unknown(&mut self, track: TrackletId, cycle: &Cycle) -> TargetId {
        let id = TargetId { slot: cycle.slot, begun: Begun::Track(track) };
        self.all.insert(id, Target::new(id, cycle.centre, cycle.settings));
        id
    }

    /// Creates a target that two cameras see, without further data.
    pub(super) fn insert_sighted(&mut self, id: TargetId, cycle: &Cycle) {
        self.all.insert(id, Target::new(id, cycle.centre, cycle.settings));
    }

    /// Unites a target that only cameras see with another one. Returns the one that ends, and the one that remains: that with a
    /// transponder, otherwise the older one. The number of the one that ends is taken over if the other has none.
    pub(super) fn join(
        &mut self,
        id: TargetId,
        other: TargetId,
        tracklets: &mut Tracklets,
    ) -> (TargetId, TargetId) {
        let has_transponder = self.all.get(other).is_some_and(|other| other.transponder.is_some());
        let (from, to) = if has_transponder || other < id { (id, other) } else { (other, id) };
        let tracks = self.all.get(from).map(|from| from.followed.clone()).unwrap_or_default();
        tracks.into_iter().for_each(|(_, track)| self.assign_track(tracklets, track, Some(to)));
        if let Some(number) = self.detach(from).and_then(|from| from.number) {
            let known = self.own_number(to);
            match self.all.get_mut(to).filter(|_| known.is_none()) {
                Some(to) => to.number = Some(number),
                None => self.numbers.release(number),
            }
        }
        (from, to)
    }

    /// Learns the white noise of each transponder from its reports up to `until`.
    pub(super) fn learn(
        &mut self,
        until: Time,
        types: &mut TransponderTypes,
        settings: &OperationalSettings,
    ) {
        let transponders = self.all.values_mut().iter_mut().filter_map(|target| target.transponder.as_mut());
        transponders.for_each(|transponder| transponder.learn(until, types, settings));
    }

    /// Updates the filter of each target.
    pub(super) fn filter_all(&mut self, tracklets: &Tracklets, cameras: &Cameras, cycle: &Cycle) {
        let filter = |target: &mut Target| target.filter(cycle.previous, tracklets, cameras, cycle);
        shared::on_each(cycle.settings.threads, self.all.values_mut(), filter);
    }

    /// Finalises all targets up to a published slot.
    pub(super) fn finalise(&mut self, tracklets: &Tracklets, cycle: &Cycle) {
        self.all.values_mut().iter_mut().for_each(|target| target.finalise(tracklets, cycle));
    }

    /// Drops reports before `kept`, and targets without a measurement for too long at `time`. Returns the identities of dropped
    /// targets.
    pub(super) fn forget_before(&mut self, kept: Time, time: Time, tracklets: &Tracklets) -> Vec<Identity> {
        let Self { all, by_identity, numbers, .. } = self;
        let mut ended = Vec::new();
        all.retain(|_, target| {
            target.followed.retain(|&(_, id)| tracklets.get(id).is_some());
            if let Some(transponder) = &mut target.transponder {
                transponder.forget_before(kept);
            }
            let is_left = time - target.newest <= TARGET_SILENT_MAX || !target.followed.is_empty();
            if !is_left {
                ended.extend(target.identity());
                end(target, by_identity, numbers);
            }
            is_left
        });
        ended
    }

    /// Drops these targets.
    pub(super) fn forget_all(&mut self, ids: &BTreeSet<TargetId>) {
        let Self { all, by_identity, numbers, .. } = self;
        if ids.is_empty() {
            return;
        }
        all.retain(|id, target| {
            let is_left = !ids.contains(&id);
            if !is_left {
                end(target, by_identity, numbers);
            }
            is_left
        });
    }

    /// Removes a target whose number stays in use, because the target or its successor will be put back.
    pub(super) fn detach(&mut self, id: TargetId) -> Option<Target> {
        let target = self.all.remove(id)?;
        target.identity().into_iter().for_each(|identity| _ = self.by_identity.remove(&identity));
        Some(target)
    }

    /// Adds a target from another engine.
    pub(super) fn insert(&mut self, target: Target) {
        target.identity().into_iter().for_each(|identity| _ = self.by_identity.insert(identity, target.id));
        self.all.insert(target.id, target);
    }

    /// Dissociates a radar track from a target. A target without any other sensor ends; its number is returned, and stays in use.
    pub(super) fn dissociate(&mut self, id: TargetId, track: TrackletId) -> Option<TrackNumber> {
        let left = self.all.get_mut(id)?;
        left.followed.retain(|followed| followed.1 != track);
        let is_over = left.followed.is_empty() && left.transponder.is_none();
        is_over.then(|| self.detach(id))??.number
    }

    /// Releases a number that is no longer used.
    pub(super) fn release(&mut self, number: TrackNumber) {
        self.numbers.release(number);
    }

    /// Records the doubt, if any, when a target with a transponder is associated with a radar track by position.
    pub(super) fn record_doubt(&mut self, id: TargetId, doubt: Option<Doubt>) {
        if let Some(target) = self.all.get_mut(id).filter(|target| target.transponder.is_some())
            && let Some(doubt) = doubt
        {
            target.doubt = Some(doubt.after(target.doubt));
        }
    }

    /// Marks the association of a tracklet, made by position alone, as wrong. The target was elsewhere, so while its transponder
    /// is silent its filter restarts from the transponder's reports.
    pub(super) fn mark_wrong(&mut self, tracklets: &Tracklets, id: TrackletId, cycle: &Cycle) {
        let Some(tracklet) = tracklets.get(id) else { return };
        let Some(left) = tracklet.target().and_then(|left| self.all.get_mut(left)) else { return };
        let is_alone = left.followed.len() == 1 && left.is_followed_by(id);
        let is_silent = !left.is_on_curve(cycle.centre, cycle.settings);
        let is_wrong = is_alone && is_silent && tracklet.spans(cycle) && !was_likely(tracklet, left.id);
        if left.transponder.is_some() && is_wrong {
            left.doubt = None;
            left.filter = TargetFilter::new(&cycle.settings.motion, cycle.settings.radars().count());
        }
    }

    /// Associates a tracklet with a target, or with none. A target that consisted of this tracklet alone ends, and the new target
    /// takes over its number, unless it has a number already.
    pub(super) fn assign_track(&mut self, tracklets: &mut Tracklets, id: TrackletId, now: Option<TargetId>) {
        let Some(tracklet) = tracklets.get_mut(id) else { return };
        let sensor = tracklet.key.sensor;
        let before = tracklet.replace_target(now);
        if before == now {
            return;
        }
        let mut number = None;
        if let Some(before) = before
            && let Some(left) = self.all.get_mut(before).filter(|left| left.is_followed_by(id))
        {
            left.followed.retain(|followed| followed.1 != id);
            if left.followed.is_empty() && left.transponder.is_none() && now.is_some() {
                number = left.number;
                self.all.remove(before);
            }
        }
        if let Some(target) = now.and_then(|id| self.all.get_mut(id)) {
            target.followed.retain(|followed| followed.0 != sensor);
            target.followed.push((sensor, id));
            let known = target.identity().and_then(|identity| self.numbers.of(identity));
            if target.number.is_none() && known.is_none() {
                target.number = number.take();
            }
        }
        number.into_iter().for_each(|number| self.numbers.release(number));
    }

    /// Associates a tracklet with a target, together with tracklets of other radars that are likely to be the same aircraft.
    pub(super) fn follow_together(&mut self, tracklets: &mut Tracklets, id: TrackletId, now: TargetId) {
        let before = tracklets.get(id).and_then(Tracklet::target).filter(|&before| before != now);
        let left = before.and_then(|before| self.all.get(before)).filter(|left| left.transponder.is_none());
        let goes_along = |other: &&Tracklet| {
            let pair = other.mutual_with(id);
            let is_free = |now: &Target| now.followed.iter().all(|followed| followed.0 != other.key.sensor);
            pair.is_some_and(|pair| pair.llr > 0.0) && self.all.get(now).is_some_and(is_free)
        };
        let others: Vec<TrackletId> = left
            .into_iter()
            .flat_map(|left| left.followed(tracklets))
            .filter(goes_along)
            .map(|other| other.id)
            .collect();
        self.assign_track(tracklets, id, Some(now));
        others.into_iter().for_each(|other| self.assign_track(tracklets, other, Some(now)));
    }

    /// Assigns a target's transponder its number for this slot; `false` if all numbers are in use. `returned`: changes of
    /// transponder numbers already processed in this slot.
    pub(super) fn number_transponder(
        &mut self,
        id: TargetId,
        slot: Slot,
        numbers: &mut Numbers,
        returned: &mut usize,
    ) -> bool {
        let Some(transponder) = self.all.get_mut(id).and_then(|target| target.transponder.as_mut()) else {
            return true;
        };
        transponder.numbered = numbers.of(transponder.identity, slot);
        if transponder.numbered.is_none() {
            numbers.note_unnumbered();
            return false;
        }
        // A returned transponder number releases the track number made from it, unless the aircraft is still a target.
        for change in &numbers.changes()[*returned..] {
            if let NumberChange::Returned(given) = change
                && !self.by_identity.contains_key(&given.identity)
            {
                self.numbers.forget(given.identity);
            }
        }
        *returned = numbers.changes().len();
        true
    }

    /// Track numbers kept for aircraft with a transponder.
    pub(super) fn kept_numbers(&self) -> impl Iterator<Item = (Identity, u32, Slot)> {
        self.numbers.recorded()
    }

    /// Restores the track number of a transponder's aircraft after a restart.
    pub(super) fn remember_number(&mut self, identity: Identity, number: u32, since: Slot) {
        self.numbers.remember(identity, number, since);
    }

    /// Track number of a target that is published as `source`.
    pub(super) fn number(&mut self, id: TargetId, source: &Source, slot: Slot) -> Option<TrackNumber> {
        let target = self.all.get_mut(id)?;
        let identity = target.identity();
        let known = target.number.or_else(|| self.numbers.of(identity?));
        let number = known.unwrap_or_else(|| self.numbers.assign(source, slot));
        target.number = Some(number);
        identity.into_iter().for_each(|identity| self.numbers.record(identity, number));
        // Several transponders of one aircraft share the oldest number.
        Some(self.together.get(&id).and_then(Membership::number).unwrap_or(number))
    }
}

/// Ends a target. The aircraft of a transponder keeps its number.
fn end(target: &Target, by_identity: &mut BTreeMap<Identity, TargetId>, numbers: &mut TrackNumbers) {
    match &target.transponder {
        Some(transponder) => _ = by_identity.remove(&transponder.identity),
        None => target.number.into_iter().for_each(|number| numbers.release(number)),
    }
}

/// Whether the transponder's reports ever supported this tracklet as that target.
fn was_likely(tracklet: &Tracklet, target: TargetId) -> bool {
    tracklet.pair(target).is_some_and(|pair| pair.last_likely.is_some())
}
