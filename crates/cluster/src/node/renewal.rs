//! Renewal of a node's lease or standby role, and requests for checkpoints.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use super::cell_member::{CellMember, steady_now};
use super::{balance, locked};
use crate::cell_thread::{CellInput, send};
use crate::log::{EntryState, Holder};
use crate::node_report::{NodeReport, NodeRole};
use crate::overload::SheddingLevel;

/// Minimum interval of requested checkpoints.
const MIN_CHECKPOINT_INTERVAL: Duration = Duration::from_secs(1);
/// Interval of checkpoints of a cell that cannot keep up.
const RARE_CHECKPOINT_INTERVAL: Duration = Duration::from_secs(120);
/// Number of outstanding slots below which a standby is ready to take over.
const READY_BELOW_SLOTS: u64 = 4;
/// Minimum interval of moves of cells or standby roles to other nodes, so that all nodes know the result of the last move.
const MOVE_INTERVAL: Duration = Duration::from_secs(10);
/// Divisors of the lease time: for its renewal, and for the check whether it is free.
const RENEWALS_PER_LEASE: u32 = 3;
const CHECKS_PER_LEASE: u32 = 12;

impl CellMember {
    /// Renews the standby role or the lease, checks whether the lease is free, and requests checkpoints.
    #[expect(clippy::disallowed_methods, reason = "a lease is timed by a clock that nobody sets")]
    pub(super) async fn maintain_role(self, standby_revision: Arc<AtomicU64>, to_cell: Sender<CellInput>) {
        let period = self.lease() / RENEWALS_PER_LEASE;
        let checkpoints = Duration::from_secs_f64(self.cluster.checkpoint_s);
        let mut ticks = tokio::time::interval(self.lease() / CHECKS_PER_LEASE);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let (mut renewed, mut written) = (Instant::now(), Instant::now());
        // The standby, if this node owns the cell. Before that, this node has the standby role itself.
        let (mut beside, mut has_standby, mut is_soon) = (None, true, false);
        loop {
            ticks.tick().await;
            let lease = *self.hold.lease.lock().await;
            if is_soon || renewed.elapsed() >= period {
                renewed = Instant::now();
                if lease.is_some() {
                    is_soon = self.renew_lease(&to_cell).await;
                } else {
                    match self.renew_standby(standby_revision.load(Ordering::Relaxed)).await {
                        Some(revision) => standby_revision.store(revision, Ordering::Relaxed),
                        None => {
                            send(&to_cell, CellInput::StandbyLost);
                            return;
                        }
                    }
                }
            }
            let is_rare = self.counts().step >= SheddingLevel::CHECKPOINTS.0;
            let is_due = written.elapsed()
                >= if is_rare { checkpoints.max(RARE_CHECKPOINT_INTERVAL) } else { checkpoints };
            if lease.is_none() {
                if let Ok(place) = self.log.entry_state(&self.owner()).await {
                    send(&to_cell, CellInput::Lease(self.is_taken(&place)));
                    let owner = if let EntryState::Held(owner) = place { Some(owner) } else { None };
                    let is_relieved = self.shared.is_relieved(SheddingLevel::STANDBYS);
                    let leaves = |peers: &[_]| {
                        is_relieved
                            || owner.is_some_and(|owner| {
                                balance::leaves_standby(
                                    peers,
                                    &self.me.node,
                                    self.cell.as_str(),
                                    &owner.by.node,
                                )
                            })
                    };
                    if self.moves(leaves) {
                        send(&to_cell, CellInput::HandOver);
                        return;
                    }
                }
                if is_due {
                    written = Instant::now();
                    send(&to_cell, CellInput::WriteCheckpoint);
                }
                continue;
            }
            if std::mem::take(&mut has_standby) {
                // Another node may become the standby.
                _ = self.log.delete_entry(&self.standby(), standby_revision.load(Ordering::Relaxed)).await;
            }
            if let Ok(standby) = self.log.holder(&self.standby()).await {
                let now_beside = standby.filter(|standby| standby.by != self.me).map(|standby| standby.by);
                let is_new = now_beside.is_some() && now_beside != beside;
                let is_wanted = now_beside.is_some()
                    && written.elapsed() >= MIN_CHECKPOINT_INTERVAL
                    && self.log.entry(&self.wanted()).await.is_ok_and(|events| {
                        events
                            .zip(now_beside.as_ref())
                            .is_some_and(|(by, beside)| by == beside.node.as_bytes())
                    });
                if is_new || is_wanted || (is_due && now_beside.is_none()) {
                    written = Instant::now();
                    send(&to_cell, CellInput::WriteCheckpoint);
                }
                let step = self.counts().step;
                // A node with only this cell would have the same problem elsewhere.
                let is_left = step >= SheddingLevel::LEFT.0 && self.shared.owned() > 1;
                let leaves = |peers: &[_]| {
                    now_beside.as_ref().is_some_and(|beside| match is_left {
                        true => balance::may_take(peers, self.cell.as_str(), &beside.node),
                        false => balance::leaves_cell(peers, &self.me.node, self.cell.as_str(), &beside.node),
                    })
                };
                if !is_new && self.moves(leaves) && self.is_followed(now_beside.as_ref()).await {
                    send(&to_cell, CellInput::HandOver);
                    return;
                }
                beside = now_beside;
            }
        }
    }

    /// Whether the node moves a cell or role to another node now. Moves happen one at a time.
    fn moves(&self, leaves: impl FnOnce(&[balance::PeerNode]) -> bool) -> bool {
        let mut moved = locked(&self.shared.moved);
        let is_time = moved.is_none_or(|moved| moved.elapsed() >= MOVE_INTERVAL);
        let moves = is_time && leaves(&locked(&self.shared.peers));
        if moves {
            *moved = Some(steady_now());
        }
        moves
    }

    /// Whether the standby has the cell's state and could continue at once.
    async fn is_followed(&self, by: Option<&Holder>) -> bool {
        let Ok(nodes) = NodeReport::all(&self.log).await else { return false };
        let counts =
            nodes.iter().find(|node| Some(&node.holder) == by).map(|node| node.counts(self.cell.as_str()));
        counts.is_some_and(|counts| counts.part == NodeRole::Standby && counts.behind < READY_BELOW_SLOTS)
    }
}
