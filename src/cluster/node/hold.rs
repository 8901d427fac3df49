//! A node's hold on the lease, or on the place of the standby, of a cell, where other processes may write, too: octets that no
//! node can have written are overwritten, and the node goes on.

use std::sync::mpsc::Sender;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::counts::Part;
use super::desk::{Desk, moment};
use super::locked;
use crate::cluster::log::{Held, Holder, LogError, Place, Renewed};
use crate::cluster::seat::{Told, tell};

/// A node that the lease names publishes within this time, or never had it.
const GRACE: Duration = Duration::from_millis(750);
/// After a name was found false, another one is written over at once for this long.
const FALSE_NAMES: Duration = Duration::from_secs(60);

/// A lease that this node has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lease {
    /// The number under which it publishes.
    epoch: u64,
    /// The number of what it wrote last.
    pub(super) revision: u64,
    /// When it asked for that: while this is less than a lease ago, no other node can have found it free.
    renewed: Instant,
    /// Since when another name stands there.
    challenged: Option<Instant>,
}

/// The lease or place of a cell that this node holds.
#[derive(Debug)]
pub(super) struct Hold {
    pub(super) lease: tokio::sync::Mutex<Option<Lease>>,
    /// When an output of the cell was read last.
    heard: Mutex<Instant>,
    /// When a name in the lease was found false.
    false_name: Mutex<Option<Instant>>,
}

impl Default for Hold {
    fn default() -> Self {
        Self {
            lease: tokio::sync::Mutex::default(),
            heard: Mutex::new(moment()),
            false_name: Mutex::default(),
        }
    }
}

impl Hold {
    /// An output of the cell was read.
    pub(super) fn hear(&self) {
        *locked(&self.heard) = moment();
    }

    fn is_silent_for(&self, time: Duration) -> bool {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner).elapsed() >= time
    }
}

impl Desk {
    /// Whether the node that is named has reported lately.
    fn is_heard(&self, by: &Holder) -> bool {
        locked(&self.shared.nodes).is_heard(by)
    }

    /// Whether another node has the cell, by its lease.
    pub(super) fn is_taken(&self, place: &Place) -> bool {
        match place {
            Place::Free => false,
            // Where nothing is published the cell has no owner, whatever the lease says.
            Place::Other(_) => !self.hold.is_silent_for(self.lease()),
            Place::Held(held) if held.by == self.me || !self.is_heard(&held.by) => {
                !self.hold.is_silent_for(self.lease())
            }
            Place::Held(held) => {
                let is_owner =
                    locked(&self.shared.nodes).part(&held.by, self.cell.as_str()) != Some(Part::Standby);
                is_owner || !self.hold.is_silent_for(2 * self.lease())
            }
        }
    }

    /// Whether another node has the cell.
    pub(super) async fn is_owned(&self) -> Result<bool, LogError> {
        Ok(self.is_taken(&self.log.place(&self.owner()).await?))
    }

    /// Takes the lease, where it is free.
    pub(super) async fn take_lease(&self, to_cell: &Sender<Told>) {
        let mut lease = self.hold.lease.lock().await;
        let (key, renewed) = (self.owner(), moment());
        let mut taken = self.log.take(&key, &self.me).await;
        if taken.is_none()
            && let Ok(place) = self.log.place(&key).await
            && !self.is_taken(&place)
            && let Place::Other(revision) | Place::Held(Held { revision, .. }) = place
            && let Renewed::Until(revision) = self.log.renew(&key, &self.me, revision).await
        {
            taken = Some(revision);
        }
        *lease = taken.map(|epoch| Lease { epoch, revision: epoch, renewed, challenged: None });
        tell(to_cell, Told::Leased(taken));
    }

    /// Whether this node certainly has the lease, so that no other node can have one of a greater number. The lease is to be locked.
    pub(super) async fn is_mine(&self, lease: Option<Lease>) -> Result<bool, LogError> {
        let Some(lease) = lease else { return Ok(false) };
        Ok(match self.log.place(&self.owner()).await? {
            Place::Held(held) if held.by == self.me => true,
            Place::Held(held) if self.is_heard(&held.by) => false,
            Place::Held(_) | Place::Other(_) => lease.renewed.elapsed() < self.lease(),
            Place::Free => false,
        })
    }

    /// Renews the lease; whether it is to be looked at again soon.
    pub(super) async fn renew_lease(&self, to_cell: &Sender<Told>) -> bool {
        let mut lease = self.hold.lease.lock().await;
        let Some(held) = &mut *lease else { return false };
        let (key, asked) = (self.owner(), moment());
        match self.log.renew(&key, &self.me, held.revision).await {
            Renewed::Until(revision) => (held.revision, held.renewed) = (revision, asked),
            Renewed::Unknown => {}
            Renewed::Lost => return self.restore(held, asked, to_cell).await,
        }
        false
    }

