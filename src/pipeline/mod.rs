//! The way in, in one place and one direction: datagram ► decode ► normalise ► who speaks ► engine. One owner; sans-IO.

mod duplicates;
mod event;
mod senders;
mod settings;

use std::net::SocketAddr;

use asterix::{Block, Record, blocks, cat034, cat048, cat129, profile};

use crate::areas::Masks;
use crate::capture::{Reception, ReceptionKind};
use crate::config::Config;
use crate::normalise::{Normaliser, Refusal, Refused};
pub(crate) use duplicates::Duplicates;
use fusion::numbering::Given;
use fusion::operational::{Correlation, NotCorrelated, ResumedCorrelation, SavedCorrelation};
use fusion::registration::{RegistrationState, RegistrationStateError};
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};
use fusion::{Due, Emission, Engine};
use fusion::{Report, SensorIndex};

pub use event::{Event, Tally};
pub use senders::Contest;
use senders::{Judged, Senders, Subject};
use settings::settings;

/// A datagram's way through decoder, normalisation and engine.
#[derive(Debug)]
pub struct Pipeline {
    duplicates: Duplicates,
    senders: Senders,
    normaliser: Normaliser,
    engine: Engine,
    tally: Tally,
    /// The latest reception.
    now: Time,
    /// Whether the clock of reception is being waited for: one alarm a step.
    clock_behind: bool,
}

/// What comes out while a reception is handled.
#[derive(Debug)]
pub enum Output {
    /// A slot that was due before the reception.
    Emission(Emission),
    /// What happened to it; already counted in the [`Tally`].
    Event(Event),
}

impl Pipeline {
    /// The pipeline of a site; plots inside `masks` are dropped.
    pub fn new(config: &Config, masks: Masks) -> Self {
        let normaliser = Normaliser::new(config, masks);
        Self {
            duplicates: Duplicates::default(),
            senders: Senders::new(config),
            engine: Engine::new(settings(config, &normaliser)).expect("the configuration was checked"),
            normaliser,
            tally: Tally::default(),
            now: Time::from_nanos(i64::MIN),
            clock_behind: false,
        }
    }

    /// Takes in what was received; hands out the slots due before it, then what happened to it.
    pub fn receive(&mut self, reception: &Reception, out: impl FnMut(Output)) {
        self.receive_some(reception, |_| true, out);
    }

    /// As [`Pipeline::receive`], but shows each report that the engine would accept to `hands_on`: the engine gets those
    /// for which it is `true`. All count as accepted.
    pub fn receive_some(
        &mut self,
        reception: &Reception,
        mut hands_on: impl FnMut(&Report) -> bool,
        mut out: impl FnMut(Output),
    ) {
        let mut out = |tally: &mut Tally, output: Output| {
            if let Output::Event(event) = &output {
                tally.count(event);
            }
            out(output);
        };
        let Reception { payload, from, .. } = reception;
        out(&mut self.tally, Output::Event(Event::Received { octets: payload.len() }));
        if let Some(received) = reception.received {
            self.advance(received, &mut out);
            if self.is_repeated(reception) {
                return out(&mut self.tally, Output::Event(Event::DuplicateDatagram));
            }
        }
        let Self { normaliser, engine, senders, tally, now, .. } = self;
        let mut intake = Intake {
            engine,
            senders,
            from: *from,
            now: *now,
            hands_on: &mut hands_on,
            taken: 0,
            refused: 0,
            contests: Vec::new(),
        };
        for block in blocks(payload) {
            let mut event = |event| out(tally, Output::Event(event));
            let Some(received) = reception.received else {
                // Nothing here has a time, nor anything before it: there is nothing to handle, only to count.
                untimed(block, &mut event);
                continue;
            };
            match block {
                Ok(block) if block.category == cat048::Record::CATEGORY => {
                    let plot = |record: &_| normaliser.plot(record, received).map(Report::Plot);
                    records(block, plot, &mut intake, &mut event);
                }
                Ok(block) if block.category == cat129::Record::CATEGORY => {
                    let fix = |record: &_| normaliser.fix(record, received).map(Report::Fix);
                    let count = records(block, fix, &mut intake, &mut event);
                    if count > 1 {
                        event(Event::SeveralRecords);
                    }
                }
                Ok(block) if block.category == cat034::Record::CATEGORY => {
                    services(block, normaliser, &mut intake, &mut event);
                }
                Ok(block) => event(unused(block)),
                Err(fault) => event(Event::Faulty { fault }),
            }
            intake.contests.drain(..).for_each(|contest| event(Event::Contested(contest)));
        }
        if intake.refused > 0 && intake.taken == 0 {
            // From a sender that counts, the same datagram is still to be handled.
            self.duplicates.was_refused(payload);
        }
    }

