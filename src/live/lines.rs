//! The lines being read: each in a task of its own, opened again when it fails or falls silent, and read to the end of what
//! has arrived when it is stopped.

use std::io;
use std::net::UdpSocket;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use asterix::DataSource;
use tokio::sync::watch;
use tracing::{Instrument, Span, error, error_span, info, warn};

use super::clock::Clock;
use super::doors::Door;
use super::posts::Posts;
use crate::config::{Config, Connection, ConnectionFormat, mavlink_sensors};
use crate::gateways::mavlink::Translator;
use crate::gateways::remote_id::Receivers;
use crate::net::listen::{self as udp, Arrival, Line, LineCounters};

/// Datagrams that may wait for the engine: some seconds of the busiest site.
const QUEUE: usize = 8192;
/// A line that failed is opened again after this time.
const REOPEN: Duration = Duration::from_secs(2);
/// A line on which nothing comes for this long is joined anew: its interface may have gone and come back.
const REJOIN: Duration = Duration::from_secs(10);
/// Time between two looks at whether anything came.
const LISTEN: Duration = Duration::from_secs(1);

/// Longest time for which a stopped line is still read: a sender that never pauses must not keep the service from ending.
const DRAIN: Duration = Duration::from_secs(1);
/// Most datagrams that are read then, more than [`udp::RECEIVE_BUFFER`] holds.
const DRAIN_DATAGRAMS: usize = 1 << 16;
/// Pause before the next try where the engine's queue is full while a line is drained.
const DRAIN_PAUSE: Duration = Duration::from_millis(1);
/// Time in which the readers end after they were asked to, unless the machine stands still.
const ENDED: Duration = Duration::from_secs(2);

/// The lines of a configuration, being read.
pub(crate) struct Listening {
    /// What comes on them; closed when the readers have ended, and everything that they had read is taken.
    pub(crate) arrivals: Receiver<Arrival>,
    /// Each line with what it counts.
    pub(crate) lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    /// Who reads them.
    pub(crate) readers: Readers,
    /// The line that gateways post to; closed where nobody keeps it.
    pub(crate) posts: Option<Posts>,
}

/// The tasks that read the lines; each goes on until it is stopped.
pub(crate) struct Readers {
    stop: watch::Sender<bool>,
    tasks: Vec<tokio::task::JoinHandle<()>>,
}

impl Readers {
    /// Asks the readers to hand on what has arrived by now, and to end. What arrives later is not waited for.
    pub(crate) fn stop(&self) {
        self.stop.send_replace(true);
    }

