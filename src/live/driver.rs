//! The pipeline with its clock: arrivals and ticks in, slots out. Sans-IO, so that a test can own the time.

use jiff::SignedDuration;

use super::contests::note_contests;
use super::health::{Health, LineStatus, SensorStatus};
use super::hub::Frame;
use super::registration::Registrar;
use crate::areas::Masks;
use crate::capture::Reception;
use crate::config::Config;
use crate::picture::{Picture, PictureMaker};
use crate::pipeline::{Event, Output, Pipeline};
use crate::state::Registrations;
use fusion::Emission;
use fusion::Report;
use fusion::numbering::{Given, NumberChange};
use fusion::operational::{Correlation, NotCorrelated, ResumedCorrelation, SavedCorrelation};
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;

/// An arrival that waited in the queue while its slot was emitted is handled this much after the slot's deadline.
const AFTER_DEADLINE: SignedDuration = SignedDuration::from_micros(1);

/// What the driver makes, in the order in which it happened.
#[derive(Debug)]
pub enum Made {
    /// A slot, not yet published: its `published_at` is its deadline.
    Slot(Frame),
    /// What became of a transponder number with the slot before it.
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
    grid: SlotGrid,
    latency: SignedDuration,
    /// From a slot's centre to its deadline.
    due_after: SignedDuration,
    /// The deadline of the slot that was emitted last, or where the clock ran on by more than the window after that, the
    /// time of the fresh start: nothing is handled at a time before.
    emitted: Option<Time>,
    seq: u64,
    /// Copies by line.
    duplicates: Vec<u64>,
}

impl Driver {
    /// For a site; `started` is now, and `lines` how many lines there are.
    pub fn new(config: &Config, masks: Masks, started: Time, lines: usize) -> Self {
        let pipeline = Pipeline::new(config, masks);
        Self {
            maker: PictureMaker::new(config, pipeline.normaliser()),
            health: Health::new(config, started),
            registrar: Registrar::new(config),
            grid: SlotGrid::new(config.fusion.slot),
            latency: config.fusion.latency(),
            due_after: config.fusion.latency() - config.fusion.slot / 2,
            pipeline,
            emitted: None,
            seq: 0,
            duplicates: vec![0; lines],
        }
    }

    /// The time at which an arrival is handled, and recorded: its own, or just after the last deadline where that has
    /// passed while it waited.
    pub fn reception(&self, received: Time) -> Time {
        self.emitted.map_or(received, |deadline| received.max(deadline + AFTER_DEADLINE))
    }

    /// When the next slot is due; `None` before the first arrival.
    pub fn deadline(&self) -> Option<Time> {
        self.pipeline.engine().next_slot().map(|slot| self.grid.open(slot) + self.latency)
    }

    /// Handles what was received; its time is the one that [`Driver::reception`] gave for it.
    pub fn receive(&mut self, reception: &Reception, out: impl FnMut(Made)) {
        self.receive_showing(reception, |_| {}, out);
    }

    /// As [`Driver::receive`], and shows each report that the engine takes.
    pub fn receive_showing(
        &mut self,
        reception: &Reception,
        mut show: impl FnMut(&Report),
        mut out: impl FnMut(Made),
    ) {
        let line = reception.input;
        // Without a time of reception nothing is accepted, and the health has nothing to note.
        let received = reception.received.unwrap_or_default();
        let Self { pipeline, maker, health, due_after, emitted, seq, duplicates, .. } = self;
        let every = |report: &Report| {
            show(report);
            true
        };
        pipeline.receive_some(reception, every, |output| match output {
            Output::Emission(emission) => slot(emission, maker, *due_after, seq, emitted, &mut out),
            Output::Event(event) => {
                if event == Event::DuplicateDatagram
                    && let Some(count) = duplicates.get_mut(line)
                {
                    *count += 1;
                }
                health.note(&event, received);
                out(Made::Event(event));
            }
        });
    }

    /// Tells the time: slots that are due are put out, one by one, also after a pause.
    pub fn tick(&mut self, now: Time, mut out: impl FnMut(Made)) {
        let Self { pipeline, maker, health, due_after, emitted, seq, .. } = self;
        pipeline.tick(now, |output| match output {
            Output::Emission(emission) => slot(emission, maker, *due_after, seq, emitted, &mut out),
            Output::Event(event) => {
                if event == Event::Restarted {
                    *emitted = Some(now);
                }
                health.note(&event, now);
                out(Made::Event(event));
            }
        });
    }

