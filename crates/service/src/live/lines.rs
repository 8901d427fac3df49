//! Readers of the inputs, each in its own task. A line is opened again when it fails or falls silent. When it is stopped,
//! it reads all that has arrived first.

use std::io;
use std::net::UdpSocket;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use asterix::DataSource;
use tokio::sync::watch;
use tracing::{Instrument, Span, error, error_span, info, warn};

use super::connections::ConnectionReader;
use super::http_input::HttpInput;
use crate::clock::WallClock;
use crate::net::listen::{self as udp, Arrival, ConfiguredLine, LineCounters};
use fusion::time::Time;
use input::gateways::lines::LineTranslator;
use input::gateways::mavlink::{MavlinkSensors, MavlinkTranslator};
use input::gateways::remote_id::ReceiverIds;
use site::config::{Config, Connection, ConnectionFormat};

/// Maximum number of datagrams waiting for the engine: some seconds at the busiest site.
const QUEUE: usize = 8192;
/// Pause before a failed line is opened again.
const REOPEN: Duration = Duration::from_secs(2);
/// Silence after which a line joins its group again: its interface may have gone and come back.
const REJOIN: Duration = Duration::from_secs(10);
/// Time between two checks for silence.
const LISTEN: Duration = Duration::from_secs(1);

/// Maximum time for which a stopped line is still read, so that a sender without pauses cannot keep the service from
/// ending.
const DRAIN: Duration = Duration::from_secs(1);
/// Maximum number of datagrams read then; more than [`udp::RECEIVE_BUFFER`] holds.
const DRAIN_DATAGRAMS: usize = 1 << 16;
/// Pause before the next attempt when the engine's queue is full while a line is drained.
const DRAIN_PAUSE: Duration = Duration::from_millis(1);
/// Time in which stopped readers have to end.
const ENDED: Duration = Duration::from_secs(2);

/// Inputs of a configuration, being read.
pub struct Listening {
    /// Received data; closed when the readers have ended and all that they had read is taken.
    pub arrivals: Receiver<Arrival>,
    /// Each line with its counters.
    pub lines: Vec<(Arc<ConfiguredLine>, Arc<LineCounters>)>,
    /// Tasks that read the lines.
    pub readers: LineReaders,
    /// The line for gateways that post over HTTP; closed when dropped.
    pub http_input: Option<HttpInput>,
}

/// Tasks that read the lines until stopped.
pub struct LineReaders {
    stop: watch::Sender<bool>,
    tasks: Vec<tokio::task::JoinHandle<()>>,
}

impl LineReaders {
    /// Asks the readers to pass on what has arrived by now, and to end.
    pub fn stop(&self) {
        self.stop.send_replace(true);
    }

    /// Waits until the readers have ended; meanwhile their output must be taken. Must not be called
    /// on a thread of their runtime.
    #[expect(
        clippy::disallowed_methods,
        reason = "the tasks are of a runtime that this thread is not part of"
    )]
    pub fn join(self) {
        self.stop();
        let until = Instant::now() + ENDED;
        while self.tasks.iter().any(|task| !task.is_finished()) {
            if Instant::now() >= until {
                warn!("an input did not end in time: what has arrived on it may not have been read");
                self.tasks.iter().for_each(tokio::task::JoinHandle::abort);
                return;
            }
            std::thread::sleep(DRAIN_PAUSE);
        }
    }
}

/// Begins to read the lines.
pub fn listen(config: &Config, clock: &WallClock, runtime: &tokio::runtime::Handle) -> Listening {
    let (sender, arrivals) = mpsc::sync_channel(QUEUE);
    let lines: Vec<(Arc<ConfiguredLine>, Arc<LineCounters>)> =
        udp::lines(config).into_iter().map(|line| (Arc::new(line), Arc::default())).collect();
    let (stop, stopped) = watch::channel(false);
    let mut http_input = None;
    let tasks = lines
        .iter()
        .enumerate()
        .map(|(index, (line, counters))| {
            let sender = sender.clone();
            // Enabled at every level: without it a warning does not state its input.
            let span = error_span!("input", line = line.name());
            let sensor = &config.sensors[line.sensors[0]];
            let source = DataSource { sac: sensor.sac, sic: sensor.sic };
            if line.is_posted() {
                let posted = config.sensors.iter().filter(|sensor| sensor.is_posted());
                let receivers = ReceiverIds::new(posted.map(|sensor| sensor.id.clone()));
                let (counters, clock) = (counters.clone(), clock.clone());
                let input = HttpInput::new(index, counters, clock, receivers, sender, QUEUE as u64 / 2);
                let closed = input.close_when(stopped.clone());
                http_input = Some(input);
                return runtime.spawn(closed.instrument(span));
            }
            if !line.is_udp() {
                let (latitude, longitude, _) = config.origin();
                let reader = ConnectionReader {
                    index,
                    line: line.clone(),
                    counters: counters.clone(),
                    clock: clock.clone(),
                    stopped: stopped.clone(),
                    source,
                    sensor: sensor.id.clone(),
                    origin: [latitude, longitude],
                    receivers: receivers_of(config, line),
                    text: line.connection.as_ref().and_then(|of| text_translator(config, line, of)),
                };
                let forward = move |arrival| sender.try_send(arrival).is_ok();
                return runtime.spawn(reader.keep_reading(forward).instrument(span));
            }
            let translator =
                line.connection.as_ref().and_then(|of| DatagramTranslator::new(config, line, of));
            let reader = LineReader {
                translator: translator.map(Mutex::new),
                index,
                line: line.clone(),
                counters: counters.clone(),
                clock: clock.clone(),
                stopped: stopped.clone(),
            };
            runtime.spawn(reader.keep_reading(sender).instrument(span))
        })
        .collect();
    Listening { arrivals, lines, readers: LineReaders { stop, tasks }, http_input }
}

