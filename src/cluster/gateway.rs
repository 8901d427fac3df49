//! A gateway: what comes on the lines goes into the log.

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
use serde::{Deserialize, Serialize};
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tracing::warn;

use super::batches::Batches;
use super::clocks::{ClockRule, GatewayClock, Keeper, Stamps};
use super::log::{Log, LogError};
use super::member_clock::{MemberClock, written};
use super::message::{Input, Origin};
use super::seat::clocks;
use crate::config::{Cluster, Config};
use crate::live::{Clock, ClockStanding, GatewayState, LineStatus, Listening, listen, now};
use crate::net::listen::{self as udp, Arrival, Line, LineCounters};
use fusion::slots::SlotGrid;
use fusion::time::Time;

/// Most octets that wait while the log is away: about a minute of a busy gateway. Then the oldest are dropped.
const WAITING: usize = 64 << 20;
/// Most messages that are sent before the log has acknowledged them.
const UNACKNOWLEDGED: usize = 256;
/// Pause before what was not acknowledged is sent again.
const AGAIN: Duration = Duration::from_millis(100);
/// Longest time between two looks at whether to stop.
const LOOK_UP: Duration = Duration::from_millis(100);
/// How often it says how it is.
const SAYS: Duration = Duration::from_secs(1);
/// And every so often of these times that it is to be missed where it says nothing.
const EXPECTED: u64 = 60;

/// What a gateway counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GatewayCounts {
    /// Messages in the log.
    pub written: u64,
    /// Messages that wait for it.
    pub waiting: u64,
    /// Datagrams that were dropped because the log was away for too long.
    pub dropped: u64,
    /// Datagrams that were not published because the clock is not fit, and others carry them.
    pub withheld: u64,
    /// How often the gateway has begun to publish again.
    pub resumed: u64,
}

/// What a gateway says of itself, each second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GatewayReport {
    /// Its name.
    pub node: String,
    /// What it counts.
    pub counts: GatewayCounts,
    /// Each of its lines, with the sensors on it, by their place in the configuration.
    pub lines: Vec<(Vec<usize>, LineStatus)>,
    /// How often it has said something: who says nothing new is gone.
    pub said: u64,
    /// How good its clock is.
    pub clock: GatewayClock,
    /// Some of the latest datagrams: hash, and when it heard them, nanoseconds since 1970.
    pub heard: Vec<(u64, i64)>,
    /// Hash of its shared configuration; 0: not stated.
    pub config: u64,
    /// When it said this, by its own clock.
    pub sent: Time,
    /// How far its clock is ahead of reference time, seconds; `None`: not known.
    pub ahead_s: Option<f64>,
}

impl GatewayReport {
    /// The reports of all gateways.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all(log: &Log) -> Result<Vec<Self>, LogError> {
        Ok(Self::all_stamped(log).await?.into_iter().map(|(_, report)| report).collect())
    }

    /// The same, each with the log's stamp.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all_stamped(log: &Log) -> Result<Vec<(Time, Self)>, LogError> {
        let read = |(name, stamp, said): (String, Time, Vec<u8>)| {
            let report = postcard::from_bytes(&said).ok().filter(|report: &Self| report.node == name);
            if report.is_none() {
                log.skips.unreadable("gateway", &said);
            }
            report.map(|report| (stamp, report))
        };
        Ok(log.all_said("gateway.").await?.into_iter().filter_map(read).collect())
    }
}

impl GatewayReport {
    /// As it is shown.
    pub fn state(&self) -> GatewayState {
        let Self { node, counts, lines, clock, ahead_s, .. } = self;
        let GatewayCounts { written, waiting, dropped, withheld, .. } = *counts;
        GatewayState {
            node: node.clone(),
            lines: lines.len() as u64,
            written,
            waiting,
            dropped,
            clock: clock.standing,
            clock_bound_s: clock.state.bound_s,
            clock_by: clock.state.by,
            unfit: clock.is_unfit,
            silent: clock.is_silent,
            withheld,
            clock_ahead_s: *ahead_s,
        }
    }
}

