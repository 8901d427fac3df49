//! The threads of the service: line tasks, the engine's own thread, and what it hands out.

use std::collections::VecDeque;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::thread::JoinHandle;
use std::time::Duration;

use asterix::DataSource;
use tracing::{error, info, warn};

use super::driver::{Driver, Made};
use super::health::{LineStatus, SensorState};
use super::hub::{Frame, HubWriter, Status};
use super::quiet::Quiet;
use crate::config::Config;
use crate::fusion::Given;
use crate::ingest::udp::{self, Arrival, Line, LineCounters};
use crate::ingest::{Reception, ReceptionKind};
use crate::publish::{Cat129Encoder, Recorded, Sinks, pack, status_block};
use crate::time::{SECOND, Time};

/// Datagrams that may wait for the engine: some seconds of the busiest site.
const QUEUE: usize = 8192;
/// The engine looks up at least this often, for a stop and for its status.
const LOOK_UP: Duration = Duration::from_millis(100);
/// The next status is at most a second ahead, unless the clock has stepped back.
const STATUS_AHEAD: jiff::SignedDuration = jiff::SignedDuration::from_millis(1100);
/// A line that failed is opened again after this time.
const REOPEN: Duration = Duration::from_secs(2);
/// A line on which nothing comes for this long is joined anew: its interface may have gone and come back.
const REJOIN: Duration = Duration::from_secs(10);
/// Lateness is told over this many slots: ten minutes of them.
const LATENESS: usize = 2400;

/// Now, by the wall clock: the only clock of the service.
#[expect(clippy::disallowed_methods, reason = "the live service is told the time by this clock")]
pub fn now() -> Time {
    Time::from_nanos(i64::try_from(jiff::Timestamp::now().as_nanosecond()).unwrap_or(i64::MAX))
}

/// Where the engine's thread hands things.
pub struct Outlets {
    /// Readers of the picture.
    pub hub: HubWriter,
    /// Destinations of CAT129 and CAT065.
    pub sinks: Sinks,
    /// The recorder, where there is one, and what it lost because it was behind.
    pub recorder: Option<(SyncSender<Recorded>, Arc<AtomicU64>)>,
    /// Who keeps the transponder numbers across restarts.
    pub numbers: Option<mpsc::Sender<Given>>,
}

/// The running service.
pub struct Service {
    stop: Arc<AtomicBool>,
    engine: JoinHandle<Driver>,
    lines: Vec<tokio::task::JoinHandle<()>>,
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
        runtime: &tokio::runtime::Handle,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let Listening { arrivals, lines: all, tasks: lines } = listen(&config, runtime);
        let engine = Engine {
            source: DataSource { sac: config.site.sac, sic: config.site.sic },
            encoder: Cat129Encoder::of(&config),
            config,
            driver,
            outlets,
            lines: all,
            lateness_us: VecDeque::new(),
            failed_sends: 0,
            next_status: now(),
            quiet: Quiet::default(),
            numbers_kept: 0,
            numbers_recorded: 0,
        };
        let stopped = stop.clone();
        let engine = std::thread::Builder::new()
            .name("engine".to_owned())
            .spawn(move || engine.run(&arrivals, &stopped))?;
        Ok(Self { stop, engine, lines })
    }

    /// Whether the engine's thread has ended, which it does by itself only when it panics.
    pub fn has_ended(&self) -> bool {
        self.engine.is_finished()
    }

    /// Stops the inputs, lets the engine put out what it owes, and gives it back.
    ///
    /// # Errors
    /// The engine's thread panicked.
    pub fn stop(self) -> Result<Driver, String> {
        self.lines.iter().for_each(tokio::task::JoinHandle::abort);
        self.stop.store(true, Ordering::Relaxed);
        self.engine.join().map_err(|_| "the engine's thread panicked; this is a bug".to_owned())
    }
}

/// The lines of a configuration, being read.
pub(crate) struct Listening {
    /// What comes on them; closed when the tasks end.
    pub(crate) arrivals: Receiver<Arrival>,
    /// Each line with what it counts.
    pub(crate) lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    /// A task a line; each goes on until it is aborted.
    pub(crate) tasks: Vec<tokio::task::JoinHandle<()>>,
}

