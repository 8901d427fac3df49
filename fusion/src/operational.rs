//! The `operational` profile: one target per aircraft for all sensors, with one number for its lifetime.
//!
//! `Operational::emit` is the pipeline of passes. Each state has one owner with private fields: `Tracklets`, `Targets`
//! (with their numbers), `Admission`, `ManualAssociations`, `Registrations`. Decisions depend on the reports received by
//! then, not on their order.

mod admission;
mod aircraft_class;
mod association;
mod by_id;
mod cameras;
mod classes;
mod competitors;
mod cycle;
mod existence;
mod handover;
mod heights;
mod ids;
mod initiation;
mod integrity;
mod likelihood;
mod lookalikes;
mod manual_association;
mod measured;
mod now;
mod output;
mod pair_likelihoods;
mod places;
mod radar_pairs;
mod reacquisition;
mod reacquisition_doubt;
mod registrations;
mod relocations;
mod residuals;
mod same_aircraft;
mod settings;
mod shared;
mod targets;
#[cfg(test)]
mod tests;
mod track_drift;
mod track_numbers;
mod tracklets;
mod transponder;
mod transponder_types;
mod tuning;
mod values;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::integrity::{ActiveOverride, Assessment, Concern, TrustOverride};
use crate::learning::{LearningState, LearningStateError, LearntType, TypeState};
use crate::numbering::Numbers;
use crate::point::{JumpingTracks, Newcomers, NowPicture, Point};
use crate::registration::{RegistrationState, RegistrationStateError};
use crate::report::{Bearing, Departed, Fix, Identity, Plot, Report, SensorIndex, TransponderType};
use crate::settings::DECIDED_AFTER;
use crate::slots::{Slot, SlotGrid};
use crate::time::{SECOND, Time};
use admission::{Admission, AdmittedIdentity};
use cameras::Cameras;
use classes::Classes;
use cycle::Cycle;
use handover::PendingHandovers;
use ids::{Begun, TargetId};
use integrity::IdentityAssessments;
use manual_association::ManualAssociations;
use registrations::Registrations;
use relocations::Relocations;
use same_aircraft::SameAircraft;
use targets::Targets;
use tracklets::Tracklets;
use transponder_types::TransponderTypes;
use values::PlannedValues;

pub use cameras::{CameraStarts, OrientedCamera};
pub use classes::LabelledTrack;
pub use handover::{TrackHandover, TrackRef};
pub use manual_association::{
    ActiveAssociation, AssociationRefusal, ManualAssociation, RestoredAssociation, SavedAssociation, Verdict,
};
pub use registrations::{Registered, Step};
pub use relocations::{ActiveRelocation, RadarRelocation, Relocation};
pub(crate) use settings::OperationalSettings;
pub use tuning::{ASSOCIATE_LLR, DISSOCIATE_LLR};
pub use values::SensorValues;

/// State of the profile, and the reports since the last slot.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Operational {
    plots: Vec<Plot>,
    fixes: Vec<Fix>,
    bearings: Vec<Bearing>,
    cameras: Cameras,
    admission: Admission,
    tracklets: Tracklets,
    targets: Targets,
    correlations: ManualAssociations,
    registrations: Registrations,
    relocations: Relocations,
    classes: Classes,
    types: TransponderTypes,
    same_aircraft: SameAircraft,
    integrities: IdentityAssessments,
    /// Centre of the slot that was decided last.
    decided: Option<Time>,
    /// Sensor values learnt by other engines, to be used from a slot on.
    planned: PlannedValues,
    /// Handed-over states of aircraft that this engine will process soon.
    awaited: PendingHandovers,
    /// Aircraft that have left since the last slot.
    left: Vec<Departed>,
}