    /// Whether the datagram has been handled. Who else brought it is a line of the same sensor.
    fn is_repeated(&mut self, reception: &Reception) -> bool {
        let Reception { payload, from, kind, .. } = reception;
        if *kind != ReceptionKind::Datagram {
            return false;
        }
        if let Some(from) = *from {
            self.senders.hear(from, self.now);
        }
        let Some(earlier) = self.duplicates.note(payload, *from, self.now) else { return false };
        if let Some((first, from)) = earlier.from.zip(*from)
            && first != from
            && holds_reports(payload)
        {
            self.senders.bring_the_same(first, from, self.now);
        }
        earlier.handled
    }

    /// Tells the time where nothing is received: hands out the slots that are due by then. Before the first reception
    /// there are none.
    ///
    /// Nothing that is received later is handled otherwise for it, but for a step of the clock by more than the window:
    /// the receptions alone, replayed, give the same slots.
    pub fn tick(&mut self, now: Time, mut out: impl FnMut(Output)) {
        if self.engine.next_slot().is_none() {
            return;
        }
        let mut out = |tally: &mut Tally, output: Output| {
            if let Output::Event(event) = &output {
                tally.count(event);
            }
            out(output);
        };
        self.note_step(now, &mut out);
        drain(self.engine.tick(now), &mut self.tally, &mut out);
    }

    /// Takes over a transponder number given before a restart; whether it did. Before the first reception.
    pub fn remember(&mut self, given: Given) -> bool {
        self.engine.remember(given)
    }

    /// Takes over what was known of a radar's registration before a restart; whether it did ([`Engine::restore`]).
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<bool, RegistrationStateError> {
        self.engine.restore(sensor, state)
    }

    /// An operator's word, from the next slot on ([`Engine::correlate`]).
    ///
    /// # Errors
    /// The profile knows no decisions, or the radar track or the transponder is not there.
    pub fn correlate(&mut self, correlation: Correlation) -> Result<(), NotCorrelated> {
        self.engine.correlate(correlation)
    }

    /// What was decided in a flight that is replayed, each with its slot ([`Engine::plan`]).
    pub fn plan(&mut self, correlations: Vec<(Slot, Correlation)>) {
        self.engine.plan(correlations);
    }

    /// Correlations of before a restart ([`Engine::resume`]).
    pub fn resume(&mut self, kept: Vec<SavedCorrelation>) {
        self.engine.resume(kept);
    }

    /// What has become of them, each once.
    pub fn resumed(&mut self) -> Vec<ResumedCorrelation> {
        self.engine.resumed()
    }

    /// Transponder numbers are given for good, whatever the profile: for a replay that begins with none.
    pub fn keep_numbers_for_good(&mut self) {
        self.engine.keep_numbers_for_good();
    }

    /// The end of the input: hands out every slot up to the last that holds a report.
    pub fn finish(&mut self, mut out: impl FnMut(Emission)) {
        let Self { engine, tally, .. } = self;
        for emission in engine.finish() {
            emission.newcomers.iter().for_each(|&newcomers| tally.count(&Event::Newcomers(newcomers)));
            out(emission);
        }
    }

    /// What happened so far.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The senders that contradict one another at `now`.
    pub fn contests(&self, now: Time) -> Vec<Contest> {
        self.senders.contests(now)
    }

    /// The site's frame and geoid.
    pub fn normaliser(&self) -> &Normaliser {
        &self.normaliser
    }

    /// The engine, to look at.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    fn advance(&mut self, received: Time, out: &mut impl FnMut(&mut Tally, Output)) {
        self.note_step(received, out);
        self.now = self.now.max(received);
        drain(self.engine.advance(received), &mut self.tally, out);
    }

    /// One alarm where the clock has stepped back.
    fn note_step(&mut self, now: Time, out: &mut impl FnMut(&mut Tally, Output)) {
        let behind_ns = self.engine.behind(now).as_nanos() as i64;
        if behind_ns > SECOND && !self.clock_behind {
            out(&mut self.tally, Output::Event(Event::ClockBehind { behind_ns }));
        }
        self.clock_behind = behind_ns > SECOND || (self.clock_behind && behind_ns > 0);
    }
}

/// Hands out what is due, and that the engine starts afresh after it.
fn drain(due: Due<'_>, tally: &mut Tally, out: &mut impl FnMut(&mut Tally, Output)) {
    let restarts = due.restarts();
    for mut emission in due {
        let newcomers = std::mem::take(&mut emission.newcomers);
        out(tally, Output::Emission(emission));
        for newcomers in newcomers {
            out(tally, Output::Event(Event::Newcomers(newcomers)));
        }
    }
    if restarts {
        out(tally, Output::Event(Event::Restarted));
    }
}

/// Where the records of a datagram go, and what becomes of them.
struct Intake<'a, H> {
    engine: &'a mut Engine,
    senders: &'a mut Senders,
    /// Who sent it; without an address nobody is judged.
    from: Option<SocketAddr>,
    now: Time,
    hands_on: H,
    /// Records that were taken, and that were refused because another sender speaks for their sensor.
    taken: u32,
    refused: u32,
    /// Contests that are to be told.
    contests: Vec<Contest>,
}

/// A report that the engine takes.
struct Accepted {
    sensor: SensorIndex,
    time: Time,
}

