//! Keeping what a node holds.

use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::Desk;
use crate::cluster::log::Renewed;
use crate::cluster::seat::{Told, tell};

/// The least time between two checkpoints that are asked for.
const WRITTEN: Duration = Duration::from_secs(1);
/// Of the lease: how often it is renewed, and how often others look whether it is free.
const RENEWED: u32 = 3;
const LOOKED_AT: u32 = 12;

impl Desk {
    /// Keeps the seat or the lease, looks whether the lease is free, and asks for checkpoints.
    #[expect(clippy::disallowed_methods, reason = "a lease is timed by a clock that nobody sets")]
    pub(super) async fn keep(
        self,
        mut seat: u64,
        to_cell: Sender<Told>,
        held: watch::Sender<Option<u64>>,
        holding: watch::Receiver<Option<u64>>,
    ) {
        let period = self.lease() / RENEWED;
        let checkpoints = Duration::from_secs_f64(self.cluster.checkpoint_s);
        let mut ticks = tokio::time::interval(self.lease() / LOOKED_AT);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let (mut renewed, mut written) = (Instant::now(), Instant::now());
        // Whoever stands by, where this node owns the cell; the seat is its own before.
        let (mut beside, mut has_seat) = (None, true);
        loop {
            ticks.tick().await;
            let lease = *holding.borrow();
            if renewed.elapsed() >= period {
                renewed = Instant::now();
                let (key, revision) = match lease {
                    Some(lease) => (self.owner(), lease),
                    None => (self.standby(), seat),
                };
                match (self.log.renew(&key, &self.me, revision).await, lease) {
                    (Renewed::Until(revision), Some(_)) => {
                        held.send_replace(Some(revision));
                    }
                    (Renewed::Until(revision), None) => seat = revision,
                    // While the log had no leader nobody could renew anything. Whoever is first goes on.
                    (Renewed::Lost, lease) => match (self.log.take(&key, &self.me).await, lease) {
                        (Some(again), Some(_)) => {
                            held.send_replace(Some(again));
                            tell(&to_cell, Told::LeasedAgain(again));
                        }
                        (Some(again), None) => seat = again,
                        (None, lease) => {
                            tell(&to_cell, if lease.is_some() { Told::Fenced } else { Told::Unseated });
                            return;
                        }
                    },
                    (Renewed::Unknown, _) => {}
                }
            }
            let is_due = written.elapsed() >= checkpoints;
            if lease.is_none() {
                if let Ok(owner) = self.log.holder(&self.owner()).await {
                    tell(&to_cell, Told::Lease(owner.is_some()));
                }
                if is_due {
                    written = Instant::now();
                    tell(&to_cell, Told::Write);
                }
                continue;
            }
            if std::mem::take(&mut has_seat) {
                // The next one may stand by.
                _ = self.log.give_up(&self.standby(), seat).await;
            }
            if let Ok(standby) = self.log.holder(&self.standby()).await {
                let now_beside = standby.filter(|standby| standby.by != self.me).map(|standby| standby.by);
                let is_new = now_beside.is_some() && now_beside != beside;
                let is_wanted = now_beside.is_some()
                    && written.elapsed() >= WRITTEN
                    && matches!(self.log.said(&self.wanted()).await, Ok(Some(_)));
                if is_new || is_wanted || (is_due && now_beside.is_none()) {
                    written = Instant::now();
                    tell(&to_cell, Told::Write);
                }
                beside = now_beside;
            }
        }
    }
}