/// Sensors that a broker's lines may name: those with a connection to the broker, and those without any input.
fn receivers_of(config: &Config, line: &ConfiguredLine) -> ReceiverIds {
    let address = line.connection.as_ref().map(|of| &of.address);
    let is_broker = |of: &Connection| of.format == ConnectionFormat::Mqtt && Some(&of.address) == address;
    let named = config.sensors.iter().filter(|sensor| {
        sensor.connections.iter().any(is_broker) || sensor.inputs.is_empty() && sensor.connections.is_empty()
    });
    ReceiverIds::new(named.map(|sensor| sensor.id.clone()))
}

/// Translator of a connection whose lines are text.
fn text_translator(config: &Config, line: &ConfiguredLine, of: &Connection) -> Option<LineTranslator> {
    of.has_lines().then(|| LineTranslator::new(config, line.sensors[0], of)).flatten()
}

/// Reader of one line.
struct LineReader {
    /// Translator, for a line whose datagrams are translated.
    translator: Option<Mutex<DatagramTranslator>>,
    index: usize,
    line: Arc<ConfiguredLine>,
    counters: Arc<LineCounters>,
    clock: WallClock,
    stopped: watch::Receiver<bool>,
}

/// Translates datagrams of another protocol.
enum DatagramTranslator {
    Mavlink(MavlinkTranslator),
    Lines(Box<LineTranslator>),
}

impl DatagramTranslator {
    fn new(config: &Config, line: &ConfiguredLine, of: &Connection) -> Option<Self> {
        if of.has_lines() {
            return text_translator(config, line, of).map(Box::new).map(Self::Lines);
        }
        let sensors = line.sensors.iter().map(|&index| &config.sensors[index]);
        let sensors = MavlinkSensors::of(sensors, |with| with.socket() == of.socket());
        Some(Self::Mavlink(MavlinkTranslator::new(sensors)))
    }

    fn take(&mut self, payload: &[u8], received: Time, out: impl FnMut(Vec<u8>)) {
        match self {
            Self::Mavlink(translator) => translator.take(payload, received, out),
            Self::Lines(translator) => translator.take(payload, received, out),
        }
    }

    fn note(&self, counters: &LineCounters) {
        match self {
            Self::Mavlink(translator) => counters.note_untranslated(translator.counts().dropped.iter()),
            Self::Lines(translator) => counters.note_untranslated(translator.dropped().iter()),
        }
    }
}

/// Reason for the end of reading.
enum LineEnd {
    /// No data was received for some time.
    Silent,
    /// The socket failed.
    Failed(io::Error),
    /// The line was stopped.
    Stopped,
}

impl LineReader {
    /// Opens the line and reads it; opens it again whenever it fails or falls silent.
    async fn keep_reading(self, sender: SyncSender<Arrival>) {
        let Self { line, counters, .. } = &self;
        let mut stopped = self.stopped.clone();
        let forward = |arrival| {
            self.translated(arrival, |arrival| match sender.try_send(arrival) {
                Ok(()) => true,
                Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => false,
            })
        };
        // A line that joins again successfully is not logged.
        let (mut joined_anew, mut failing) = (false, false);
        loop {
            let opened = line.open().and_then(|(socket, buffer)| {
                counters.opened(&socket);
                Ok((tokio::net::UdpSocket::from_std(socket)?, buffer))
            });
            counters.joined.store(opened.is_ok(), Ordering::Relaxed);
            match opened {
                Ok((socket, buffer)) => {
                    if std::mem::take(&mut failing) || !joined_anew {
                        info!(receive_buffer_kib = buffer / 1024, "listening");
                    }
                    match self.read_until_silent(&socket, forward).await {
                        LineEnd::Silent => {
                            joined_anew = true;
                            continue;
                        }
                        LineEnd::Failed(error) => {
                            counters.joined.store(false, Ordering::Relaxed);
                            joined_anew = false;
                            error!(%error, "input failed: opened again");
                        }
                        LineEnd::Stopped => {
                            // The runtime may not have been notified of waiting datagrams; the socket is read directly.
                            let span = Span::current();
                            let drain = move |socket| span.in_scope(|| self.drain(&socket, &sender));
                            let drain = socket
                                .into_std()
                                .map(|socket| tokio::task::spawn_blocking(move || drain(socket)));
                            if let Ok(drain) = drain {
                                let _ = drain.await;
                            }
                            return;
                        }
                    }
                }
                Err(error) if !std::mem::replace(&mut failing, true) => {
                    error!(%error, retry_s = REOPEN.as_secs(), "input cannot be opened: tried again");
                }
                Err(_) => {}
            }
            tokio::select! {
                () = tokio::time::sleep(REOPEN) => {}
                _ = stopped.wait_for(|stopped| *stopped) => return,
            }
        }
    }