    /// The lease has other octets than this node wrote last.
    async fn restore(&self, held: &mut Lease, asked: Instant, to_cell: &Sender<Told>) -> bool {
        let key = self.owner();
        let Ok(place) = self.log.place(&key).await else { return true };
        let is_lapsed = held.renewed.elapsed() >= self.lease();
        let revision = match place {
            // Its own, whose acknowledgement was lost.
            Place::Held(Held { by, revision }) if by == self.me => {
                (held.revision, held.renewed) = (revision, asked);
                self.release(held, to_cell);
                return false;
            }
            // While the log had no leader no node could renew anything. The first one goes on.
            Place::Free => match self.log.take(&key, &self.me).await {
                Some(again) => return self.lease_again(held, again, asked, to_cell),
                None => return true,
            },
            Place::Held(Held { by, revision }) if is_lapsed || self.is_heard(&by) => revision,
            Place::Other(revision) if is_lapsed => revision,
            // No node can have written this: the cell is still its own.
            Place::Other(revision) | Place::Held(Held { revision, .. }) => {
                if let Renewed::Until(revision) = self.log.renew(&key, &self.me, revision).await {
                    (held.revision, held.renewed) = (revision, asked);
                    self.release(held, to_cell);
                    return false;
                }
                return true;
            }
        };
        // The node that is named publishes soon, and then this node has lost the cell.
        let is_false = locked(&self.hold.false_name).is_some_and(|at| at.elapsed() < FALSE_NAMES);
        let since = *held.challenged.get_or_insert(asked);
        if since.elapsed() < GRACE && (is_lapsed || !is_false) {
            tell(to_cell, Told::HoldBack(true));
            return true;
        }
        match self.log.renew(&key, &self.me, revision).await {
            Renewed::Until(again) => {
                *locked(&self.hold.false_name) = Some(moment());
                self.log.skips.note(&key, "the name of a node that does not publish");
                self.lease_again(held, again, asked, to_cell)
            }
            Renewed::Lost | Renewed::Unknown => true,
        }
    }

    fn release(&self, held: &mut Lease, to_cell: &Sender<Told>) {
        if held.challenged.take().is_some() {
            tell(to_cell, Told::HoldBack(false));
        }
    }

    fn lease_again(&self, held: &mut Lease, again: u64, asked: Instant, to_cell: &Sender<Told>) -> bool {
        (held.epoch, held.revision, held.renewed) = (again, again, asked);
        tell(to_cell, Told::LeasedAgain(again));
        self.release(held, to_cell);
        false
    }

    /// Takes the place of the standby, also from octets that no node can have written; `is_long`: these have been there for longer
    /// than a lease lasts. `None`: another node has the place, or no answer came.
    pub(super) async fn sit(&self, is_long: bool) -> Option<u64> {
        let key = self.standby();
        if let Some(seat) = self.log.take(&key, &self.me).await {
            return Some(seat);
        }
        let revision = match self.log.place(&key).await.ok()? {
            Place::Other(revision) => revision,
            Place::Held(held) if is_long && !self.is_heard(&held.by) => held.revision,
            Place::Held(_) | Place::Free => return None,
        };
        match self.log.renew(&key, &self.me, revision).await {
            Renewed::Until(revision) => Some(revision),
            Renewed::Lost | Renewed::Unknown => None,
        }
    }

    /// Renews the place of the standby. `None`: it is another node's.
    pub(super) async fn renew_seat(&self, seat: u64) -> Option<u64> {
        let key = self.standby();
        match self.log.renew(&key, &self.me, seat).await {
            Renewed::Until(revision) => return Some(revision),
            Renewed::Unknown => return Some(seat),
            Renewed::Lost => {}
        }
        let revision = match self.log.place(&key).await {
            Err(_) => return Some(seat),
            Ok(Place::Held(held)) if held.by == self.me => return Some(held.revision),
            Ok(Place::Held(held)) if self.is_heard(&held.by) => return None,
            Ok(Place::Free) => return self.log.take(&key, &self.me).await,
            Ok(Place::Held(Held { revision, .. }) | Place::Other(revision)) => revision,
        };
        match self.log.renew(&key, &self.me, revision).await {
            Renewed::Until(revision) => Some(revision),
            Renewed::Unknown => Some(seat),
            Renewed::Lost => None,
        }
    }
}