/// Begins to read the lines.
pub(crate) fn listen(config: &Config, runtime: &tokio::runtime::Handle) -> Listening {
    let (sender, arrivals) = mpsc::sync_channel(QUEUE);
    let lines: Vec<(Arc<Line>, Arc<LineCounters>)> =
        udp::lines(config).into_iter().map(|line| (Arc::new(line), Arc::default())).collect();
    let tasks = lines
        .iter()
        .enumerate()
        .map(|(index, (line, counters))| {
            runtime.spawn(keep_reading(index, line.clone(), counters.clone(), sender.clone()))
        })
        .collect();
    Listening { arrivals, lines, tasks }
}

/// Opens a line and reads it; opens it again whenever it fails, or falls silent.
async fn keep_reading(
    index: usize,
    line: Arc<Line>,
    counters: Arc<LineCounters>,
    sender: SyncSender<Arrival>,
) {
    let hand_on = |arrival| match sender.try_send(arrival) {
        Ok(()) => true,
        Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => false,
    };
    let mut told = false;
    loop {
        let opened = line.open().and_then(|(socket, buffer)| {
            counters.opened(&socket);
            Ok((tokio::net::UdpSocket::from_std(socket)?, buffer))
        });
        match opened {
            Ok((socket, buffer)) => {
                counters.joined.store(true, Ordering::Relaxed);
                if !std::mem::take(&mut told) {
                    info!("listening to {}, receive buffer {} KiB", line.name(), buffer / 1024);
                }
                let failed = read_until_silent(index, &socket, &line, &counters, hand_on).await;
                counters.joined.store(failed.is_none(), Ordering::Relaxed);
                match failed {
                    Some(error) => error!("{}: {error}; it is opened again", line.name()),
                    None => {
                        told = true; // joined anew without a word
                        continue;
                    }
                }
            }
            Err(error) if !told => {
                told = true;
                error!(
                    "{} cannot be opened: {error}; it is tried again every {} s",
                    line.name(),
                    REOPEN.as_secs()
                );
            }
            Err(_) => {}
        }
        tokio::time::sleep(REOPEN).await;
    }
}

/// Why reading ended; `None`: the line fell silent.
async fn read_until_silent(
    index: usize,
    socket: &tokio::net::UdpSocket,
    line: &Line,
    counters: &LineCounters,
    hand_on: impl Fn(Arrival) -> bool,
) -> Option<io::Error> {
    let reading = udp::read(socket, index, line, counters, now, hand_on);
    tokio::pin!(reading);
    let mut before = counters.last_received.load(Ordering::Relaxed);
    loop {
        tokio::select! {
            ended = &mut reading => return ended.err(),
            () = tokio::time::sleep(REJOIN) => {
                let last = counters.last_received.load(Ordering::Relaxed);
                if last == before {
                    return None;
                }
                before = last;
            }
        }
    }
}

/// The engine's thread.
struct Engine {
    config: Arc<Config>,
    source: DataSource,
    encoder: Cat129Encoder,
    driver: Driver,
    outlets: Outlets,
    lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    lateness_us: VecDeque<u32>,
    failed_sends: u64,
    next_status: Time,
    quiet: Quiet,
    /// How many of the new transponder numbers their keeper, and the recorder, have been told.
    numbers_kept: usize,
    numbers_recorded: usize,
}

impl Engine {
    fn run(mut self, arrivals: &Receiver<Arrival>, stop: &AtomicBool) -> Driver {
        while !stop.load(Ordering::Relaxed) {
            let until_due = self.driver.deadline().map(|deadline| deadline - now());
            let wait =
                until_due.map_or(LOOK_UP, |due| Duration::try_from(due).unwrap_or_default().min(LOOK_UP));
            match arrivals.recv_timeout(wait) {
                Ok(arrival) => self.receive(arrival),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            // What waits came before now: it is handled before the slots that are due by now.
            let at = now();
            if self.driver.deadline().is_some_and(|deadline| deadline <= at) {
                while let Ok(arrival) = arrivals.try_recv() {
                    self.receive(arrival);
                }
                self.tick(at);
            }
            // Also where the clock has stepped back, of which the driver must be told.
            if at >= self.next_status || self.next_status - at > STATUS_AHEAD {
                self.tick(at);
                self.tell(at);
            }
        }
        while let Ok(arrival) = arrivals.try_recv() {
            self.receive(arrival);
        }
        if self.config.output.flush_on_stop {
            let mut owed = Vec::new();
            self.driver.finish(|frame| owed.push(frame));
            owed.into_iter().for_each(|frame| self.publish(frame));
            self.tell_numbers();
        }
        self.tell(now());
        self.driver
    }

    fn receive(&mut self, arrival: Arrival) {
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
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: arrival.payload,
        };
        let mut made = Vec::new();
        let Self { driver, outlets, .. } = self;
        driver.receive_showing(&reception, |report| outlets.hub.inputs.note(report), |one| made.push(one));
        self.hand_out(made);
    }