/// Output of a slot.
#[derive(Debug, Default)]
pub(super) struct SlotOutput {
    /// Points, in order.
    pub(super) points: Vec<Point>,
    /// Integrity concerns about transponders.
    pub(super) concerns: Vec<Concern>,
    /// Counts of new identities.
    pub(super) newcomers: Vec<Newcomers>,
    /// Counts of radar tracks discarded because their numbers jump.
    pub(super) jumping: Vec<JumpingTracks>,
    /// Predicted picture of the deadline, if enabled.
    pub(super) now: Option<NowPicture>,
}

/// Output of the `reference` profile, which has only points.
impl From<Vec<Point>> for SlotOutput {
    fn from(points: Vec<Point>) -> Self {
        Self { points, ..Self::default() }
    }
}

/// The slot that is decided with the reports received by a deadline, at which a later slot may be shown.
fn decided_slot(deadline: Time, shown: Slot, grid: SlotGrid) -> Slot {
    grid.of(deadline + -DECIDED_AFTER).min(shown)
}

/// Number of discarded radar tracks by radar.
fn count_by_radar(jumping: Vec<SensorIndex>) -> Vec<JumpingTracks> {
    let mut counts: BTreeMap<SensorIndex, u32> = BTreeMap::new();
    jumping.into_iter().for_each(|sensor| *counts.entry(sensor).or_default() += 1);
    counts.into_iter().map(|(sensor, discarded)| JumpingTracks { sensor, discarded }).collect()
}

impl Operational {
    /// Accepts a report.
    pub(super) fn handle(&mut self, report: Report) {
        match report {
            Report::Plot(plot) => self.plots.push(plot),
            Report::Fix(fix) => self.fixes.push(fix),
            Report::Bearing(bearing) => self.bearings.push(bearing),
        }
    }

    /// Forgets an aircraft that has left, with the next slot.
    pub(super) fn leave(&mut self, left: Departed) {
        self.left.push(left);
    }

    /// Publishes a slot.
    pub(super) fn emit(
        &mut self,
        slot: Slot,
        grid: SlotGrid,
        settings: &OperationalSettings,
        numbers: &mut Numbers,
    ) -> SlotOutput {
        self.turn_values(slot);
        let mut settings = self.registrations.settings(settings, &mut self.types);
        self.relocations.apply(&mut settings);
        let settings = &settings;
        let deadline = grid.open(slot) + settings.latency;
        let cycle_of = |slot, previous| Cycle::new(slot, deadline, grid, previous, settings);
        let cycle = &cycle_of(decided_slot(deadline, slot, grid), self.decided);
        let shown = &cycle_of(slot, None);
        self.pass(cycle.centre, settings);
        self.apply_pending_handovers(settings);
        let mut jumping = self.sort_plots(cycle.slot, settings);
        self.sort_fixes(cycle.slot, settings);
        self.sort_bearings();
        jumping.extend(self.forget(cycle));
        let Self {
            cameras,
            tracklets,
            targets,
            correlations,
            registrations,
            classes,
            types,
            same_aircraft,
            integrities,
            ..
        } = self;
        pair_likelihoods::compare(tracklets, targets, cycle);
        integrities.assess(tracklets, targets, cycle);
        same_aircraft.assess(targets, tracklets, integrities, cycle);
        same_aircraft.unite(targets, tracklets, cycle);
        let decided = &mut correlations.decided(tracklets, targets);
        integrities.part(decided, tracklets, targets, settings);
        let decided = &*decided;
        let measured = &reacquisition::MeasuredPositions::of(targets);
        association::associate(tracklets, targets, measured, decided, cycle);
        integrities.exclude_suspects(registrations, targets, settings, cycle.centre);
        registrations.register(tracklets, targets, types, cycle);
        initiation::initiate(tracklets, targets, measured, decided, integrities.twins(), cycle);
        cameras.follow(targets, |id| !registrations.ignores(id), cycle);
        cameras.join(targets, tracklets, cycle);
        cameras.start(targets, cycle);
        targets.filter_all(tracklets, cameras, cycle);
        let mut points = output::publish(targets, tracklets, cameras, correlations, numbers, grid, shown);
        let concerns = integrities.mark(&mut points, tracklets, targets, cycle);
        let now = settings.now.then(|| {
            let cycle = &cycle_of(grid.of(deadline), None);
            let mut predicted = now::predict(targets, tracklets, cameras, correlations, grid, cycle);
            integrities.flag(&mut predicted, &points, cycle);
            NowPicture { slot: cycle.slot, time: cycle.centre, points: predicted }
        });
        targets.finalise(tracklets, cycle);
        targets.learn(cycle.centre, types, settings);
        tracklets.finalise(cycle.centre, settings);
        classes.learn(tracklets, targets, cycle);
        self.decided = Some(cycle.centre);
        let (newcomers, jumping) = (self.admission.take_counts(), count_by_radar(jumping));
        SlotOutput { points, concerns, newcomers, jumping, now }
    }

