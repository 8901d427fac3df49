//! The pipeline with its clock: arrivals and ticks in, slots out. Sans-IO, so that a test can own the time.

use std::collections::VecDeque;

use bytes::Bytes;
use jiff::SignedDuration;

use super::contests::note_contests;
use super::health::{Health, LineStatus, SensorStatus};
use super::published::PublishedPicture;
use super::registration::Registrar;
use crate::areas::Masks;
use crate::capture::Reception;
use crate::config::Config;
use crate::integrity::{Flags, Lookout};
use crate::picture::PictureMaker;
use crate::pipeline::{Event, NotRestored, Output, Pipeline, Selection, Shed, Shedding};
use crate::state::{EngineState, Warm};
use fusion::Engine;
use fusion::integrity::Word;
use fusion::numbering::{Given, NumberChange};
use fusion::operational::{Correlation, NotCorrelated};
use fusion::slots::Slot;
use fusion::time::Time;

/// An arrival that waited in the queue while a slot was made is handled this much later than that.
const AFTER_MAKING: SignedDuration = SignedDuration::from_micros(1);

/// A clock that is set back after a start by no more than this makes the first slot later by as much.
const CLOCK_SET: SignedDuration = SignedDuration::from_secs(1);

/// Output of the driver.
#[derive(Debug)]
pub enum Made {
    /// A slot, not yet published: its `published_at` is its deadline, which may lie ahead by [`Driver::lead`].
    Slot(PublishedPicture),
    /// A change of a transponder number, which came with the slot before it.
    Number(NumberChange),
    /// Something that happened to what was received.
    Event(Event),
}

/// The one owner of the engine.
#[derive(Debug)]
pub struct Driver {
    pipeline: Pipeline,
    maker: PictureMaker,
    health: Health,
    registrar: Registrar,
    lookout: Lookout,
    flags: Flags,
    /// From a slot's centre to its deadline.
    due_after: SignedDuration,
    /// When the latest slot was to be made, or the time of a fresh start after it: nothing is handled at an earlier time.
    made_at: Option<Time>,
    /// The latest slot's centre.
    latest: Option<Time>,
    /// Slots up to this centre were an earlier service's to publish.
    published: Option<Time>,
    seq: u64,
    /// Copies by line.
    duplicates: Vec<u64>,
    /// What the latest input made; the buffer is reused.
    made: VecDeque<Made>,
}

impl Driver {
    /// The driver of a site with that number of lines; `started` is now.
    pub fn new(config: &Config, masks: Masks, started: Time, lines: usize) -> Self {
        let pipeline = Pipeline::new(config, masks);
        Self {
            maker: PictureMaker::new(config, pipeline.normaliser()),
            health: Health::new(config, started),
            registrar: Registrar::new(config),
            lookout: Lookout::default(),
            flags: Flags::default(),
            due_after: config.fusion.latency() - config.fusion.slot / 2,
            pipeline,
            made_at: None,
            latest: None,
            published: None,
            seq: 0,
            duplicates: vec![0; lines],
            made: VecDeque::new(),
        }
    }

    /// Goes on where an earlier service has stopped: what that one had not published, and was not due by `now`, this one does.
    ///
    /// # Errors
    /// The state is of another version, or the site or its settings are others now.
    pub fn go_on(
        &mut self,
        config: &Config,
        masks: Masks,
        warm: &Warm,
        now: Time,
    ) -> Result<(), NotRestored> {
        self.restore(config, masks, &warm.engine)?;
        warm.inputs.iter().for_each(|input| self.receive(input));
        // Slots that were due meanwhile are nobody's any more.
        self.tick(now);
        self.made.clear();
        self.published = warm.published;
        self.seq = 0;
        Ok(())
    }

    /// Leaves slots up to this centre to an earlier service, of which nobody knows what it has published.
    pub fn publish_after(&mut self, centre: Time) {
        self.published = Some(centre);
    }

    /// The centre up to which slots are published, by this service or an earlier one.
    pub fn published(&self) -> Option<Time> {
        self.latest.max(self.published)
    }

