//! The threads of the service: line tasks, the engine's own thread, and what it hands out.

mod keepers;

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::Duration;

use asterix::DataSource;
use tracing::{info, warn};

use super::alerts::{Severity, Trouble};
use super::clock::Clock;
use super::condition::Level;
use super::driver::{Driver, Made};
use super::health::LineStatus;
use super::hub::{Frame, HubWriter, Status};
use super::lines::{Listening, Readers, listen};
use super::losses::Losses;
use super::quiet::Quiet;
use crate::capture::{Ending, Endpoints, Reception, ReceptionKind, TrailerRules, Trailers};
use crate::config::{Config, Profile};
use crate::formats::{Cat129Encoder, pack, status_block};
use crate::net::listen::{self as udp, Arrival, Line, LineCounters};
use crate::net::send::Sinks;
use crate::pipeline::Event;
use crate::record::{Recorded, RecorderQueue};
use crate::state::correlation_line;
use fusion::SensorIndex;
use fusion::numbering::{LARGEST_TRANSPONDER_NUMBER, NumberChange};
use fusion::operational::HeldCorrelation;
use fusion::registration::Misalignment;
use fusion::time::{SECOND, Time};

/// The engine looks up at least this often, for a stop and for its status.
const LOOK_UP: Duration = Duration::from_millis(100);
/// The next status is at most a second ahead, unless the clock has stepped back.
const STATUS_AHEAD: jiff::SignedDuration = jiff::SignedDuration::from_millis(1100);
/// A datagram that waited for the engine for longer than this has waited for long: as a rule none waits for a millisecond.
const WAITED: jiff::SignedDuration = jiff::SignedDuration::from_millis(500);
/// Lateness is told over this many slots: ten minutes of them.
const LATENESS: usize = 2400;

/// An alert tells of transponder numbers from this share in use on.
const NUMBERS_LOW: f64 = 0.9;

/// What is known of the radars' set-up.
type Estimates = Vec<(SensorIndex, Misalignment)>;

/// Where the engine's thread hands things.
pub struct Outlets {
    /// Readers of the picture.
    pub hub: HubWriter,
    /// Destinations of CAT129 and CAT065.
    pub sinks: Sinks,
    /// The recorder, where there is one.
    pub recorder: Option<RecorderQueue>,
    /// Who keeps the transponder numbers across restarts.
    pub numbers: Option<SyncSender<NumberChange>>,
    /// Who keeps the registration across restarts.
    pub registration: Option<SyncSender<Arc<str>>>,
    /// Who keeps what operators have decided across restarts.
    pub correlations: Option<SyncSender<Arc<str>>>,
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
        let Listening { arrivals, lines, readers } = listen(&config, &clock, runtime);
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

