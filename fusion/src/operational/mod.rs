//! The `operational` profile: one target per aircraft, whatever sees it, and one number for its life.
//!
//! `Operational::emit` is the pipeline of passes. Each state has one owner with private fields: `Tracklets`, `Targets`
//! (with their numbers), `Admission`, `Correlations`, `Registrations`. What is decided depends on the reports received by
//! then, not on the order in which they came.

mod acquaintance;
mod admission;
mod aircraft_class;
mod association;
mod by_id;
mod cameras;
mod classes;
mod comparison;
mod competitors;
mod correlation;
mod cycle;
mod doubt;
mod existence;
mod ids;
mod initiation;
mod integrity;
mod likelihood;
mod measured;
mod mutual;
mod now;
mod output;
mod places;
mod reacquisition;
mod registrations;
mod residuals;
mod settings;
mod shared;
mod targets;
#[cfg(test)]
mod tests;
mod track_numbers;
mod tracklets;
mod transponder;
mod transponder_types;
mod tuning;
mod values;
mod walk_off;

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::integrity::{Assessment, Concern, HeldWord, Word};
use crate::learning::{LearningState, LearningStateError, LearntType, TypeState};
use crate::numbering::Numbers;
use crate::point::{Newcomers, NowPicture, Point};
use crate::registration::{RegistrationState, RegistrationStateError};
use crate::report::{Bearing, Fix, Identity, Left, Plot, Report, SensorIndex, TransponderType};
use crate::slots::{Slot, SlotGrid};
use crate::time::{SECOND, Time};
use acquaintance::Awaited;
use admission::{Admission, Admitted};
use cameras::Cameras;
use classes::Classes;
use correlation::Correlations;
use cycle::Cycle;
use ids::{Begun, TargetId};
use integrity::Integrities;
use registrations::Registrations;
use targets::Targets;
use tracklets::Tracklets;
use transponder_types::TransponderTypes;
use values::Planned;

pub use acquaintance::{Acquaintance, Name};
pub use classes::LabelledTrack;
pub use correlation::{
    Correlation, HeldCorrelation, NotCorrelated, ResumedCorrelation, SavedCorrelation, Verdict,
};
pub use registrations::{Registered, Step};
pub(crate) use settings::Settings;
pub(super) use tuning::DECIDED_AFTER;
pub use tuning::{ASSOCIATE_LLR, DISSOCIATE_LLR};
pub use values::SensorValues;

/// What the profile knows, and the reports since the last slot.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Operational {
    plots: Vec<Plot>,
    fixes: Vec<Fix>,
    bearings: Vec<Bearing>,
    cameras: Cameras,
    admission: Admission,
    tracklets: Tracklets,
    targets: Targets,
    correlations: Correlations,
    registrations: Registrations,
    classes: Classes,
    types: TransponderTypes,
    integrities: Integrities,
    /// Centre of the slot that was decided last.
    decided: Option<Time>,
    /// What others have learnt of the sensors, to be used from a slot on.
    planned: Planned,
    /// What others know of aircraft that are seen here soon.
    awaited: Awaited,
    /// Who has left since the last slot.
    left: Vec<Left>,
}

/// What a slot yields.
#[derive(Debug, Default)]
pub(super) struct Yield {
    /// Its points, in order.
    pub(super) points: Vec<Point>,
    /// What is wrong with transponders at it.
    pub(super) concerns: Vec<Concern>,
    /// What became of new identities.
    pub(super) newcomers: Vec<Newcomers>,
    /// The picture of its deadline, where that is wanted.
    pub(super) now: Option<NowPicture>,
}

/// Of the other profile, which tells of nothing else.
impl From<Vec<Point>> for Yield {
    fn from(points: Vec<Point>) -> Self {
        Self { points, ..Self::default() }
    }
}