    /// Is from now on as the driver was that wrote this state.
    ///
    /// # Errors
    /// The state is of another version, or the site or its settings are others now.
    pub fn restore(&mut self, config: &Config, masks: Masks, state: &[u8]) -> Result<(), NotRestored> {
        let state = EngineState::parse(state).ok_or(NotRestored::Unreadable)?;
        self.pipeline = Pipeline::restored(config, masks, state.pipeline)?;
        self.lookout.go_on(state.lookout);
        Ok(())
    }

    /// The state as octets ([`Driver::restore`]).
    pub fn checkpoint(&self, config: &Config) -> Bytes {
        let mut octets = Vec::new();
        self.checkpoint_into(config, &mut octets);
        octets.into()
    }

    /// The same, written behind what stands in a buffer.
    pub fn checkpoint_into(&self, config: &Config, octets: &mut Vec<u8>) {
        EngineState::begin(&self.lookout.checkpoint(), octets);
        self.pipeline.checkpoint_into(config, octets);
    }

    /// The same for a cell: its engine is given what is for it.
    pub fn selecting(self, selection: Selection) -> Self {
        Self { pipeline: self.pipeline.selecting(selection), ..self }
    }

    /// The slot that is made next; `None` before the first arrival.
    pub fn next_slot(&self) -> Option<Slot> {
        self.pipeline.engine().next_slot()
    }

    /// The same with somebody on the lookout for drones without a transponder.
    pub fn with_lookout(self, lookout: Lookout) -> Self {
        Self { lookout, ..self }
    }

    /// The time at which an arrival is handled at `now`, and recorded: its own, or just after the last slot was to be made
    /// where that has been while it waited. Where the clock was set back by more than the window it is its own.
    pub fn reception(&self, received: Time, now: Time) -> Time {
        if self.pipeline.engine().is_set_back(received.max(now)) {
            return received;
        }
        self.made_at.map_or(received, |made| received.max(made + AFTER_MAKING))
    }

    /// When the next slot is to be made; `None` before the first arrival.
    pub fn next_made(&self) -> Option<Time> {
        self.pipeline.engine().next_made()
    }

    /// How long before it is due a slot is made.
    pub fn lead(&self) -> SignedDuration {
        self.pipeline.engine().lead()
    }

    /// Handles what was received; its time is the one that [`Driver::reception`] gave for it.
    pub fn receive(&mut self, reception: &Reception) {
        self.pipeline.receive(reception);
        // Without a time of reception nothing is accepted, and the health has nothing to note.
        self.gather(reception.received.unwrap_or_default(), Some(reception.input));
    }

    /// Tells the time: slots that are due are made, one by one, also after a pause.
    pub fn tick(&mut self, now: Time) {
        self.pipeline.tick(now);
        self.gather(now, None);
    }

    /// The end: makes what the window still holds.
    pub fn finish(&mut self) {
        self.pipeline.finish();
        self.gather(Time::default(), None);
    }

    /// The next of what the latest input made, in the order in which it happened. What nobody took is gone with the next
    /// input.
    pub fn poll(&mut self) -> Option<Made> {
        self.made.pop_front()
    }

    /// Whether the engine starts afresh after the slots that wait here.
    pub fn starts_afresh(&self) -> bool {
        self.made.iter().any(|made| matches!(made, Made::Event(Event::Restarted)))
    }

    /// Whether a slot was an earlier service's. Where it is older than any that was still to be made at the start, the clock has
    /// been set back since, and what it said then counts no more.
    fn is_left(&mut self, centre: Time) -> bool {
        self.published = self.published.filter(|&until| until - centre <= self.due_after + CLOCK_SET);
        self.published.is_some_and(|until| centre <= until)
    }

