//! A node's lease or standby role of a cell. Other processes may write there, too: octets that no node can have written are
//! overwritten, and the node continues.

use std::sync::mpsc::Sender;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::cell_member::{CellMember, steady_now};
use super::locked;
use crate::cell_thread::{CellInput, send};
use crate::log::{EntryState, HeldEntry, Holder, LogError, Renewal};
use crate::node_report::NodeRole;

/// Time within which a node named in the lease has to publish. After it the name counts as false.
const CHALLENGE_TIMEOUT: Duration = Duration::from_millis(750);
/// Time after a false name for which further ones are overwritten at once.
const FALSE_NAME_MEMORY: Duration = Duration::from_secs(60);

/// A lease held by this node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lease {
    /// Lease number under which the node publishes.
    epoch: u64,
    /// Number of the last entry that it wrote.
    pub(super) revision: u64,
    /// Time at which the last renewal was requested. Until a lease time after it, no other node can have found the lease free.
    renewed: Instant,
    /// Time since when the lease names another node.
    challenged: Option<Instant>,
}

/// The lease or standby role of a cell that this node holds.
#[derive(Debug)]
pub(super) struct HeldRole {
    pub(super) lease: tokio::sync::Mutex<Option<Lease>>,
    /// Time at which an output of the cell was last read.
    last_output_read: Mutex<Instant>,
    /// Time at which the lease last had a false name.
    false_name: Mutex<Option<Instant>>,
}

impl Default for HeldRole {
    fn default() -> Self {
        Self {
            lease: tokio::sync::Mutex::default(),
            last_output_read: Mutex::new(steady_now()),
            false_name: Mutex::default(),
        }
    }
}

impl HeldRole {
    /// Notes that an output of the cell was read.
    pub(super) fn note_output(&self) {
        *locked(&self.last_output_read) = steady_now();
    }

    fn is_silent_for(&self, time: Duration) -> bool {
        self.last_output_read.lock().unwrap_or_else(PoisonError::into_inner).elapsed() >= time
    }
}

impl CellMember {
    /// Whether the named node has reported recently.
    fn is_reporting(&self, by: &Holder) -> bool {
        locked(&self.shared.nodes).is_reporting(by)
    }

    /// Whether another node has the cell, by its lease.
    pub(super) fn is_taken(&self, place: &EntryState) -> bool {
        match place {
            EntryState::Free => false,
            // A cell without outputs has no owner, whatever the lease states.
            EntryState::Foreign(_) => !self.hold.is_silent_for(self.lease()),
            EntryState::Held(held) if held.by == self.me || !self.is_reporting(&held.by) => {
                !self.hold.is_silent_for(self.lease())
            }
            EntryState::Held(held) => {
                let is_owner =
                    locked(&self.shared.nodes).role(&held.by, self.cell.as_str()) != Some(NodeRole::Standby);
                is_owner || !self.hold.is_silent_for(2 * self.lease())
            }
        }
    }

    /// Whether another node has the cell.
    pub(super) async fn is_owned(&self) -> Result<bool, LogError> {
        Ok(self.is_taken(&self.log.entry_state(&self.owner()).await?))
    }

    /// Takes the lease if it is free.
    pub(super) async fn take_lease(&self, to_cell: &Sender<CellInput>) {
        let mut lease = self.hold.lease.lock().await;
        let (key, renewed) = (self.owner(), steady_now());
        let mut taken = self.log.create_entry(&key, &self.me).await;
        if taken.is_none()
            && let Ok(place) = self.log.entry_state(&key).await
            && !self.is_taken(&place)
            && let EntryState::Foreign(revision) | EntryState::Held(HeldEntry { revision, .. }) = place
            && let Renewal::Until(revision) = self.log.renew_entry(&key, &self.me, revision).await
        {
            taken = Some(revision);
        }
        *lease = taken.map(|epoch| Lease { epoch, revision: epoch, renewed, challenged: None });
        send(to_cell, CellInput::LeaseAnswer(taken));
    }

    /// Whether this node certainly has the lease, so that no other node can have one with a greater number. The lease has to be
    /// locked.
    pub(super) async fn is_mine(&self, lease: Option<Lease>) -> Result<bool, LogError> {
        let Some(lease) = lease else { return Ok(false) };
        Ok(match self.log.entry_state(&self.owner()).await? {
            EntryState::Held(held) if held.by == self.me => true,
            EntryState::Held(held) if self.is_reporting(&held.by) => false,
            EntryState::Held(_) | EntryState::Foreign(_) => lease.renewed.elapsed() < self.lease(),
            EntryState::Free => false,
        })
    }

    /// Renews the lease. Returns whether it has to be checked again soon.
    pub(super) async fn renew_lease(&self, to_cell: &Sender<CellInput>) -> bool {
        let mut lease = self.hold.lease.lock().await;
        let Some(held) = &mut *lease else { return false };
        let (key, asked) = (self.owner(), steady_now());
        match self.log.renew_entry(&key, &self.me, held.revision).await {
            Renewal::Until(revision) => (held.revision, held.renewed) = (revision, asked),
            Renewal::Unknown => {}
            Renewal::Lost => return self.recover_lease(held, asked, to_cell).await,
        }
        false
    }