/// What waits for the log.
#[derive(Debug, Default)]
struct Waiting {
    inputs: Mutex<Inputs>,
    more: Notify,
    /// When it heard some of the latest datagrams, published or not.
    stamps: Mutex<Stamps>,
}

#[derive(Debug, Default)]
struct Inputs {
    queue: VecDeque<Input>,
    octets: usize,
    written: u64,
    dropped: u64,
    /// Whether the gateway publishes nothing.
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
    waiting: Arc<Waiting>,
    log: Log,
    name: String,
}

impl Gateway {
    /// Listens to the sensors, and writes what they send into the log.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(config: &Config, cluster: &Cluster, log: Log, runtime: &Handle) -> io::Result<Self> {
        let clock = Clock::default();
        let Listening { arrivals, lines, readers, .. } = listen(config, &clock, runtime);
        let feed = |(line, _): &(Arc<Line>, _)| {
            let sensor = &config.sensors[line.sensors[0]];
            (DataSource { sac: sensor.sac, sic: sensor.sic }, SocketAddr::from(line.destination()))
        };
        let mut batches =
            Batches::new(SlotGrid::new(config.fusion.slot), lines.iter().map(feed), clock.now());
        let stop = Arc::new(AtomicBool::new(false));
        let waiting = Arc::new(Waiting::default());
        let (stopped, queue) = (stop.clone(), waiting.clone());
        let thread = std::thread::Builder::new().name("gateway".to_owned()).spawn(move || {
            gather(&mut batches, &arrivals, &clock, &queue, &stopped);
            readers.stop();
        })?;
        let writing = runtime.spawn(write(log.clone(), cluster.node.clone(), waiting.clone()));
        let saying =
            runtime.spawn(say(log.clone(), cluster.clone(), lines, waiting.clone(), Keeper::start()?));
        Ok(Self { stop, thread, tasks: [writing, saying], waiting, log, name: cluster.node.clone() })
    }

    /// Whether one of its threads has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished() || self.tasks.iter().any(tokio::task::JoinHandle::is_finished)
    }

    /// Stops to listen, and waits until what was heard is in the log, for at most a second.
    pub async fn stop(self) {
        self.stop.store(true, Ordering::Relaxed);
        let Self { thread, tasks, waiting, log, name, .. } = self;
        drop(tokio::task::spawn_blocking(move || thread.join()).await);
        let written = async {
            while waiting.counts().waiting > 0 {
                tokio::time::sleep(AGAIN / 10).await;
            }
        };
        drop(tokio::time::timeout(Duration::from_secs(1), written).await);
        tasks.iter().for_each(tokio::task::JoinHandle::abort);
        // The gateway is no longer expected.
        _ = log.forget_gateway(&name).await;
    }
}