impl<H: FnMut(&Report) -> bool> Intake<'_, H> {
    /// Hands on a report of this category, unless somebody refuses it.
    fn take(&mut self, category: u8, report: Result<Report, Refused>) -> Result<Accepted, Refused> {
        let report = report.inspect_err(|(sensor, _)| {
            if let Some(sensor) = *sensor {
                self.note_spoken(Subject { sensor, category, identity: None });
            }
        })?;
        let (sensor, identity) = match &report {
            Report::Plot(plot) => (plot.track.sensor, None),
            Report::Fix(fix) => (fix.sensor, Some(fix.identity)),
        };
        let (time, subject) = (report.time(), Subject { sensor, category, identity });
        let accepted = self.engine.accepts(time).map_err(|refused| (Some(sensor), refusal(refused)));
        accepted.inspect_err(|_| self.note_spoken(subject))?;
        self.judge(subject)?;
        if (self.hands_on)(&report) {
            self.engine.handle(report).map_err(|refused| (Some(sensor), refusal(refused)))?;
        }
        Ok(Accepted { sensor, time })
    }

    /// Whether the sender of the datagram speaks for this sensor.
    fn judge(&mut self, subject: Subject) -> Result<(), Refused> {
        let judged = self.from.map_or(Judged::Counts, |from| self.senders.judge(subject, from, self.now));
        match judged {
            Judged::Counts => {
                self.taken += 1;
                Ok(())
            }
            Judged::Refused(contest) => {
                self.refused += 1;
                self.contests.extend(contest);
                Err((Some(subject.sensor), Refusal::OtherSender))
            }
        }
    }

    fn note_spoken(&mut self, subject: Subject) {
        if let Some(from) = self.from {
            self.senders.still_speaks(subject, from, self.now);
        }
    }
}

fn refusal(refused: fusion::Refused) -> Refusal {
    match refused {
        fusion::Refused::Late => Refusal::Late,
        fusion::Refused::Future => Refusal::Future,
    }
}

/// Whether a datagram tells lines of one sensor from two sensors: service messages of two radars may be equal by chance.
fn holds_reports(payload: &[u8]) -> bool {
    let reports = [cat048::Record::CATEGORY, cat129::Record::CATEGORY];
    blocks(payload).flatten().any(|block| reports.contains(&block.category))
}

/// Hands the reports of a block's records on; returns how many records were whole.
fn records<R: Record>(
    block: Block<'_>,
    report: impl Fn(&R) -> Result<Report, Refused>,
    intake: &mut Intake<'_, impl FnMut(&Report) -> bool>,
    event: &mut impl FnMut(Event),
) -> usize {
    let category = block.category;
    let mut count = 0;
    for located in block.records::<R>() {
        let record = match located {
            Ok(located) => located.record,
            Err(fault) => {
                event(Event::Faulty { fault });
                break;
            }
        };
        count += 1;
        event(match intake.take(category, report(&record)) {
            Ok(Accepted { sensor, time }) => Event::Accepted { sensor, time },
            Err((sensor, refusal)) => Event::Refused { category, sensor, refusal },
        });
    }
    count
}

/// Hands on what the radars say of themselves.
fn services(
    block: Block<'_>,
    normaliser: &Normaliser,
    intake: &mut Intake<'_, impl FnMut(&Report) -> bool>,
    event: &mut impl FnMut(Event),
) {
    let category = block.category;
    for located in block.records::<cat034::Record>() {
        let record = match located {
            Ok(located) => located.record,
            Err(fault) => return event(Event::Faulty { fault }),
        };
        let said = normaliser.service(&record).and_then(|(sensor, service)| {
            intake.judge(Subject { sensor, category, identity: None })?;
            Ok(Event::Service { sensor, service })
        });
        event(said.unwrap_or_else(|(sensor, refusal)| Event::Refused { category, sensor, refusal }));
    }
}

/// Counts a block in front of the first record that has a time.
fn untimed(block: Result<Block<'_>, asterix::Fault>, event: &mut impl FnMut(Event)) {
    fn each<R: Record>(block: Block<'_>, event: &mut impl FnMut(Event)) {
        let refused = Event::Refused { category: block.category, sensor: None, refusal: Refusal::NoTime };
        for located in block.records::<R>() {
            event(located.map_or_else(|fault| Event::Faulty { fault }, |_| refused));
        }
    }
    match block {
        Ok(block) if block.category == cat048::Record::CATEGORY => each::<cat048::Record>(block, event),
        Ok(block) if block.category == cat129::Record::CATEGORY => each::<cat129::Record>(block, event),
        Ok(block) if block.category == cat034::Record::CATEGORY => each::<cat034::Record>(block, event),
        Ok(block) => event(unused(block)),
        Err(fault) => event(Event::Faulty { fault }),
    }
}

/// A block that nothing is taken from. Of a category whose profile is known it must still be well formed.
fn unused(block: Block<'_>) -> Event {
    let fault = profile(block.category).and_then(|profile| block.measure(profile).err());
    fault.map_or(Event::SkippedBlock { category: block.category }, |fault| Event::Faulty { fault })
}
