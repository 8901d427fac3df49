//! The input path, in one direction: datagram ► decode ► normalise ► check sender ► engine. One owner; sans-IO.

mod checkpoint;
mod duplicates;
mod event;
mod generations;
mod journal;
mod names;
mod remote_id;
mod selection;
mod sender;
mod senders;
mod settings;
mod shedding;

use asterix::{
    Block, DataSource, Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129,
    profile,
};
use serde::{Deserialize, Serialize};

use crate::capture::{Reception, ReceptionKind};
use crate::gateways::remote_id::BroadcastLine;
pub use crate::gateways::remote_id::{is_broadcast, is_lines};
use crate::normalise::{Barometer, Normaliser, Refusal, Refused, Service};
pub(crate) use duplicates::Duplicates;
use fusion::time::{SECOND, Time};
use fusion::{Emission, Engine, Fix, Report, SensorIndex};
use site::areas::Masks;
use site::config::Config;

pub use checkpoint::NotRestored;
pub use event::{Event, Tally};
use journal::Journal;
pub use journal::Output;
use names::Names;
pub use remote_id::LineFault;
use remote_id::{RemoteIdOutcome, Transmitters};
pub use selection::Selection;
use sender::Sender;
pub use senders::{Contest, ContestReason, Takeover};
use senders::{Senders, Subject};
use settings::settings;
pub use shedding::{Shed, Shedding};

/// Number used in place of a category for Remote ID.
const REMOTE_ID: u8 = 0;

/// Passes datagrams through decoder, normalisation and engine.
///
/// Each input ([`Pipeline::receive`], [`Pipeline::tick`], [`Pipeline::finish`]) is processed at once. Its outputs are taken by
/// [`Pipeline::poll`] in the order in which they occurred; the next input discards those that were not taken.
#[derive(Debug)]
pub struct Pipeline {
    duplicates: Duplicates,
    senders: Senders,
    normaliser: Normaliser,
    barometer: Barometer,
    /// State of Remote ID; `None`: the site has no Remote ID.
    remote_id: Option<RemoteId>,
    /// SAC and SIC of the service's own output.
    own: DataSource,
    engine: Engine,
    /// Whether plots are checked and counted, and not passed to the engine.
    withholds_plots: bool,
    /// Reports that belong to this cell; `None`: all.
    selection: Option<Selection>,
    /// Plots that are left out during overload; `None`: none, and nothing is tracked.
    shedding: Option<Shedding>,
    journal: Journal,
    /// Time of the latest reception.
    now: Time,
    /// Whether the clock of reception is behind: a step is reported once.
    clock_behind: bool,
}

/// State of Remote ID.
#[derive(Debug, Default, Serialize, Deserialize)]
struct RemoteId {
    transmitters: Transmitters,
    names: Names,
}

impl Pipeline {
    /// The pipeline of a site. Plots inside `masks` are dropped.
    pub fn new(config: &Config, masks: Masks) -> Self {
        let normaliser = Normaliser::new(config, masks);
        let remote_id = normaliser.remote_id_receivers().next().map(|_| RemoteId::default());
        Self {
            duplicates: Duplicates::default(),
            senders: Senders::new(config),
            engine: Engine::new(settings(config, &normaliser)).expect("the configuration was checked"),
            withholds_plots: false,
            selection: None,
            shedding: None,
            barometer: Barometer::default(),
            remote_id,
            own: DataSource { sac: config.site.sac, sic: config.site.sic },
            normaliser,
            journal: Journal::default(),
            now: Time::from_nanos(i64::MIN),
            clock_behind: false,
        }
    }

    /// This pipeline, with plots not passed to the engine; they still count as accepted.
    pub fn without_plots(self) -> Self {
        Self { withholds_plots: true, ..self }
    }

    /// This pipeline, for one cell: only reports for the cell reach the engine, everything else is counted.
    pub fn selecting(self, selection: Selection) -> Self {
        Self { selection: Some(selection), ..self }
    }