    /// Starts with the transponder numbers given before a restart; drops those that cannot be taken over
    /// ([`fusion::numbering::Numbers::remember`]), and returns how many.
    pub fn remember(&mut self, numbers: &mut Vec<Given>) -> usize {
        let before = numbers.len();
        numbers.retain(|&given| self.pipeline.remember(given));
        before - numbers.len()
    }

    /// Starts with what was known of the radars' registration before a restart, at `now`; what cannot be taken over is told
    /// ([`Registrations::restore`]).
    pub fn restore(&mut self, kept: &Registrations, config: &Config, now: Time) -> Vec<String> {
        kept.restore(config, Some(now), &mut self.pipeline)
    }

    /// An operator's word; the first slot that is put out by it.
    ///
    /// # Errors
    /// The profile knows no decisions, or the radar track or the transponder is not there.
    pub fn correlate(&mut self, correlation: Correlation) -> Result<Slot, NotCorrelated> {
        self.pipeline.correlate(correlation)?;
        // Before the first slot nothing is there.
        self.pipeline.engine().next_slot().ok_or(NotCorrelated::NoRadarTrack)
    }

    /// Whether its profile knows decisions.
    pub fn knows_correlations(&self) -> bool {
        self.pipeline.engine().knows_correlations()
    }

    /// What was decided in a flight that is replayed, each with its slot.
    pub fn plan(&mut self, correlations: Vec<(Slot, Correlation)>) {
        self.pipeline.plan(correlations);
    }

    /// Correlations of before a restart: each holds again where its radar track is heard again in time.
    pub fn resume(&mut self, kept: Vec<SavedCorrelation>) {
        self.pipeline.resume(kept);
    }

    /// What has become of them, each once.
    pub fn resumed(&mut self) -> Vec<ResumedCorrelation> {
        self.pipeline.resumed()
    }

    /// The sensors at `now`, with the lines that belong to each.
    pub fn sensors(&mut self, now: Time, lines: impl Fn(usize) -> Vec<LineStatus>) -> Vec<SensorStatus> {
        let mut sensors = self.health.sensors(now, lines);
        note_contests(&mut sensors, &self.pipeline.contests(now));
        let registrations = self.registrar.statuses(self.pipeline.engine(), now);
        for (sensor, registration) in sensors.iter_mut().zip(registrations) {
            sensor.registration = registration;
        }
        sensors
    }

    /// The end: what the window still holds is put out.
    pub fn finish(&mut self, mut out: impl FnMut(Made)) {
        let Self { pipeline, maker, due_after, emitted, seq, .. } = self;
        pipeline.finish(|emission| slot(emission, maker, *due_after, seq, emitted, &mut out));
    }

    /// The pipeline, to look at.
    pub fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    /// The health of the sensors.
    pub fn health(&self) -> &Health {
        &self.health
    }

    /// Copies that a line brought of what another had brought before.
    pub fn duplicates(&self, line: usize) -> u64 {
        self.duplicates.get(line).copied().unwrap_or(0)
    }

    /// Makes JSON of tracks.
    pub fn maker(&self) -> &PictureMaker {
        &self.maker
    }
}

/// Hands a slot out, and what became of transponder numbers with it.
fn slot(
    mut emission: Emission,
    maker: &PictureMaker,
    due_after: SignedDuration,
    seq: &mut u64,
    emitted: &mut Option<Time>,
    out: &mut impl FnMut(Made),
) {
    let numbers = std::mem::take(&mut emission.numbers);
    out(Made::Slot(frame(maker.picture(emission), due_after, seq, emitted)));
    numbers.into_iter().for_each(|change| out(Made::Number(change)));
}

fn frame(picture: Picture, due_after: SignedDuration, seq: &mut u64, emitted: &mut Option<Time>) -> Frame {
    let due = picture.time + due_after;
    *emitted = Some(due);
    *seq += 1;
    Frame { seq: *seq, due, published_at: due, picture }
}
