//! The pipeline with its clock: takes arrivals and ticks, produces slots. Sans-IO, so that tests control the time.

use std::collections::VecDeque;

use bytes::Bytes;
use jiff::SignedDuration;

use super::contests::note_contests;
use super::health::{LineStatus, SensorMonitor, SensorStatus};
use super::published::PublishedPicture;
use super::registration::Registrar;
use crate::integrity::Flags;
use crate::state::{EngineState, WarmState};
use fusion::Engine;
use fusion::integrity::TrustOverride;
use fusion::numbering::{Given, NumberChange};
use fusion::operational::{AssociationRefusal, ManualAssociation, RadarRelocation};
use fusion::slots::Slot;
use fusion::time::Time;
use input::capture::Reception;
use input::pipeline::{Event, NotRestored, Output, Pipeline, Selection, Shed, Shedding};
use picture::{PictureMaker, PictureSeries, UncooperativeDetector};
use site::areas::Masks;
use site::config::Config;

/// An arrival that waited in the queue while a slot was made is handled this much later than the slot.
const AFTER_MAKING: SignedDuration = SignedDuration::from_micros(1);

/// Maximum backward step of the clock after a start that only delays the first slot.
const CLOCK_SET: SignedDuration = SignedDuration::from_secs(1);

/// Output of the driver.
#[derive(Debug)]
pub enum DriverEvent {
    /// A slot, not yet published. Its `published_at` is its deadline, which may be up to [`Driver::lead`] ahead.
    Slot(PublishedPicture),
    /// A change of a transponder number, together with the slot before it.
    Number(NumberChange),
    /// An event about received data.
    Event(Event),
}

/// The pipeline and all that follows from it; the only owner of the engine.
#[derive(Debug)]
pub struct Driver {
    pipeline: Pipeline,
    series: PictureSeries,
    health: SensorMonitor,
    registrar: Registrar,
    flags: Flags,
    /// Time from a slot's centre to its deadline.
    due_after: SignedDuration,
    /// Time at which the latest slot was to be made, or of a fresh start after it. No arrival is handled at an earlier
    /// time.
    made_at: Option<Time>,
    /// Centre of the latest slot.
    latest: Option<Time>,
    /// Slots up to this centre are left to an earlier run of the service.
    published: Option<Time>,
    seq: u64,
    /// Copies received, by line.
    duplicates: Vec<u64>,
    /// Output of the latest input; the buffer is reused.
    events: VecDeque<DriverEvent>,
}

impl Driver {
    /// Driver of a site with that number of lines; `started` is the present time.
    pub fn new(config: &Config, masks: Masks, started: Time, lines: usize) -> Self {
        let pipeline = Pipeline::new(config, masks);
        Self {
            series: PictureSeries::new(
                PictureMaker::new(config, pipeline.normaliser()),
                UncooperativeDetector::default(),
            ),
            health: SensorMonitor::new(config, started),
            registrar: Registrar::new(config),
            flags: Flags::default(),
            due_after: config.fusion.latency() - config.fusion.slot / 2,
            pipeline,
            made_at: None,
            latest: None,
            published: None,
            seq: 0,
            duplicates: vec![0; lines],
            events: VecDeque::new(),
        }
    }

    /// States the present time of a recording whose first data had none.
    pub(super) fn begin(&mut self, now: Time) {
        self.health.begin(now);
    }

    /// Resumes from the state of an earlier run. Slots that the earlier run did not publish, and that were not due by
    /// `now`, are published by this one.
    ///
    /// # Errors
    /// The state is of another version, or the site or its settings have changed.
    pub fn resume(
        &mut self,
        config: &Config,
        masks: Masks,
        warm: &WarmState,
        now: Time,
    ) -> Result<(), NotRestored> {
        self.restore(config, masks, &warm.engine)?;
        warm.inputs.iter().for_each(|input| self.receive(input));
        // Slots that were due during the restart are dropped.
        self.tick(now);
        self.events.clear();
        self.published = warm.published;
        self.seq = 0;
        Ok(())
    }

    /// Leaves slots up to this centre to an earlier run, because it is unknown which of them it published.
    pub fn publish_after(&mut self, centre: Time) {
        self.published = Some(centre);
    }

