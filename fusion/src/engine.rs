//! The engine: told the time and the reports, it yields every slot once. What is published is the profile's to say.
//!
//! Sans-IO: no clock, no socket, no randomness. [`Engine::advance`] first, drained; then [`Engine::handle`].

mod due;
mod learnt;
mod plan;

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::checkpoint::{self, CheckpointError};
use crate::integrity::{Assessment, HeldWord, Trust, Word};
use crate::numbering::{Given, Keeping, Numbers};
use crate::operational::{
    self, Correlation, HeldCorrelation, NotCorrelated, Operational, ResumedCorrelation, SavedCorrelation,
    Yield,
};
use crate::point::Emission;
use crate::reference::Reference;
use crate::report::{Identity, Left, Report};
use crate::settings::{Profile, Settings, SettingsError};
use crate::slots::{Slot, Window};
use crate::time::Time;
pub use due::Due;
use plan::Plan;

/// The engine: told the time and the reports, it yields every slot once. See the crate's first page for a whole loop.
#[derive(Debug)]
pub struct Engine {
    settings: Settings,
    clock: Option<Clock>,
    /// The newest slot that holds a report since the window was last empty.
    newest: Option<Slot>,
    rules: Rules,
    numbers: Numbers,
    plan: Plan,
}

/// Receptions that stay more than the window behind for this long mean a clock that was set back, and no stragglers.
const SET_BACK: SignedDuration = SignedDuration::from_secs(5);

/// What is published for a slot is the profile's to say.
#[derive(Debug)]
enum Rules {
    Reference(Reference),
    Operational(Box<Operational>, operational::Settings),
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Clock {
    /// The latest time told, by a reception or a tick.
    now: Time,
    /// The latest reception.
    received: Time,
    /// The first of the latest receptions that are more than the window behind; `None` where the last one is not.
    set_back: Option<Time>,
    /// The slot to be emitted next.
    next: Slot,
}

/// Why the engine did not take a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// Its slot has already left the window.
    #[error("the report is older than the window")]
    Late,
    /// Its slot is farther ahead of the window than reports may wait.
    #[error("the report is too far ahead of the time")]
    Future,
}