    /// This pipeline, with heights optional in ADS-B and Remote ID under any profile; a missing height is assumed.
    pub fn with_optional_heights(self) -> Self {
        Self { normaliser: self.normaliser.with_optional_heights(), ..self }
    }

    /// Processes a reception. Outputs: the slots due before it, then the events in handling it.
    pub fn receive(&mut self, reception: &Reception) {
        let Reception { payload, from, received, .. } = reception;
        self.journal.outputs.clear();
        self.journal.note(Event::Received { octets: payload.len() });
        if let Some(received) = *received {
            self.note_step(received);
            let due = self.engine.advance(received);
            let is_set_back = due.restarts() && received < self.now;
            self.journal.emit(due);
            if is_set_back {
                self.set_back();
            }
            self.now = if is_set_back { received } else { self.now.max(received) };
            let left = self.selection.as_mut().map(|selection| selection.left(received));
            left.into_iter().flatten().for_each(|left| self.engine.forget_departed(left));
        }
        let mut sender = Sender::of(*from);
        if received.is_some() && self.is_repeated(reception, &mut sender) {
            return self.journal.note(Event::DuplicateDatagram);
        }
        // Receptions without a time occur only before the first record with a time: they are counted and not handled.
        let timed = received.ok_or((None, Refusal::NoTime));
        if self.remote_id.is_some()
            && reception.kind == ReceptionKind::Datagram
            && let Some(heard) = remote_id::heard(payload, *from)
        {
            heard.into_iter().for_each(|heard| match heard {
                Ok(heard) => self.hear(&heard, timed, &mut sender),
                Err(fault) => self.journal.note(Event::FaultyLine { fault }),
            });
            return self.note_refused(payload, &sender);
        }
        for block in blocks(payload) {
            match block {
                Ok(block) if block.category == cat048::Record::CATEGORY => {
                    self.each(block, |pipeline, record: &cat048::Record| {
                        pipeline.admit((block.category, record.data_source), &mut sender)?;
                        let report = pipeline.normaliser.plot(record, timed?);
                        pipeline.take(block.category, report.map(Report::Plot), &mut sender)
                    });
                }
                Ok(block) if block.category == cat129::Record::CATEGORY => {
                    let count = self.each(block, |pipeline, record: &cat129::Record| {
                        pipeline.admit((block.category, record.data_source), &mut sender)?;
                        let report = pipeline.normaliser.fix(record, timed?);
                        pipeline.take(block.category, report.map(Report::Fix), &mut sender)
                    });
                    if count > 1 && timed.is_ok() {
                        self.journal.note(Event::SeveralRecords);
                    }
                }
                Ok(block) if block.category == cat021::Record::CATEGORY && self.normaliser.has_adsb() => {
                    // For a receiver that is not configured the edition does not matter.
                    let source = block.first_source();
                    let edition =
                        source.and_then(|source| self.normaliser.edition(source)).unwrap_or_default();
                    self.each_in(block, edition, |pipeline, record: &cat021::Record| {
                        pipeline.admit((block.category, record.data_source), &mut sender)?;
                        let before = pipeline.barometer.clone();
                        let report = pipeline.normaliser.adsb(record, timed?, &mut pipeline.barometer);
                        let taken = pipeline.take(block.category, report.map(Report::Fix), &mut sender);
                        if matches!(taken, Err((_, Refusal::OtherSender))) {
                            // Only accepted senders may update the barometer.
                            pipeline.barometer = before;
                        }
                        taken
                    });
                }
                Ok(block) if block.category == cat015::Record::CATEGORY && self.normaliser.has_cameras() => {
                    self.each(block, |pipeline, record: &cat015::Record| {
                        pipeline.admit((block.category, record.data_source), &mut sender)?;
                        let report = pipeline.normaliser.bearing(record, timed?);
                        pipeline.take(block.category, report.map(Report::Bearing), &mut sender)
                    });
                }
                Ok(block) if block.category == cat034::Record::CATEGORY => {
                    self.each::<cat034::Record>(block, |pipeline, record| {
                        pipeline.admit((block.category, record.data_source), &mut sender)?;
                        timed?;
                        let (sensor, service) = pipeline.normaliser.service(record)?;
                        let subject = Subject { sensor, category: block.category, identity: None };
                        let Self { senders, journal, .. } = pipeline;
                        sender.judge(subject, senders, pipeline.now, journal)?;
                        Ok(Event::Service { sensor, service, from: sender.address })
                    });
                }
                Ok(block) if block.category == cat062::Record::CATEGORY && self.is_own(block) => {
                    self.refuse_own::<cat062::Record>(block);
                }
                Ok(block) if block.category == cat063::Record::CATEGORY && self.is_own(block) => {
                    self.refuse_own::<cat063::Record>(block);
                }
                Ok(block) => self.journal.note(unused(block)),
                Err(fault) => self.journal.note(Event::Faulty { fault }),
            }
        }
        self.note_refused(payload, &sender);
    }

