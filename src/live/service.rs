//! The threads of the service: line tasks, the engine's own thread, and what it hands out.

mod decisions;
mod foresight;
mod keepers;
mod publication;
mod troubles;
mod viewer;
mod warm;

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::Duration;

use tracing::{info, warn};

use super::clock::Clock;
use super::driver::{Driver, Made};
use super::health::LineStatus;
use super::hub::HubWriter;
use super::lines::{Listening, Readers, listen};
use super::losses::Losses;
use super::published::Status;
use super::quiet::Quiet;
use crate::capture::{Ending, Endpoints, Reception, ReceptionKind, TrailerRules, Trailers, oradis_blocks};
use crate::config::Config;
use crate::formats::Encoders;
use crate::net::listen::{self as udp, Arrival, Line, LineCounters};
use crate::net::send::Sinks;
use crate::pipeline::Event;
use crate::record::{Recorded, RecorderQueue};
use crate::state::WarmQueue;
use fusion::SensorIndex;
use fusion::numbering::NumberChange;
use fusion::registration::Misalignment;
use fusion::report::TransponderType;
use fusion::time::{SECOND, Time};
use keepers::InForce;
use publication::Publisher;

pub use decisions::{Decision, decisions};
pub use viewer::{Seen, SeenCounts, Viewer};

/// Longest time between two looks at whether to stop or to publish a status.
const LOOK_UP: Duration = Duration::from_millis(100);
/// The next status is at most a second ahead, unless the clock has stepped back.
const STATUS_AHEAD: jiff::SignedDuration = jiff::SignedDuration::from_millis(1100);
/// A datagram that waited longer than this for the engine counts as delayed: as a rule none waits for a millisecond.
const WAITED: jiff::SignedDuration = jiff::SignedDuration::from_millis(500);

/// What was learnt of the sensors, as far as it shows that there is more of it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Estimates {
    radars: Vec<(SensorIndex, Misalignment)>,
    /// Reports of each type of transponders.
    reports: Vec<(TransponderType, u64)>,
}

impl Estimates {
    fn of(engine: &fusion::Engine) -> Self {
        let types = engine.learnt_types().into_iter();
        Self {
            radars: engine.registered().map(|(sensor, now)| (sensor, now.estimate)).collect(),
            reports: types.map(|(kind, learnt)| (kind, learnt.reports)).collect(),
        }
    }
}

/// Where the engine's thread hands its results.
pub struct Outlets {
    /// Readers of the picture.
    pub hub: HubWriter,
    /// Destinations of the tracks and the status.
    pub sinks: Sinks,
    /// What is sent to them.
    pub encoders: Encoders,
    /// The recorder, where there is one.
    pub recorder: Option<RecorderQueue>,
    /// Those who keep the state across restarts, where it is kept.
    pub keepers: Option<KeeperQueues>,
}

/// The queues of those who keep the state across restarts.
pub struct KeeperQueues {
    /// Of the transponder numbers.
    pub numbers: SyncSender<NumberChange>,
    /// Of the registration: the text of its file.
    pub registration: SyncSender<Arc<str>>,
    /// Of the operators' decisions: the text of its file.
    pub decisions: SyncSender<Arc<str>>,
    /// Of the alerts that are shelved: the text of its file.
    pub shelved: SyncSender<Arc<str>>,
    /// Of the engine's state, where checkpoints are wanted.
    pub warm: Option<WarmQueue>,
}

/// The running service.
pub struct Service {
    stop: Arc<AtomicBool>,
    engine: JoinHandle<Driver>,
    readers: Readers,
}

impl Service {
    /// Starts the lines on `runtime` and the engine on a thread of its own.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(
        config: Arc<Config>,
        driver: Driver,
        outlets: Outlets,
        clock: Clock,
        runtime: &tokio::runtime::Handle,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let Listening { arrivals, lines, readers, posts } = listen(&config, &clock, runtime);
        posts.into_iter().for_each(|posts| outlets.hub.set_posts(posts));
        if let Some(recorder) = &outlets.recorder {
            outlets.hub.set_recorder(recorder.meter());
        }
        let engine = Engine::new(config, driver, outlets, lines, clock);
        let stopped = stop.clone();
        let engine = std::thread::Builder::new()
            .name("engine".to_owned())
            .spawn(move || engine.run(&arrivals, &stopped))?;
        Ok(Self { stop, engine, readers })
    }

    /// Whether the engine's thread has ended, which it does by itself only when it panics.
    pub fn has_ended(&self) -> bool {
        self.engine.is_finished()
    }

    /// Stops the inputs, each when what has arrived on it by now is read, lets the engine handle that and publish what it
    /// owes, and returns it. Not on a thread of the runtime.
    ///
    /// # Errors
    /// The engine's thread panicked.
    pub fn stop(self) -> Result<Driver, String> {
        // The engine takes meanwhile what they hand on.
        self.readers.join();
        self.stop.store(true, Ordering::Relaxed);
        self.engine.join().map_err(|_| "the engine's thread panicked; this is a bug".to_owned())
    }
}

