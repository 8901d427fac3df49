//! Threads of the service: the line tasks, the engine's thread, and its outputs.

mod conflicts;
mod decisions;
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

use super::driver::{Driver, DriverEvent};
use super::health::LineStatus;
use super::hub::HubWriter;
use super::lines::{LineReaders, Listening, listen};
use super::ongoing_losses::OngoingLosses;
use super::published::Status;
use super::warning_limiter::WarningLimiter;
use crate::clock::WallClock;
use crate::net::listen::{self as udp, Arrival, ConfiguredLine, LineCounters};
use crate::net::send::UdpDestinations;
use crate::record::{RecorderQueue, RecordingItem};
use crate::state::WarmQueue;
use fusion::SensorIndex;
use fusion::numbering::NumberChange;
use fusion::registration::Misalignment;
use fusion::report::TransponderType;
use fusion::time::{SECOND, Time};
use input::capture::{Ending, Endpoints, Reception, ReceptionKind, TrailerRules, Trailers, oradis_blocks};
use input::pipeline::Event;
use keepers::DecisionsInForce;
use picture::formats::Encoders;
use publication::Publisher;
use site::config::Config;

pub use decisions::{OperatorDecision, decisions};
pub use viewer::{Viewer, ViewerCounts, ViewerInput};

/// Maximum time between two checks for a stop or a due status.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Maximum time to the next status; it is longer only after the clock stepped back.
const STATUS_AHEAD: jiff::SignedDuration = jiff::SignedDuration::from_millis(1100);
/// Waiting time in the engine's queue from which a datagram counts as delayed; typically it is below a millisecond.
const WAITED: jiff::SignedDuration = jiff::SignedDuration::from_millis(500);

/// Learned values, as far as needed to detect a change.
#[derive(Clone, Debug, Default, PartialEq)]
struct Estimates {
    radars: Vec<(SensorIndex, Misalignment)>,
    /// Number of reports of each transponder type.
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

/// Outputs of the engine's thread.
pub struct Outlets {
    /// Readers of the picture.
    pub hub: HubWriter,
    /// Destinations of tracks and status.
    pub sinks: UdpDestinations,
    /// Encoders for the destinations.
    pub encoders: Encoders,
    /// The recorder, if there is one.
    pub recorder: Option<RecorderQueue>,
    /// Queues to the keepers of the state, if it is kept.
    pub keepers: Option<KeeperQueues>,
}

/// Queues to the keepers, which write state for a restart.
pub struct KeeperQueues {
    /// Changes of transponder numbers.
    pub numbers: SyncSender<NumberChange>,
    /// Registration: text of its file.
    pub registration: SyncSender<Arc<str>>,
    /// Operators' decisions: text of the file.
    pub decisions: SyncSender<Arc<str>>,
    /// Shelved alerts: text of the file.
    pub shelved: SyncSender<Arc<str>>,
    /// The engine's state, if checkpoints are configured.
    pub warm: Option<WarmQueue>,
}

/// The running service.
pub struct LiveService {
    stop: Arc<AtomicBool>,
    engine: JoinHandle<Driver>,
    readers: LineReaders,
}

impl LiveService {
    /// Starts the lines on `runtime` and the engine on its own thread.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(
        config: Arc<Config>,
        driver: Driver,
        outlets: Outlets,
        clock: WallClock,
        runtime: &tokio::runtime::Handle,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let Listening { arrivals, lines, readers, http_input } = listen(&config, &clock, runtime);
        http_input.into_iter().for_each(|http_input| outlets.hub.set_http_input(http_input));
        if let Some(recorder) = &outlets.recorder {
            outlets.hub.set_recorder(recorder.meter());
        }
        let engine = EngineThread::new(config, driver, outlets, lines, clock);
        let stopped = stop.clone();
        let engine = std::thread::Builder::new()
            .name("engine".to_owned())
            .spawn(move || engine.run(&arrivals, &stopped))?;
        Ok(Self { stop, engine, readers })
    }

    /// Whether the engine's thread has ended, which it does by itself only on a panic.
    pub fn has_ended(&self) -> bool {
        self.engine.is_finished()
    }

    /// Stops the inputs after reading what has arrived. The engine then handles it, publishes the pending slots and is
    /// returned. Must not be called on a thread of the runtime.
    ///
    /// # Errors
    /// The engine's thread panicked.
    pub fn stop(self) -> Result<Driver, String> {
        // The engine takes their output meanwhile.
        self.readers.join();
        self.stop.store(true, Ordering::Relaxed);
        self.engine.join().map_err(|_| "the engine's thread panicked; this is a bug".to_owned())
    }
}

/// Progress of the engine with received data.
struct EngineProgress {
    /// Data received until then has been handled.
    until: Time,
    /// Whether all received data has been handled.
    is_all: bool,
}

