//! A node's part in one cell: it waits for the standby role, stands by, owns the cell, and starts again when that is lost.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use jiff::SignedDuration;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tracing::{info, warn};

use super::delivery::deliver;
use super::disk_copy::DiskCopy;
use super::held_role::HeldRole;
use super::inputs::{input, read};
use super::{NodeShared, balance, disk_copy, locked};
use crate::audience::Audience;
use crate::cell::{Cell, CellLoss};
use crate::cell_thread::{CellEvent, CellInput, run_cell, send};
use crate::cells::Cells;
use crate::engine::SiteEngine;
use crate::log::{Checkpoint, Holder, Log, LogError};
use crate::node_report::{CellCounts, NodeRole};
use crate::overload::SheddingLevel;
use crate::region::CellMessage;
use crate::shared_configuration::SharedConfiguration;
use fusion::Identity;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use service::live::now;
use service::state::StateHealth;
use site::areas::Areas;
use site::config::{Cluster, Config};
use site::territory::CellName;

/// Pause before the log is asked again.
const RETRY_PAUSE: Duration = Duration::from_millis(250);
/// Pause of a node that cannot follow the owner, so that another node can take the standby role.
const UNFIT_PAUSE: Duration = Duration::from_secs(5);
/// Number of refused attempts after which the streams are opened again, because they may be lost.
const MAX_REFUSED_ATTEMPTS: u32 = 8;
/// Interval at which the cell's numbers are written into the table again: a server may have lost acknowledged entries.
const CLAIM_INTERVAL: Duration = Duration::from_secs(3600);
/// Time for which a free standby role is left to the preferred node, which may be unable to take it.
const PREFERRED_NODE_TIMEOUT: Duration = Duration::from_secs(8);

/// Table into which the cell's numbers were written, and the time of writing.
#[derive(Clone, Copy)]
struct NumbersClaim {
    table: i128,
    at: Instant,
}

/// State shared by all tasks of a node for one cell.
#[derive(Clone)]
pub(super) struct CellMember {
    pub(super) log: Log,
    pub(super) cluster: Cluster,
    pub(super) config: Arc<Config>,
    pub(super) areas: Areas,
    pub(super) cells: Arc<Cells>,
    pub(super) cell: CellName,
    pub(super) audience: Arc<Audience>,
    pub(super) me: Holder,
    pub(super) shared: Arc<NodeShared>,
    /// The lease or standby role that this node holds.
    pub(super) hold: Arc<HeldRole>,
    pub(super) stop: watch::Receiver<bool>,
    /// Health of the files of `[state] dir`.
    pub(super) health: StateHealth,
}

/// Reason why a node has left a cell.
enum MemberExit {
    /// The node is stopping.
    Stopped,
    /// The node has to start again. The value is the last output that it reproduced as published.
    Lost(CellLoss, u64),
    /// Another node has the standby role: this node was away for too long.
    StandbyLost,
    /// The node left the cell, or the standby role, to another node with less load.
    HandedOver,
}

impl CellMember {
    pub(super) fn update_counts(&self, note: impl FnOnce(&mut CellCounts)) {
        note(locked(&self.shared.counts).entry(self.cell.to_string()).or_default());
    }

