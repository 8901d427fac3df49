//! The engine: takes times and reports, and returns every slot once. The profile determines a slot's points.
//!
//! Sans-IO: no clock, no socket, no randomness. Call [`Engine::advance`] first and drain it, then call
//! [`Engine::handle`].

mod due;
mod learnt;
mod plan;
mod profile_state;

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::checkpoint::{self, CheckpointError};
use crate::integrity::{ActiveOverride, Assessment, Trust, TrustOverride};
use crate::numbering::{Given, Keeping, Numbers};
use crate::operational::{
    ActiveAssociation, ActiveRelocation, AssociationRefusal, ManualAssociation, Operational, RadarRelocation,
    RestoredAssociation, SavedAssociation, SlotOutput,
};
use crate::point::Emission;
use crate::report::{Departed, Identity, Report};
use crate::settings::{Profile, Settings, SettingsError};
use crate::slots::{Slot, Window};
use crate::time::Time;
pub use due::Due;
use plan::Plan;
use profile_state::ProfileState;

/// The engine: takes times and reports, and returns every slot once. The crate's documentation has a complete loop.
#[derive(Debug)]
pub struct Engine {
    settings: Settings,
    clock: Option<Clock>,
    /// Newest slot that contains a report since the window was last empty.
    newest: Option<Slot>,
    rules: ProfileState,
    numbers: Numbers,
    plan: Plan,
}

/// Receptions that stay more than the window behind for this long mean that the clock of reception was set back.
/// Shorter runs are late stragglers.
const SET_BACK: SignedDuration = SignedDuration::from_secs(5);

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Clock {
    /// Latest time of a reception or a tick.
    now: Time,
    /// Time of the latest reception.
    received: Time,
    /// First of the consecutive receptions that are more than the window behind; `None` if the last one is not.
    set_back: Option<Time>,
    /// The next slot to be emitted.
    next: Slot,
}

/// Why the engine refused a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReportRefusal {
    /// The report's slot has already left the window.
    #[error("the report is older than the window")]
    Late,
    /// The report's slot is further ahead of the window than reports may wait.
    #[error("the report is too far ahead of the time")]
    Future,
}