/// How far the engine has come with what was received.
struct Handled {
    /// Everything that was received by then has been handled.
    until: Time,
    /// Whether that is now.
    is_all: bool,
}

/// The engine's thread.
struct Engine {
    config: Arc<Config>,
    driver: Driver,
    publisher: Publisher,
    lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    /// What stands behind the blocks of datagrams.
    trailers: Trailers,
    /// Sends that failed and have been told.
    failed_told: u64,
    /// Datagrams of sensors that the engine never saw, datagrams that were not recorded, seconds whose conflicts came too late.
    input_losses: Losses,
    recorder_losses: Losses,
    conflict_losses: Losses,
    next_status: Time,
    quiet: Quiet,
    /// Changes of transponder numbers that their keeper, and the recorder, have not got yet: the latest of each number.
    unkept: BTreeMap<u32, NumberChange>,
    unrecorded_numbers: BTreeMap<u32, NumberChange>,
    /// The registrations that their keeper and the recorder have, and when they get the next.
    registered: Estimates,
    next_registration: Time,
    /// The decisions in force that the recorder has, and what waits for room in its queue.
    held: InForce,
    unrecorded: VecDeque<Recorded>,
    /// The text that the decisions' keeper has, and that of the shelved alerts.
    kept: Arc<str>,
    kept_shelves: Arc<str>,
    /// When the next checkpoint is written.
    next_checkpoint: Time,
    /// Octets that the next one will take, by the one before.
    checkpoint_room: usize,
}

impl Engine {
    fn new(
        config: Arc<Config>,
        driver: Driver,
        outlets: Outlets,
        lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
        clock: Clock,
    ) -> Self {
        Self {
            next_status: clock.now(),
            publisher: Publisher::new(&config, outlets, clock),
            trailers: Trailers::new(TrailerRules::of(&config)),
            config,
            driver,
            lines,
            failed_told: 0,
            input_losses: Losses::default(),
            recorder_losses: Losses::default(),
            conflict_losses: Losses::default(),
            quiet: Quiet::default(),
            unkept: BTreeMap::new(),
            unrecorded_numbers: BTreeMap::new(),
            registered: Estimates::default(),
            next_registration: Time::default(),
            held: InForce::default(),
            unrecorded: VecDeque::new(),
            kept: "".into(),
            kept_shelves: "".into(),
            next_checkpoint: Time::default(),
            checkpoint_room: 0,
        }
    }

