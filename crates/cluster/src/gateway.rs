//! A gateway: writes the datagrams received on the lines into the log.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use asterix::DataSource;
use futures_util::future::join_all;
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tracing::warn;

use super::batches::InputBatcher;
use super::cell_thread::clocks;
use super::clocks::{ClockQuery, ClockRule, DatagramStamps};
use super::gateway_report::{GatewayClock, GatewayCounts, GatewayReport};
use super::log::Log;
use super::member_clock::{MemberClock, report_times};
use super::message::{GatewayInput, InputOrigin};
use fusion::slots::SlotGrid;
use service::live::{ClockStanding, GatewayState, LineStatus, Listening, WallClock, listen, now};
use service::net::listen::{self as udp, Arrival, ConfiguredLine, LineCounters};
use site::config::{Cluster, Config};

/// Maximum size of the messages that wait while the log is unavailable, in octets: about a minute of a busy gateway. Beyond it
/// the oldest are dropped.
const MAX_WAITING_OCTETS: usize = 64 << 20;
/// Maximum number of unacknowledged messages.
const MAX_UNACKNOWLEDGED: usize = 256;
/// Pause before unacknowledged messages are sent again.
const RETRY_PAUSE: Duration = Duration::from_millis(100);
/// Maximum time between two checks for a stop.
const STOP_CHECK_INTERVAL: Duration = Duration::from_millis(100);
/// Interval of the reports.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);
/// Interval, in reports, at which the gateway registers as expected.
const REGISTRATION_INTERVAL: u64 = 60;

/// Messages waiting for the log.
#[derive(Debug, Default)]
struct PendingInputs {
    inputs: Mutex<InputQueue>,
    more: Notify,
    /// Timestamps of some of the latest datagrams, published or not.
    stamps: Mutex<DatagramStamps>,
}

#[derive(Debug, Default)]
struct InputQueue {
    queue: VecDeque<GatewayInput>,
    octets: usize,
    written: u64,
    dropped: u64,
    /// Whether publication is suspended.
    is_silent: bool,
    withheld: u64,
    resumed: u64,
}

/// A running gateway.
#[derive(Debug)]
pub struct Gateway {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<()>,
    tasks: [tokio::task::JoinHandle<()>; 2],
    waiting: Arc<PendingInputs>,
    log: Log,
    name: String,
}

impl Gateway {
    /// Listens to the sensors, and writes their datagrams into the log.
    ///
    /// # Errors
    /// A thread cannot be created.
    pub fn start(config: &Config, cluster: &Cluster, log: Log, runtime: &Handle) -> io::Result<Self> {
        let clock = WallClock::default();
        let Listening { arrivals, lines, readers, .. } = listen(config, &clock, runtime);
        let feed = |(line, _): &(Arc<ConfiguredLine>, _)| {
            let sensor = &config.sensors[line.sensors[0]];
            (DataSource { sac: sensor.sac, sic: sensor.sic }, SocketAddr::from(line.destination()))
        };
        let mut batches =
            InputBatcher::new(SlotGrid::new(config.fusion.slot), lines.iter().map(feed), clock.now());
        let stop = Arc::new(AtomicBool::new(false));
        let waiting = Arc::new(PendingInputs::default());
        let (stopped, queue) = (stop.clone(), waiting.clone());
        let thread = std::thread::Builder::new().name("gateway".to_owned()).spawn(move || {
            collect(&mut batches, &arrivals, &clock, &queue, &stopped);
            readers.stop();
        })?;
        let writing = runtime.spawn(write(log.clone(), cluster.node.clone(), waiting.clone()));
        let reporting = runtime.spawn(report_each_second(
            log.clone(),
            cluster.clone(),
            lines,
            waiting.clone(),
            ClockQuery::start()?,
        ));
        Ok(Self { stop, thread, tasks: [writing, reporting], waiting, log, name: cluster.node.clone() })
    }