    /// Skips a slot after the last report of the input, in which nothing is shown.
    pub(super) fn skip(&mut self, slot: Slot, grid: SlotGrid, settings: &OperationalSettings) -> SlotOutput {
        let deadline = grid.open(slot) + settings.latency;
        self.pass(grid.centre(decided_slot(deadline, slot, grid)), settings);
        let slot = grid.of(deadline);
        let now = || NowPicture { slot, time: grid.centre(slot), points: Vec::new() };
        SlotOutput {
            newcomers: self.admission.take_counts(),
            now: settings.now.then(now),
            ..SlotOutput::default()
        }
    }

    /// Advances the admission to a decided slot.
    fn pass(&mut self, time: Time, settings: &OperationalSettings) {
        self.admission.begin_slot(time, |sensor| settings.transponder(sensor).copied());
    }

    /// Corrects the new plots, and sorts them into tracklets. Returns the radar of each plot whose track number jumps too often.
    fn sort_plots(&mut self, slot: Slot, settings: &OperationalSettings) -> Vec<SensorIndex> {
        let mut jumping = Vec::new();
        self.plots.sort_by_key(|plot| (plot.time, plot.track));
        for plot in self.plots.drain(..) {
            if let Some(radar) = settings.radar(plot.track.sensor) {
                let plot = self.relocations.place(plot, radar);
                let corrected = self.registrations.correct(plot, radar);
                if !self.tracklets.insert(corrected, plot.position, slot, radar) {
                    jumping.push(plot.track.sensor);
                }
            }
        }
        self.tracklets.update_evidence(&self.classes, settings);
        jumping
    }

    /// Corrects the new transponder reports to the time of their measurement, and sorts them into targets.
    fn sort_fixes(&mut self, slot: Slot, settings: &OperationalSettings) {
        self.fixes.sort_by_key(|fix| (fix.time, fix.identity));
        self.integrities.add_reports(&self.fixes, settings);
        for mut fix in self.fixes.drain(..) {
            let Some(receiver) = settings.transponder(fix.sensor) else { continue };
            let begun = Begun::Transponder(fix.time, fix.identity);
            let delay_s =
                settings.delay(&fix.identity, &fix.transponder_type()).unwrap_or_default().applied_s;
            fix.time = Time::from_nanos(fix.time.nanos() - (delay_s * SECOND as f64).round() as i64);
            let known = self.targets.of_identity(fix.identity);
            if let Some(target) = known.and_then(|id| self.targets.get_mut(id)) {
                self.admission.refresh(fix.identity);
                if !target.transponder().is_some_and(|own| own.has_better(&fix, settings)) {
                    target.insert(fix);
                }
            } else if let Some(AdmittedIdentity { target, waited }) =
                self.admission.offer(&fix, receiver, TargetId { slot, begun })
            {
                self.targets.insert_transponder(target, waited, fix, settings);
            }
        }
    }

    /// Sorts the cameras' new bearings into their tracks.
    fn sort_bearings(&mut self) {
        self.bearings.sort_by_key(|bearing| (bearing.time, bearing.track));
        self.bearings.drain(..).for_each(|bearing| self.cameras.insert(bearing));
    }