    fn run(mut self, arrivals: &Receiver<Arrival>, stop: &AtomicBool) -> Driver {
        while !stop.load(Ordering::Relaxed) {
            match arrivals.recv_timeout(self.until_due()) {
                Ok(arrival) => self.receive(arrival),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.decide();
            let at = self.publisher.clock.now();
            let was_ready = self.publisher.next_due().is_some();
            self.publish_due(at);
            if was_ready && self.publisher.next_due().is_none() {
                // Of all moments the one from which it is longest until the next slot is made.
                self.keep_checkpoint();
            }
            self.publisher.look_ahead();
            let slot_is_due = self.driver.next_made().is_some_and(|made| made <= at);
            // Also where the clock has stepped back, of which the driver must be told.
            let status_is_due = at >= self.next_status || self.next_status - at > STATUS_AHEAD;
            if slot_is_due || status_is_due {
                let handled = self.catch_up(arrivals);
                if handled.is_all {
                    self.tick(handled.until);
                }
                if status_is_due {
                    self.tell(handled.until);
                }
            }
        }
        while let Ok(arrival) = arrivals.try_recv() {
            self.receive(arrival);
        }
        self.end_checkpoint();
        if self.config.output.flush_on_stop {
            self.driver.finish();
            self.hand_out(true);
        }
        self.publisher.publish_owed();
        self.end_published();
        self.tell(self.publisher.clock.now());
        // This time there is time to wait.
        if let Some(keepers) = self.publisher.outlets.keepers.take() {
            std::mem::take(&mut self.unkept)
                .into_values()
                .for_each(|change| _ = keepers.numbers.send(change));
            self.new_registration().into_iter().for_each(|(_, text)| _ = keepers.registration.send(text));
            self.new_decisions().into_iter().for_each(|text| _ = keepers.decisions.send(text));
            self.new_shelves().into_iter().for_each(|text| _ = keepers.shelved.send(text));
        }
        self.driver
    }

    fn publish_due(&mut self, now: Time) {
        self.publisher.publish_due(now, self.driver.lead());
    }

    /// How long nothing is due: no slot is to be made or published.
    fn until_due(&self) -> Duration {
        let published = self.publisher.next_due();
        let next = self.driver.next_made().into_iter().chain(published).min();
        let wait = next.map(|due| Duration::try_from(due - self.publisher.clock.now()).unwrap_or_default());
        wait.map_or(LOOK_UP, |wait| wait.min(LOOK_UP))
    }

    /// Handles what waits, which came before the slots that are due by now. Where that is more than can be handled until the
    /// engine looks up, it is not all: then the clock may publish no slot, because what belongs into it still waits.
    fn catch_up(&mut self, arrivals: &Receiver<Arrival>) -> Handled {
        let began = self.publisher.clock.now();
        loop {
            let now = self.publisher.clock.now();
            let Ok(arrival) = arrivals.try_recv() else { return Handled { until: now, is_all: true } };
            let until = arrival.received;
            self.receive(arrival);
            if now.nanos().abs_diff(began.nanos()) > LOOK_UP.as_nanos() as u64 {
                return Handled { until, is_all: false };
            }
        }
    }

    fn receive(&mut self, arrival: Arrival) {
        let now = self.publisher.clock.now();
        self.publisher.waited += usize::from(now - arrival.received > WAITED);
        let received = self.driver.reception(arrival.received, now);
        self.publisher.record(|| Recorded::Input {
            received,
            line: arrival.line,
            from: arrival.from,
            payload: arrival.payload.clone(),
        });
        let reception = Reception {
            received: Some(received),
            input: arrival.line,
            from: Some(arrival.from.into()),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: self.without_trailer(arrival),
        };
        self.keep_input(&reception);
        self.driver.receive(&reception);
        self.hand_out(self.driver.starts_afresh());
        let posted = self.lines.get(reception.input).filter(|(line, _)| line.is_posted());
        if let Some((_, counters)) = posted {
            counters.handled.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The blocks of a datagram, without what some senders put in front of them or behind.
    fn without_trailer(&mut self, arrival: Arrival) -> Vec<u8> {
        let mut payload = arrival.payload;
        if let Some(blocks) = oradis_blocks(&payload) {
            return blocks;
        }
        let endpoints = self.lines.get(arrival.line).map(|(line, _)| Endpoints {
            source: SocketAddr::V4(arrival.from),
            destination: line.destination().into(),
        });
        if let Ending::Trailer(octets) = self.trailers.see(endpoints, &payload) {
            payload.truncate(payload.len() - octets);
        }
        for trailer in self.trailers.news() {
            info!(trailer_octets = trailer.octets, %trailer, "datagrams have a trailer: set trailer_octets of the input");
        }
        payload
    }

    fn tick(&mut self, at: Time) {
        self.driver.tick(at);
        self.hand_out(self.driver.starts_afresh());
    }

    /// Hands out what the driver has made. Slots before a fresh start are owed from before a pause, or a step of the clock:
    /// how late they are says nothing about the picture that follows.
    fn hand_out(&mut self, are_owed: bool) {
        while let Some(made) = self.driver.poll() {
            match made {
                Made::Slot(frame) => self.publisher.take(frame),
                Made::Number(change) => self.note_number(change),
                Made::Event(event) if event.is_warning() => {
                    if self.quiet.may_tell(event.kind(), self.publisher.clock.now()) {
                        event.log();
                    }
                }
                Made::Event(Event::Accepted { report, .. }) => {
                    self.publisher.outlets.hub.inputs.note(&report);
                }
                Made::Event(_) => {}
            }
        }
        match are_owed {
            true => self.publisher.publish_owed(),
            false => self.publish_due(self.publisher.clock.now()),
        }
        self.tell_numbers();
        self.tell_decisions();
    }

    /// Publishes the status, once a second, to readers and to the sinks. What was received is handled until `handled`: a
    /// sensor whose reports still wait has not fallen silent.
    fn tell(&mut self, handled: Time) {
        let at = self.publisher.clock.now();
        self.next_status = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
        for (kind, count) in self.quiet.suppressed(at) {
            warn!(kind, count, "more warnings of this kind");
        }
        let table = udp::kernel_table();
        self.lines.iter().for_each(|(_, counters)| counters.note_kernel_drops(&table));
        let duplicates: Vec<u64> = (0..self.lines.len()).map(|index| self.driver.duplicates(index)).collect();
        let lines = |sensor: usize| {
            let of = |(index, (line, counters)): (usize, &(Arc<Line>, Arc<LineCounters>))| {
                line.sensors
                    .contains(&sensor)
                    .then(|| LineStatus::of(line.name(), counters, duplicates[index]))
            };
            self.lines.iter().enumerate().filter_map(of).collect()
        };
        let sensors = self.driver.sensors(handled, lines);
        self.tell_registration(at);
        self.keep_decisions();
        let status = Status {
            at,
            sensors,
            unknown: self.driver.health().unknown(),
            tally: self.driver.pipeline().tally().clone(),
            numbers_used: self.driver.pipeline().engine().numbers().used(),
            lateness_s: None,
            failed_sends: 0,
            troubles: self.troubles(at, handled),
        };
        self.publisher.tell(status);
    }
}

/// Median, 95th and 99th percentile, seconds.
fn percentiles(microseconds: &VecDeque<u32>) -> Option<[f64; 3]> {
    let mut sorted: Vec<f64> = microseconds.iter().map(|&late_us| f64::from(late_us) * 1e-6).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share| crate::statistics::quantile(&sorted, share);
    Some([at(0.5)?, at(0.95)?, at(0.99)?])
}

#[cfg(test)]
mod tests;
