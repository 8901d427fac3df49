//! A node at one cell: it waits for a seat, stands by, owns the cell, and begins anew where that is lost.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use jiff::SignedDuration;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tracing::{info, warn};

use super::counts::{CellCounts, Part};
use super::hold::Hold;
use super::inputs::{input, read};
use super::post::deliver;
use super::{Shared, balance, disk, locked};
use crate::areas::Areas;
use crate::cluster::cell::{Cell, Lost};
use crate::cluster::cells::{Audience, Cells};
use crate::cluster::engine::SiteEngine;
use crate::cluster::log::{Checkpoint, Holder, Log, LogError};
use crate::cluster::region::Letter;
use crate::cluster::relief::Step;
use crate::cluster::seat::{Says, Told, tell, work};
use crate::cluster::shared::SharedConfiguration;
use crate::config::{Cluster, Config};
use crate::live::now;
use crate::state::StateHealth;
use crate::territory::CellName;
use fusion::Identity;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;

/// Pause before the log is asked again.
const AGAIN: Duration = Duration::from_millis(250);
/// Pause of a node that cannot follow the owner, while others may.
const UNFIT: Duration = Duration::from_secs(5);
/// Refusals after which it is looked whether there is anything to take.
const LOST: u32 = 8;
/// What is the cell's is written into the table of numbers again after this: a server may have lost what it had acknowledged.
const CLAIMED_AGAIN: Duration = Duration::from_secs(3600);
/// How long a free seat is left to the node that ought to take it: that one may be unable to.
const LEFT: Duration = Duration::from_secs(8);

/// A table into which what is the cell's was written, and when.
#[derive(Clone, Copy)]
struct Claimed {
    table: i128,
    at: Instant,
}

/// What all of a node's tasks at a cell know.
#[derive(Clone)]
pub(super) struct Desk {
    pub(super) log: Log,
    pub(super) cluster: Cluster,
    pub(super) config: Arc<Config>,
    pub(super) areas: Areas,
    pub(super) cells: Arc<Cells>,
    pub(super) cell: CellName,
    pub(super) audience: Arc<Audience>,
    pub(super) me: Holder,
    pub(super) shared: Arc<Shared>,
    /// The lease or place that this node holds.
    pub(super) hold: Arc<Hold>,
    pub(super) stop: watch::Receiver<bool>,
    /// Health of the files of `[state] dir`.
    pub(super) health: StateHealth,
}

/// Why a node is no longer at a cell.
enum Left {
    /// It is to end.
    Stopped,
    /// It has to begin anew; the last output that it had made as it was published.
    Lost(Lost, u64),
    /// Another one has its seat: it was away for too long.
    Unseated,
    /// It left the cell, or the seat, to another node that has less to do.
    Moved,
}

impl Desk {
    pub(super) fn note(&self, note: impl FnOnce(&mut CellCounts)) {
        note(locked(&self.shared.counts).entry(self.cell.to_string()).or_default());
    }

    fn copy(&self) -> disk::Copy {
        disk::Copy::of(&self.config.state.dir, &self.cluster.region, self.cell.as_str(), &self.health)
    }

    pub(super) fn counts(&self) -> CellCounts {
        locked(&self.shared.counts).get(self.cell.as_str()).copied().unwrap_or_default()
    }

    pub(super) fn owner(&self) -> String {
        format!("{}.owner", self.cell)
    }

    pub(super) fn standby(&self) -> String {
        format!("{}.standby", self.cell)
    }

    pub(super) fn wanted(&self) -> String {
        format!("{}.wanted", self.cell)
    }

    pub(super) fn lease(&self) -> Duration {
        Duration::from_secs_f64(self.cluster.lease_s)
    }