/// The engine's thread.
struct EngineThread {
    config: Arc<Config>,
    driver: Driver,
    publisher: Publisher,
    lines: Vec<(Arc<ConfiguredLine>, Arc<LineCounters>)>,
    /// Detects trailers behind the blocks of datagrams.
    trailers: Trailers,
    /// Number of failed sends already logged.
    failed_logged: u64,
    /// Losses: datagrams from sensors that did not reach the engine, datagrams not recorded, and evaluations of conflicts
    /// that came too late.
    input_losses: OngoingLosses,
    recorder_losses: OngoingLosses,
    conflict_losses: OngoingLosses,
    next_status: Time,
    warning_limiter: WarningLimiter,
    /// Changes of transponder numbers not yet passed to the keeper and to the recorder: the latest of each number.
    unsaved_numbers: BTreeMap<u32, NumberChange>,
    unrecorded_numbers: BTreeMap<u32, NumberChange>,
    /// Estimates last passed to keeper and recorder, and the time of the next transfer.
    registered: Estimates,
    next_registration: Time,
    /// Decisions in force last passed to the recorder, and entries waiting for space in its queue.
    in_force: DecisionsInForce,
    unrecorded: VecDeque<RecordingItem>,
    /// Texts last passed to the keepers of the decisions and of the shelved alerts.
    saved_decisions: Arc<str>,
    saved_shelves: Arc<str>,
    /// Time of the next checkpoint.
    next_checkpoint: Time,
    /// Expected size of the next checkpoint in octets, from the one before.
    checkpoint_capacity: usize,
}

impl EngineThread {
    fn new(
        config: Arc<Config>,
        driver: Driver,
        outlets: Outlets,
        lines: Vec<(Arc<ConfiguredLine>, Arc<LineCounters>)>,
        clock: WallClock,
    ) -> Self {
        Self {
            next_status: clock.now(),
            publisher: Publisher::new(&config, outlets, clock),
            trailers: Trailers::new(TrailerRules::of(&config)),
            config,
            driver,
            lines,
            failed_logged: 0,
            input_losses: OngoingLosses::default(),
            recorder_losses: OngoingLosses::default(),
            conflict_losses: OngoingLosses::default(),
            warning_limiter: WarningLimiter::default(),
            unsaved_numbers: BTreeMap::new(),
            unrecorded_numbers: BTreeMap::new(),
            registered: Estimates::default(),
            next_registration: Time::default(),
            in_force: DecisionsInForce::default(),
            unrecorded: VecDeque::new(),
            saved_decisions: "".into(),
            saved_shelves: "".into(),
            next_checkpoint: Time::default(),
            checkpoint_capacity: 0,
        }
    }