    /// Marks a datagram as refused if all of it was refused because of its sender: a copy from an accepted sender is still to be
    /// handled.
    fn note_refused(&mut self, payload: &[u8], sender: &Sender) {
        if sender.was_refused && !sender.was_taken {
            self.duplicates.was_refused(payload);
        }
    }

    /// Discards the state that depends on times that now lie in the future: the clock of reception was set back for good.
    fn set_back(&mut self) {
        self.duplicates = Duplicates::default();
        self.senders.start_afresh();
        self.barometer = Barometer::default();
        self.remote_id.iter_mut().for_each(|known| *known = RemoteId::default());
        self.clock_behind = false;
    }

    /// Whether the datagram has already been handled. Adds to `sender` the senders from which it was refused before.
    fn is_repeated(&mut self, reception: &Reception, sender: &mut Sender) -> bool {
        let Reception { payload, from, kind, .. } = reception;
        if *kind != ReceptionKind::Datagram {
            return false;
        }
        if let Some(from) = *from {
            let contests = self.senders.hear(from, self.now);
            contests.into_iter().for_each(|contest| self.journal.note(Event::Contested(contest)));
        }
        let Some(earlier) = self.duplicates.note(payload, *from, self.now) else { return false };
        if let Some(from) = *from
            && holds_reports(payload)
        {
            for first in earlier.from.into_iter().chain(earlier.refused.iter().map(|&(first, _)| first)) {
                self.senders.bring_the_same(first.ip(), from.ip(), self.now);
            }
        }
        sender.earlier = earlier.refused;
        earlier.handled
    }

    /// Checks whether the sender may speak for the sensor of a record.
    fn admit(
        &mut self,
        (category, source): (u8, Option<DataSource>),
        sender: &mut Sender,
    ) -> Result<(), Refused> {
        let sensor = source.and_then(|source| self.normaliser.sensor(category, source));
        sensor.map_or(Ok(()), |sensor| self.admit_for(sensor, category, sender))
    }

    fn admit_for(&mut self, sensor: SensorIndex, category: u8, sender: &mut Sender) -> Result<(), Refused> {
        let Self { senders, journal, now, .. } = self;
        sender.admit((sensor, category), senders, *now, journal)
    }

    /// Processes a broadcast of Remote ID and notes its events.
    fn hear(&mut self, heard: &BroadcastLine, timed: Result<Time, Refused>, sender: &mut Sender) {
        // Several receivers of a site receive the same drones, so their senders are not compared.
        let mut nobody = Sender::default();
        let host = sender.host();
        let sensor = self.normaliser.remote_id_receiver(heard.receiver.as_deref());
        let of_sensor = timed.and_then(|received| {
            let sensor = sensor?;
            self.admit_for(sensor, REMOTE_ID, sender)?;
            sender.was_taken = true;
            Ok((received, sensor))
        });
        let (received, sensor) = match of_sensor {
            Ok(known) => known,
            Err((sensor, refusal)) => return self.journal.note(Event::Refused { sensor, refusal }),
        };
        let said = self.remote_id.as_mut().map(|known| known.transmitters.hear(heard, self.now));
        for said in said.into_iter().flatten() {
            let event = match said {
                RemoteIdOutcome::Position(identity, location, declared) => {
                    let drone = (identity, &location, declared);
                    let Self { normaliser, barometer, .. } = self;
                    let report = normaliser.remote_id(sensor, drone, received, heard.time, barometer);
                    let report = report.map(|fix| Report::Fix(Fix { host, ..fix }));
                    let taken = self.take(REMOTE_ID, report, &mut nobody);
                    taken.unwrap_or_else(|(sensor, refusal)| Event::Refused { sensor, refusal })
                }
                RemoteIdOutcome::Identity => {
                    Event::Service { sensor, service: Service::default(), from: sender.address }
                }
                RemoteIdOutcome::Unused(refusal) => Event::Refused { sensor: Some(sensor), refusal },
                RemoteIdOutcome::Faulty(fault) => Event::FaultyLine { fault },
            };
            self.journal.note(event);
        }
    }