    /// Handles a lease whose octets are not the last that this node wrote.
    async fn recover_lease(&self, held: &mut Lease, asked: Instant, to_cell: &Sender<CellInput>) -> bool {
        let key = self.owner();
        let Ok(place) = self.log.entry_state(&key).await else { return true };
        let has_expired = held.renewed.elapsed() >= self.lease();
        let revision = match place {
            // This node's own entry, whose acknowledgement was lost.
            EntryState::Held(HeldEntry { by, revision }) if by == self.me => {
                (held.revision, held.renewed) = (revision, asked);
                self.resume_publication(held, to_cell);
                return false;
            }
            // Without a leader of the log no node could renew. The first one continues.
            EntryState::Free => match self.log.create_entry(&key, &self.me).await {
                Some(again) => return self.lease_again(held, again, asked, to_cell),
                None => return true,
            },
            EntryState::Held(HeldEntry { by, revision }) if has_expired || self.is_reporting(&by) => revision,
            EntryState::Foreign(revision) if has_expired => revision,
            // No node can have written this: this node still owns the cell.
            EntryState::Foreign(revision) | EntryState::Held(HeldEntry { revision, .. }) => {
                if let Renewal::Until(revision) = self.log.renew_entry(&key, &self.me, revision).await {
                    (held.revision, held.renewed) = (revision, asked);
                    self.resume_publication(held, to_cell);
                    return false;
                }
                return true;
            }
        };
        // If the named node publishes soon, this node has lost the cell.
        let is_false = locked(&self.hold.false_name).is_some_and(|at| at.elapsed() < FALSE_NAME_MEMORY);
        let since = *held.challenged.get_or_insert(asked);
        if since.elapsed() < CHALLENGE_TIMEOUT && (has_expired || !is_false) {
            send(to_cell, CellInput::Suspend(true));
            return true;
        }
        match self.log.renew_entry(&key, &self.me, revision).await {
            Renewal::Until(again) => {
                *locked(&self.hold.false_name) = Some(steady_now());
                self.log.skips.note(&key, "the name of a node that does not publish");
                self.lease_again(held, again, asked, to_cell)
            }
            Renewal::Lost | Renewal::Unknown => true,
        }
    }

    fn resume_publication(&self, held: &mut Lease, to_cell: &Sender<CellInput>) {
        if held.challenged.take().is_some() {
            send(to_cell, CellInput::Suspend(false));
        }
    }

    fn lease_again(&self, held: &mut Lease, again: u64, asked: Instant, to_cell: &Sender<CellInput>) -> bool {
        (held.epoch, held.revision, held.renewed) = (again, again, asked);
        send(to_cell, CellInput::LeaseRecreated(again));
        self.resume_publication(held, to_cell);
        false
    }

    /// Takes the standby role, also from octets that no node can have written. `is_long` states that these have been there for
    /// longer than a lease lasts. `None` if another node has the role or the log did not answer.
    pub(super) async fn take_standby(&self, is_long: bool) -> Option<u64> {
        let key = self.standby();
        if let Some(standby_revision) = self.log.create_entry(&key, &self.me).await {
            return Some(standby_revision);
        }
        let revision = match self.log.entry_state(&key).await.ok()? {
            EntryState::Foreign(revision) => revision,
            EntryState::Held(held) if is_long && !self.is_reporting(&held.by) => held.revision,
            EntryState::Held(_) | EntryState::Free => return None,
        };
        match self.log.renew_entry(&key, &self.me, revision).await {
            Renewal::Until(revision) => Some(revision),
            Renewal::Lost | Renewal::Unknown => None,
        }
    }

    /// Renews the standby role. `None` if another node has it.
    pub(super) async fn renew_standby(&self, standby_revision: u64) -> Option<u64> {
        let key = self.standby();
        match self.log.renew_entry(&key, &self.me, standby_revision).await {
            Renewal::Until(revision) => return Some(revision),
            Renewal::Unknown => return Some(standby_revision),
            Renewal::Lost => {}
        }
        let revision = match self.log.entry_state(&key).await {
            Err(_) => return Some(standby_revision),
            Ok(EntryState::Held(held)) if held.by == self.me => return Some(held.revision),
            Ok(EntryState::Held(held)) if self.is_reporting(&held.by) => return None,
            Ok(EntryState::Free) => return self.log.create_entry(&key, &self.me).await,
            Ok(EntryState::Held(HeldEntry { revision, .. }) | EntryState::Foreign(revision)) => revision,
        };
        match self.log.renew_entry(&key, &self.me, revision).await {
            Renewal::Until(revision) => Some(revision),
            Renewal::Unknown => Some(standby_revision),
            Renewal::Lost => None,
        }
    }
}