    /// Passes on an arrival, or the translator's output for it. Returns whether all of it was passed on.
    fn translated(&self, arrival: Arrival, forward: impl Fn(Arrival) -> bool) -> bool {
        let Some(translator) = &self.translator else { return forward(arrival) };
        let mut translator = translator.lock().unwrap_or_else(PoisonError::into_inner);
        let Arrival { line, received, from, payload } = arrival;
        let mut is_whole = true;
        translator.take(&payload, received, |payload| {
            is_whole &= forward(Arrival { line, received, from, payload });
        });
        translator.note(&self.counters);
        is_whole
    }

    async fn read_until_silent(
        &self,
        socket: &tokio::net::UdpSocket,
        forward: impl Fn(Arrival) -> bool,
    ) -> LineEnd {
        let Self { index, line, counters, clock, stopped, .. } = self;
        let reading = udp::read(socket, *index, line, counters, || clock.now(), forward);
        tokio::pin!(reading);
        let mut stopped = stopped.clone();
        let (mut before, mut silent) = (counters.last_received.load(Ordering::Relaxed), Duration::ZERO);
        while silent < REJOIN {
            tokio::select! {
                ended = &mut reading => return ended.map_or_else(LineEnd::Failed, |()| LineEnd::Silent),
                // Also ends when the sender of the stop signal is dropped.
                _ = stopped.wait_for(|stopped| *stopped) => return LineEnd::Stopped,
                () = tokio::time::sleep(LISTEN) => {
                    let last = counters.last_received.load(Ordering::Relaxed);
                    silent = if last == before { silent + LISTEN } else { Duration::ZERO };
                    before = last;
                }
            }
        }
        LineEnd::Silent
    }

    /// Passes on the datagrams waiting in the kernel, within a time limit.
    #[expect(clippy::disallowed_methods, reason = "how long stopping takes is limited; this thread may wait")]
    fn drain(&self, socket: &UdpSocket, sender: &SyncSender<Arrival>) {
        let Self { index, line, counters, clock, .. } = self;
        let until = Instant::now() + DRAIN;
        let insist = |mut arrival| loop {
            match sender.try_send(arrival) {
                Ok(()) => return true,
                Err(TrySendError::Full(back)) if Instant::now() < until => arrival = back,
                Err(_) => return false,
            }
            std::thread::sleep(DRAIN_PAUSE);
        };
        let forward = |arrival| self.translated(arrival, insist);
        let mut left = DRAIN_DATAGRAMS;
        let goes_on = || {
            left -= 1;
            left > 0 && Instant::now() < until
        };
        match udp::drain(socket, *index, line, counters, || clock.now(), forward, goes_on) {
            Ok(true) => {}
            Ok(false) => {
                warn!("input was stopped while more came than could be read: the rest is lost");
            }
            Err(error) => warn!(%error, "input failed: what waited on it is lost"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;
    use site::config::{Address, Input};

    /// The readers' runtime is not running while datagrams arrive and the readers are stopped.
    #[test]
    #[expect(clippy::disallowed_methods, reason = "sockets, as a sensor has them")]
    fn received_datagrams_are_read_before_a_line_closes() {
        const SENT: usize = 50;
        let site = include_str!("../../../../config/demo.toml");
        let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        for sensor in &mut config.sensors {
            // A free port, which the line then takes.
            let port = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port();
            sensor.inputs = vec![Input {
                address: Address::Unicast(Ipv4Addr::LOCALHOST),
                port,
                source: None,
                trailer_octets: None,
            }];
        }
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let Listening { arrivals, lines, readers, .. } =
            listen(&config, &WallClock::default(), runtime.handle());
        let is_joined = || lines.iter().all(|(_, counters)| counters.joined.load(Ordering::Relaxed));
        runtime.block_on(async {
            while !is_joined() {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        });
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        for number in 0..SENT {
            for sensor in &config.sensors {
                socket.send_to(&[number as u8], (Ipv4Addr::LOCALHOST, sensor.inputs[0].port)).unwrap();
            }
        }
        readers.stop();
        runtime.block_on(async {
            for task in readers.tasks {
                task.await.unwrap();
            }
        });
        for (index, (_, counters)) in lines.iter().enumerate() {
            assert_eq!(counters.received.load(Ordering::Relaxed), SENT as u64, "line {index}");
        }
        let read: Vec<Arrival> = arrivals.iter().collect();
        for line in 0..lines.len() {
            let numbers =
                read.iter().filter(|arrival| arrival.line == line).map(|arrival| arrival.payload[0]);
            assert!(numbers.eq(0..SENT as u8), "in their order");
        }
    }
}