    /// Notes the outcome of each record of a block; returns the number of readable records.
    fn each<R: Record<Edition = ()>>(
        &mut self,
        block: Block<'_>,
        take: impl FnMut(&mut Self, &R) -> Result<Event, Refused>,
    ) -> usize {
        self.each_in(block, (), take)
    }

    /// Notes the outcome of each record of a block in an edition of its category; returns the number of readable records.
    fn each_in<R: Record>(
        &mut self,
        block: Block<'_>,
        edition: R::Edition,
        mut take: impl FnMut(&mut Self, &R) -> Result<Event, Refused>,
    ) -> usize {
        let mut count = 0;
        for located in block.records_in::<R>(edition) {
            let event = match located {
                Ok(located) => {
                    count += 1;
                    let refused = |(sensor, refusal)| Event::Refused { sensor, refusal };
                    take(self, &located.record).unwrap_or_else(refused)
                }
                Err(fault) => Event::Faulty { fault },
            };
            self.journal.note(event);
        }
        count
    }

    /// Whether the first record of a block of CAT062 or CAT063 comes from this service. I062/010 and I063/010 are the first items
    /// in every edition, directly after the FSPEC.
    fn is_own(&self, block: Block<'_>) -> bool {
        let record = block.contents();
        let announces_it = record.first().is_some_and(|first| first & 0x80 != 0);
        let last = record.iter().position(|octet| octet & 1 == 0);
        let source = last.and_then(|last| record.get(last + 1..last + 3));
        announces_it && source == Some(&[self.own.sac, self.own.sic])
    }

    /// Refuses tracks and status that this service itself has sent: they come from no sensor.
    fn refuse_own<R: Record<Edition = ()>>(&mut self, block: Block<'_>) {
        let own = self.own;
        let refusal = Refusal::UnknownSource { category: block.category, source: own };
        self.each::<R>(block, |_, _| Err((None, refusal)));
    }

    /// Passes a report of this category to the engine, unless the engine or the check of its sender refuses it.
    fn take(
        &mut self,
        category: u8,
        report: Result<Report, Refused>,
        sender: &mut Sender,
    ) -> Result<Event, Refused> {
        let Self {
            engine,
            senders,
            now,
            withholds_plots,
            remote_id,
            selection,
            shedding,
            normaliser,
            journal,
            ..
        } = self;
        let mut report = report.inspect_err(|(sensor, _)| {
            if let Some(sensor) = *sensor {
                sender.keep_active(Subject { sensor, category, identity: None }, senders, *now);
            }
        })?;
        if let Report::Fix(fix) = &mut report {
            if sender.address.is_some() {
                fix.host = sender.host();
            }
            if let Some(known) = remote_id {
                fix.identity = known.names.settle(fix.identity, *now);
            }
        }
        let (sensor, identity) = match &report {
            Report::Plot(plot) => (plot.track.sensor, None),
            Report::Fix(fix) => (fix.sensor, Some(fix.identity)),
            Report::Bearing(bearing) => (bearing.track.sensor, None),
        };
        let subject = Subject { sensor, category, identity };
        let offer = engine.offer(report).map_err(|refused| {
            sender.keep_active(subject, senders, *now);
            (Some(sensor), refusal(refused))
        })?;
        sender.judge(subject, senders, *now, journal)?;
        if selection.as_mut().is_some_and(|selection| !selection.takes(&report, normaliser.frame())) {
            return Ok(Event::Elsewhere { sensor, report });
        }
        if let (Report::Plot(plot), Some(shedding)) = (&report, shedding)
            && !shedding.takes(plot)
        {
            return Ok(Event::Shed { sensor, report });
        }
        if !(*withholds_plots && matches!(report, Report::Plot(_))) {
            offer.accept();
        }
        Ok(Event::Accepted { sensor, report })
    }