    /// Centre of the last published slot, by this run or an earlier one.
    pub fn published(&self) -> Option<Time> {
        self.latest.max(self.published)
    }

    /// Restores the state of the driver that wrote it.
    ///
    /// # Errors
    /// The state is of another version, or the site or its settings have changed.
    pub fn restore(&mut self, config: &Config, masks: Masks, state: &[u8]) -> Result<(), NotRestored> {
        let state = EngineState::parse(state).ok_or(NotRestored::Unreadable)?;
        self.pipeline = Pipeline::restored(config, masks, state.pipeline)?;
        self.series.detector.restore(state.detector);
        Ok(())
    }

    /// Encodes the state for [`Driver::restore`].
    pub fn checkpoint(&self, config: &Config) -> Bytes {
        let mut octets = Vec::new();
        self.checkpoint_into(config, &mut octets);
        octets.into()
    }

    /// Appends the encoded state to a buffer.
    pub fn checkpoint_into(&self, config: &Config, octets: &mut Vec<u8>) {
        EngineState::begin(&self.series.detector.checkpoint(), octets);
        self.pipeline.checkpoint_into(config, octets);
    }

    /// Restricts the driver to a cell: its engine receives only the reports for that cell.
    pub fn selecting(self, selection: Selection) -> Self {
        Self { pipeline: self.pipeline.selecting(selection), ..self }
    }

    /// Next slot to be made; `None` before the first arrival.
    pub fn next_slot(&self) -> Option<Slot> {
        self.pipeline.engine().next_slot()
    }

    /// Adds the detection of drones without a transponder.
    pub fn with_detector(mut self, detector: UncooperativeDetector) -> Self {
        self.series.detector = detector;
        self
    }

    /// Time at which an arrival is handled and recorded: its time of reception, or just after the last slot was to be made,
    /// if that time passed while the arrival waited. If the clock was set back by more than the window, always its time of
    /// reception.
    pub fn reception(&self, received: Time, now: Time) -> Time {
        if self.pipeline.engine().is_set_back(received.max(now)) {
            return received;
        }
        self.made_at.map_or(received, |made| received.max(made + AFTER_MAKING))
    }

    /// Time at which the next slot is to be made; `None` before the first arrival.
    pub fn next_made(&self) -> Option<Time> {
        self.pipeline.engine().next_made()
    }

    /// Time by which a slot is made before it is due.
    pub fn lead(&self) -> SignedDuration {
        self.pipeline.engine().lead()
    }

    /// Handles an arrival, at the time that [`Driver::reception`] returned for it.
    pub fn receive(&mut self, reception: &Reception) {
        self.pipeline.receive(reception);
        // Without a time of reception no report is accepted, so the health is not affected.
        self.collect_output(reception.received.unwrap_or_default(), Some(reception.input));
    }

    /// Advances the time. Slots that are due are made one by one, also after a pause.
    pub fn tick(&mut self, now: Time) {
        self.pipeline.tick(now);
        self.collect_output(now, None);
    }

    /// Ends the run: makes the slots still in the window.
    pub fn finish(&mut self) {
        self.pipeline.finish();
        self.collect_output(Time::default(), None);
    }

    /// Next output of the latest input, in order of occurrence. Output not taken is dropped at the next input.
    pub fn poll(&mut self) -> Option<DriverEvent> {
        self.events.pop_front()
    }

    /// Whether the engine restarts after the slots in the output.
    pub fn starts_afresh(&self) -> bool {
        self.events.iter().any(|event| matches!(event, DriverEvent::Event(Event::Restarted)))
    }

    /// Whether a slot is left to an earlier run. A slot older than any that was pending at the start means that the clock
    /// was set back since; the earlier run's statement is then dropped.
    fn is_left_to_earlier_run(&mut self, centre: Time) -> bool {
        self.published = self.published.filter(|&until| until - centre <= self.due_after + CLOCK_SET);
        self.published.is_some_and(|until| centre <= until)
    }

