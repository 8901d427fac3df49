//! Three nodes, two gateways, and a log that is slow, leaves requests unanswered, or loses its leader or the connection to a
//! node.

mod gateways;

use std::collections::{BTreeSet, VecDeque};

use asterix::DataSource;
use fusion::slots::SlotGrid;
use fusion::time::Time;
use jiff::SignedDuration;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cell::{AppendResult, Cell, CellEngine, CellLoss, InputRecord, LogRequest, Tail};
use crate::message::{CellOutput, LoggedMessage};
use crate::overload::SheddingLevel;
use crate::reference_clock::ClockReading;
use crate::region::CellMessage;
pub(super) use gateways::{ClockOwner, Clocks, Sent};
use gateways::{SimulatedGateway, header};

const STEP_MS: i64 = 20;
pub(super) const LASTS_MS: i64 = 60_000;
/// Period in which faults start, so that all members can recover afterwards.
const FAULTS_MS: std::ops::Range<i64> = 3_000..42_000;
/// Time until a restarted gateway has a vote, with a margin, in milliseconds.
const SETTLES_MS: i64 = 4_000;
/// Time for which a node waits for sensors.
pub(super) const WAIT: SignedDuration = SignedDuration::from_millis(500);
const LEASE_MS: i64 = 3_000;
const RENEWED_MS: i64 = 900;
const CHECKPOINT_MS: i64 = 5_000;
/// Timeout of requests to the log.
const PATIENCE_MS: i64 = 1_000;
const NODES: usize = 3;
const GATEWAYS: usize = 2;

/// Sensor data: time in milliseconds, sensor, and octets.
pub(super) type Feed = Vec<(i64, DataSource, Vec<u8>)>;

/// An engine of a node.
pub(super) trait Engine: CellEngine {
    /// Creates an engine without data.
    fn new() -> Self;

    /// Serialises the state.
    fn written(&self) -> Vec<u8>;

    /// Restores the state.
    fn read(octets: &[u8]) -> Self;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The owner's process is killed, and starts again after some seconds.
    Kill,
    /// The owner's process is suspended for some seconds.
    Pause,
    /// The log has no leader: no request is answered, and half of them are executed nevertheless.
    Leaderless,
    /// The owner and the log cannot reach each other.
    Partition,
    /// A gateway ends, and starts again.
    Gateway,
}

/// Faults with start and end, in milliseconds.
#[derive(Clone, Debug)]
pub(super) struct Faults(Vec<(Fault, i64, i64)>);

impl Faults {
    pub(super) const fn none() -> Self {
        Self(Vec::new())
    }

    pub(super) fn only(seed: u64, fault: Fault) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xfa17);
        let from = random.random_range(10_000..30_000);
        Self(vec![(fault, from, from + random.random_range(200..10_000))])
    }

    pub(super) fn any(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xa11);
        let kinds = [Fault::Kill, Fault::Pause, Fault::Leaderless, Fault::Partition, Fault::Gateway];
        let count = random.random_range(3..12);
        let fault = |_| {
            let from = random.random_range(FAULTS_MS);
            (kinds[random.random_range(0..kinds.len())], from, from + random.random_range(100..9_000))
        };
        Self((0..count).map(fault).collect())
    }

    /// Removes gateway faults while the log's or the other gateway's clock is wrong: of two clocks there is no majority.
    pub(super) fn without_gateways(self, clocks: &Clocks) -> Self {
        let is_apart = |(fault, from, until): &(Fault, i64, i64)| {
            *fault != Fault::Gateway || !clocks.is_wrong_within(from - SETTLES_MS..until + SETTLES_MS)
        };
        Self(self.0.into_iter().filter(is_apart).collect())
    }
}

/// Model of the log.
#[derive(Debug, Default)]
struct LogModel {
    inputs: Vec<LoggedMessage>,
    /// Timestamp of each input, by the clock of the log's leader.
    stamps: Vec<Time>,
    /// True values of each message that a gateway sent.
    sent: Vec<Option<Sent>>,
    /// True time of each output.
    written_at: Vec<i64>,
    clock_ms: i64,
    now: i64,
    /// Identifiers of the inputs, for recognising copies.
    ids: Vec<String>,
    outputs: Vec<CellOutput>,
    /// Lease number, node, and time of expiry.
    lease: Option<(u64, usize, i64)>,
    leases: u64,
    checkpoint: Option<(Vec<u8>, u64, u64)>,
    refused: usize,
}