    /// Whether a thread or task has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished() || self.tasks.iter().any(tokio::task::JoinHandle::is_finished)
    }

    /// Stops listening, and waits at most one second until all received datagrams are in the log.
    pub async fn stop(self) {
        self.stop.store(true, Ordering::Relaxed);
        let Self { thread, tasks, waiting, log, name, .. } = self;
        drop(tokio::task::spawn_blocking(move || thread.join()).await);
        let written = async {
            while waiting.counts().waiting > 0 {
                tokio::time::sleep(RETRY_PAUSE / 10).await;
            }
        };
        drop(tokio::time::timeout(Duration::from_secs(1), written).await);
        tasks.iter().for_each(tokio::task::JoinHandle::abort);
        // The gateway is no longer expected.
        _ = log.forget_gateway(&name).await;
    }
}

/// Queues the messages of each slot when it is over.
fn collect(
    batches: &mut InputBatcher,
    arrivals: &Receiver<Arrival>,
    clock: &WallClock,
    waiting: &PendingInputs,
    stop: &AtomicBool,
) {
    while !stop.load(Ordering::Relaxed) {
        let wait = Duration::try_from(batches.due_at() - clock.now()).unwrap_or_default();
        match arrivals.recv_timeout(wait.min(STOP_CHECK_INTERVAL)) {
            Ok(Arrival { line, received, from, payload }) => {
                waiting.add(batches.add(line, received, from.into(), payload));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        waiting.add(batches.close_slots(clock.now()));
    }
}

impl PendingInputs {
    fn inputs(&self) -> std::sync::MutexGuard<'_, InputQueue> {
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, inputs: impl IntoIterator<Item = GatewayInput>) {
        let mut stamps = self.stamps.lock().unwrap_or_else(PoisonError::into_inner);
        let mut waiting = self.inputs();
        let mut is_more = false;
        for input in inputs {
            stamps.note(&input);
            if waiting.is_silent {
                waiting.withheld += input.datagrams.len() as u64;
                continue;
            }
            waiting.octets += octets(&input);
            waiting.queue.push_back(input);
            is_more = true;
        }
        while waiting.octets > MAX_WAITING_OCTETS {
            let Some(oldest) = waiting.queue.pop_front() else { break };
            waiting.octets -= octets(&oldest);
            waiting.dropped += oldest.datagrams.len() as u64;
        }
        if is_more {
            self.more.notify_one();
        }
    }

    /// Suspends or resumes publication. Returns the counters at that moment; while the gateway is silent `written` and `waiting`
    /// do not grow.
    fn set_silent(&self, is_silent: bool) -> GatewayCounts {
        let mut inputs = self.inputs();
        inputs.resumed += u64::from(inputs.is_silent && !is_silent);
        inputs.is_silent = is_silent;
        inputs.counts()
    }

    fn counts(&self) -> GatewayCounts {
        self.inputs().counts()
    }

    fn recent_datagrams(&self) -> Vec<(u64, i64)> {
        self.stamps.lock().unwrap_or_else(PoisonError::into_inner).recent()
    }
}

impl InputQueue {
    fn counts(&self) -> GatewayCounts {
        let Self { written, dropped, withheld, resumed, .. } = *self;
        GatewayCounts { written, waiting: self.queue.len() as u64, dropped, withheld, resumed }
    }
}

fn octets(input: &GatewayInput) -> usize {
    const OF_EACH: usize = 96;
    OF_EACH + input.datagrams.iter().map(|heard| OF_EACH + heard.payload.len()).sum::<usize>()
}

/// Writes the waiting messages in order. An unacknowledged message is written again with all that follow it; the log recognises
/// copies.
///
/// While there is no connection no message is handed to the client: it would wait there, with an outdated time of sending.
async fn write(log: Log, gateway: String, waiting: Arc<PendingInputs>) {
    loop {
        while !log.is_connected() {
            tokio::time::sleep(RETRY_PAUSE).await;
        }
        let next: Vec<GatewayInput> =
            waiting.inputs().queue.iter().take(MAX_UNACKNOWLEDGED).cloned().collect();
        if next.is_empty() {
            waiting.more.notified().await;
            continue;
        }
        let origin = InputOrigin { gateway: gateway.clone(), sent: now(), config: log.config };
        let sent: Vec<GatewayInput> =
            next.iter().map(|input| GatewayInput { origin: Some(origin.clone()), ..input.clone() }).collect();
        let written = join_all(sent.iter().map(|input| log.publish(input))).await;
        let stored = written.iter().take_while(|written| written.is_ok()).count();
        {
            let mut inputs = waiting.inputs();
            for input in &next[..stored] {
                // The message may have been dropped from the queue meanwhile. It is in the log nevertheless.
                if inputs.queue.front() == Some(input) {
                    inputs.queue.pop_front();
                    inputs.octets -= octets(input);
                }
            }
            inputs.written += stored as u64;
        }
        if let Some(Err(error)) = written.get(stored) {
            tracing::debug!(%error, "not written: tried again");
            tokio::time::sleep(RETRY_PAUSE).await;
        }
    }
}

/// Reports each second, and suspends publication while the clock is unfit.
async fn report_each_second(
    mut log: Log,
    cluster: Cluster,
    lines: Vec<(Arc<ConfiguredLine>, Arc<LineCounters>)>,
    waiting: Arc<PendingInputs>,
    clock_query: ClockQuery,
) {
    let (node, key) = (&cluster.node, format!("gateway.{}", cluster.node));
    let mut seconds = tokio::time::interval(REPORT_INTERVAL);
    let began = tokio::time::Instant::now();
    let (mut dropped, mut was_away, mut is_unexpected) = (0, false, true);
    let (mut rule, mut previous_clock) = (ClockRule::default(), None);
    let (mut own, mut was_wrong) = (MemberClock::default(), false);
    for report_number in 0.. {
        seconds.tick().await;
        let table = udp::kernel_table();
        lines.iter().for_each(|(_, counters)| counters.note_kernel_drops(&table));
        let status = |(line, counters): &(Arc<ConfiguredLine>, Arc<LineCounters>)| {
            (line.sensors.clone(), LineStatus::of(line.name(), counters, 0))
        };
        let lines: Vec<_> = lines.iter().map(status).collect();
        let asked = clock_query.state();
        let mut clock = rule.update_clock(asked.unwrap_or_default(), began.elapsed());
        let others = match report_times(&log, None).await {
            Ok((written, mut reports)) => {
                own.update((node, true), written, clocks());
                reports.retain(|report| report.node != *node);
                Some(reports)
            }
            Err(_) => None,
        };
        if rule.needs_others() {
            clock = rule.decide(&lines, others.as_deref(), began.elapsed());
        }
        let ahead_s = own.ahead_s();
        match (own.is_wrong(), std::mem::replace(&mut was_wrong, own.is_wrong())) {
            (true, false) => {
                warn!(ahead_s, "the clock of this machine is wrong: what is heard here is refused");
            }
            (false, true) => tracing::info!(ahead_s, "the clock of this machine is right again"),
            _ => {}
        }
        let counts = waiting.set_silent(clock.is_silent);
        if counts.dropped > dropped {
            warn!(datagrams = counts.dropped - dropped, "dropped: the log is away for too long");
            dropped = counts.dropped;
        }
        let recent_datagrams = waiting.recent_datagrams();
        let (node, config) = (node.clone(), log.config);
        let report = GatewayReport {
            node,
            counts,
            lines,
            report_number,
            clock,
            recent_datagrams,
            config,
            sent: now(),
            ahead_s,
        };
        if is_unexpected || report_number % REGISTRATION_INTERVAL == 0 {
            is_unexpected = log.expect_gateway(&report.node).await.is_err();
        }
        if asked.is_some() {
            log_clock_change(&report, previous_clock.replace(clock));
        }
        let octets = postcard::to_stdvec(&report).expect("it can be written");
        let is_away = log.put_entry(&key, octets).await.is_err();
        if is_away && let Ok(again) = log.reopen(&cluster).await {
            // Streams that the servers have lost are created again.
            log = again;
        }
        if is_away != was_away {
            match is_away {
                true => warn!("the log does not answer: what is heard waits"),
                false => tracing::info!("the log answers"),
            }
            was_away = is_away;
        }
    }
}

/// Logs a change of the clock's rating, and of the publication that follows from it.
fn log_clock_change(report: &GatewayReport, before: Option<GatewayClock>) {
    let GatewayClock { standing, is_silent, .. } = report.clock;
    if before.map(|before| before.standing) != Some(standing) {
        let state = report.state();
        let (clock, by) = (GatewayState { silent: false, ..state.clone() }.clock_text(), state.clock_by);
        match standing {
            ClockStanding::Good => tracing::info!(clock, ?by, "the clock of this machine is good"),
            _ => warn!(clock, ?by, "the clock of this machine is not known to be good"),
        }
    }
    if before.is_some_and(|before| before.is_silent) != is_silent {
        let withheld = report.counts.withheld;
        match is_silent {
            true => warn!("publishes nothing: the clock is not synchronised, and others carry what is heard"),
            false => tracing::info!(withheld, "publishes again what is heard"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::ReceivedDatagram;
    use fusion::slots::Slot;
    use fusion::time::Time;

    #[test]
    fn newest_64_mib_wait_and_dropped_datagrams_are_counted() {
        let waiting = PendingInputs::default();
        let address = SocketAddr::from(([127, 0, 0, 1], 8600));
        let datagram = ReceivedDatagram {
            received: Time::default(),
            from: address,
            to: address,
            payload: vec![0; 65_000],
        };
        let input = |slot| GatewayInput {
            origin: None,
            sensor: DataSource { sac: 1, sic: 2 },
            slot: Slot(slot),
            part: 0,
            is_last: true,
            datagrams: vec![datagram.clone(); 10],
        };
        waiting.add((0..150).map(input));
        let GatewayCounts { waiting: left, dropped, .. } = waiting.counts();
        assert_eq!(dropped, 10 * (150 - left), "each is there, or is counted");
        let inputs = waiting.inputs();
        let octets: usize = inputs.queue.iter().map(octets).sum();
        assert_eq!(inputs.octets, octets);
        assert!(
            octets <= MAX_WAITING_OCTETS && octets + self::octets(&input(0)) > MAX_WAITING_OCTETS,
            "{octets}"
        );
        let slots: Vec<i64> = inputs.queue.iter().map(|input| input.slot.0).collect();
        assert_eq!(slots, (150 - left as i64..150).collect::<Vec<_>>());
    }
    #[test]
    fn report_of_silence_counts_earlier_messages() {
        let waiting = PendingInputs::default();
        let address = SocketAddr::from(([127, 0, 0, 1], 8600));
        let heard =
            ReceivedDatagram { received: Time::default(), from: address, to: address, payload: vec![0; 9] };
        let input = |slot| GatewayInput {
            origin: None,
            sensor: DataSource { sac: 1, sic: 2 },
            slot: Slot(slot),
            part: 0,
            is_last: true,
            datagrams: vec![heard.clone(); 2],
        };
        waiting.add((0..3).map(input));
        let before = waiting.set_silent(true);
        waiting.add((3..7).map(input));
        let silent = waiting.set_silent(true);
        assert_eq!((before.written + before.waiting, before.withheld), (3, 0));
        assert_eq!((silent.written + silent.waiting, silent.withheld, silent.resumed), (3, 8, 0));
        let resumed = waiting.set_silent(false);
        waiting.add((7..8).map(input));
        assert_eq!((resumed.resumed, waiting.counts().waiting), (1, 4));
    }
}