    /// Collects the pipeline's output for an input at `at`; `line` is the line on which it was received.
    fn collect_output(&mut self, at: Time, line: Option<usize>) {
        self.events.clear();
        while let Some(output) = self.pipeline.poll() {
            match output {
                Output::Emission(mut emission) => {
                    let numbers = std::mem::take(&mut emission.numbers);
                    self.flags.note(&emission.concerns);
                    let (picture, now) = self.series.pictures(emission, true);
                    self.latest = Some(picture.time);
                    let due = picture.time + self.due_after;
                    self.made_at = Some(due + -self.lead());
                    if !self.is_left_to_earlier_run(picture.time) {
                        self.seq += 1;
                        self.events.push_back(DriverEvent::Slot(PublishedPicture {
                            seq: self.seq,
                            due,
                            published_at: due,
                            picture,
                            now: now.into(),
                        }));
                    }
                    self.events.extend(numbers.into_iter().map(DriverEvent::Number));
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
                    self.events.push_back(DriverEvent::Event(event));
                }
            }
        }
    }

    /// Restores the transponder numbers assigned before a restart. Drops those that contradict others
    /// ([`fusion::numbering::Numbers::remember`]), and returns how many.
    pub fn remember(&mut self, numbers: &mut Vec<Given>) -> usize {
        let before = numbers.len();
        numbers.retain(|&given| self.pipeline.engine_mut().remember(given));
        before - numbers.len()
    }

    /// Applies an operator's decision; returns the first slot that it affects.
    ///
    /// # Errors
    /// The profile has no correlations, or the radar track or the transponder does not exist.
    pub fn correlate(&mut self, correlation: ManualAssociation) -> Result<Slot, AssociationRefusal> {
        let engine = self.pipeline.engine_mut();
        engine.correlate(correlation)?;
        // Before the first slot no radar track exists.
        engine.next_slot().ok_or(AssociationRefusal::NoRadarTrack)
    }

    /// Sets which reports are left out from now on, on a machine that cannot keep up.
    pub fn shed(&mut self, shed: Shed) {
        self.pipeline.shed(shed);
    }

    /// State of the load shedding, if it is active.
    pub fn shedding_mut(&mut self) -> Option<&mut Shedding> {
        self.pipeline.shedding_mut()
    }

    /// Applies an operator's trust setting for a transponder; returns the first slot that it affects. `None`: the profile
    /// has no trust settings, or no data was received yet.
    pub fn set_trust(&mut self, word: TrustOverride) -> Option<Slot> {
        let engine = self.pipeline.engine_mut();
        engine.set_trust(word).then(|| engine.next_slot()).flatten()
    }

    /// Moves a radar; returns the first slot that it affects. `None`: the profile has no relocations, there is no such radar, or
    /// no data was received yet.
    pub fn relocate(&mut self, decided: RadarRelocation) -> Option<Slot> {
        let engine = self.pipeline.engine_mut();
        engine.relocate(decided).then(|| engine.next_slot()).flatten()
    }

    /// Centre of the latest slot made.
    pub fn latest(&self) -> Option<Time> {
        self.latest
    }

    /// The engine, for restoring state of an earlier run ([`Pipeline::engine_mut`]).
    pub fn engine_mut(&mut self) -> &mut Engine {
        self.pipeline.engine_mut()
    }

    /// Status of the sensors at `now`, with the lines of each.
    pub fn sensors(&mut self, now: Time, lines: impl Fn(usize) -> Vec<LineStatus>) -> Vec<SensorStatus> {
        let mut sensors = self.health.sensors(now, lines);
        note_contests(&mut sensors, &self.pipeline.contests(now));
        let registrations = self.registrar.statuses(self.pipeline.engine(), now);
        for (sensor, registration) in sensors.iter_mut().zip(registrations) {
            sensor.note_registration(registration);
        }
        for (camera, oriented) in self.pipeline.engine().oriented_cameras() {
            if let Some(sensor) = sensors.get_mut(usize::from(camera.0)) {
                sensor.orientation = Some(*oriented);
            }
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

    /// Number of flags on transponders, by reason.
    pub fn flags(&self) -> &Flags {
        &self.flags
    }

    /// Health of the sensors.
    pub fn health(&self) -> &SensorMonitor {
        &self.health
    }

    /// Number of a line's datagrams that were copies of another line's.
    pub fn duplicates(&self, line: usize) -> u64 {
        self.duplicates.get(line).copied().unwrap_or(0)
    }

    /// Converts the engine's output to pictures.
    pub fn maker(&self) -> &PictureMaker {
        self.series.maker()
    }
}