    fn tick(&mut self, at: Time) {
        let mut made = Vec::new();
        self.driver.tick(at, |one| made.push(one));
        self.hand_out(made);
    }

    fn hand_out(&mut self, made: Vec<Made>) {
        for made in made {
            match made {
                Made::Slot(frame) => self.publish(frame),
                Made::Event(event) if event.is_warning() => {
                    if self.quiet.may_tell(event.kind(), now()) {
                        warn!("{event}");
                    }
                }
                Made::Event(_) => {}
            }
        }
        self.tell_numbers();
    }

    /// Hands on the transponder numbers that were given; what does not fit the recorder's queue waits for the next time.
    fn tell_numbers(&mut self) {
        let new = self.driver.pipeline().engine().numbers().new_ones();
        if let Some(keeper) = &self.outlets.numbers {
            // A keeper that has ended has said so.
            for &(_, given) in &new[self.numbers_kept..] {
                let _ = keeper.send(given);
            }
        }
        self.numbers_kept = new.len();
        if let Some((recorder, _)) = &self.outlets.recorder {
            let told = new[self.numbers_recorded..]
                .iter()
                .take_while(|&&(slot, given)| recorder.try_send(Recorded::Numbered { slot, given }).is_ok());
            self.numbers_recorded += told.count();
        }
    }

    /// Sends the slot, then shows it.
    fn publish(&mut self, mut frame: Frame) {
        for payload in pack(&frame.picture, &self.encoder) {
            self.failed_sends += self.outlets.sinks.send(&payload);
            let due = frame.due;
            self.record(|| Recorded::Output { due, payload });
        }
        frame.published_at = now();
        let late_us = (frame.published_at.nanos() - frame.due.nanos()).max(0) / 1000;
        if self.lateness_us.len() == LATENESS {
            self.lateness_us.pop_front();
        }
        self.lateness_us.push_back(u32::try_from(late_us).unwrap_or(u32::MAX));
        self.outlets.hub.publish(frame);
    }

    fn record(&self, what: impl FnOnce() -> Recorded) {
        if let Some((recorder, lost)) = &self.outlets.recorder
            && recorder.try_send(what()).is_err()
        {
            lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Once a second: how everything is, to readers and to the sinks.
    fn tell(&mut self, at: Time) {
        self.next_status = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
        for (kind, count) in self.quiet.suppressed(at) {
            warn!("{kind}: {count} more like this");
        }
        let table = udp::kernel_table();
        self.lines.iter().for_each(|(_, counters)| counters.note_kernel_drops(&table));
        let lines = |sensor: usize| {
            let of = |(index, (line, counters)): (usize, &(Arc<Line>, Arc<LineCounters>))| {
                line.sensors
                    .contains(&sensor)
                    .then(|| LineStatus::of(line.name(), counters, self.driver.duplicates(index)))
            };
            self.lines.iter().enumerate().filter_map(of).collect()
        };
        let sensors = self.driver.health().sensors(at, lines);
        let degraded = sensors.iter().any(|sensor| sensor.state != SensorState::Operational);
        if self.config.output.status {
            self.failed_sends += self.outlets.sinks.send(&status_block(self.source, at, degraded));
        }
        self.outlets.hub.tell(Status {
            at,
            sensors,
            unknown: self.driver.health().unknown(),
            tally: self.driver.pipeline().tally().clone(),
            lateness_s: percentiles(&self.lateness_us),
            failed_sends: self.failed_sends,
        });
    }
}

/// Median, 95th and 99th percentile, seconds.
fn percentiles(microseconds: &VecDeque<u32>) -> Option<[f64; 3]> {
    let mut sorted: Vec<u32> = microseconds.iter().copied().collect();
    sorted.sort_unstable();
    let last = sorted.len().checked_sub(1)?;
    Some([0.5, 0.95, 0.99].map(|share| f64::from(sorted[(share * last as f64).round() as usize]) * 1e-6))
}
