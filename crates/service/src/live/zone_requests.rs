//! Queue of operators' requests about zones. The API sends them to the owner of the areas in force, which also reloads the
//! configuration.

use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};
use tracing::info;

use crate::current::Current;
use crate::state::{OperatorZone, ZoneRefusal, ZoneStore};
use fusion::time::Time;
use site::areas::Areas;

/// Maximum number of requests waiting for the owner.
const PENDING: usize = 16;

/// A request about a zone of an operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZoneRequest {
    /// Name of the zone.
    pub name: String,
    /// Change of the zone.
    pub action: ZoneAction,
    /// Name of the operator.
    pub by: String,
}

/// Change of a zone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ZoneAction {
    /// Activate the zone of this GeoJSON text, or replace the zone of the same name.
    Activate(Vec<u8>),
    /// Revoke the zone.
    Revoke,
}

/// A request about a zone has not been carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ZoneRequestError {
    /// The request is refused.
    #[error(transparent)]
    Refused(#[from] ZoneRefusal),
    /// The queue of requests is full.
    #[error("too many requests about zones wait")]
    Busy,
    /// The owner has not answered in time, or has stopped.
    #[error("no answer in time; /api/v1/zones shows whether the zone is active")]
    Gone,
}

type ZoneAnswer = Result<OperatorZone, ZoneRefusal>;

/// A request, and the channel for its result.
#[derive(Debug)]
pub struct PendingZoneRequest {
    request: ZoneRequest,
    answer: oneshot::Sender<ZoneAnswer>,
}

/// The API's end of the queue, and the zones in force; cheap to clone.
#[derive(Clone, Debug)]
pub struct ZoneRequests {
    requests: mpsc::Sender<PendingZoneRequest>,
    in_force: Current<Vec<OperatorZone>>,
}

/// The zones of operators with the queue of requests about them, for their only owner.
#[derive(Debug)]
pub struct OperatorZones {
    store: ZoneStore,
    pending: mpsc::Receiver<PendingZoneRequest>,
    in_force: Current<Vec<OperatorZone>>,
}

impl OperatorZones {
    /// The zones of a store, and the API's end of the queue.
    pub fn new(store: ZoneStore) -> (Self, ZoneRequests) {
        let (requests, pending) = mpsc::channel(PENDING);
        let in_force = Current::from(store.zones().cloned().collect::<Vec<_>>());
        (Self { store, pending, in_force: in_force.clone() }, ZoneRequests { requests, in_force })
    }

    /// The zones as areas.
    pub fn areas(&self) -> impl Iterator<Item = &Areas> {
        self.store.zones().map(|zone| &zone.areas)
    }

    /// The next request; `None` if the API has ended.
    pub async fn next(&mut self) -> Option<PendingZoneRequest> {
        self.pending.recv().await
    }

    /// Carries out a request and logs it. `apply` puts the zones in force before the request is answered.
    pub fn carry_out(&mut self, pending: PendingZoneRequest, now: Time, apply: impl FnOnce(&Self)) {
        let PendingZoneRequest { request: ZoneRequest { name, action, by }, answer } = pending;
        let changed = match &action {
            ZoneAction::Activate(geojson) => self.store.activate(&name, geojson, &by, now),
            ZoneAction::Revoke => self.store.revoke(&name),
        };
        if changed.is_ok() {
            self.in_force.replace(self.store.zones().cloned().collect());
            apply(self);
            match action {
                ZoneAction::Activate(_) => info!(name, by, "zone activated"),
                ZoneAction::Revoke => info!(name, by, "zone revoked"),
            }
        }
        // The client may have closed its connection; the change holds.
        let _ = answer.send(changed);
    }
}

impl ZoneRequests {
    /// Submits a request; the answer contains the zone that was activated or revoked.
    ///
    /// # Errors
    /// The queue is full.
    pub fn submit(&self, request: ZoneRequest) -> Result<oneshot::Receiver<ZoneAnswer>, ZoneRequestError> {
        let (answer, answered) = oneshot::channel();
        let sent = self.requests.try_send(PendingZoneRequest { request, answer });
        sent.map(|()| answered).map_err(|_| ZoneRequestError::Busy)
    }

    /// The zones in force, by name.
    pub fn in_force(&self) -> Arc<Vec<OperatorZone>> {
        self.in_force.get()
    }
}