    /// Waits until they have ended; somebody must take what they hand on. Not on a thread of their runtime.
    #[expect(
        clippy::disallowed_methods,
        reason = "the tasks are of a runtime that this thread is not part of"
    )]
    pub(crate) fn join(self) {
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
pub(crate) fn listen(config: &Config, clock: &Clock, runtime: &tokio::runtime::Handle) -> Listening {
    let (sender, arrivals) = mpsc::sync_channel(QUEUE);
    let lines: Vec<(Arc<Line>, Arc<LineCounters>)> =
        udp::lines(config).into_iter().map(|line| (Arc::new(line), Arc::default())).collect();
    let (stop, stopped) = watch::channel(false);
    let mut posts = None;
    let tasks = lines
        .iter()
        .enumerate()
        .map(|(index, (line, counters))| {
            let sender = sender.clone();
            // Enabled at every level: without it a warning does not say which input it is about.
            let span = error_span!("input", name = line.name());
            let sensor = &config.sensors[line.sensors[0]];
            let source = DataSource { sac: sensor.sac, sic: sensor.sic };
            if line.is_posted() {
                let posted = config.sensors.iter().filter(|sensor| sensor.is_posted());
                let receivers = Receivers::new(posted.map(|sensor| sensor.id.clone()));
                let (counters, clock) = (counters.clone(), clock.clone());
                let door = Posts::new(index, counters, clock, receivers, sender, QUEUE as u64 / 2);
                let closed = door.close_when(stopped.clone());
                posts = Some(door);
                return runtime.spawn(closed.instrument(span));
            }
            if !line.is_udp() {
                let (latitude, longitude, _) = config.origin();
                let door = Door {
                    index,
                    line: line.clone(),
                    counters: counters.clone(),
                    clock: clock.clone(),
                    stopped: stopped.clone(),
                    source,
                    sensor: sensor.id.clone(),
                    origin: [latitude, longitude],
                    receivers: receivers_of(config, line),
                };
                let hand_on = move |arrival| sender.try_send(arrival).is_ok();
                return runtime.spawn(door.keep_reading(hand_on).instrument(span));
            }
            let translator = line.connection.as_ref().map(|of| {
                let sensors = line.sensors.iter().map(|&index| &config.sensors[index]);
                Mutex::new(Translator::new(mavlink_sensors(sensors, |with| with.socket() == of.socket())))
            });
            let reader = Reader {
                translator,
                index,
                line: line.clone(),
                counters: counters.clone(),
                clock: clock.clone(),
                stopped: stopped.clone(),
            };
            runtime.spawn(reader.keep_reading(sender).instrument(span))
        })
        .collect();
    Listening { arrivals, lines, readers: Readers { stop, tasks }, posts }
}

/// The sensors that a broker's lines may name: those with a connection to it, and those that nothing else can be heard for.
fn receivers_of(config: &Config, line: &Line) -> Receivers {
    let address = line.connection.as_ref().map(|of| &of.address);
    let is_broker = |of: &Connection| of.format == ConnectionFormat::Mqtt && Some(&of.address) == address;
    let named = config.sensors.iter().filter(|sensor| {
        sensor.connections.iter().any(is_broker) || sensor.inputs.is_empty() && sensor.connections.is_empty()
    });
    Receivers::new(named.map(|sensor| sensor.id.clone()))
}

/// The reader of a line.
struct Reader {
    /// Of a line whose datagrams are translated.
    translator: Option<Mutex<Translator>>,
    index: usize,
    line: Arc<Line>,
    counters: Arc<LineCounters>,
    clock: Clock,
    stopped: watch::Receiver<bool>,
}

/// Why a line is read no longer.
enum Ended {
    /// Nothing came for some time.
    Silent,
    /// The socket failed.
    Failed(io::Error),
    /// It is to end.
    Stopped,
}

impl Reader {
    /// Opens the line and reads it; opens it again whenever it fails, or falls silent.
    async fn keep_reading(self, sender: SyncSender<Arrival>) {
        let Self { line, counters, .. } = &self;
        let mut stopped = self.stopped.clone();
        let hand_on = |arrival| {
            self.translated(arrival, |arrival| match sender.try_send(arrival) {
                Ok(()) => true,
                Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => false,
            })
        };
        // A line that is joined anew and works needs no word.
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
                    match self.read_until_silent(&socket, hand_on).await {
                        Ended::Silent => {
                            joined_anew = true;
                            continue;
                        }
                        Ended::Failed(error) => {
                            counters.joined.store(false, Ordering::Relaxed);
                            joined_anew = false;
                            error!(%error, "input failed: opened again");
                        }
                        Ended::Stopped => {
                            // The runtime may not have heard yet of what waits; the socket itself knows.
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

    /// Hands on an arrival, or what a translator makes of it; whether nothing of it was lost.
    fn translated(&self, arrival: Arrival, hand_on: impl Fn(Arrival) -> bool) -> bool {
        let Some(translator) = &self.translator else { return hand_on(arrival) };
        let mut translator = translator.lock().unwrap_or_else(PoisonError::into_inner);
        let Arrival { line, received, from, payload } = arrival;
        let mut is_whole = true;
        translator.take(&payload, received, |payload| {
            is_whole &= hand_on(Arrival { line, received, from, payload });
        });
        self.counters.note_untranslated(translator.counts().dropped.iter());
        is_whole
    }

    async fn read_until_silent(
        &self,
        socket: &tokio::net::UdpSocket,
        hand_on: impl Fn(Arrival) -> bool,
    ) -> Ended {
        let Self { index, line, counters, clock, stopped, .. } = self;
        let reading = udp::read(socket, *index, line, counters, || clock.now(), hand_on);
        tokio::pin!(reading);
        let mut stopped = stopped.clone();
        let (mut before, mut silent) = (counters.last_received.load(Ordering::Relaxed), Duration::ZERO);
        while silent < REJOIN {
            tokio::select! {
                ended = &mut reading => return ended.map_or_else(Ended::Failed, |()| Ended::Silent),
                // Also where nobody is left who could say so.
                _ = stopped.wait_for(|stopped| *stopped) => return Ended::Stopped,
                () = tokio::time::sleep(LISTEN) => {
                    let last = counters.last_received.load(Ordering::Relaxed);
                    silent = if last == before { silent + LISTEN } else { Duration::ZERO };
                    before = last;
                }
            }
        }
        Ended::Silent
    }

    /// Hands on what waits in the kernel, as far as that takes no long time.
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
        let hand_on = |arrival| self.translated(arrival, insist);
        let mut left = DRAIN_DATAGRAMS;
        let goes_on = || {
            left -= 1;
            left > 0 && Instant::now() < until
        };
        match udp::drain(socket, *index, line, counters, || clock.now(), hand_on, goes_on) {
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
    use crate::config::{Address, Input};

    /// Each reader sleeps in its runtime, which nobody drives, while datagrams arrive and it is asked to end.
    #[test]
    #[expect(clippy::disallowed_methods, reason = "sockets, as a sensor has them")]
    fn what_has_arrived_is_read_before_a_line_is_closed() {
        const SENT: usize = 50;
        let site = include_str!("../../config/demo.toml");
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
        let Listening { arrivals, lines, readers, .. } = listen(&config, &Clock::default(), runtime.handle());
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