/// Hands on each slot when it is over.
fn gather(
    batches: &mut Batches,
    arrivals: &Receiver<Arrival>,
    clock: &Clock,
    waiting: &Waiting,
    stop: &AtomicBool,
) {
    while !stop.load(Ordering::Relaxed) {
        let wait = Duration::try_from(batches.ends() - clock.now()).unwrap_or_default();
        match arrivals.recv_timeout(wait.min(LOOK_UP)) {
            Ok(Arrival { line, received, from, payload }) => {
                waiting.add(batches.hear(line, received, from.into(), payload));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        waiting.add(batches.end(clock.now()));
    }
}

impl Waiting {
    fn inputs(&self) -> std::sync::MutexGuard<'_, Inputs> {
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, inputs: impl IntoIterator<Item = Input>) {
        let mut stamps = self.stamps.lock().unwrap_or_else(PoisonError::into_inner);
        let mut waiting = self.inputs();
        let mut is_more = false;
        for input in inputs {
            stamps.note(&input);
            if waiting.is_silent {
                waiting.withheld += input.heard.len() as u64;
                continue;
            }
            waiting.octets += octets(&input);
            waiting.queue.push_back(input);
            is_more = true;
        }
        while waiting.octets > WAITING {
            let Some(oldest) = waiting.queue.pop_front() else { break };
            waiting.octets -= octets(&oldest);
            waiting.dropped += oldest.heard.len() as u64;
        }
        if is_more {
            self.more.notify_one();
        }
    }

    /// Publishes nothing from now on, or publishes again. The counts of that moment: nothing is added to what is written and what
    /// waits while the gateway is silent.
    fn silence(&self, is_silent: bool) -> GatewayCounts {
        let mut inputs = self.inputs();
        inputs.resumed += u64::from(inputs.is_silent && !is_silent);
        inputs.is_silent = is_silent;
        inputs.counts()
    }

    fn counts(&self) -> GatewayCounts {
        self.inputs().counts()
    }

    fn heard(&self) -> Vec<(u64, i64)> {
        self.stamps.lock().unwrap_or_else(PoisonError::into_inner).said()
    }
}

impl Inputs {
    fn counts(&self) -> GatewayCounts {
        let Self { written, dropped, withheld, resumed, .. } = *self;
        GatewayCounts { written, waiting: self.queue.len() as u64, dropped, withheld, resumed }
    }
}

fn octets(input: &Input) -> usize {
    const OF_EACH: usize = 96;
    OF_EACH + input.heard.iter().map(|heard| OF_EACH + heard.payload.len()).sum::<usize>()
}

/// Writes what waits, in order. What was not acknowledged is written again, with what came after it: the log knows copies.
///
/// Nothing is handed to the client while there is no connection: it would wait there, and state a time of sending that is long past.
async fn write(log: Log, gateway: String, waiting: Arc<Waiting>) {
    loop {
        while !log.is_connected() {
            tokio::time::sleep(AGAIN).await;
        }
        let next: Vec<Input> = waiting.inputs().queue.iter().take(UNACKNOWLEDGED).cloned().collect();
        if next.is_empty() {
            waiting.more.notified().await;
            continue;
        }
        let origin = Origin { gateway: gateway.clone(), sent: now(), config: log.config };
        let sent: Vec<Input> =
            next.iter().map(|input| Input { origin: Some(origin.clone()), ..input.clone() }).collect();
        let written = join_all(sent.iter().map(|input| log.publish(input))).await;
        let stored = written.iter().take_while(|written| written.is_ok()).count();
        {
            let mut inputs = waiting.inputs();
            for input in &next[..stored] {
                // What was dropped meanwhile is in the log all the same.
                if inputs.queue.front() == Some(input) {
                    inputs.queue.pop_front();
                    inputs.octets -= octets(input);
                }
            }
            inputs.written += stored as u64;
        }
        if let Some(Err(error)) = written.get(stored) {
            tracing::debug!(%error, "not written: tried again");
            tokio::time::sleep(AGAIN).await;
        }
    }
}

/// Says each second how it is, and is silent where its clock is not to be used.
async fn say(
    mut log: Log,
    cluster: Cluster,
    lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    waiting: Arc<Waiting>,
    keeper: Keeper,
) {
    let (node, key) = (&cluster.node, format!("gateway.{}", cluster.node));
    let mut seconds = tokio::time::interval(SAYS);
    let began = tokio::time::Instant::now();
    let (mut dropped, mut was_away, mut is_unexpected) = (0, false, true);
    let (mut rule, mut told) = (ClockRule::default(), None);
    let (mut own, mut was_wrong) = (MemberClock::default(), false);
    for said in 0.. {
        seconds.tick().await;
        let table = udp::kernel_table();
        lines.iter().for_each(|(_, counters)| counters.note_kernel_drops(&table));
        let status = |(line, counters): &(Arc<Line>, Arc<LineCounters>)| {
            (line.sensors.clone(), LineStatus::of(line.name(), counters, 0))
        };
        let lines: Vec<_> = lines.iter().map(status).collect();
        let asked = keeper.state();
        let mut clock = rule.note(asked.unwrap_or_default(), began.elapsed());
        let others = match written(&log, None).await {
            Ok((written, mut reports)) => {
                own.look((node, true), written, clocks());
                reports.retain(|report| report.node != *node);
                Some(reports)
            }
            Err(_) => None,
        };
        if rule.wants_others() {
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
        let counts = waiting.silence(clock.is_silent);
        if counts.dropped > dropped {
            warn!(datagrams = counts.dropped - dropped, "dropped: the log is away for too long");
            dropped = counts.dropped;
        }
        let heard = waiting.heard();
        let (node, config) = (node.clone(), log.config);
        let report = GatewayReport { node, counts, lines, said, clock, heard, config, sent: now(), ahead_s };
        if is_unexpected || said % EXPECTED == 0 {
            is_unexpected = log.expect_gateway(&report.node).await.is_err();
        }
        if asked.is_some() {
            tell(&report, told.replace(clock));
        }
        let octets = postcard::to_stdvec(&report).expect("it can be written");
        let is_away = log.say(&key, octets).await.is_err();
        if is_away && let Ok(again) = log.again(&cluster).await {
            // What the servers lost is there again.
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

/// A line of the log where the clock is worth another thing than before, or for that reason something else is done.
fn tell(report: &GatewayReport, before: Option<GatewayClock>) {
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
    use crate::cluster::message::Heard;
    use fusion::slots::Slot;

    #[test]
    fn while_the_log_is_away_the_newest_64_mib_wait_and_what_was_dropped_is_counted() {
        let waiting = Waiting::default();
        let address = SocketAddr::from(([127, 0, 0, 1], 8600));
        let datagram =
            Heard { received: Time::default(), from: address, to: address, payload: vec![0; 65_000] };
        let input = |slot| Input {
            origin: None,
            sensor: DataSource { sac: 1, sic: 2 },
            slot: Slot(slot),
            part: 0,
            is_last: true,
            heard: vec![datagram.clone(); 10],
        };
        waiting.add((0..150).map(input));
        let GatewayCounts { waiting: left, dropped, .. } = waiting.counts();
        assert_eq!(dropped, 10 * (150 - left), "each is there, or is counted");
        let inputs = waiting.inputs();
        let octets: usize = inputs.queue.iter().map(octets).sum();
        assert_eq!(inputs.octets, octets);
        assert!(octets <= WAITING && octets + self::octets(&input(0)) > WAITING, "{octets}");
        let slots: Vec<i64> = inputs.queue.iter().map(|input| input.slot.0).collect();
        assert_eq!(slots, (150 - left as i64..150).collect::<Vec<_>>());
    }
    #[test]
    fn report_of_silence_counts_what_was_handed_on_before_it() {
        let waiting = Waiting::default();
        let address = SocketAddr::from(([127, 0, 0, 1], 8600));
        let heard = Heard { received: Time::default(), from: address, to: address, payload: vec![0; 9] };
        let input = |slot| Input {
            origin: None,
            sensor: DataSource { sac: 1, sic: 2 },
            slot: Slot(slot),
            part: 0,
            is_last: true,
            heard: vec![heard.clone(); 2],
        };
        waiting.add((0..3).map(input));
        let before = waiting.silence(true);
        waiting.add((3..7).map(input));
        let silent = waiting.silence(true);
        assert_eq!((before.written + before.waiting, before.withheld), (3, 0));
        assert_eq!((silent.written + silent.waiting, silent.withheld, silent.resumed), (3, 8, 0));
        let speaks = waiting.silence(false);
        waiting.add((7..8).map(input));
        assert_eq!((speaks.resumed, waiting.counts().waiting), (1, 4));
    }
}