    /// Drops the targets of aircraft that have left. A radar track with a transponder leaves with the transponder.
    fn forget_left(&mut self, cycle: &Cycle) {
        let Self { left, targets, tracklets, .. } = self;
        let target = |left: Departed| match left {
            Departed::Transponder(identity) => targets.of_identity(identity),
            Departed::Track(key) => {
                let tracklet = tracklets.with_number(key, cycle.centre, cycle.settings)?;
                tracklet
                    .target()
                    .filter(|&id| targets.get(id).is_some_and(|target| target.identity().is_none()))
            }
        };
        let gone: BTreeSet<TargetId> = left.drain(..).filter_map(target).collect();
        targets.forget_all(&gone);
    }

    /// Forgets old reports, and the state that refers to them. Returns the radar of each discarded track whose number jumps.
    fn forget(&mut self, cycle: &Cycle) -> impl Iterator<Item = SensorIndex> + use<> {
        let Cycle { centre, settings, .. } = *cycle;
        self.forget_left(cycle);
        let jumping = self.tracklets.forget_before(centre + -tuning::PLOTS_KEPT);
        self.tracklets.advance(centre);
        self.registrations.end(&self.tracklets, &mut self.types);
        let ended = self.targets.forget_before(centre + -tuning::FIXES_KEPT, centre, &self.tracklets);
        self.same_aircraft.end(&ended, &mut self.targets);
        self.tracklets.forget_targets(|&id| self.targets.get(id).is_some());
        self.correlations.end(&self.tracklets, centre, settings);
        jumping.into_iter().map(|id| id.track.sensor)
    }

    /// State of each radar's registration.
    pub(crate) fn registered(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.registrations.radars()
    }

    /// Orientation of each camera that has sent bearings.
    pub(crate) fn oriented(&self) -> impl Iterator<Item = (SensorIndex, &OrientedCamera)> {
        self.cameras.oriented()
    }

    /// Pairs of camera tracks that have begun no target.
    pub(crate) fn camera_starts(&self) -> CameraStarts {
        self.cameras.starts()
    }

    /// Restores a radar's registration after a restart.
    pub(crate) fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<(), RegistrationStateError> {
        self.registrations.restore(sensor, state)
    }

    /// Restores a radar's learnt errors after a restart.
    pub(crate) fn restore_learning(
        &mut self,
        sensor: SensorIndex,
        state: &LearningState,
    ) -> Result<(), LearningStateError> {
        self.registrations.restore_learning(sensor, state)
    }

    /// Learnt values of each transponder type.
    pub(crate) fn learnt_types(&self, settings: &OperationalSettings) -> Vec<(TransponderType, LearntType)> {
        self.types.learnt(settings)
    }

    /// State of each transponder type, to be restored after a restart.
    pub(crate) fn type_states(&self) -> Vec<TypeState> {
        self.types.to_states()
    }

    /// Restores the learnt state of a transponder type after a restart.
    pub(crate) fn restore_type(&mut self, state: &TypeState) -> Result<(), LearningStateError> {
        self.types.restore(state)
    }

    /// Keeps the state that survives a restart of the engine: registrations, orientations of cameras, transponder types, shared values and
    /// integrity.
    pub(crate) fn inherit(&mut self, before: Self) {
        self.registrations = before.registrations.without_tracks();
        self.relocations = before.relocations;
        self.cameras = before.cameras.without_tracks();
        self.types = before.types;
        self.classes = before.classes.only_shared();
        self.planned = before.planned;
        self.integrities = before.integrities.without_tracks();
    }