    /// Advances the time while nothing is received. Outputs: the slots that are due by then; none before the first reception.
    ///
    /// A tick does not affect later receptions, except after a step of the clock by more than the window: replaying the
    /// receptions without ticks gives the same slots.
    pub fn tick(&mut self, now: Time) {
        self.journal.outputs.clear();
        if self.engine.next_slot().is_some() {
            self.note_step(now);
            self.journal.emit(self.engine.tick(now));
        }
    }

    /// Ends the input. Outputs: all slots up to the last one that holds a report.
    pub fn finish(&mut self) {
        let Journal { tally, outputs } = &mut self.journal;
        outputs.clear();
        for emission in self.engine.finish() {
            emission.newcomers.iter().for_each(|&newcomers| tally.count(&Event::Newcomers(newcomers)));
            emission.jumping.iter().for_each(|&jumping| tally.count(&Event::JumpingTracks(jumping)));
            outputs.push_back(Output::Emission(emission));
        }
    }

    /// The next output for the latest input.
    pub fn poll(&mut self) -> Option<Output> {
        self.journal.outputs.pop_front()
    }

    /// The slots among the outputs for the latest input; its events are discarded.
    pub fn emissions(&mut self) -> impl Iterator<Item = Emission> {
        self.journal.outputs.drain(..).filter_map(|output| match output {
            Output::Emission(emission) => Some(emission),
            Output::Event(_) => None,
        })
    }

    /// Counters of all events so far.
    pub fn tally(&self) -> &Tally {
        &self.journal.tally
    }

    /// The contests between senders that last at `now`.
    pub fn contests(&self, now: Time) -> Vec<Contest> {
        self.senders.contests(now)
    }

    /// The normaliser, with the site's frame and geoid.
    pub fn normaliser(&self) -> &Normaliser {
        &self.normaliser
    }

    /// The engine, for reading.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The engine, for restoring the state of an earlier run and for operators' decisions. Only the pipeline passes it time and
    /// reports.
    pub fn engine_mut(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Reports a backward step of the clock, once per step.
    fn note_step(&mut self, now: Time) {
        let behind_ns = self.engine.behind(now).as_nanos() as i64;
        if behind_ns > SECOND && !self.clock_behind {
            self.journal.note(Event::ClockBehind { behind_ns });
        }
        self.clock_behind = behind_ns > SECOND || (self.clock_behind && behind_ns > 0);
    }
}

fn refusal(refused: fusion::ReportRefusal) -> Refusal {
    match refused {
        fusion::ReportRefusal::Late => Refusal::Late,
        fusion::ReportRefusal::Future => Refusal::Future,
    }
}

/// Whether a datagram holds reports, so that two senders of it are redundant lines. Service messages of two radars may be equal
/// by chance.
fn holds_reports(payload: &[u8]) -> bool {
    let reports = [48, 129, 21, 15];
    blocks(payload).flatten().any(|block| reports.contains(&block.category))
}

/// The event of a block that is not used. The status of a service (CAT065) must be well formed; other unused categories may
/// follow any edition.
fn unused(block: Block<'_>) -> Event {
    let profile = profile(block.category).filter(|_| block.category == cat065::Record::CATEGORY);
    let fault = profile.and_then(|profile| block.measure(profile).err());
    fault.map_or(Event::SkippedBlock { category: block.category }, |fault| Event::Faulty { fault })
}