impl LogModel {
    /// Writes an input unless it is a copy. Now and then a copy is not recognised.
    fn write(&mut self, logged: LoggedMessage, sent: Option<Sent>, random: &mut ChaCha8Rng) {
        let id = logged.id();
        let is_copy = self.ids.iter().rev().take(40).any(|known| *known == id);
        if !is_copy || random.random_bool(0.05) {
            self.inputs.push(logged);
            self.stamps.push(time(self.now + self.clock_ms));
            self.sent.push(sent);
            self.ids.push(id);
        }
    }

    fn append(&mut self, expected: u64, output: CellOutput) -> AppendResult {
        if self.outputs.len() as u64 != expected {
            self.refused += 1;
            return AppendResult::Refused;
        }
        self.outputs.push(output);
        self.written_at.push(self.now);
        AppendResult::Stored(self.outputs.len() as u64)
    }

    fn create_lease(&mut self, node: usize, now: i64) -> Option<u64> {
        if self.lease.is_some_and(|(_, _, until)| now < until) {
            return None;
        }
        self.leases += 1;
        self.lease = Some((self.leases, node, now + LEASE_MS));
        Some(self.leases)
    }

    fn renew(&mut self, epoch: u64, now: i64) -> bool {
        match &mut self.lease {
            Some((of, _, until)) if *of == epoch && now < *until => {
                *until = now + LEASE_MS;
                true
            }
            _ => false,
        }
    }
}

/// An answer on its way to a node.
#[derive(Debug)]
enum Answer {
    Lease(Option<u64>),
    Tail(Result<Tail, ()>),
    Appended(AppendResult),
}

#[derive(Debug)]
struct SimulatedNode<E> {
    cell: Option<Cell<E>>,
    /// Time by which the node's clock is ahead.
    clock_ms: i64,
    /// Numbers of inputs and outputs delivered by the log.
    read: (usize, usize),
    /// Times at which the node starts again or continues.
    down_until: i64,
    paused_until: i64,
    cut_until: i64,
    answer: Option<(i64, Answer)>,
    epoch: Option<u64>,
    /// Messages that are not in the log yet.
    post: VecDeque<CellMessage>,
    renews_at: i64,
    writes_at: i64,
}

pub(super) struct World<E> {
    feed: Feed,
    sensors: BTreeSet<DataSource>,
    random: ChaCha8Rng,
    faults: Faults,
    log: LogModel,
    nodes: Vec<SimulatedNode<E>>,
    gateways: [SimulatedGateway; GATEWAYS],
    /// Messages on their way to the log.
    sent: VecDeque<gateways::InTransit>,
    clocks: Clocks,
    /// Whether messages are written that no member would write.
    is_odd: bool,
    now: i64,
    takeovers: usize,
    lost: usize,
    last_output: (usize, i64),
    silence_ms: i64,
    /// Whether owners change their level of load shedding at random.
    relieves: bool,
}

/// Start of the simulation, in milliseconds since 1970.
pub(super) const BEGINS_MS: i64 = 1_795_168_800_000;

fn time(ms: i64) -> Time {
    Time::from_nanos((BEGINS_MS + ms) * 1_000_000)
}