    /// Applies a decision from the slot `since` on: the next one or, in a replay, the original one.
    pub(crate) fn correlate(
        &mut self,
        correlation: ManualAssociation,
        since: Slot,
        settings: &OperationalSettings,
    ) -> Result<(), AssociationRefusal> {
        let ManualAssociation { radar, transponder, .. } = correlation;
        let time = self.decided.ok_or(AssociationRefusal::NoRadarTrack)?;
        let tracklet = self.tracklets.with_number(radar, time, settings);
        let id = tracklet.ok_or(AssociationRefusal::NoRadarTrack)?.id;
        let is_known = self.targets.of_identity(transponder).is_some();
        if !is_known && !self.correlations.contains(id, transponder) {
            return Err(AssociationRefusal::NoTransponder);
        }
        if self.correlations.apply(id, correlation, since, &self.tracklets)
            && let Some(target) = self.targets.of_identity(transponder)
            && let Some(tracklet) = self.tracklets.get(id)
            && tracklet.target() == Some(target)
            && tracklet.pair_llr(target).is_none()
        {
            // Without anything to compare it with, it would stay what it was by the operator's decision alone.
            self.targets.assign_track(&mut self.tracklets, id, None);
        }
        Ok(())
    }

    /// Moves a radar to another position from the slot `since` on. `is_new`: its registration restarts.
    pub(crate) fn relocate(&mut self, decided: RadarRelocation, since: Slot, is_new: bool) {
        self.relocations.set(decided, since);
        if is_new {
            self.registrations.restart(decided.radar);
        }
    }

    /// The relocations in force.
    pub(crate) fn relocations(&self) -> &Relocations {
        &self.relocations
    }

    /// Applies a correlation from before a restart again, if its radar track has a plot within the break of its number.
    /// `None`: this is not known yet. `time` is the centre of the slot that is published next.
    pub(crate) fn resume(
        &mut self,
        kept: SavedAssociation,
        time: Time,
        settings: &OperationalSettings,
    ) -> Option<RestoredAssociation> {
        let SavedAssociation { held: ActiveAssociation { correlation, since }, heard } = kept;
        let ended = Some(RestoredAssociation::Ended(kept.held));
        let Some(radar) = settings.radar(correlation.radar.sensor) else { return ended };
        let until = heard + radar.track_break();
        match self.decided.and_then(|time| self.tracklets.with_number(correlation.radar, time, settings)) {
            Some(tracklet) if tracklet.first() <= until => {
                self.correlations.apply(tracklet.id, correlation, since, &self.tracklets);
                Some(RestoredAssociation::Holds(kept.held))
            }
            None if time <= until => None,
            Some(_) | None => ended,
        }
    }

    /// The track numbers kept for transponders' aircraft, each with the slot in which it was assigned.
    pub(crate) fn track_numbers(&self) -> impl Iterator<Item = (Identity, u32, Slot)> {
        self.targets.kept_numbers()
    }

    /// Restores the track number that a transponder's aircraft had before a restart.
    pub(crate) fn remember_track_number(&mut self, identity: Identity, number: u32, since: Slot) {
        self.targets.remember_number(identity, number, since);
    }

    /// The correlations in force, each with the time of the last plot of its radar track.
    pub(crate) fn kept(&self) -> Vec<SavedAssociation> {
        self.correlations.saved(&self.tracklets)
    }

    /// The correlations in force, by radar track.
    pub(crate) fn correlations(&self) -> Vec<ActiveAssociation> {
        self.kept().into_iter().map(|kept| kept.held).collect()
    }

    /// Applies an operator's trust override of an identity, from the slot `since` on.
    pub(crate) fn set_trust(&mut self, word: TrustOverride, since: Slot) {
        self.integrities.set_trust(word, since);
    }

    /// The operators' trust overrides in force, by identity.
    pub(crate) fn trust_overrides(&self) -> impl Iterator<Item = ActiveOverride> {
        self.integrities.trust_overrides()
    }

    /// Assessments of the identities received lately.
    pub(crate) fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.integrities.assessments()
    }

    /// The transponders that can be correlated.
    pub(crate) fn transponders(&self) -> impl Iterator<Item = Identity> {
        self.targets.identities()
    }
}