    fn run(mut self, arrivals: &Receiver<Arrival>, stop: &AtomicBool) -> Driver {
        while !stop.load(Ordering::Relaxed) {
            match arrivals.recv_timeout(self.until_due()) {
                Ok(arrival) => self.receive(arrival),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.carry_out_requests();
            let at = self.publisher.clock.now();
            let was_ready = self.publisher.next_due().is_some();
            self.publish_due(at);
            if was_ready && self.publisher.next_due().is_none() {
                // Right after a publication, the time to the next slot is longest.
                self.keep_checkpoint();
            }
            self.publisher.evaluate_conflicts();
            let slot_is_due = self.driver.next_made().is_some_and(|made| made <= at);
            // Also due after the clock stepped back: the driver has to handle the step.
            let status_is_due = at >= self.next_status || self.next_status - at > STATUS_AHEAD;
            if slot_is_due || status_is_due {
                let handled = self.catch_up(arrivals);
                if handled.is_all {
                    self.tick(handled.until);
                }
                if status_is_due {
                    self.publish_status(handled.until);
                }
            }
        }
        while let Ok(arrival) = arrivals.try_recv() {
            self.receive(arrival);
        }
        self.end_checkpoint();
        if self.config.output.flush_on_stop {
            self.driver.finish();
            self.pass_on_output(true);
        }
        self.publisher.publish_pending();
        self.end_published();
        self.publish_status(self.publisher.clock.now());
        // At the end, the sends may wait.
        if let Some(keepers) = self.publisher.outlets.keepers.take() {
            std::mem::take(&mut self.unsaved_numbers)
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

    /// Time until the next slot is to be made or published, limited to [`POLL_INTERVAL`].
    fn until_due(&self) -> Duration {
        let published = self.publisher.next_due();
        let next = self.driver.next_made().into_iter().chain(published).min();
        let wait = next.map(|due| Duration::try_from(due - self.publisher.clock.now()).unwrap_or_default());
        wait.map_or(POLL_INTERVAL, |wait| wait.min(POLL_INTERVAL))
    }

    /// Handles waiting arrivals, which precede the slots due by now. If this takes longer than [`POLL_INTERVAL`], some still
    /// wait. No slot may then be published by the clock, because it would miss them.
    fn catch_up(&mut self, arrivals: &Receiver<Arrival>) -> EngineProgress {
        let began = self.publisher.clock.now();
        loop {
            let now = self.publisher.clock.now();
            let Ok(arrival) = arrivals.try_recv() else { return EngineProgress { until: now, is_all: true } };
            let until = arrival.received;
            self.receive(arrival);
            if now.nanos().abs_diff(began.nanos()) > POLL_INTERVAL.as_nanos() as u64 {
                return EngineProgress { until, is_all: false };
            }
        }
    }

    fn receive(&mut self, arrival: Arrival) {
        let now = self.publisher.clock.now();
        self.publisher.waited += usize::from(now - arrival.received > WAITED);
        let received = self.driver.reception(arrival.received, now);
        self.publisher.record(|| RecordingItem::Input {
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
        self.pass_on_output(self.driver.starts_afresh());
        let posted = self.lines.get(reception.input).filter(|(line, _)| line.is_posted());
        if let Some((_, counters)) = posted {
            counters.handled.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Blocks of a datagram, without headers or trailers that some senders add.
    fn without_trailer(&mut self, arrival: Arrival) -> Vec<u8> {
        let mut payload = arrival.payload;
        if let Some(blocks) = oradis_blocks(&payload) {
            return blocks;
        }
        let endpoints = self.lines.get(arrival.line).map(|(line, _)| Endpoints {
            source: SocketAddr::V4(arrival.from),
            destination: line.destination().into(),
        });
        if let Ending::Trailer(octets) = self.trailers.examine(endpoints, &payload) {
            payload.truncate(payload.len() - octets);
        }
        for trailer in self.trailers.take_new() {
            info!(trailer_octets = trailer.octets, %trailer, "datagrams have a trailer: set trailer_octets of the input");
        }
        payload
    }

    fn tick(&mut self, at: Time) {
        self.driver.tick(at);
        self.pass_on_output(self.driver.starts_afresh());
    }

    /// Passes on the driver's output. `are_late`: the slots precede a fresh start, after a pause or a step of the clock;
    /// their lateness says nothing about the following picture.
    fn pass_on_output(&mut self, are_late: bool) {
        while let Some(event) = self.driver.poll() {
            match event {
                DriverEvent::Slot(frame) => self.publisher.enqueue(frame),
                DriverEvent::Number(change) => self.note_number(change),
                DriverEvent::Event(event) if event.is_warning() => {
                    if self.warning_limiter.may_log(event.kind(), self.publisher.clock.now()) {
                        event.log();
                    }
                }
                DriverEvent::Event(Event::Accepted { report, .. }) => {
                    self.publisher.outlets.hub.recent_reports.note(&report);
                }
                DriverEvent::Event(_) => {}
            }
        }
        match are_late {
            true => self.publisher.publish_pending(),
            false => self.publish_due(self.publisher.clock.now()),
        }
        self.pass_on_numbers();
        self.publish_decisions();
    }

    /// Publishes the status to readers and sinks, once a second. Data received until `handled` is handled: a sensor whose
    /// reports still wait has not fallen silent.
    fn publish_status(&mut self, handled: Time) {
        let at = self.publisher.clock.now();
        self.next_status = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
        for (kind, count) in self.warning_limiter.suppressed(at) {
            warn!(kind, count, "more warnings of this kind");
        }
        let table = udp::kernel_table();
        self.lines.iter().for_each(|(_, counters)| counters.note_kernel_drops(&table));
        let duplicates: Vec<u64> = (0..self.lines.len()).map(|index| self.driver.duplicates(index)).collect();
        let lines = |sensor: usize| {
            let of = |(index, (line, counters)): (usize, &(Arc<ConfiguredLine>, Arc<LineCounters>))| {
                line.sensors
                    .contains(&sensor)
                    .then(|| LineStatus::of(line.name(), counters, duplicates[index]))
            };
            self.lines.iter().enumerate().filter_map(of).collect()
        };
        let sensors = self.driver.sensors(handled, lines);
        self.pass_on_registration(at);
        self.save_decisions();
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
        self.publisher.publish_status(status);
    }
}

/// Median, 95th and 99th percentile, in seconds.
fn percentiles(microseconds: &VecDeque<u32>) -> Option<[f64; 3]> {
    let mut sorted: Vec<f64> = microseconds.iter().map(|&late_us| f64::from(late_us) * 1e-6).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share| input::statistics::quantile(&sorted, share);
    Some([at(0.5)?, at(0.95)?, at(0.99)?])
}

#[cfg(test)]
mod tests;