impl Engine {
    /// Creates an engine without any state.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        let keeping = match settings.profile {
            Profile::Reference(_) => Keeping::ForGood,
            Profile::Operational(_) => Keeping::ADay,
        };
        Ok(Self {
            clock: None,
            newest: None,
            rules: ProfileState::new(&settings),
            numbers: Numbers::new(settings.grid, keeping, settings.transponder_numbers.clone()),
            plan: Plan::default(),
            settings,
        })
    }

    /// Serialises the state: an engine that is restored from it with the same settings publishes the same slots
    /// ([`Engine::restored`]).
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let mut octets = Vec::new();
        self.checkpoint_into(&mut octets);
        octets
    }

    /// Like [`Engine::checkpoint`], appended to a buffer: with thousands of aircraft the state has tens of megabytes.
    pub fn checkpoint_into(&self, octets: &mut Vec<u8>) {
        let Self { settings, clock, newest, rules, numbers, plan } = self;
        let (reference, operational) = match rules {
            ProfileState::Reference(reference) => (Some(reference), None),
            ProfileState::Operational(operational, _) => (None, Some(operational)),
        };
        checkpoint::write(settings, &(clock, newest, numbers, plan, reference, operational), octets);
    }

    /// Restores an engine from a checkpoint.
    ///
    /// # Errors
    /// The octets are no checkpoint, are damaged, or were written by another version or with other settings.
    pub fn restored(settings: Settings, octets: &[u8]) -> Result<Self, CheckpointError> {
        let (clock, newest, numbers, plan, reference, operational) = checkpoint::read(&settings, octets)?;
        let rules = match (ProfileState::new(&settings), reference, operational) {
            (ProfileState::Reference(_), Some(reference), None) => ProfileState::Reference(reference),
            (ProfileState::Operational(_, profile), None, Some(operational)) => {
                ProfileState::Operational(operational, profile)
            }
            _ => return Err(CheckpointError::Damaged),
        };
        Ok(Self { settings, clock, newest, rules, numbers, plan })
    }

    /// Advances to the time of a reception; returns the slots that must be emitted before the received reports are
    /// handled.
    ///
    /// The first call starts the clock: slots due by then are never emitted. A step of more than the window forward,
    /// from one reception to the next, emits the slots that are due and restarts with an empty window (numbers and
    /// registrations stay). Ticks in between do not matter: the receptions alone give the same slots. A step backward
    /// changes nothing at first. When the receptions stay more than the window behind for 5 s, the clock of reception
    /// was set back: the engine restarts as well.
    pub fn advance(&mut self, received: Time) -> Due<'_> {
        let Some(clock) = &mut self.clock else {
            self.start(received);
            return Due { engine: self, last: None, restart: None };
        };
        let window = self.settings.window();
        if clock.now - received > window {
            let since = clock.set_back.map_or(received, |since| since.min(received));
            clock.set_back = Some(since);
            let restart = (received - since >= SET_BACK).then_some(received);
            return Due { last: restart.and_then(|_| self.last()), restart, engine: self };
        }
        clock.set_back = None;
        if received - clock.received > window {
            return Due { last: self.last(), restart: Some(received), engine: self };
        }
        clock.received = clock.received.max(received);
        self.until(received)
    }

    /// Advances to a time at which nothing is received; returns the slots that are due by then. Before the first
    /// reception it does nothing. A step of more than the window forward from the latest time restarts the engine, as
    /// in [`Engine::advance`].
    pub fn tick(&mut self, now: Time) -> Due<'_> {
        let window = self.settings.window();
        match self.clock {
            None => Due { engine: self, last: None, restart: None },
            Some(clock) if now - clock.now > window => {
                Due { last: self.last(), restart: Some(now), engine: self }
            }
            Some(_) => self.until(now),
        }
    }

    fn until(&mut self, now: Time) -> Due<'_> {
        let last = self.clock.as_mut().map(|clock| {
            clock.now = clock.now.max(now);
            self.settings.grid.of(clock.now + self.settings.lead()).plus(-self.settings.latency_slots)
        });
        Due { engine: self, last, restart: None }
    }

    /// Ends the input: returns every slot up to the last one that is worth a picture.
    pub fn finish(&mut self) -> Due<'_> {
        Due { last: self.last(), engine: self, restart: None }
    }

    /// Checks the time of a report. [`Offer::accept`] accepts the report; an offer that is dropped changes nothing.
    ///
    /// # Errors
    /// The report's time is outside the window and the slots that may wait ahead of it.
    ///
    /// # Panics
    /// If [`Engine::advance`] was never called.
    pub fn offer(&mut self, report: Report) -> Result<Offer<'_>, ReportRefusal> {
        let clock = self.clock.expect("advance() receives the reception time before its reports are handled");
        let slot = self.settings.grid.of(report.time());
        let window = self.window(clock.next);
        if slot < window.first {
            return Err(ReportRefusal::Late);
        }
        if slot > window.last.plus(self.settings.waiting_slots()) {
            return Err(ReportRefusal::Future);
        }
        Ok(Offer { engine: self, slot, report })
    }

    /// Forgets, with the next slot, an aircraft that is now tracked elsewhere. Without this call the engine would
    /// extrapolate it.
    pub fn forget_departed(&mut self, left: Departed) {
        if let ProfileState::Operational(operational, _) = &mut self.rules {
            operational.leave(left);
        }
    }

    /// Accepts a report.
    ///
    /// # Errors
    /// As [`Engine::offer`].
    ///
    /// # Panics
    /// If [`Engine::advance`] was never called.
    pub fn handle(&mut self, report: Report) -> Result<(), ReportRefusal> {
        self.offer(report).map(Offer::accept)
    }

    /// Whether a reception is so far behind the engine's time that the clock of reception may have been set back
    /// ([`Engine::advance`]).
    pub fn is_set_back(&self, received: Time) -> bool {
        self.behind(received) > self.settings.window()
    }

    /// How far a reception is behind the engine's time; zero if it is not behind.
    pub fn behind(&self, received: Time) -> SignedDuration {
        self.clock.map_or(SignedDuration::ZERO, |clock| (clock.now - received).max(SignedDuration::ZERO))
    }

    /// The next slot to be emitted, once the clock has started.
    pub fn next_slot(&self) -> Option<Slot> {
        self.clock.map(|clock| clock.next)
    }

    /// Time at which the next slot is made, once the clock has started: [`Settings::lead`] before its deadline.
    pub fn next_made(&self) -> Option<Time> {
        let Settings { grid, latency_slots, .. } = self.settings;
        Some(grid.open(self.next_slot()?.plus(latency_slots)) + -self.settings.lead())
    }

    /// Time between making a slot and its deadline ([`Settings::lead`]).
    pub fn lead(&self) -> SignedDuration {
        self.settings.lead()
    }

    /// Number of points omitted because all transponder numbers were in use.
    pub fn unnumbered(&self) -> u64 {
        self.numbers.unnumbered()
    }

    /// The transponder numbers in use.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// Makes numbers permanent in every profile: for a replay that starts without any.
    pub fn keep_numbers_for_good(&mut self) {
        self.numbers.keep_for_good();
    }

    /// Restores a number that was assigned before a restart; returns whether it was accepted ([`Numbers::remember`]).
    pub fn remember(&mut self, given: Given) -> bool {
        self.numbers.remember(given)
    }

    /// Track numbers that aircraft with a transponder keep while they are remembered, each with the slot in which it
    /// was assigned. Empty in the `reference` profile, where they follow from the transponder's number.
    pub fn track_numbers(&self) -> Vec<(Identity, u32, Slot)> {
        match &self.rules {
            ProfileState::Reference(_) => Vec::new(),
            ProfileState::Operational(operational, _) => operational.track_numbers().collect(),
        }
    }

    /// Restores the track numbers from before a restart: an aircraft that at first only a radar detected keeps its
    /// number.
    pub fn remember_track_numbers(&mut self, numbers: Vec<(Identity, u32, Slot)>) {
        if let ProfileState::Operational(operational, _) = &mut self.rules {
            for (identity, number, since) in numbers {
                operational.remember_track_number(identity, number, since);
            }
        }
    }

    /// Applies an operator's correlation from the next slot on, until the radar's track number ends.
    ///
    /// # Errors
    /// The profile has no correlations, or the radar track or the transponder is not present.
    pub fn correlate(&mut self, correlation: ManualAssociation) -> Result<(), AssociationRefusal> {
        match (&mut self.rules, self.clock) {
            (ProfileState::Reference(_), _) => Err(AssociationRefusal::Reference),
            (ProfileState::Operational(..), None) => Err(AssociationRefusal::NoRadarTrack),
            (ProfileState::Operational(operational, profile), Some(clock)) => {
                operational.correlate(correlation, clock.next, profile)
            }
        }
    }

    /// Plans the correlations of a replayed flight. Each takes effect in its slot, as it did live. Those from before
    /// the replay begins take effect as soon as the radar track is present, within the length of a window.
    pub fn plan(&mut self, mut correlations: Vec<(Slot, ManualAssociation)>) {
        correlations.sort_by_key(|planned| planned.0);
        self.plan.correlations = correlations;
    }

    /// Restores correlations after a restart. Each takes effect again when a plot of its radar track is received within
    /// the break of the radar's track numbers. To be called before the first reception.
    pub fn resume(&mut self, kept: Vec<SavedAssociation>) {
        self.plan.kept = kept;
        if !self.knows_correlations() {
            self.plan.end_kept();
        }
    }

    /// Outcomes of the correlations restored after a restart; each is returned once.
    pub fn resumed(&mut self) -> Vec<RestoredAssociation> {
        std::mem::take(&mut self.plan.resumed)
    }

    /// Correlations to save for a restart: those in force, and restored ones that are still undecided.
    pub fn saved_associations(&self) -> Vec<SavedAssociation> {
        let in_force = self.operational().map_or_else(Vec::new, Operational::kept);
        in_force.into_iter().chain(self.plan.kept.iter().copied()).collect()
    }

    /// Number of planned correlations whose radar track or transponder was not present.
    pub fn missed(&self) -> u64 {
        self.plan.missed
    }

    /// The correlations in force, by radar track.
    pub fn correlations(&self) -> Vec<ActiveAssociation> {
        self.operational().map_or_else(Vec::new, Operational::correlations)
    }

    /// Applies an operator's trust override of an identity from the next slot on, until the next override. Returns
    /// `false` if the profile has no overrides or nothing was received yet.
    pub fn set_trust(&mut self, word: TrustOverride) -> bool {
        match (&mut self.rules, self.clock) {
            (ProfileState::Operational(operational, _), Some(clock)) => {
                // An override from before a restart may still wait for the first slot.
                let is_over = |since: Slot, earlier: TrustOverride| {
                    earlier.identity == word.identity && since <= clock.next
                };
                self.plan.overrides.retain(|&(since, earlier)| !is_over(since, earlier));
                operational.set_trust(word, clock.next);
                true
            }
            _ => false,
        }
    }

    /// Plans the trust overrides of a replayed flight or from before a restart. Each takes effect in its slot, as it
    /// did then.
    pub fn plan_trust_overrides(&mut self, mut overrides: Vec<(Slot, TrustOverride)>) {
        overrides.sort_by_key(|planned| planned.0);
        self.plan.overrides = overrides;
    }

    /// The operators' trust overrides in force, by identity, including those from before a restart from the first
    /// report on.
    pub fn trust_overrides(&self) -> Vec<ActiveOverride> {
        let (Some(operational), Some(clock)) = (self.operational(), self.clock) else { return Vec::new() };
        let mut overrides: BTreeMap<Identity, ActiveOverride> =
            operational.trust_overrides().map(|held| (held.word.identity, held)).collect();
        for &(since, word) in self.plan.overrides.iter().take_while(|(since, _)| *since <= clock.next) {
            match word.trust {
                Trust::Automatic => overrides.remove(&word.identity),
                Trust::Trusted | Trust::Distrusted => {
                    overrides.insert(word.identity, ActiveOverride { word, since })
                }
            };
        }
        overrides.into_values().collect()
    }

    /// Moves a radar from the next slot on: its plots, and what is computed from its position. Its registration restarts.
    /// Returns `false` if the profile has no relocations, there is no such radar, or nothing was received yet.
    pub fn relocate(&mut self, decided: RadarRelocation) -> bool {
        match (&mut self.rules, self.clock) {
            (ProfileState::Operational(operational, profile), Some(clock)) => {
                let is_radar = profile.radars.get(usize::from(decided.radar.0)).is_some_and(Option::is_some);
                if is_radar {
                    operational.relocate(decided, clock.next, true);
                }
                is_radar
            }
            _ => false,
        }
    }

    /// Plans the relocations of a replayed flight or from before a restart. Each takes effect in its slot, as it did then. Those
    /// from before the first slot leave the registration as it is: it rests on them.
    pub fn plan_relocations(&mut self, mut relocations: Vec<(Slot, RadarRelocation)>) {
        relocations.sort_by_key(|planned| planned.0);
        self.plan.relocations = relocations;
    }

    /// The relocations in force, by radar, including those from before a restart from the first report on.
    pub fn relocations(&self) -> Vec<ActiveRelocation> {
        let (Some(operational), Some(clock)) = (self.operational(), self.clock) else { return Vec::new() };
        let mut active = operational.relocations().clone();
        for &(since, decided) in self.plan.relocations.iter().take_while(|(since, _)| *since <= clock.next) {
            active.set(decided, since);
        }
        active.all().collect()
    }

    /// Assessments of the identities received lately; empty in the `reference` profile.
    pub fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.operational().into_iter().flat_map(Operational::assessments)
    }

    /// The transponders that an operator can decide on; empty in the `reference` profile.
    pub fn transponders(&self) -> impl Iterator<Item = Identity> {
        self.operational().into_iter().flat_map(Operational::transponders)
    }

    /// Whether the profile supports operators' correlations.
    pub fn knows_correlations(&self) -> bool {
        self.operational().is_some()
    }

    fn operational(&self) -> Option<&Operational> {
        match &self.rules {
            ProfileState::Operational(operational, _) => Some(operational),
            ProfileState::Reference(_) => None,
        }
    }

    fn start(&mut self, received: Time) {
        let Settings { grid, latency_slots, .. } = self.settings;
        let next = grid.of(received + self.settings.lead()).plus(1 - latency_slots);
        self.plan.first.get_or_insert(next);
        self.clock = Some(Clock { now: received, received, set_back: None, next });
    }

    fn restart(&mut self, received: Time) {
        self.newest = None;
        let before = std::mem::replace(&mut self.rules, ProfileState::new(&self.settings));
        // A break in reception does not change how the radars are aligned.
        if let (ProfileState::Operational(now, _), ProfileState::Operational(before, _)) =
            (&mut self.rules, before)
        {
            now.inherit(*before);
        }
        self.start(received);
        // Correlations end with their radar tracks.
        let next = self.next_slot();
        self.plan.correlations.retain(|planned| Some(planned.0) >= next);
        self.plan.end_kept();
    }

    fn window(&self, emitted: Slot) -> Window {
        let Settings { latency_slots, window_slots, .. } = self.settings;
        let ahead = match &self.settings.profile {
            Profile::Reference(rules) => rules.suppress_slots,
            Profile::Operational(_) => 0,
        };
        let last = emitted.plus(latency_slots - 1);
        Window {
            first: emitted.plus(latency_slots - window_slots),
            emitted,
            horizon: emitted.plus(ahead).min(last),
            last,
        }
    }

    /// The last slot that is worth a picture: at its deadline the newest report is no older than at the usual latency.
    fn last(&self) -> Option<Slot> {
        Some(self.newest?.plus(self.settings.lasting_slots()))
    }

    /// Emits the next slot.
    fn emit(&mut self) -> Option<Emission> {
        let clock = self.clock.as_mut()?;
        let slot = clock.next;
        clock.next = slot.plus(1);
        let (window, last) = (self.window(slot), self.last());
        let Self { settings, rules, numbers, plan, .. } = self;
        numbers.begin_slot(slot);
        if let ProfileState::Operational(operational, profile) = rules {
            plan.carry_out(slot, settings.window_slots, operational, profile);
            plan.resume((slot, settings.grid.centre(slot)), operational, profile);
        }
        let SlotOutput { points, concerns, newcomers, jumping, now } = match rules {
            ProfileState::Reference(reference) => reference.emit(&window, numbers).into(),
            // No aircraft is extrapolated after the last report of the input: a replay ends there, too.
            ProfileState::Operational(operational, profile) if last.is_none_or(|last| slot > last) => {
                operational.skip(slot, settings.grid, profile)
            }
            ProfileState::Operational(operational, profile) => {
                operational.emit(slot, settings.grid, profile, numbers)
            }
        };
        let numbers = numbers.take_changes();
        let time = settings.grid.centre(slot);
        Some(Emission { slot, time, points, numbers, newcomers, jumping, concerns, now })
    }
}

/// A report whose time is accepted, and that is not yet handled.
#[derive(Debug)]
pub struct Offer<'a> {
    engine: &'a mut Engine,
    slot: Slot,
    report: Report,
}

impl Offer<'_> {
    /// Accepts the report.
    pub fn accept(self) {
        let Self { engine, slot, report } = self;
        engine.newest = engine.newest.max(Some(slot));
        match &mut engine.rules {
            ProfileState::Reference(reference) => reference.handle(report),
            ProfileState::Operational(operational, _) => operational.handle(report),
        }
    }
}
