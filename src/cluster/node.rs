//! A node: for each cell it holds, a thread with the engine, and tasks that speak with the log for it.
//!
//! Who wants a cell takes the seat beside its owner first, and follows; so nobody owns a cell whose state it has not. There is one
//! such seat a cell: others wait until it is free.

mod counts;
mod keep;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use jiff::SignedDuration;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::sync::watch;
use tokio::task::{JoinHandle, JoinSet};
use tracing::{Instrument, error_span, info, warn};

use super::cell::{Appended, Cell, Lost, Wish};
use super::engine::SiteEngine;
use super::log::{Checkpoint, Holder, Log, LogError, Reading, Renewed, placed};
use super::message::{Input, Output};
use super::seat::{Says, Told, tell, work};
use crate::areas::Areas;
use crate::config::{Cluster, Config};
use crate::live::now;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;

pub use counts::{CellCounts, NodeReport, Part};

/// Pause before the log is asked again.
const AGAIN: Duration = Duration::from_millis(250);
/// The same where a slot waits for it.
const SOON: Duration = Duration::from_millis(50);
/// How often it says how it is.
const SAYS: Duration = Duration::from_secs(1);
/// Pause of a node that cannot follow the owner, while others may.
const UNFIT: Duration = Duration::from_secs(5);
/// Refusals after which it is looked whether there is anything to take.
const LOST: u32 = 8;

/// A running node.
#[derive(Debug)]
pub struct Node {
    stop: Arc<watch::Sender<bool>>,
    say: JoinHandle<()>,
    part: JoinHandle<()>,
    counts: Arc<Mutex<CellCounts>>,
}

/// What all of a node's tasks know.
#[derive(Clone)]
struct Desk {
    log: Log,
    cluster: Cluster,
    config: Arc<Config>,
    areas: Areas,
    cell: String,
    me: Holder,
    counts: Arc<Mutex<CellCounts>>,
    stop: watch::Receiver<bool>,
}

impl Node {
    /// Takes part in a cell; within a runtime.
    pub fn start(
        config: Arc<Config>,
        cluster: &Cluster,
        areas: Areas,
        cell: &str,
        me: Holder,
        log: Log,
    ) -> Self {
        let (stop, stopped) = watch::channel(false);
        let stop = Arc::new(stop);
        let counts = Arc::<Mutex<CellCounts>>::default();
        let desk = Desk {
            log,
            cluster: cluster.clone(),
            config,
            areas,
            cell: cell.to_owned(),
            me,
            counts: counts.clone(),
            stop: stopped,
        };
        let span = error_span!("cell", name = cell);
        let say = tokio::spawn(desk.clone().say(stop.clone()));
        let part = tokio::spawn(desk.take_part().instrument(span));
        Self { stop, say, part, counts }
    }

    /// What it counts.
    pub fn counts(&self) -> CellCounts {
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether one of its tasks has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.say.is_finished() || (self.part.is_finished() && !*self.stop.borrow())
    }

    /// Gives up its cells, so that whoever stands by goes on at once, and ends.
    pub async fn stop(self) {
        self.stop.send_replace(true);
        drop(self.part.await);
        self.say.abort();
    }
}

/// Why a node is no longer at a cell.
enum Left {
    /// It is to end.
    Stopped,
    /// It has to begin anew; the last output that it had made as it was published.
    Lost(Lost, u64),
    /// Another one has its seat: it was away for too long.
    Unseated,
}