    /// Takes the pipeline's outputs of an input at `at`, which came on `line` where it was received.
    fn gather(&mut self, at: Time, line: Option<usize>) {
        self.made.clear();
        while let Some(output) = self.pipeline.poll() {
            match output {
                Output::Emission(mut emission) => {
                    let numbers = std::mem::take(&mut emission.numbers);
                    self.flags.note(&emission.concerns);
                    let now = emission.now.take().map(|now| self.maker.now(now));
                    let mut picture = self.maker.picture(emission);
                    self.lookout.look(&mut picture, &self.maker);
                    let now = now.map(|mut now| {
                        now.mark_as(&picture);
                        now
                    });
                    self.latest = Some(picture.time);
                    let due = picture.time + self.due_after;
                    self.made_at = Some(due + -self.lead());
                    if !self.is_left(picture.time) {
                        self.seq += 1;
                        self.made.push_back(Made::Slot(PublishedPicture {
                            seq: self.seq,
                            due,
                            published_at: due,
                            picture,
                            now: now.into(),
                        }));
                    }
                    self.made.extend(numbers.into_iter().map(Made::Number));
                }
                Output::Event(event) => {
                    match (event, line) {
                        (Event::DuplicateDatagram, Some(line)) => {
                            self.duplicates.get_mut(line).into_iter().for_each(|count| *count += 1);
                        }
                        (Event::Restarted, None) => self.made_at = Some(at),
                        (Event::Restarted, Some(_)) => self.made_at = self.made_at.filter(|&made| made <= at),
                        _ => {}
                    }
                    self.health.note(&event, at);
                    self.made.push_back(Made::Event(event));
                }
            }
        }
    }

    /// Restores the transponder numbers given before a restart; drops those that contradict others
    /// ([`fusion::numbering::Numbers::remember`]), and returns how many.
    pub fn remember(&mut self, numbers: &mut Vec<Given>) -> usize {
        let before = numbers.len();
        numbers.retain(|&given| self.pipeline.engine_mut().remember(given));
        before - numbers.len()
    }

    /// An operator's decision; the first slot that is published by it.
    ///
    /// # Errors
    /// The profile knows no decisions, or the radar track or the transponder is not there.
    pub fn correlate(&mut self, correlation: Correlation) -> Result<Slot, NotCorrelated> {
        let engine = self.pipeline.engine_mut();
        engine.correlate(correlation)?;
        // Before the first slot nothing is there.
        engine.next_slot().ok_or(NotCorrelated::NoRadarTrack)
    }

    /// What is left out from now on, for a machine that cannot keep up.
    pub fn shed(&mut self, shed: Shed) {
        self.pipeline.shed(shed);
    }

    /// Who is left out, where somebody is.
    pub fn shedding_mut(&mut self) -> Option<&mut Shedding> {
        self.pipeline.shedding_mut()
    }

    /// An operator's word on a transponder; the first slot that is published by it. `None`: the profile knows none, or nothing
    /// was received yet.
    pub fn say(&mut self, word: Word) -> Option<Slot> {
        let engine = self.pipeline.engine_mut();
        engine.say(word).then(|| engine.next_slot()).flatten()
    }

    /// The centre of the latest slot that was made.
    pub fn latest(&self) -> Option<Time> {
        self.latest
    }

    /// The engine, for what it takes over from an earlier run ([`Pipeline::engine_mut`]).
    pub fn engine_mut(&mut self) -> &mut Engine {
        self.pipeline.engine_mut()
    }

    /// The sensors at `now`, with the lines that belong to each.
    pub fn sensors(&mut self, now: Time, lines: impl Fn(usize) -> Vec<LineStatus>) -> Vec<SensorStatus> {
        let mut sensors = self.health.sensors(now, lines);
        note_contests(&mut sensors, &self.pipeline.contests(now));
        let registrations = self.registrar.statuses(self.pipeline.engine(), now);
        for (sensor, registration) in sensors.iter_mut().zip(registrations) {
            sensor.registration = registration;
        }
        for (kind, learnt) in self.pipeline.engine().learnt_types() {
            if let Some(sensor) = sensors.get_mut(usize::from(kind.receiver.0)) {
                sensor.types.push((kind, learnt));
            }
        }
        sensors
    }

    /// The pipeline.
    pub fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    /// How often transponders were flagged.
    pub fn flags(&self) -> &Flags {
        &self.flags
    }

    /// The health of the sensors.
    pub fn health(&self) -> &Health {
        &self.health
    }

    /// Datagrams of a line that were copies of another line's.
    pub fn duplicates(&self, line: usize) -> u64 {
        self.duplicates.get(line).copied().unwrap_or(0)
    }

    /// The maker of pictures.
    pub fn maker(&self) -> &PictureMaker {
        &self.maker
    }
}