    fn copy(&self) -> DiskCopy {
        DiskCopy::of(&self.config.state.dir, &self.cluster.region, self.cell.as_str(), &self.health)
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

    /// Reference time as known to this node.
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

    /// Takes the standby role whenever it is free, and keeps it until it is lost.
    pub(super) async fn run(mut self) {
        let mut refused = 0_u32;
        let mut left = None;
        // First output after which a checkpoint is usable. A state from before a divergence would diverge again.
        let mut from = 0;
        while !self.is_stopped() {
            if self.is_owner_foreign().await {
                self.pause(UNFIT_PAUSE).await;
                continue;
            }
            if self.is_for_others(&mut left).await {
                self.pause(RETRY_PAUSE).await;
                continue;
            }
            let is_long = RETRY_PAUSE * refused > 3 * self.lease();
            let Some(standby_revision) = self.take_standby(is_long).await else {
                refused += 1;
                if refused.is_multiple_of(MAX_REFUSED_ATTEMPTS)
                    && let Ok(log) = self.log.reopen(&self.cluster).await
                {
                    self.log = log;
                }
                self.pause(RETRY_PAUSE).await;
                continue;
            };
            refused = 0;
            self.hold = Arc::default();
            match self.run_cell(standby_revision, from).await {
                Ok(MemberExit::Stopped) => {}
                Ok(MemberExit::Lost(lost, published)) => {
                    warn!(reason = %lost, "begins anew");
                    if lost == CellLoss::Diverged {
                        from = published + 1;
                    }
                    self.update_counts(|counts| match lost {
                        CellLoss::Fenced => counts.fenced += 1,
                        CellLoss::Diverged => counts.diverged += 1,
                        CellLoss::Behind => {}
                    });
                }
                Ok(MemberExit::HandedOver) => {
                    info!("left to another node");
                    from = 0;
                }
                Ok(MemberExit::StandbyLost) => {
                    info!("does not stand by: another node may");
                    // The streams may have been lost, and their sequences with them.
                    from = 0;
                }
                Err(error) => {
                    info!(%error, "waits for the log");
                    self.pause(RETRY_PAUSE).await;
                }
            }
            self.update_counts(|counts| {
                (counts.part, counts.epoch, counts.behind, counts.step) = (NodeRole::None, 0, 0, 0);
            });
            // The streams may have been lost; the sequences would then be meaningless.
            if let Ok(log) = self.log.reopen(&self.cluster).await {
                self.log = log;
            }
        }
    }

    /// Whether a node with another configuration owns the cell. This node cannot be its standby.
    async fn is_owner_foreign(&self) -> bool {
        let Ok(Some(owner)) = self.log.holder(&self.owner()).await else { return false };
        let is_owner_foreign = !SharedConfiguration::accepts(self.me.config, owner.by.config)
            && locked(&self.shared.nodes).is_reporting(&owner.by);
        if is_owner_foreign {
            warn!(
                node = owner.by.node,
                "the owner has another configuration: this node stands by for nobody"
            );
        }
        is_owner_foreign
    }

    /// Whether the free standby role is for another node; `left` is the time since when it is.
    async fn is_for_others(&self, left: &mut Option<Instant>) -> bool {
        let Ok(owner) = self.log.holder(&self.owner()).await else { return false };
        if let Some(owner) = &owner
            && owner.by.node == self.me.node
        {
            return owner.by.run == self.me.run;
        }
        // If the log does not answer, try; a failure is handled then.
        let Ok(standby_revision) = self.log.holder(&self.standby()).await else { return false };
        let is_taken = standby_revision.is_some_and(|standby_revision| {
            standby_revision.by != self.me && locked(&self.shared.nodes).is_reporting(&standby_revision.by)
        });
        if is_taken || self.shared.is_relieved(SheddingLevel::STANDBYS) {
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
        left.get_or_insert_with(steady_now).elapsed() < PREFERRED_NODE_TIMEOUT
    }

    /// Follows the owner from a state at output `from` or later, and takes over the cell if it has no owner. Returns when the
    /// role is lost.
    async fn run_cell(&self, standby_revision: u64, from: u64) -> Result<MemberExit, LogError> {
        let mut standby_revision = standby_revision;
        let Some((cell, handled, published)) = self.load_cell(&mut standby_revision, from).await? else {
            return Ok(MemberExit::StandbyLost);
        };
        self.update_counts(|counts| counts.part = NodeRole::Standby);
        info!(input = handled, output = published, "stands by");
        let (to_cell, inputs) = std::sync::mpsc::channel();
        let (post, messages) = unbounded_channel();
        let (says, events) = unbounded_channel();
        let name = self.me.node.clone();
        let thread = std::thread::Builder::new()
            .name(format!("cell {}", self.cell))
            .spawn(move || run_cell(cell, &name, &inputs, &says))
            .map_err(|error| LogError::Unusable(error.to_string()))?;
        let mut tasks = JoinSet::new();
        let (own, audience) = (self.cell.clone(), self.audience.clone());
        let log = self.log.clone();
        tasks.spawn(read(
            self.log.inputs(handled + 1),
            to_cell.clone(),
            async move |sequence, octets, place| input(&log, (&own, &audience), (sequence, &octets), place),
        ));
        tasks.spawn(deliver(self.log.clone(), messages));
        let member = self.clone();
        let outputs = self.log.outputs(self.cell.as_str(), published + 1);
        tasks.spawn(read(outputs, to_cell.clone(), async move |sequence, octets, _| {
            match member.log.validated_when_available(member.cell.as_str(), &octets).await {
                Some(output) => {
                    member.hold.note_output();
                    CellInput::Output(sequence, output)
                }
                None => CellInput::Skipped(sequence),
            }
        }));
        let standby_revision = Arc::new(AtomicU64::new(standby_revision));
        tasks.spawn(self.clone().maintain_role(standby_revision.clone(), to_cell.clone()));
        let left = self.handle_events(events, (&to_cell, &post), &mut tasks).await;
        // The other node, owner or standby, can continue at once.
        send(&to_cell, CellInput::Stop);
        tasks.abort_all();
        drop(tokio::task::spawn_blocking(move || thread.join()).await);
        // The task that held the lock has ended.
        let lease = self.hold.lease.lock().await.take();
        match lease {
            Some(lease) if matches!(left, MemberExit::Stopped | MemberExit::HandedOver) => {
                _ = self.log.delete_entry(&self.owner(), lease.revision).await;
            }
            Some(_) => {}
            None => {
                _ = self.log.delete_entry(&self.standby(), standby_revision.load(Ordering::Relaxed)).await;
            }
        }
        Ok(left)
    }

    /// Loads the cell from the newest checkpoint, with its sequences. If there is no usable one and the cell has no owner, starts
    /// without a state. `None` if it took too long and another node has the standby role.
    async fn load_cell(
        &self,
        standby_revision: &mut u64,
        mut from: u64,
    ) -> Result<Option<(Cell<SiteEngine>, u64, u64)>, LogError> {
        // The last output read while it is unknown whether any node publishes.
        let (mut newest, mut is_unfit) = (0, false);
        let grid = SlotGrid::new(self.config.fusion.slot);
        let wait = SignedDuration::from_nanos((self.cluster.wait_s * 1e9) as i64);
        let anew = || self.cells.engine(&self.config, self.areas.masks(), self.now(), &self.cell);
        loop {
            let oldest = self.log.oldest_input().await?;
            let checkpoint = self.log.checkpoint(self.cell.as_str()).await?;
            let known = match &checkpoint {
                Some(kept) if kept.published < from => false,
                Some(kept) => self.log.matches_streams(kept).await?,
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
                    // The checkpoint may not be the owner's, who then writes another one.
                    Err(error) if !std::mem::replace(&mut is_unfit, true) => {
                        info!(%error, "a checkpoint does not fit: waits for another one");
                        from = published + 1;
                    }
                    // Another node may have the owner's version and configuration.
                    Err(error) if self.is_owned().await? => {
                        warn!(%error, "the owner's checkpoint does not fit: cannot stand by");
                        _ = self.log.delete_entry(&self.standby(), *standby_revision).await;
                        self.pause(UNFIT_PAUSE).await;
                        return Ok(None);
                    }
                    Err(error) => warn!(%error, "the checkpoint does not fit"),
                }
            }
            let last = self.log.last(self.cell.as_str()).await?;
            let sequence = last.as_ref().map_or(0, |(sequence, _)| *sequence);
            if sequence > std::mem::replace(&mut newest, sequence) {
                self.hold.note_output();
            }
            if !self.is_owned().await? {
                let (published, slot) =
                    last.map_or((0, None), |(sequence, last)| (sequence, Some(last.slot)));
                // Slots that were due by now are not published.
                let due = self.config.fusion.latency();
                let by_now = grid.of(self.now() + -due);
                let after = slot.map_or(by_now, |slot: Slot| slot.max(by_now));
                let mut engine = anew();
                let kept = checkpoint.map(|kept| kept.engine).or_else(|| self.copy().read());
                if let Some(kept) = kept {
                    engine.restore_lasting(self.areas.masks(), &kept, self.now());
                }
                warn!("begins without a state: the first 25 s are less than usual");
                let handled = oldest.saturating_sub(1);
                let cell = Cell::new(engine, grid, wait, handled, published).configured(self.me.config);
                let cell = cell.silent_until(after);
                return Ok(Some((cell, handled, published)));
            }
            // The owner writes a checkpoint when it reads this.
            _ = self.log.put_entry(&self.wanted(), self.me.node.clone().into_bytes()).await;
            self.pause(RETRY_PAUSE).await;
            match self.renew_standby(*standby_revision).await {
                Some(revision) => *standby_revision = revision,
                None => return Ok(None),
            }
            if self.is_stopped() {
                return Ok(None);
            }
        }
    }

    /// Executes the cell's requests, until the cell is lost.
    async fn handle_events(
        &self,
        mut events: UnboundedReceiver<CellEvent>,
        (to_cell, post): (&Sender<CellInput>, &UnboundedSender<CellMessage>),
        tasks: &mut JoinSet<()>,
    ) -> MemberExit {
        let mut stop = self.stop.clone();
        let writing = Arc::new(AtomicU64::new(0));
        let claimed = Arc::<Mutex<Option<NumbersClaim>>>::default();
        loop {
            let says = tokio::select! {
                says = events.recv() => says,
                _ = stop.wait_for(|stop| *stop) => return MemberExit::Stopped,
            };
            match says {
                // The thread has ended without a message.
                None => return MemberExit::Lost(CellLoss::Behind, 0),
                Some(CellEvent::Lost(lost, published)) => return MemberExit::Lost(lost, published),
                Some(CellEvent::StandbyLost) => return MemberExit::StandbyLost,
                Some(CellEvent::HandedOver) => {
                    *locked(&self.shared.moved) = Some(steady_now());
                    return MemberExit::HandedOver;
                }
                Some(CellEvent::LevelChanged(step)) => {
                    match step > SheddingLevel::default() {
                        true => warn!(step = step.0, "the cell cannot keep up: {}", step.description()),
                        false => info!("the cell keeps up again: nothing is left out"),
                    }
                    self.update_counts(|counts| {
                        counts.relieved += u64::from(step.0 > counts.step);
                        counts.step = step.0;
                    });
                }
                Some(CellEvent::Messages(messages)) => {
                    messages.into_iter().for_each(|message| _ = post.send(message));
                }
                Some(CellEvent::Claims(blocks, numbers)) => {
                    tasks.spawn(self.clone().claim(blocks, numbers, claimed.clone()));
                }
                Some(CellEvent::Request(request)) => {
                    tasks.spawn(self.clone().execute(request, to_cell.clone()));
                }
                Some(CellEvent::Owns(epoch)) => {
                    info!(epoch, "owns the cell");
                    self.update_counts(|counts| {
                        (counts.part, counts.epoch, counts.behind) = (NodeRole::Owner, epoch, 0);
                        counts.takeovers += 1;
                    });
                }
                Some(CellEvent::Foreign(outputs)) => {
                    if self.counts().foreign == 0 {
                        warn!("outputs of the cell are left out: no owner can have written them");
                    }
                    self.update_counts(|counts| counts.foreign = counts.foreign.max(outputs));
                }
                Some(CellEvent::Refused(refusals)) => self.refused(&refusals),
                Some(CellEvent::Behind(slots)) => self.update_counts(|counts| counts.behind = slots),
                Some(CellEvent::Report(mut report)) => {
                    report.status.troubles.extend(disk_copy::troubles(&self.health, &self.me.node));
                    let (log, key) = (self.log.clone(), format!("{}.report", self.cell));
                    tasks.spawn(async move { _ = log.put_entry(&key, report.octets()).await });
                }
                Some(CellEvent::Checkpoint(handled, published, engine)) => {
                    if writing.swap(1, Ordering::Relaxed) == 1 {
                        continue;
                    }
                    let (member, writing) = (self.clone(), writing.clone());
                    tasks.spawn(async move {
                        match member.write_checkpoint(handled, published, engine).await {
                            Ok(()) => member.update_counts(|counts| counts.checkpoints += 1),
                            Err(error) => info!(%error, "no checkpoint is written"),
                        }
                        writing.store(0, Ordering::Relaxed);
                    });
                }
            }
        }
    }

    /// Writes the cell's numbers into the table if the table is new, and at a fixed interval. If the log does not answer, the
    /// next call tries again.
    async fn claim(
        self,
        blocks: Vec<u32>,
        numbers: Vec<(Identity, u32)>,
        claimed: Arc<Mutex<Option<NumbersClaim>>>,
    ) {
        let Ok(table) = self.log.number_table_created().await else { return };
        let is_there = |last: NumbersClaim| last.table == table && last.at.elapsed() < CLAIM_INTERVAL;
        if !locked(&claimed).is_some_and(is_there)
            && self.log.claim_numbers(&self.cell, &blocks, &numbers).await.is_ok()
        {
            *locked(&claimed) = Some(NumbersClaim { table, at: steady_now() });
        }
    }

    async fn write_checkpoint(&self, handled: u64, published: u64, engine: Vec<u8>) -> Result<(), LogError> {
        let (copy, octets) = (self.copy(), engine.clone());
        let _ = tokio::task::spawn_blocking(move || copy.maintain_role(&octets)).await;
        let mark = self.log.mark(handled, published).await?;
        let mark = mark.ok_or_else(|| LogError::Unanswered("what was handled is gone".to_owned()))?;
        self.log.put_checkpoint(self.cell.as_str(), &Checkpoint { mark, handled, published, engine }).await
    }
}

#[expect(clippy::disallowed_methods, reason = "how long a seat is free is timed by a clock that nobody sets")]
pub(super) fn steady_now() -> Instant {
    Instant::now()
}
