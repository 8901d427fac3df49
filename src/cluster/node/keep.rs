//! Keeping what a node holds.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use super::counts::{NodeReport, Part};
use super::desk::{Desk, moment};
use super::{balance, locked};
use crate::cluster::log::{Holder, Place};
use crate::cluster::relief::Step;
use crate::cluster::seat::{Told, tell};

/// The least time between two checkpoints that are asked for.
const WRITTEN: Duration = Duration::from_secs(1);
/// Checkpoints of a cell that cannot keep up are this far apart.
const RARE: Duration = Duration::from_secs(120);
/// Who stands by is near enough with fewer slots than these to make.
const FOLLOWED: u64 = 4;
/// The least time between two cells or seats that a node leaves to others: so that all know what became of the last one.
const MOVES: Duration = Duration::from_secs(10);
/// Of the lease: how often it is renewed, and how often others look whether it is free.
const RENEWED: u32 = 3;
const LOOKED_AT: u32 = 12;

impl Desk {
    /// Keeps the seat or the lease, looks whether the lease is free, and asks for checkpoints.
    #[expect(clippy::disallowed_methods, reason = "a lease is timed by a clock that nobody sets")]
    pub(super) async fn keep(self, seated: Arc<AtomicU64>, to_cell: Sender<Told>) {
        let period = self.lease() / RENEWED;
        let checkpoints = Duration::from_secs_f64(self.cluster.checkpoint_s);
        let mut ticks = tokio::time::interval(self.lease() / LOOKED_AT);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let (mut renewed, mut written) = (Instant::now(), Instant::now());
        // Whoever stands by, where this node owns the cell; the seat is its own before.
        let (mut beside, mut has_seat, mut is_soon) = (None, true, false);
        loop {
            ticks.tick().await;
            let lease = *self.hold.lease.lock().await;
            if is_soon || renewed.elapsed() >= period {
                renewed = Instant::now();
                if lease.is_some() {
                    is_soon = self.renew_lease(&to_cell).await;
                } else {
                    match self.renew_seat(seated.load(Ordering::Relaxed)).await {
                        Some(revision) => seated.store(revision, Ordering::Relaxed),
                        None => {
                            tell(&to_cell, Told::Unseated);
                            return;
                        }
                    }
                }
            }
            let is_rare = self.counts().step >= Step::CHECKPOINTS.0;
            let is_due = written.elapsed() >= if is_rare { checkpoints.max(RARE) } else { checkpoints };
            if lease.is_none() {
                if let Ok(place) = self.log.place(&self.owner()).await {
                    tell(&to_cell, Told::Lease(self.is_taken(&place)));
                    let owner = if let Place::Held(owner) = place { Some(owner) } else { None };
                    let is_relieved = self.shared.is_relieved(Step::STANDBYS);
                    let leaves = |peers: &[_]| {
                        is_relieved
                            || owner.is_some_and(|owner| {
                                balance::leaves_seat(peers, &self.me.node, self.cell.as_str(), &owner.by.node)
                            })
                    };
                    if self.moves(leaves) {
                        tell(&to_cell, Told::Move);
                        return;
                    }
                }
                if is_due {
                    written = Instant::now();
                    tell(&to_cell, Told::Write);
                }
                continue;
            }
            if std::mem::take(&mut has_seat) {
                // The next one may stand by.
                _ = self.log.give_up(&self.standby(), seated.load(Ordering::Relaxed)).await;
            }
            if let Ok(standby) = self.log.holder(&self.standby()).await {
                let now_beside = standby.filter(|standby| standby.by != self.me).map(|standby| standby.by);
                let is_new = now_beside.is_some() && now_beside != beside;
                let is_wanted = now_beside.is_some()
                    && written.elapsed() >= WRITTEN
                    && self.log.said(&self.wanted()).await.is_ok_and(|said| {
                        said.zip(now_beside.as_ref()).is_some_and(|(by, beside)| by == beside.node.as_bytes())
                    });
                if is_new || is_wanted || (is_due && now_beside.is_none()) {
                    written = Instant::now();
                    tell(&to_cell, Told::Write);
                }
                let step = self.counts().step;
                // Whoever owns this one alone would have the same trouble elsewhere.
                let is_left = step >= Step::LEFT.0 && self.shared.owned() > 1;
                let leaves = |peers: &[_]| {
                    now_beside.as_ref().is_some_and(|beside| match is_left {
                        true => balance::may_take(peers, self.cell.as_str(), &beside.node),
                        false => balance::leaves_cell(peers, &self.me.node, self.cell.as_str(), &beside.node),
                    })
                };
                if !is_new && self.moves(leaves) && self.is_followed(now_beside.as_ref()).await {
                    tell(&to_cell, Told::Move);
                    return;
                }
                beside = now_beside;
            }
        }
    }

    /// Whether something is left to another node now: not more than one thing at a time.
    fn moves(&self, leaves: impl FnOnce(&[balance::Peer]) -> bool) -> bool {
        let mut moved = locked(&self.shared.moved);
        let is_time = moved.is_none_or(|moved| moved.elapsed() >= MOVES);
        let moves = is_time && leaves(&locked(&self.shared.peers));
        if moves {
            *moved = Some(moment());
        }
        moves
    }

    /// Whether who stands by has the cell's state, and would go on at once.
    async fn is_followed(&self, by: Option<&Holder>) -> bool {
        let Ok(nodes) = NodeReport::all(&self.log).await else { return false };
        let counts =
            nodes.iter().find(|node| Some(&node.holder) == by).map(|node| node.counts(self.cell.as_str()));
        counts.is_some_and(|counts| counts.part == Part::Standby && counts.behind < FOLLOWED)
    }
}
