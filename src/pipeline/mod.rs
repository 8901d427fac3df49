//! The way in, in one place and one direction: datagram ► decode ► normalise ► engine. One owner; sans-IO.

mod duplicates;
mod event;
mod settings;

use asterix::{Block, Record, blocks, cat034, cat048, cat129, profile};

use crate::areas::Masks;
use crate::config::Config;
use crate::fusion::operational::{Decision, Undecided};
use crate::fusion::{self, Due, Emission, Engine, Given, Slot};
use crate::ingest::{Reception, ReceptionKind};
use crate::normalise::{Normaliser, Refusal, Refused, Report, SensorIndex};
use crate::registration::{State, StateError};
use crate::time::{SECOND, Time};
pub(crate) use duplicates::Duplicates;

pub use event::{Event, Tally};
use settings::settings;

/// A datagram's way through decoder, normalisation and engine.
#[derive(Debug)]
pub struct Pipeline {
    duplicates: Duplicates,
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
            engine: Engine::new(settings(config, &normaliser)),
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
        let octets = reception.payload.len();
        out(&mut self.tally, Output::Event(Event::Received { octets }));
        if let Some(received) = reception.received {
            self.advance(received, &mut out);
            let is_datagram = reception.kind == ReceptionKind::Datagram;
            if is_datagram && self.duplicates.is_repeated(&reception.payload, self.now) {
                return out(&mut self.tally, Output::Event(Event::DuplicateDatagram));
            }
        }
        for block in blocks(&reception.payload) {
            let Self { normaliser, engine, tally, .. } = self;
            let mut event = |event| out(tally, Output::Event(event));
            let Some(received) = reception.received else {
                // Nothing here has a time, nor anything before it: there is nothing to handle, only to count.
                untimed(block, &mut event);
                continue;
            };
            match block {
                Ok(block) if block.category == cat048::Record::CATEGORY => {
                    let plot = |record: &_| normaliser.plot(record, received).map(Report::Plot);
                    records(block, plot, |report| handle(engine, report, &mut hands_on), &mut event);
                }
                Ok(block) if block.category == cat129::Record::CATEGORY => {
                    let fix = |record: &_| normaliser.fix(record, received).map(Report::Fix);
                    let count =
                        records(block, fix, |report| handle(engine, report, &mut hands_on), &mut event);
                    if count > 1 {
                        event(Event::SeveralRecords);
                    }
                }
                Ok(block) if block.category == cat034::Record::CATEGORY => {
                    services(block, normaliser, &mut event);
                }
                Ok(block) => event(unused(block)),
                Err(fault) => event(Event::Faulty { fault }),
            }
        }
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
    pub fn restore(&mut self, sensor: SensorIndex, state: &State) -> Result<bool, StateError> {
        self.engine.restore(sensor, state)
    }

    /// An operator's word, from the next slot on ([`Engine::decide`]).
    ///
    /// # Errors
    /// The profile knows no decisions, or the radar track or the transponder is not there.
    pub fn decide(&mut self, decision: Decision) -> Result<(), Undecided> {
        self.engine.decide(decision)
    }

    /// What was decided in a flight that is replayed, each with its slot ([`Engine::plan`]).
    pub fn plan(&mut self, decisions: Vec<(Slot, Decision)>) {
        self.engine.plan(decisions);
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
        let behind_ns = self.engine.behind_ns(now);
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

/// Hands the reports of a block's records on; returns how many records were whole.
fn records<R: Record>(
    block: Block<'_>,
    report: impl Fn(&R) -> Result<Report, Refused>,
    mut handle: impl FnMut(Report) -> Result<Accepted, Refused>,
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
        event(match report(&record).and_then(&mut handle) {
            Ok(Accepted { sensor, time }) => Event::Accepted { sensor, time },
            Err((sensor, refusal)) => Event::Refused { category, sensor, refusal },
        });
    }
    count
}

/// A report that the engine takes.
struct Accepted {
    sensor: SensorIndex,
    time: Time,
}

fn handle(
    engine: &mut Engine,
    report: Report,
    hands_on: &mut impl FnMut(&Report) -> bool,
) -> Result<Accepted, Refused> {
    let time = report.time();
    let sensor = match &report {
        Report::Plot(plot) => plot.track.sensor,
        Report::Fix(fix) => fix.sensor,
    };
    let accepts = engine.accepts(time);
    let handled = if accepts.is_ok() && hands_on(&report) { engine.handle(report) } else { accepts };
    handled.map(|()| Accepted { sensor, time }).map_err(|refused| {
        let refusal = match refused {
            fusion::Refused::Late => Refusal::Late,
            fusion::Refused::Future => Refusal::Future,
        };
        (Some(sensor), refusal)
    })
}

/// Hands on what the radars say of themselves.
fn services(block: Block<'_>, normaliser: &Normaliser, event: &mut impl FnMut(Event)) {
    let category = block.category;
    for located in block.records::<cat034::Record>() {
        let record = match located {
            Ok(located) => located.record,
            Err(fault) => return event(Event::Faulty { fault }),
        };
        event(match normaliser.service(&record) {
            Ok((sensor, service)) => Event::Service { sensor, service },
            Err((sensor, refusal)) => Event::Refused { category, sensor, refusal },
        });
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