/// The slot that is decided on by what is received by a deadline, at which another one is shown.
fn decided_slot(deadline: Time, shown: Slot, grid: SlotGrid) -> Slot {
    grid.of(deadline + -DECIDED_AFTER).min(shown)
}

impl Operational {
    /// Takes a report in.
    pub(super) fn handle(&mut self, report: Report) {
        match report {
            Report::Plot(plot) => self.plots.push(plot),
            Report::Fix(fix) => self.fixes.push(fix),
            Report::Bearing(bearing) => self.bearings.push(bearing),
        }
    }

    /// Forgets who has left, with the next slot.
    pub(super) fn leave(&mut self, left: Left) {
        self.left.push(left);
    }

    /// Publishes a slot.
    pub(super) fn emit(
        &mut self,
        slot: Slot,
        grid: SlotGrid,
        settings: &Settings,
        numbers: &mut Numbers,
    ) -> Yield {
        self.turn_values(slot);
        let settings = &self.registrations.settings(settings, &mut self.types);
        let deadline = grid.open(slot) + settings.latency;
        let cycle_of = |slot, previous| Cycle::new(slot, deadline, grid, previous, settings);
        let cycle = &cycle_of(decided_slot(deadline, slot, grid), self.decided);
        let shown = &cycle_of(slot, None);
        self.pass(cycle.centre, settings);
        self.meet_awaited(settings);
        self.sort_plots(cycle.slot, settings);
        self.sort_fixes(cycle.slot, settings);
        self.sort_bearings();
        self.forget(cycle);
        let Self {
            cameras,
            tracklets,
            targets,
            correlations,
            registrations,
            classes,
            types,
            integrities,
            ..
        } = self;
        comparison::compare(tracklets, targets, cycle);
        integrities.assess(tracklets, targets, cycle);
        let decided = &mut correlations.decided(tracklets, targets);
        integrities.part(decided, tracklets, targets, settings);
        let decided = &*decided;
        let measured = &reacquisition::Measured::of(targets);
        association::associate(tracklets, targets, measured, decided, cycle);
        integrities.protect(registrations, targets, settings, cycle.centre);
        registrations.register(tracklets, targets, types, cycle);
        initiation::initiate(tracklets, targets, measured, decided, integrities.twins(), cycle);
        cameras.follow(targets, cycle);
        targets.filter_all(tracklets, cameras, cycle);
        let mut points = output::publish(targets, tracklets, cameras, correlations, numbers, grid, shown);
        let concerns = integrities.mark(&mut points, tracklets, targets, cycle);
        let now = settings.now.then(|| {
            let cycle = &cycle_of(grid.of(deadline), None);
            let mut predicted = now::predict(targets, tracklets, cameras, correlations, grid, cycle);
            integrities.flag(&mut predicted, &points, cycle);
            NowPicture { slot: cycle.slot, time: cycle.centre, points: predicted }
        });
        targets.settle(tracklets, cycle);
        targets.learn(cycle.centre, types, settings);
        tracklets.settle(cycle.centre, settings);
        classes.learn(tracklets, targets, cycle);
        self.decided = Some(cycle.centre);
        Yield { points, concerns, newcomers: self.admission.take(), now }
    }

    /// A slot behind the last report of all, where nothing is to be shown.
    pub(super) fn skip(&mut self, slot: Slot, grid: SlotGrid, settings: &Settings) -> Yield {
        let deadline = grid.open(slot) + settings.latency;
        self.pass(grid.centre(decided_slot(deadline, slot, grid)), settings);
        let slot = grid.of(deadline);
        let now = || NowPicture { slot, time: grid.centre(slot), points: Vec::new() };
        Yield { newcomers: self.admission.take(), now: settings.now.then(now), ..Yield::default() }
    }

    /// A slot is decided.
    fn pass(&mut self, time: Time, settings: &Settings) {
        self.admission.turn(time, |sensor| settings.transponder(sensor).copied());
    }