impl<E: Engine> World<E> {
    pub(super) fn new(seed: u64, faults: Faults, feed: Feed) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let node = |_| SimulatedNode {
            cell: None,
            clock_ms: random.random_range(-100..100),
            read: (0, 0),
            down_until: 0,
            paused_until: 0,
            cut_until: 0,
            answer: None,
            epoch: None,
            post: VecDeque::new(),
            renews_at: 0,
            writes_at: CHECKPOINT_MS,
        };
        let nodes = (0..NODES).map(node).collect();
        Self {
            sensors: feed.iter().map(|(_, sensor, _)| *sensor).collect(),
            feed,
            random,
            faults,
            log: LogModel::default(),
            nodes,
            gateways: <[SimulatedGateway; GATEWAYS]>::default(),
            sent: VecDeque::new(),
            clocks: Clocks::default(),
            is_odd: false,
            now: 0,
            takeovers: 0,
            lost: 0,
            last_output: (0, 8_000),
            silence_ms: 0,
            relieves: false,
        }
    }

    /// Makes owners change their level of load shedding at random, as if they could not keep up.
    pub(super) fn relieving(self) -> Self {
        Self { relieves: true, ..self }
    }

    pub(super) fn inputs(&self) -> &[LoggedMessage] {
        &self.log.inputs
    }

    pub(super) fn outputs(&self) -> &[CellOutput] {
        &self.log.outputs
    }

    pub(super) const fn takeovers(&self) -> usize {
        self.takeovers
    }

    pub(super) const fn refused(&self) -> usize {
        self.log.refused
    }

    pub(super) const fn lost(&self) -> usize {
        self.lost
    }

    /// Longest time without an output after the first one, in seconds.
    pub(super) fn silence_s(&self) -> f64 {
        self.silence_ms as f64 * 1e-3
    }

    pub(super) fn run(&mut self) {
        while self.now < LASTS_MS {
            self.log.now = self.now;
            self.log.clock_ms = self.clocks.error_ms(ClockOwner::Log, self.now);
            self.strike();
            self.gather();
            for index in 0..NODES {
                self.step(index);
            }
            if self.log.outputs.len() > self.last_output.0 {
                self.last_output = (self.log.outputs.len(), self.now);
            } else if self.last_output.0 > 0 {
                self.silence_ms = self.silence_ms.max(self.now - self.last_output.1);
            }
            self.now += STEP_MS;
        }
        let behind_ms = self.now - self.last_output.1;
        assert!(
            behind_ms < 2_500,
            "nothing was published in the last {behind_ms} ms: {:?} {:?}",
            self.faults,
            self.clocks
        );
    }

    fn is_leaderless(&self) -> bool {
        self.faults
            .0
            .iter()
            .any(|(fault, from, until)| *fault == Fault::Leaderless && (*from..*until).contains(&self.now))
    }

    /// Applies the faults that start now, mostly to the owner.
    fn strike(&mut self) {
        let owner = self.nodes.iter().position(|node| node.cell.as_ref().is_some_and(Cell::owns));
        let victim = owner.filter(|_| self.random.random_bool(0.8));
        let victim = victim.unwrap_or_else(|| self.random.random_range(0..NODES));
        for &(fault, from, until) in &self.faults.0 {
            if !(from..from + STEP_MS).contains(&self.now) {
                continue;
            }
            let node = &mut self.nodes[victim];
            match fault {
                Fault::Kill => {
                    (node.cell, node.answer, node.epoch) = (None, None, None);
                    node.post.clear();
                    node.down_until = until;
                }
                Fault::Pause => node.paused_until = until,
                Fault::Partition => node.cut_until = until,
                Fault::Gateway => self.gateways[victim % GATEWAYS].down_until = until,
                Fault::Leaderless => {}
            }
        }
    }

    fn step(&mut self, index: usize) {
        let now = self.now;
        if now < self.nodes[index].down_until || now < self.nodes[index].paused_until {
            return;
        }
        if self.nodes[index].cell.is_none() {
            self.begin(index);
        }
        if let Err(lost) = self.work(index) {
            let node = &mut self.nodes[index];
            (node.cell, node.answer, node.epoch) = (None, None, None);
            node.post.clear();
            self.lost += 1;
            // Start from the next checkpoint, unless there is already a newer one.
            if lost == CellLoss::Behind {
                node.down_until = now + 1_000;
            }
        }
    }

    /// Starts from the newest checkpoint, or without a state if nothing was published.
    fn begin(&mut self, index: usize) {
        let (engine, handled, published) = match &self.log.checkpoint {
            Some((engine, handled, published)) => (E::read(engine), *handled, *published),
            None => (E::new(), 0, 0),
        };
        let node = &mut self.nodes[index];
        node.read = (handled as usize, published as usize);
        node.cell = Some(Cell::new(engine, SlotGrid::default(), WAIT, handled, published));
    }

    fn work(&mut self, index: usize) -> Result<(), CellLoss> {
        let (now, is_leaderless) = (self.now, self.is_leaderless());
        let has_faults = self.faults.0.len() > 1;
        let Self { nodes, log, random, takeovers, relieves, clocks, .. } = self;
        let node = &mut nodes[index];
        let wall = time(now + node.clock_ms + clocks.error_ms(ClockOwner::Node(index), now));
        let at = ClockReading { steady: SignedDuration::from_millis(now), wall };
        let Some(cell) = &mut node.cell else { return Ok(()) };
        let is_cut = now < node.cut_until;
        if let Some((_, answer)) = node.answer.take_if(|(at, _)| *at <= now) {
            match answer {
                Answer::Lease(epoch) => {
                    node.epoch = epoch;
                    node.renews_at = now + RENEWED_MS;
                    *takeovers += usize::from(epoch.is_some());
                    cell.handle_lease(epoch);
                }
                Answer::Tail(last) => cell.handle_tail(last)?,
                Answer::Appended(appended) => cell.handle_append(appended),
            }
        }
        // Deliveries are late and in order, and sometimes pause.
        if !is_cut && random.random_bool(0.8) {
            for (index, logged) in log.inputs.iter().enumerate().skip(node.read.0) {
                let (stamp, has_more) = (log.stamps[index], index + 1 < log.inputs.len());
                let (header, logged) = (header(logged), Some(logged.clone()));
                cell.read_input(index as u64 + 1, InputRecord { stamp, at, header, logged, has_more });
            }
            node.read.0 = log.inputs.len();
        }
        if !is_cut && random.random_bool(0.8) {
            for (sequence, output) in log.outputs.iter().enumerate().skip(node.read.1) {
                cell.handle_output(sequence as u64 + 1, output.clone())?;
            }
            node.read.1 = log.outputs.len();
        }
        if !is_cut && !is_leaderless {
            cell.set_lease_held(log.lease.is_some_and(|(_, _, until)| now < until));
            // A node that continues after a pause may send any request first.
            if let Some(epoch) = node.epoch
                && now >= node.renews_at
                && random.random_bool(0.3)
            {
                node.renews_at = now + RENEWED_MS;
                if !log.renew(epoch, now) {
                    // The lease has expired. The first node to create it continues.
                    let Some(again) = log.create_lease(index, now) else { return Err(CellLoss::Fenced) };
                    node.epoch = Some(again);
                    cell.handle_recreated_lease(again);
                }
            }
        }
        if *relieves && cell.owns() && random.random_bool(0.02) {
            cell.set_level(SheddingLevel(random.random_range(0..8)));
        }
        cell.request_rest(now >= node.writes_at && !is_cut && !is_leaderless);
        cell.pump(at)?;
        node.post.extend(std::iter::from_fn(|| cell.next_message()));
        while !is_cut
            && !is_leaderless
            && random.random_bool(0.7)
            && let Some(message) = node.post.pop_front()
        {
            log.write(LoggedMessage::Message(Box::new(message)), None, random);
        }
        if let Some(request) = cell.next_request() {
            // Now and then an answer is lost, in schedules with several faults.
            let is_lost = has_faults && random.random_bool(0.01);
            let is_answered = !is_cut && !is_leaderless && !is_lost;
            let is_done = is_answered || (!is_cut && random.random_bool(0.5));
            let at = match is_answered {
                true => now + random.random_range(2..60),
                false => now + PATIENCE_MS,
            };
            let answer = match request {
                LogRequest::Lease => {
                    let lease = is_done.then(|| log.create_lease(index, now)).flatten();
                    Answer::Lease(lease.filter(|_| is_answered))
                }
                LogRequest::Tail(after) => {
                    let outputs = (1..).zip(log.outputs.iter().cloned()).skip(after as usize).collect();
                    let is_mine = log
                        .lease
                        .is_some_and(|(of, by, until)| by == index && node.epoch == Some(of) && now < until);
                    let tail = Tail { outputs, last: log.outputs.len() as u64, is_complete: true, is_mine };
                    Answer::Tail(if is_answered { Ok(tail) } else { Err(()) })
                }
                LogRequest::Append { expected, output } => {
                    let appended = if is_done { log.append(expected, output) } else { AppendResult::Unknown };
                    Answer::Appended(if is_answered { appended } else { AppendResult::Unknown })
                }
            };
            node.answer = Some((at, answer));
        }
        if now >= node.writes_at
            && !is_cut
            && !is_leaderless
            && let Some((handled, published)) = cell.rest_sequences()
        {
            node.writes_at = now + CHECKPOINT_MS;
            if published > 0 {
                log.checkpoint = Some((cell.engine().written(), handled, published));
            }
        }
        Ok(())
    }
}