impl Desk {
    fn note(&self, note: impl FnOnce(&mut CellCounts)) {
        note(&mut self.counts.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn owner(&self) -> String {
        format!("{}.owner", self.cell)
    }

    fn standby(&self) -> String {
        format!("{}.standby", self.cell)
    }

    fn wanted(&self) -> String {
        format!("{}.wanted", self.cell)
    }

    fn lease(&self) -> Duration {
        Duration::from_secs_f64(self.cluster.lease_s)
    }

    fn is_stopped(&self) -> bool {
        *self.stop.borrow()
    }

    async fn pause(&self, pause: Duration) {
        let mut stop = self.stop.clone();
        tokio::select! {
            () = tokio::time::sleep(pause) => {}
            _ = stop.wait_for(|stop| *stop) => {}
        }
    }

    /// Says each second how this node is, and looks whether it is to give up its cells.
    async fn say(self, stop: Arc<watch::Sender<bool>>) {
        let drained = format!("drain.{}", self.me.node);
        loop {
            let counts = *self.counts.lock().unwrap_or_else(PoisonError::into_inner);
            let report = NodeReport {
                holder: self.me.clone(),
                cells: vec![(self.cell.clone(), counts)],
                is_draining: self.is_stopped(),
            };
            let octets = postcard::to_stdvec(&report).expect("it can be written");
            // Who hears nothing of it for some seconds takes it to be gone.
            _ = self.log.say(&format!("node.{}", self.me.node), octets).await;
            if let Ok(Some(run)) = self.log.said(&drained).await
                && *run == *self.me.run.to_string().as_bytes()
                && !stop.send_replace(true)
            {
                info!("drained: it takes no cell until it is started anew");
            }
            tokio::time::sleep(SAYS).await;
        }
    }

    /// Takes the seat beside the owner whenever that is free, and stays until it is lost.
    async fn take_part(mut self) {
        let mut refused = 0_u32;
        // Where its picture differed from the owner's: from a state of before it would do so again.
        let mut from = 0;
        while !self.is_stopped() {
            if self.is_for_others().await {
                self.pause(AGAIN).await;
                continue;
            }
            let Some(seat) = self.log.take(&self.standby(), &self.me).await else {
                refused += 1;
                if refused.is_multiple_of(LOST)
                    && let Ok(log) = self.log.again(&self.cluster).await
                {
                    self.log = log;
                }
                self.pause(AGAIN).await;
                continue;
            };
            match self.stay(seat, from).await {
                Ok(Left::Stopped) => {}
                Ok(Left::Lost(lost, published)) => {
                    warn!(reason = %lost, "begins anew");
                    if lost == Lost::Diverged {
                        from = published + 1;
                    }
                    self.note(|counts| match lost {
                        Lost::Fenced => counts.fenced += 1,
                        Lost::Diverged => counts.diverged += 1,
                        Lost::Behind => {}
                    });
                }
                Ok(Left::Unseated) => {
                    info!("does not stand by: another node may");
                    // Or the streams were lost, and their sequences with them.
                    from = 0;
                }
                Err(error) => {
                    info!(%error, "waits for the log");
                    self.pause(AGAIN).await;
                }
            }
            self.note(|counts| (counts.part, counts.epoch, counts.behind) = (Part::None, 0, 0));
            // Streams may have been lost, and with them what the sequences mean.
            if let Ok(log) = self.log.again(&self.cluster).await {
                self.log = log;
            }
        }
    }

    /// Whether the owner is on this machine, and a node of another one wants to stand by.
    async fn is_for_others(&self) -> bool {
        match self.log.holder(&self.owner()).await {
            Ok(Some(owner)) if owner.by.node == self.me.node => owner.by.run == self.me.run,
            Ok(Some(owner)) => owner.by.machine == self.me.machine && self.has_other_machine().await,
            _ => false,
        }
    }

    async fn has_other_machine(&self) -> bool {
        let Ok(keys) = self.log.keys().await else { return false };
        for key in keys.iter().filter(|key| key.starts_with("node.")) {
            if let Ok(Some(said)) = self.log.said(key).await
                && let Ok(report) = postcard::from_bytes::<NodeReport>(&said)
                && report.holder.machine != self.me.machine
                && !report.is_draining
            {
                return true;
            }
        }
        false
    }

    /// Follows the owner from a state of that output or a later one, and owns the cell when nobody does, until it is lost.
    async fn stay(&self, seat: u64, from: u64) -> Result<Left, LogError> {
        let mut seat = seat;
        let Some((cell, handled, published)) = self.begin(&mut seat, from).await? else {
            return Ok(Left::Unseated);
        };
        self.note(|counts| counts.part = Part::Standby);
        info!(input = handled, output = published, "stands by");
        let (to_cell, told) = std::sync::mpsc::channel();
        let (says, said) = unbounded_channel();
        let name = self.me.node.clone();
        let thread = std::thread::Builder::new()
            .name(format!("cell {}", self.cell))
            .spawn(move || work(cell, &name, &told, &says))
            .map_err(|error| LogError::Unusable(error.to_string()))?;
        let (held, holding) = watch::channel(None);
        let mut tasks = JoinSet::new();
        tasks.spawn(read(self.log.inputs(handled + 1), to_cell.clone(), |sequence, octets| {
            Input::parse(octets).ok().map(|input| Told::Input(sequence, input))
        }));
        tasks.spawn(read(
            self.log.outputs(&self.cell, published + 1),
            to_cell.clone(),
            |sequence, octets| Output::parse(octets).ok().map(|output| Told::Output(sequence, output)),
        ));
        tasks.spawn(self.clone().keep(seat, to_cell.clone(), held.clone(), holding.clone()));
        let left = self.serve(said, &to_cell, &held, &mut tasks).await;
        // Whoever stands by goes on at once.
        tell(&to_cell, Told::Stop);
        tasks.abort_all();
        drop(tokio::task::spawn_blocking(move || thread.join()).await);
        let lease = *holding.borrow();
        match lease {
            Some(lease) if matches!(left, Left::Stopped) => _ = self.log.give_up(&self.owner(), lease).await,
            Some(_) => {}
            None => _ = self.log.give_up(&self.standby(), seat).await,
        }
        Ok(left)
    }

    /// The cell as it was when the newest checkpoint was written, with its sequences; where nobody owns it and there is no such
    /// state, as of now. `None`: it took too long, and the seat is another's.
    async fn begin(
        &self,
        seat: &mut u64,
        from: u64,
    ) -> Result<Option<(Cell<SiteEngine>, u64, u64)>, LogError> {
        let grid = SlotGrid::new(self.config.fusion.slot);
        let wait = SignedDuration::from_nanos((self.cluster.wait_s * 1e9) as i64);
        let anew = || SiteEngine::new(Config::clone(&self.config), self.areas.masks(), now());
        loop {
            let oldest = self.log.oldest_input().await?;
            let checkpoint = self.log.checkpoint(&self.cell).await?;
            let known = match &checkpoint {
                Some(kept) if kept.published < from => false,
                Some(kept) => self.log.knows(kept).await?,
                None => false,
            };
            if let Some(Checkpoint { handled, published, engine, .. }) = checkpoint.as_ref().filter(|_| known)
            {
                match anew().restored(self.areas.masks(), engine) {
                    Ok(engine) => {
                        let cell = Cell::new(engine, grid, wait, *handled, *published);
                        return Ok(Some((cell, *handled, *published)));
                    }
                    // Another node may be of the owner's version, and of its configuration.
                    Err(error) if self.log.holder(&self.owner()).await?.is_some() => {
                        warn!(%error, "the owner's checkpoint does not fit: cannot stand by");
                        _ = self.log.give_up(&self.standby(), *seat).await;
                        self.pause(UNFIT).await;
                        return Ok(None);
                    }
                    Err(error) => warn!(%error, "the checkpoint does not fit"),
                }
            }
            if self.log.holder(&self.owner()).await?.is_none() {
                let last = self.log.last(&self.cell).await?;
                let (published, slot) =
                    last.map_or((0, None), |(sequence, last)| (sequence, Some(last.slot)));
                // What was due by now is nobody's any more.
                let due = self.config.fusion.latency();
                let by_now = grid.of(now() + -due);
                let after = slot.map_or(by_now, |slot: Slot| slot.max(by_now));
                let mut engine = anew();
                if let Some(kept) = checkpoint {
                    engine.remember(self.areas.masks(), &kept.engine, now());
                }
                warn!("begins without a state: the first 25 s are less than usual");
                let handled = oldest.saturating_sub(1);
                let cell = Cell::new(engine, grid, wait, handled, published).silent_until(after);
                return Ok(Some((cell, handled, published)));
            }
            // The owner writes one when it hears that.
            _ = self.log.say(&self.wanted(), self.me.node.clone().into_bytes()).await;
            self.pause(AGAIN).await;
            match self.log.renew(&self.standby(), &self.me, *seat).await {
                Renewed::Until(revision) => *seat = revision,
                Renewed::Unknown => {}
                Renewed::Lost => return Ok(None),
            }
            if self.is_stopped() {
                return Ok(None);
            }
        }
    }

    /// Does what the cell wishes, until it is lost.
    async fn serve(
        &self,
        mut said: UnboundedReceiver<Says>,
        to_cell: &Sender<Told>,
        held: &watch::Sender<Option<u64>>,
        tasks: &mut JoinSet<()>,
    ) -> Left {
        let mut stop = self.stop.clone();
        let writing = Arc::new(AtomicU64::new(0));
        loop {
            let says = tokio::select! {
                says = said.recv() => says,
                _ = stop.wait_for(|stop| *stop) => return Left::Stopped,
            };
            match says {
                // The thread has ended without a word.
                None => return Left::Lost(Lost::Behind, 0),
                Some(Says::Lost(lost, published)) => return Left::Lost(lost, published),
                Some(Says::Unseated) => return Left::Unseated,
                Some(Says::Wish(wish)) => {
                    tasks.spawn(self.clone().grant(wish, to_cell.clone(), held.clone()));
                }
                Some(Says::Owns(epoch)) => {
                    info!(epoch, "owns the cell");
                    self.note(|counts| {
                        (counts.part, counts.epoch, counts.behind) = (Part::Owner, epoch, 0);
                        counts.takeovers += 1;
                    });
                }
                Some(Says::Behind(slots)) => self.note(|counts| counts.behind = slots),
                Some(Says::Report(report)) => {
                    let (log, key) = (self.log.clone(), format!("{}.report", self.cell));
                    tasks.spawn(async move { _ = log.say(&key, report.octets()).await });
                }
                Some(Says::Written(handled, published, engine)) => {
                    if writing.swap(1, Ordering::Relaxed) == 1 {
                        continue;
                    }
                    let (desk, writing) = (self.clone(), writing.clone());
                    tasks.spawn(async move {
                        match desk.write(handled, published, engine).await {
                            Ok(()) => desk.note(|counts| counts.checkpoints += 1),
                            Err(error) => info!(%error, "no checkpoint is written"),
                        }
                        writing.store(0, Ordering::Relaxed);
                    });
                }
            }
        }
    }

    async fn write(&self, handled: u64, published: u64, engine: Vec<u8>) -> Result<(), LogError> {
        let mark = self.log.mark(handled, published).await?;
        let mark = mark.ok_or_else(|| LogError::Unanswered("what was handled is gone".to_owned()))?;
        self.log.keep(&self.cell, &Checkpoint { mark, handled, published, engine }).await
    }

    /// Asks the log for what the cell wishes, and tells it the answer.
    async fn grant(self, wish: Wish, to_cell: Sender<Told>, held: watch::Sender<Option<u64>>) {
        let answer = match wish {
            Wish::Lease => {
                let lease = self.log.take(&self.owner(), &self.me).await;
                held.send_replace(lease);
                Told::Leased(lease)
            }
            Wish::Last => {
                let last = self.log.last(&self.cell).await;
                if last.is_err() {
                    tokio::time::sleep(SOON).await;
                }
                Told::Last(last.map(|last| last.as_ref().map(placed)).map_err(drop))
            }
            Wish::Append { expected, output } => {
                let appended = self.log.append(&self.cell, expected, &output).await;
                match appended {
                    Appended::Stored(_) => self.note(|counts| counts.published += 1),
                    Appended::Refused => {}
                    // Servers that choose a leader say so at once.
                    Appended::Unknown => tokio::time::sleep(SOON).await,
                }
                Told::Appended(appended)
            }
        };
        tell(&to_cell, answer);
    }
}

/// Tells the cell what comes in a stream.
async fn read(mut reading: Reading, to_cell: Sender<Told>, of: impl Fn(u64, &[u8]) -> Option<Told>) {
    loop {
        let Some((sequence, octets)) = reading.next().await else {
            warn!("the log has lost what it held: begun anew");
            tell(&to_cell, Told::Unseated);
            return;
        };
        match of(sequence, &octets) {
            Some(told) => {
                if !tell(&to_cell, told) {
                    return;
                }
            }
            None => warn!(sequence, "a message of the log is not one of this version"),
        }
    }
}

/// A number that no other run of a node has.
pub fn run_number() -> u64 {
    let at: Time = now();
    u64::try_from(at.nanos()).unwrap_or_default()
}