    /// Corrects the plots that came, and sorts them into tracklets.
    fn sort_plots(&mut self, slot: Slot, settings: &Settings) {
        self.plots.sort_by_key(|plot| (plot.time, plot.track));
        for plot in self.plots.drain(..) {
            if let Some(radar) = settings.radar(plot.track.sensor) {
                let corrected = self.registrations.correct(plot, radar);
                self.tracklets.insert(corrected, plot.position, slot, radar);
            }
        }
        self.tracklets.look_ahead(&self.classes, settings);
    }

    /// Puts the transponder reports that came to the time of their measurement, and sorts them into targets.
    fn sort_fixes(&mut self, slot: Slot, settings: &Settings) {
        self.fixes.sort_by_key(|fix| (fix.time, fix.identity));
        self.integrities.hear(&self.fixes, settings);
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
            } else if let Some(Admitted { target, waited }) =
                self.admission.offer(&fix, receiver, TargetId { slot, begun })
            {
                self.targets.insert_transponder(target, waited, fix, settings);
            }
        }
    }

    /// Sorts the cameras' bearings that came into their tracks.
    fn sort_bearings(&mut self) {
        self.bearings.sort_by_key(|bearing| (bearing.time, bearing.track));
        self.bearings.drain(..).for_each(|bearing| self.cameras.insert(bearing));
    }

    /// Drops the targets of who has left. A radar track that goes with a transponder's leaves with that.
    fn forget_left(&mut self, cycle: &Cycle) {
        let Self { left, targets, tracklets, .. } = self;
        let target = |left: Left| match left {
            Left::Transponder(identity) => targets.of_identity(identity),
            Left::Track(key) => {
                let tracklet = tracklets.with_number(key, cycle.centre, cycle.settings)?;
                tracklet
                    .target()
                    .filter(|&id| targets.get(id).is_some_and(|target| target.identity().is_none()))
            }
        };
        let gone: BTreeSet<TargetId> = left.drain(..).filter_map(target).collect();
        targets.forget_all(&gone);
    }

    /// Forgets what is too old, and what was about that.
    fn forget(&mut self, cycle: &Cycle) {
        let Cycle { centre, settings, .. } = *cycle;
        self.forget_left(cycle);
        self.tracklets.forget_before(centre + -tuning::PLOTS_KEPT);
        self.tracklets.turn(centre);
        self.registrations.end(&self.tracklets, &mut self.types);
        self.targets.forget_before(centre + -tuning::FIXES_KEPT, centre, &self.tracklets);
        self.tracklets.forget_targets(|&id| self.targets.get(id).is_some());
        self.correlations.end(&self.tracklets, centre, settings);
    }

    /// What is known of each radar that is registered.
    pub(crate) fn registered(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.registrations.radars()
    }

    /// Takes over a radar's registration of before a restart.
    pub(crate) fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<(), RegistrationStateError> {
        self.registrations.restore(sensor, state)
    }

    /// Takes over what was learnt of a radar's errors before a restart.
    pub(crate) fn restore_learning(
        &mut self,
        sensor: SensorIndex,
        state: &LearningState,
    ) -> Result<(), LearningStateError> {
        self.registrations.restore_learning(sensor, state)
    }

    /// What is known of each type of transponders.
    pub(crate) fn learnt_types(&self, settings: &Settings) -> Vec<(TransponderType, LearntType)> {
        self.types.learnt(settings)
    }

    /// The same, to outlive a restart.
    pub(crate) fn type_states(&self) -> Vec<TypeState> {
        self.types.to_states()
    }

    /// Takes over what was known of a type of transponders before a restart.
    pub(crate) fn restore_type(&mut self, state: &TypeState) -> Result<(), LearningStateError> {
        self.types.restore(state)
    }

    /// Takes over what outlives a fresh start: the registrations, and what is known of transponders.
    pub(crate) fn inherit(&mut self, before: Self) {
        self.registrations = before.registrations.without_tracks();
        self.types = before.types;
        self.classes = before.classes.only_shared();
        self.planned = before.planned;
        self.integrities = before.integrities.without_tracks();
    }

    /// Takes a decision over from the slot `since` on, which is the next one or, of a flight that is replayed, was.
    pub(crate) fn correlate(
        &mut self,
        correlation: Correlation,
        since: Slot,
        settings: &Settings,
    ) -> Result<(), NotCorrelated> {
        let Correlation { radar, transponder, .. } = correlation;
        let time = self.decided.ok_or(NotCorrelated::NoRadarTrack)?;
        let tracklet = self.tracklets.with_number(radar, time, settings);
        let id = tracklet.ok_or(NotCorrelated::NoRadarTrack)?.id;
        let is_known = self.targets.of_identity(transponder).is_some();
        if !is_known && !self.correlations.contains(id, transponder) {
            return Err(NotCorrelated::NoTransponder);
        }
        if self.correlations.hold(id, correlation, since, &self.tracklets)
            && let Some(target) = self.targets.of_identity(transponder)
            && let Some(tracklet) = self.tracklets.get(id)
            && tracklet.target() == Some(target)
            && tracklet.pair_llr(target).is_none()
        {
            // Without anything to compare it with it would stay what it was by the operator's decision alone.
            self.targets.follow(&mut self.tracklets, id, None);
        }
        Ok(())
    }

    /// Lets a correlation of before a restart hold again, where its radar track was heard again within the break of its number;
    /// `None`: that is not known yet. `time` is the centre of the slot that is published next.
    pub(crate) fn resume(
        &mut self,
        kept: SavedCorrelation,
        time: Time,
        settings: &Settings,
    ) -> Option<ResumedCorrelation> {
        let SavedCorrelation { held: HeldCorrelation { correlation, since }, heard } = kept;
        let ended = Some(ResumedCorrelation::Ended(kept.held));
        let Some(radar) = settings.radar(correlation.radar.sensor) else { return ended };
        let until = heard + radar.track_break();
        match self.decided.and_then(|time| self.tracklets.with_number(correlation.radar, time, settings)) {
            Some(tracklet) if tracklet.first() <= until => {
                self.correlations.hold(tracklet.id, correlation, since, &self.tracklets);
                Some(ResumedCorrelation::Holds(kept.held))
            }
            None if time <= until => None,
            Some(_) | None => ended,
        }
    }

    /// The track numbers that transponders' aircraft keep, each with the slot in which it was given.
    pub(crate) fn track_numbers(&self) -> impl Iterator<Item = (Identity, u32, Slot)> {
        self.targets.kept_numbers()
    }

    /// Takes over a track number that a transponder's aircraft had before a restart.
    pub(crate) fn remember_track_number(&mut self, identity: Identity, number: u32, since: Slot) {
        self.targets.remember_number(identity, number, since);
    }

    /// The correlations in force, each with the last plot of its radar track.
    pub(crate) fn kept(&self) -> Vec<SavedCorrelation> {
        self.correlations.kept(&self.tracklets)
    }

    /// The correlations in force, by radar track.
    pub(crate) fn correlations(&self) -> Vec<HeldCorrelation> {
        self.kept().into_iter().map(|kept| kept.held).collect()
    }

    /// An operator's word on an identity, from the slot `since` on.
    pub(crate) fn say(&mut self, word: Word, since: Slot) {
        self.integrities.say(word, since);
    }

    /// The operators' words in force, by identity.
    pub(crate) fn words(&self) -> impl Iterator<Item = HeldWord> {
        self.integrities.words()
    }

    /// What is known of each identity heard lately.
    pub(crate) fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.integrities.assessments()
    }

    /// The transponders that can be correlated.
    pub(crate) fn transponders(&self) -> impl Iterator<Item = Identity> {
        self.targets.identities()
    }
}