impl Engine {
    /// An engine that knows nothing yet.
    ///
    /// # Errors
    /// A setting is outside its range.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        let keeping = match settings.profile {
            Profile::Reference(_) => Keeping::ForGood,
            Profile::Operational(_) => Keeping::ADay,
        };
        Ok(Self {
            clock: None,
            newest: None,
            rules: Rules::new(&settings),
            numbers: Numbers::new(settings.grid, keeping, settings.transponder_numbers.clone()),
            plan: Plan::default(),
            settings,
        })
    }

    /// The state as octets: an engine of the same settings that is made of them publishes what this one would have
    /// ([`Engine::restored`]).
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let mut octets = Vec::new();
        self.checkpoint_into(&mut octets);
        octets
    }

    /// The same, written behind what stands in a buffer: of thousands of aircraft it is tens of megabytes.
    pub fn checkpoint_into(&self, octets: &mut Vec<u8>) {
        let Self { settings, clock, newest, rules, numbers, plan } = self;
        let (reference, operational) = match rules {
            Rules::Reference(reference) => (Some(reference), None),
            Rules::Operational(operational, _) => (None, Some(operational)),
        };
        checkpoint::write(settings, &(clock, newest, numbers, plan, reference, operational), octets);
    }

    /// The engine that wrote a checkpoint.
    ///
    /// # Errors
    /// It is none, it is damaged, or another version or an engine with other settings wrote it.
    pub fn restored(settings: Settings, octets: &[u8]) -> Result<Self, CheckpointError> {
        let (clock, newest, numbers, plan, reference, operational) = checkpoint::read(&settings, octets)?;
        let rules = match (Rules::new(&settings), reference, operational) {
            (Rules::Reference(_), Some(reference), None) => Rules::Reference(reference),
            (Rules::Operational(_, profile), None, Some(operational)) => {
                Rules::Operational(operational, profile)
            }
            _ => return Err(CheckpointError::Damaged),
        };
        Ok(Self { settings, clock, newest, rules, numbers, plan })
    }

    /// Tells the time of a reception; yields the slots that are due before what was received may be handled.
    ///
    /// The first call starts the clock: slots due by then are never emitted. A step of more than the window
    /// forward, from one reception to the next, emits what is owed and starts afresh with an empty window (numbers and
    /// registrations stay), whatever was told in between: the receptions alone give the same slots. A step backward changes
    /// nothing at first. When the receptions stay more than the window behind for 5 s, the clock of reception was set back:
    /// the engine starts afresh as well.
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

    /// Tells the time where nothing is received; yields the slots that are due by then. Nothing before the first
    /// reception. A step of more than the window forward from the latest time told starts afresh, as
    /// [`Engine::advance`] does.
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

    /// The end of the input: yields every slot up to the last that holds a report.
    pub fn finish(&mut self) -> Due<'_> {
        Due { last: self.last(), engine: self, restart: None }
    }

    /// Looks at a report: where it is in time, [`Offer::take`] takes it in. An offer that is dropped changes nothing.
    ///
    /// # Errors
    /// Its time is outside the window and the slots that may wait behind it.
    ///
    /// # Panics
    /// When no time was told before.
    pub fn offer(&mut self, report: Report) -> Result<Offer<'_>, Refused> {
        let clock = self.clock.expect("advance() is told the reception before its reports are handled");
        let slot = self.settings.grid.of(report.time());
        let window = self.window(clock.next);
        if slot < window.first {
            return Err(Refused::Late);
        }
        if slot > window.last.plus(self.settings.waiting_slots()) {
            return Err(Refused::Future);
        }
        Ok(Offer { engine: self, slot, report })
    }

    /// Forgets the aircraft of somebody who has left with the next slot: else it would look for it where it was last.
    pub fn leave(&mut self, left: Left) {
        if let Rules::Operational(operational, _) = &mut self.rules {
            operational.leave(left);
        }
    }

    /// Takes a report in.
    ///
    /// # Errors
    /// As [`Engine::offer`].
    ///
    /// # Panics
    /// When no time was told before.
    pub fn handle(&mut self, report: Report) -> Result<(), Refused> {
        self.offer(report).map(Offer::take)
    }

    /// Whether a reception is so far behind the engine's time that the clock of reception was set back
    /// ([`Engine::advance`]).
    pub fn is_set_back(&self, received: Time) -> bool {
        self.behind(received) > self.settings.window()
    }

    /// How far a reception lies behind the engine's time; zero where it does not.
    pub fn behind(&self, received: Time) -> SignedDuration {
        self.clock.map_or(SignedDuration::ZERO, |clock| (clock.now - received).max(SignedDuration::ZERO))
    }

    /// The next slot to be emitted, once the clock has started.
    pub fn next_slot(&self) -> Option<Slot> {
        self.clock.map(|clock| clock.next)
    }

    /// When the next slot is made, once the clock has started: the settings' lead before its deadline.
    pub fn next_made(&self) -> Option<Time> {
        let Settings { grid, latency_slots, .. } = self.settings;
        Some(grid.open(self.next_slot()?.plus(latency_slots)) + -self.settings.lead())
    }

    /// How long before its deadline a slot is made ([`Settings::lead`]).
    pub fn lead(&self) -> SignedDuration {
        self.settings.lead()
    }

    /// Points left out because all transponder numbers were used up.
    pub fn unnumbered(&self) -> u64 {
        self.numbers.unnumbered()
    }

    /// The transponder numbers that somebody has.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// Numbers are given for good, whatever the profile: for a replay that begins with none.
    pub fn keep_numbers_for_good(&mut self) {
        self.numbers.keep_for_good();
    }

    /// Takes over a number given in an earlier life; whether it did ([`Numbers::remember`]).
    pub fn remember(&mut self, given: Given) -> bool {
        self.numbers.remember(given)
    }

    /// The track numbers that aircraft with a transponder keep while they are remembered, each with the slot in which it was given.
    /// Of the `reference` profile none: there they follow from the transponder's number.
    pub fn track_numbers(&self) -> Vec<(Identity, u32, Slot)> {
        match &self.rules {
            Rules::Reference(_) => Vec::new(),
            Rules::Operational(operational, _) => operational.track_numbers().collect(),
        }
    }

    /// Takes over the track numbers before a restart: an aircraft that only a radar saw first keeps its number.
    pub fn remember_track_numbers(&mut self, numbers: Vec<(Identity, u32, Slot)>) {
        if let Rules::Operational(operational, _) = &mut self.rules {
            for (identity, number, since) in numbers {
                operational.remember_track_number(identity, number, since);
            }
        }
    }

    /// An operator's word; it counts from the next slot on, until the radar's track number ends.
    ///
    /// # Errors
    /// The profile knows no decisions, or the radar track or the transponder is not there.
    pub fn correlate(&mut self, correlation: Correlation) -> Result<(), NotCorrelated> {
        match (&mut self.rules, self.clock) {
            (Rules::Reference(_), _) => Err(NotCorrelated::Reference),
            (Rules::Operational(..), None) => Err(NotCorrelated::NoRadarTrack),
            (Rules::Operational(operational, profile), Some(clock)) => {
                operational.correlate(correlation, clock.next, profile)
            }
        }
    }

    /// What was decided in a flight that is replayed, each with its slot: it counts from that slot on, as it did then. What
    /// was decided before the replay begins counts as soon as the radar track is there, within a window's length.
    pub fn plan(&mut self, mut correlations: Vec<(Slot, Correlation)>) {
        correlations.sort_by_key(|planned| planned.0);
        self.plan.correlations = correlations;
    }

    /// Correlations of before a restart: each holds again as soon as its radar track is heard again, where that is within the
    /// break of the radar's track numbers. Before the first reception.
    pub fn resume(&mut self, kept: Vec<SavedCorrelation>) {
        self.plan.kept = kept;
        if !self.knows_correlations() {
            self.plan.end_kept();
        }
    }

    /// What has become of the decisions of before a restart, each once.
    pub fn resumed(&mut self) -> Vec<ResumedCorrelation> {
        std::mem::take(&mut self.plan.resumed)
    }

    /// The decisions that a restart would have to know: those in force, and those of the last restart that may still hold.
    pub fn kept(&self) -> Vec<SavedCorrelation> {
        let in_force = self.operational().map_or_else(Vec::new, Operational::kept);
        in_force.into_iter().chain(self.plan.kept.iter().copied()).collect()
    }

    /// Correlations of the plan that were about what was not there.
    pub fn missed(&self) -> u64 {
        self.plan.missed
    }

    /// The decisions that are in force, by radar track.
    pub fn correlations(&self) -> Vec<HeldCorrelation> {
        self.operational().map_or_else(Vec::new, Operational::correlations)
    }

    /// An operator's word on an identity; it counts from the next slot on, until another one does. `false`: the profile knows
    /// none, or nothing was received yet.
    pub fn say(&mut self, word: Word) -> bool {
        match (&mut self.rules, self.clock) {
            (Rules::Operational(operational, _), Some(clock)) => {
                // What was said before a restart may still wait for the first slot.
                let is_over =
                    |since: Slot, earlier: Word| earlier.identity == word.identity && since <= clock.next;
                self.plan.words.retain(|&(since, earlier)| !is_over(since, earlier));
                operational.say(word, clock.next);
                true
            }
            _ => false,
        }
    }

    /// What was said in a flight that is replayed, or before a restart, each with its slot: it counts from that slot on, as it
    /// did then.
    pub fn plan_words(&mut self, mut words: Vec<(Slot, Word)>) {
        words.sort_by_key(|planned| planned.0);
        self.plan.words = words;
    }

    /// The operators' words in force, by identity; those of before a restart from the first report on.
    pub fn words(&self) -> Vec<HeldWord> {
        let (Some(operational), Some(clock)) = (self.operational(), self.clock) else { return Vec::new() };
        let mut words: BTreeMap<Identity, HeldWord> =
            operational.words().map(|held| (held.word.identity, held)).collect();
        for &(since, word) in self.plan.words.iter().take_while(|(since, _)| *since <= clock.next) {
            match word.trust {
                Trust::Automatic => words.remove(&word.identity),
                Trust::Trusted | Trust::Distrusted => words.insert(word.identity, HeldWord { word, since }),
            };
        }
        words.into_values().collect()
    }

    /// What is known of each identity heard lately; nothing in the `reference` profile.
    pub fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.operational().into_iter().flat_map(Operational::assessments)
    }

    /// The transponders that something can be decided of; none in the `reference` profile.
    pub fn transponders(&self) -> impl Iterator<Item = Identity> {
        self.operational().into_iter().flat_map(Operational::transponders)
    }

    /// Whether the profile knows decisions.
    pub fn knows_correlations(&self) -> bool {
        self.operational().is_some()
    }

    fn operational(&self) -> Option<&Operational> {
        match &self.rules {
            Rules::Operational(operational, _) => Some(operational),
            Rules::Reference(_) => None,
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
        let before = std::mem::replace(&mut self.rules, Rules::new(&self.settings));
        // A silence says nothing about how the radars are set up.
        if let (Rules::Operational(now, _), Rules::Operational(before, _)) = (&mut self.rules, before) {
            now.inherit(*before);
        }
        self.start(received);
        // Correlations ended with what they were about.
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

    /// The last slot that is worth a picture: at its deadline the newest report is no older than one is at the usual latency.
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
        numbers.turn(slot);
        if let Rules::Operational(operational, profile) = rules {
            plan.carry_out(slot, settings.window_slots, operational, profile);
            plan.resume((slot, settings.grid.centre(slot)), operational, profile);
        }
        let Yield { points, concerns, newcomers, now } = match rules {
            Rules::Reference(reference) => reference.emit(&window, numbers).into(),
            // Behind the last report of all nobody is extrapolated: a replay ends there, too.
            Rules::Operational(operational, profile) if last.is_none_or(|last| slot > last) => {
                operational.skip(slot, settings.grid, profile)
            }
            Rules::Operational(operational, profile) => {
                operational.emit(slot, settings.grid, profile, numbers)
            }
        };
        let numbers = numbers.take_changes();
        Some(Emission { slot, time: settings.grid.centre(slot), points, numbers, newcomers, concerns, now })
    }
}

impl Rules {
    fn new(settings: &Settings) -> Self {
        match &settings.profile {
            Profile::Reference(rules) => Self::Reference(Reference::new(settings, rules)),
            Profile::Operational(rules) => {
                let latency = settings.grid.slot() * settings.latency_slots as i32;
                let rules = operational::Settings::new(&settings.sensors, latency, rules);
                Self::Operational(Box::default(), rules)
            }
        }
    }
}

/// A report that is in time, and not taken in yet.
#[derive(Debug)]
pub struct Offer<'a> {
    engine: &'a mut Engine,
    slot: Slot,
    report: Report,
}

impl Offer<'_> {
    /// Takes it in.
    pub fn take(self) {
        let Self { engine, slot, report } = self;
        engine.newest = engine.newest.max(Some(slot));
        match &mut engine.rules {
            Rules::Reference(reference) => reference.handle(report),
            Rules::Operational(operational, _) => operational.handle(report),
        }
    }
}