    /// Stops the inputs, each when what has arrived on it by now is read, lets the engine handle that and put out what it
    /// owes, and gives it back. Not on a thread of the runtime.
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
    source: DataSource,
    encoder: Cat129Encoder,
    driver: Driver,
    outlets: Outlets,
    lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    /// What stands behind the blocks of datagrams.
    trailers: Trailers,
    lateness_us: VecDeque<u32>,
    /// Sends that failed, and those of them that have been told.
    failed_sends: u64,
    failed_told: u64,
    /// Datagrams of sensors that the engine never saw, and datagrams that were not recorded.
    input_losses: Losses,
    recorder_losses: Losses,
    /// Datagrams since the last slot that waited for long.
    waited: usize,
    clock: Clock,
    next_status: Time,
    quiet: Quiet,
    /// What their keeper, and the recorder, have not been told yet of transponder numbers: of each number the latest.
    unkept: BTreeMap<u32, NumberChange>,
    unrecorded_numbers: BTreeMap<u32, NumberChange>,
    /// What the registration's keeper and the recorder have been told of, and when they are told again.
    registered: Estimates,
    next_registration: Time,
    /// The decisions in force that the recorder has been told, and what waits for room in its queue.
    held: Vec<HeldCorrelation>,
    unrecorded: VecDeque<Recorded>,
    /// The text of decisions that their keeper has been told.
    kept: Arc<str>,
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
            source: DataSource { sac: config.site.sac, sic: config.site.sic },
            encoder: Cat129Encoder::of(&config),
            trailers: Trailers::new(TrailerRules::of(&config)),
            config,
            driver,
            outlets,
            lines,
            lateness_us: VecDeque::new(),
            failed_sends: 0,
            failed_told: 0,
            input_losses: Losses::default(),
            recorder_losses: Losses::default(),
            waited: 0,
            next_status: clock.now(),
            clock,
            quiet: Quiet::default(),
            unkept: BTreeMap::new(),
            unrecorded_numbers: BTreeMap::new(),
            registered: Vec::new(),
            next_registration: Time::default(),
            held: Vec::new(),
            unrecorded: VecDeque::new(),
            kept: "".into(),
        }
    }

    fn run(mut self, arrivals: &Receiver<Arrival>, stop: &AtomicBool) -> Driver {
        while !stop.load(Ordering::Relaxed) {
            let until_due = self.driver.deadline().map(|deadline| deadline - self.clock.now());
            let wait =
                until_due.map_or(LOOK_UP, |due| Duration::try_from(due).unwrap_or_default().min(LOOK_UP));
            match arrivals.recv_timeout(wait) {
                Ok(arrival) => self.receive(arrival),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.correlate();
            let at = self.clock.now();
            let slot_is_due = self.driver.deadline().is_some_and(|deadline| deadline <= at);
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
        if self.config.output.flush_on_stop {
            let mut owed = Vec::new();
            self.driver.finish(|made| owed.push(made));
            self.hand_out_as(owed, true);
        }
        self.tell(self.clock.now());
        // This time there is time to wait.
        if let Some(keeper) = &self.outlets.numbers {
            for change in std::mem::take(&mut self.unkept).into_values() {
                let _ = keeper.send(change);
            }
        }
        let text = self.new_registration();
        if let Some((keeper, (_, text))) = self.outlets.registration.take().zip(text) {
            let _ = keeper.send(text);
        }
        if let (Some(keeper), Some(text)) = (self.outlets.correlations.take(), self.newly_kept()) {
            let _ = keeper.send(text);
        }
        self.driver
    }

    /// Handles what waits, which came before the slots that are due by now. Where that is more than can be handled until the
    /// engine looks up, it is not all: then the clock may publish no slot, because what belongs into it still waits.
    fn catch_up(&mut self, arrivals: &Receiver<Arrival>) -> Handled {
        let began = self.clock.now();
        loop {
            let now = self.clock.now();
            let Ok(arrival) = arrivals.try_recv() else { return Handled { until: now, is_all: true } };
            let until = arrival.received;
            self.receive(arrival);
            if now.nanos().abs_diff(began.nanos()) > LOOK_UP.as_nanos() as u64 {
                return Handled { until, is_all: false };
            }
        }
    }

    fn receive(&mut self, arrival: Arrival) {
        self.waited += usize::from(self.clock.now() - arrival.received > WAITED);
        let received = self.driver.reception(arrival.received);
        self.record(|| Recorded::Input {
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
        let mut made = Vec::new();
        let Self { driver, outlets, .. } = self;
        driver.receive_showing(&reception, |report| outlets.hub.inputs.note(report), |one| made.push(one));
        self.hand_out(made);
    }

    /// The blocks of a datagram.
    fn without_trailer(&mut self, arrival: Arrival) -> Vec<u8> {
        let mut payload = arrival.payload;
        let endpoints = self.lines.get(arrival.line).map(|(line, _)| Endpoints {
            source: SocketAddr::V4(arrival.from),
            destination: line.destination(),
        });
        if let Ending::Trailer(octets) = self.trailers.see(endpoints, &payload) {
            payload.truncate(payload.len() - octets);
        }
        for trailer in self.trailers.news() {
            info!("{trailer}; trailer_octets = {} of this input would say so from the start", trailer.octets);
        }
        payload
    }

    fn tick(&mut self, at: Time) {
        let mut made = Vec::new();
        self.driver.tick(at, |one| made.push(one));
        self.hand_out(made);
    }

    fn hand_out(&mut self, made: Vec<Made>) {
        // The slots before a fresh start are owed from before a pause, or a step of the clock: how late they are says
        // nothing about the picture that follows.
        let are_owed = made.iter().any(|made| matches!(made, Made::Event(Event::Restarted)));
        self.hand_out_as(made, are_owed);
    }

    fn hand_out_as(&mut self, made: Vec<Made>, are_owed: bool) {
        for made in made {
            match made {
                Made::Slot(frame) if are_owed => self.publish_owed(frame),
                Made::Slot(frame) => self.publish(frame),
                Made::Number(change) => self.note_number(change),
                Made::Event(event) if event.is_warning() => {
                    if self.quiet.may_tell(event.kind(), self.clock.now()) {
                        warn!("{event}");
                    }
                }
                Made::Event(_) => {}
            }
        }
        self.tell_numbers();
        self.tell_decisions();
    }

    /// Does what operators ask for.
    fn correlate(&mut self) {
        for (slot, correlation) in self.outlets.hub.correlations.obey(&mut self.driver) {
            let line = correlation_line(slot, &correlation, &self.config).into();
            self.unrecorded.push_back(Recorded::Decided { line });
        }
        self.tell_decisions();
    }

    /// Sends the slot, then shows it, and notes how late that is.
    fn publish(&mut self, frame: Frame) {
        let frame = self.send(frame);
        let late_us = (frame.published_at.nanos() - frame.due.nanos()).max(0) / 1000;
        if self.lateness_us.len() == LATENESS {
            self.lateness_us.pop_front();
        }
        self.lateness_us.push_back(u32::try_from(late_us).unwrap_or(u32::MAX));
        self.outlets.hub.publish_live(frame, std::mem::take(&mut self.waited));
    }

    /// The same for a slot whose lateness says nothing about the service.
    fn publish_owed(&mut self, frame: Frame) {
        let frame = self.send(frame);
        self.outlets.hub.publish(frame);
    }

    /// Sends and records the slot, which is published now.
    fn send(&mut self, mut frame: Frame) -> Frame {
        for payload in pack(&frame.picture, &self.encoder) {
            self.failed_sends += self.outlets.sinks.send(&payload);
            let due = frame.due;
            self.record(|| Recorded::Output { due, payload });
        }
        frame.published_at = self.clock.now();
        frame
    }

    fn record(&mut self, what: impl FnOnce() -> Recorded) {
        if let Some(recorder) = &mut self.outlets.recorder {
            recorder.offer(what());
        }
    }

    /// Once a second: how everything is, to readers and to the sinks. What was received is handled until `handled`: a
    /// sensor whose reports still wait has not fallen silent.
    fn tell(&mut self, handled: Time) {
        let at = self.clock.now();
        self.next_status = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
        for (kind, count) in self.quiet.suppressed(at) {
            warn!("{kind}: {count} more like this");
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
        let mut status = Status {
            at,
            sensors,
            unknown: self.driver.health().unknown(),
            tally: self.driver.pipeline().tally().clone(),
            numbers_used: self.driver.pipeline().engine().numbers().used(),
            lateness_s: percentiles(&self.lateness_us),
            failed_sends: self.failed_sends,
            troubles: self.troubles(at),
        };
        if self.config.output.status {
            let degraded = self.outlets.hub.condition(&status).level() > Level::Ok;
            self.failed_sends += self.outlets.sinks.send(&status_block(self.source, at, degraded));
            status.failed_sends = self.failed_sends;
        }
        self.outlets.hub.tell(status);
    }

    /// What is wrong with the service itself, since it was told last.
    fn troubles(&mut self, at: Time) -> Vec<Trouble> {
        let mut troubles = Vec::new();
        let mut find = |about, severity, text: String| troubles.push(Trouble { about, severity, text });
        let behind_ns = self.driver.pipeline().engine().behind(at).as_nanos() as i64;
        if behind_ns > SECOND {
            let behind_s = behind_ns / SECOND;
            let text = format!(
                "the clock of this machine was set back: nothing is published for {behind_s} s, until it is caught up"
            );
            find(Trouble::CLOCK, Severity::Critical, text);
        }
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let lost = |(_, line): &(_, Arc<LineCounters>)| count(&line.queue_full) + count(&line.kernel_dropped);
        if let Some(lost) = self.input_losses.going_on(self.lines.iter().map(lost).sum(), at) {
            let text = format!("{lost} datagrams of sensors were lost before the engine could handle them");
            find(Trouble::INPUT, Severity::Critical, text);
        }
        let failed = self.failed_sends - std::mem::replace(&mut self.failed_told, self.failed_sends);
        if failed > 0 {
            find(
                Trouble::OUTPUT,
                Severity::Critical,
                format!("{failed} datagrams could not be sent in a second"),
            );
        }
        if let Some(counts) = self.outlets.recorder.as_ref().map(RecorderQueue::counts) {
            let missing = self.recorder_losses.going_on(counts.lost + counts.unwritten, at);
            let text = match missing {
                _ if counts.failing => Some("nothing is recorded: the disk cannot be written".to_owned()),
                Some(missing) => Some(format!("{missing} datagrams are missing in the recording")),
                None => None,
            };
            text.into_iter().for_each(|text| find(Trouble::RECORDER, Severity::Warning, text));
        }
        let used = self.driver.pipeline().engine().numbers().used();
        if let Some(text) = numbers_low(used, self.config.fusion.profile) {
            find("numbers", Severity::Warning, text);
        }
        troubles
    }
}

/// What is to be said where few transponder numbers are left.
fn numbers_low(used: usize, profile: Profile) -> Option<String> {
    let then = match profile {
        Profile::Operational => "a new transponder takes that of the one heard longest ago",
        Profile::Reference => "new transponders are left out",
    };
    (used as f64 >= NUMBERS_LOW * f64::from(LARGEST_TRANSPONDER_NUMBER)).then(|| {
        format!("{used} of {LARGEST_TRANSPONDER_NUMBER} transponder numbers are in use; when all are, {then}")
    })
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