    /// Reference time, as far as this node knows it.
    fn now(&self) -> Time {
        now() + -locked(&self.shared.clock).ahead().unwrap_or_default()
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

    /// Takes the seat beside the owner whenever that is free, and stays until it is lost.
    pub(super) async fn take_part(mut self) {
        let mut refused = 0_u32;
        let mut left = None;
        // Where its picture differed from the owner's: from a state of before it would do so again.
        let mut from = 0;
        while !self.is_stopped() {
            if self.is_foreign().await {
                self.pause(UNFIT).await;
                continue;
            }
            if self.is_for_others(&mut left).await {
                self.pause(AGAIN).await;
                continue;
            }
            let is_long = AGAIN * refused > 3 * self.lease();
            let Some(seat) = self.sit(is_long).await else {
                refused += 1;
                if refused.is_multiple_of(LOST)
                    && let Ok(log) = self.log.again(&self.cluster).await
                {
                    self.log = log;
                }
                self.pause(AGAIN).await;
                continue;
            };
            refused = 0;
            self.hold = Arc::default();
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
                Ok(Left::Moved) => {
                    info!("left to another node");
                    from = 0;
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
            self.note(|counts| {
                (counts.part, counts.epoch, counts.behind, counts.step) = (Part::None, 0, 0, 0);
            });
            // Streams may have been lost, and with them what the sequences mean.
            if let Ok(log) = self.log.again(&self.cluster).await {
                self.log = log;
            }
        }
    }

    /// Whether the cell is owned by a node of another configuration: this node cannot stand by for it.
    async fn is_foreign(&self) -> bool {
        let Ok(Some(owner)) = self.log.holder(&self.owner()).await else { return false };
        let is_foreign = !SharedConfiguration::accepts(self.me.config, owner.by.config)
            && locked(&self.shared.nodes).is_heard(&owner.by);
        if is_foreign {
            warn!(
                node = owner.by.node,
                "the owner has another configuration: this node stands by for nobody"
            );
        }
        is_foreign
    }

    /// Whether the free seat is another node's to take; `left`: since when it is.
    async fn is_for_others(&self, left: &mut Option<Instant>) -> bool {
        let Ok(owner) = self.log.holder(&self.owner()).await else { return false };
        if let Some(owner) = &owner
            && owner.by.node == self.me.node
        {
            return owner.by.run == self.me.run;
        }
        // Where the log does not answer it is tried, and looked into when that fails.
        let Ok(seat) = self.log.holder(&self.standby()).await else { return false };
        let is_taken =
            seat.is_some_and(|seat| seat.by != self.me && locked(&self.shared.nodes).is_heard(&seat.by));
        if is_taken || self.shared.is_relieved(Step::STANDBYS) {
            *left = None;
            return true;
        }
        let owner = owner.as_ref().map(|owner| owner.by.node.as_str());
        let is_for_others =
            balance::is_for_others(&locked(&self.shared.peers), &self.me.node, self.cell.as_str(), owner);
        if !is_for_others {
            *left = None;
            return false;
        }
        left.get_or_insert_with(moment).elapsed() < LEFT
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
        let (post, letters) = unbounded_channel();
        let (says, said) = unbounded_channel();
        let name = self.me.node.clone();
        let thread = std::thread::Builder::new()
            .name(format!("cell {}", self.cell))
            .spawn(move || work(cell, &name, &told, &says))
            .map_err(|error| LogError::Unusable(error.to_string()))?;
        let mut tasks = JoinSet::new();
        let (own, audience) = (self.cell.clone(), self.audience.clone());
        let log = self.log.clone();
        tasks.spawn(read(
            self.log.inputs(handled + 1),
            to_cell.clone(),
            async move |sequence, octets, place| input(&log, (&own, &audience), (sequence, &octets), place),
        ));
        tasks.spawn(deliver(self.log.clone(), letters));
        let desk = self.clone();
        let outputs = self.log.outputs(self.cell.as_str(), published + 1);
        tasks.spawn(read(outputs, to_cell.clone(), async move |sequence, octets, _| {
            match desk.log.worth(desk.cell.as_str(), &octets).await {
                Some(output) => {
                    desk.hold.hear();
                    Told::Output(sequence, output)
                }
                None => Told::Skipped(sequence),
            }
        }));
        let seated = Arc::new(AtomicU64::new(seat));
        tasks.spawn(self.clone().keep(seated.clone(), to_cell.clone()));
        let left = self.serve(said, (&to_cell, &post), &mut tasks).await;
        // Whoever stands by goes on at once.
        tell(&to_cell, Told::Stop);
        tasks.abort_all();
        drop(tokio::task::spawn_blocking(move || thread.join()).await);
        // The task that kept it has ended, and with it what it had locked.
        let lease = self.hold.lease.lock().await.take();
        match lease {
            Some(lease) if matches!(left, Left::Stopped | Left::Moved) => {
                _ = self.log.give_up(&self.owner(), lease.revision).await;
            }
            Some(_) => {}
            None => _ = self.log.give_up(&self.standby(), seated.load(Ordering::Relaxed)).await,
        }
        Ok(left)
    }

    /// The cell as it was when the newest checkpoint was written, with its sequences; where nobody owns it and there is no such
    /// state, as of now. `None`: it took too long, and the seat is another's.
    async fn begin(
        &self,
        seat: &mut u64,
        mut from: u64,
    ) -> Result<Option<(Cell<SiteEngine>, u64, u64)>, LogError> {
        // An output that was read last, while it is not known whether any node publishes.
        let (mut newest, mut is_unfit) = (0, false);
        let grid = SlotGrid::new(self.config.fusion.slot);
        let wait = SignedDuration::from_nanos((self.cluster.wait_s * 1e9) as i64);
        let anew = || self.cells.engine(&self.config, self.areas.masks(), self.now(), &self.cell);
        loop {
            let oldest = self.log.oldest_input().await?;
            let checkpoint = self.log.checkpoint(self.cell.as_str()).await?;
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
                        let cell = cell.configured(self.me.config);
                        return Ok(Some((cell, *handled, *published)));
                    }
                    // It may be of no owner: the owner writes another one then.
                    Err(error) if !std::mem::replace(&mut is_unfit, true) => {
                        info!(%error, "a checkpoint does not fit: waits for another one");
                        from = published + 1;
                    }
                    // Another node may be of the owner's version, and of its configuration.
                    Err(error) if self.is_owned().await? => {
                        warn!(%error, "the owner's checkpoint does not fit: cannot stand by");
                        _ = self.log.give_up(&self.standby(), *seat).await;
                        self.pause(UNFIT).await;
                        return Ok(None);
                    }
                    Err(error) => warn!(%error, "the checkpoint does not fit"),
                }
            }
            let last = self.log.last(self.cell.as_str()).await?;
            let sequence = last.as_ref().map_or(0, |(sequence, _)| *sequence);
            if sequence > std::mem::replace(&mut newest, sequence) {
                self.hold.hear();
            }
            if !self.is_owned().await? {
                let (published, slot) =
                    last.map_or((0, None), |(sequence, last)| (sequence, Some(last.slot)));
                // What was due by now is nobody's any more.
                let due = self.config.fusion.latency();
                let by_now = grid.of(self.now() + -due);
                let after = slot.map_or(by_now, |slot: Slot| slot.max(by_now));
                let mut engine = anew();
                let kept = checkpoint.map(|kept| kept.engine).or_else(|| self.copy().kept());
                if let Some(kept) = kept {
                    engine.remember(self.areas.masks(), &kept, self.now());
                }
                warn!("begins without a state: the first 25 s are less than usual");
                let handled = oldest.saturating_sub(1);
                let cell = Cell::new(engine, grid, wait, handled, published).configured(self.me.config);
                let cell = cell.silent_until(after);
                return Ok(Some((cell, handled, published)));
            }
            // The owner writes one when it hears that.
            _ = self.log.say(&self.wanted(), self.me.node.clone().into_bytes()).await;
            self.pause(AGAIN).await;
            match self.renew_seat(*seat).await {
                Some(revision) => *seat = revision,
                None => return Ok(None),
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
        (to_cell, post): (&Sender<Told>, &UnboundedSender<Letter>),
        tasks: &mut JoinSet<()>,
    ) -> Left {
        let mut stop = self.stop.clone();
        let writing = Arc::new(AtomicU64::new(0));
        let claimed = Arc::<Mutex<Option<Claimed>>>::default();
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
                Some(Says::Moved) => {
                    *locked(&self.shared.moved) = Some(moment());
                    return Left::Moved;
                }
                Some(Says::Relieved(step)) => {
                    match step > Step::default() {
                        true => warn!(step = step.0, "the cell cannot keep up: {}", step.words()),
                        false => info!("the cell keeps up again: nothing is left out"),
                    }
                    self.note(|counts| {
                        counts.relieved += u64::from(step.0 > counts.step);
                        counts.step = step.0;
                    });
                }
                Some(Says::Post(letters)) => letters.into_iter().for_each(|letter| _ = post.send(letter)),
                Some(Says::Claims(blocks, numbers)) => {
                    tasks.spawn(self.clone().claim(blocks, numbers, claimed.clone()));
                }
                Some(Says::Wish(wish)) => {
                    tasks.spawn(self.clone().grant(wish, to_cell.clone()));
                }
                Some(Says::Owns(epoch)) => {
                    info!(epoch, "owns the cell");
                    self.note(|counts| {
                        (counts.part, counts.epoch, counts.behind) = (Part::Owner, epoch, 0);
                        counts.takeovers += 1;
                    });
                }
                Some(Says::Foreign(outputs)) => {
                    if self.counts().foreign == 0 {
                        warn!("outputs of the cell are left out: no owner can have written them");
                    }
                    self.note(|counts| counts.foreign = counts.foreign.max(outputs));
                }
                Some(Says::Refused(refusals)) => self.refused(&refusals),
                Some(Says::Behind(slots)) => self.note(|counts| counts.behind = slots),
                Some(Says::Report(mut report)) => {
                    report.status.troubles.extend(disk::troubles(&self.health, &self.me.node));
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

    /// Writes what is the cell's into the table of numbers, where that is another one than it was, and now and then. Where the log
    /// does not answer, again in a minute.
    async fn claim(
        self,
        blocks: Vec<u32>,
        numbers: Vec<(Identity, u32)>,
        claimed: Arc<Mutex<Option<Claimed>>>,
    ) {
        let Ok(table) = self.log.table().await else { return };
        let is_there = |last: Claimed| last.table == table && last.at.elapsed() < CLAIMED_AGAIN;
        if !locked(&claimed).is_some_and(is_there)
            && self.log.claim(&self.cell, &blocks, &numbers).await.is_ok()
        {
            *locked(&claimed) = Some(Claimed { table, at: moment() });
        }
    }

    async fn write(&self, handled: u64, published: u64, engine: Vec<u8>) -> Result<(), LogError> {
        let (copy, octets) = (self.copy(), engine.clone());
        let _ = tokio::task::spawn_blocking(move || copy.keep(&octets)).await;
        let mark = self.log.mark(handled, published).await?;
        let mark = mark.ok_or_else(|| LogError::Unanswered("what was handled is gone".to_owned()))?;
        self.log.keep(self.cell.as_str(), &Checkpoint { mark, handled, published, engine }).await
    }
}

#[expect(clippy::disallowed_methods, reason = "how long a seat is free is timed by a clock that nobody sets")]
pub(super) fn moment() -> Instant {
    Instant::now()
}
