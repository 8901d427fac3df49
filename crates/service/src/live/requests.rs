//! Queue of operators' requests to the engine, which reads it several times a second, and the decisions in force.

use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};

use tokio::sync::{oneshot, watch};

use fusion::operational::AssociationRefusal;

/// Maximum number of requests waiting for the engine.
const QUEUE: usize = 64;

/// Reasons for refusing a request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// Refused by the engine.
    #[error(transparent)]
    NotCorrelated(#[from] AssociationRefusal),
    /// Several transponders have that serial number.
    #[error("several transponders have this serial number; their registration countries: {}", .0.join(", "))]
    Ambiguous(Vec<String>),
    /// Trust in transponders is not assessed.
    #[error(
        "transponders are not judged here: the reference profile does not, nor does the operational one with [integrity] \
         action = \"off\""
    )]
    NotJudged,
    /// The radar's tracks agree with its position.
    #[error("the radar's tracks do not contradict its position: there is nothing to apply")]
    NotContradicted,
    /// The configured position holds.
    #[error("the radar is where the configuration says: there is nothing to undo")]
    NotRelocated,
    /// The engines run on other nodes.
    #[error("a cluster's radars are where its configuration says: set the position there")]
    NotRelocatedHere,
    /// Other nodes make the picture, and none is received.
    #[error("nobody who makes the picture is heard: nothing can be decided now")]
    Unheard,
    /// The queue is full.
    #[error("too many decisions wait for the engine")]
    Busy,
    /// The engine has ended.
    #[error("the engine does not answer")]
    Gone,
}

struct PendingRequest<W, H> {
    request: W,
    answer: oneshot::Sender<Result<Arc<H>, RequestError>>,
}

impl<W: fmt::Debug, H> fmt::Debug for PendingRequest<W, H> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.request.fmt(f)
    }
}

/// The API's end of the queue, for requests `W` and decisions in force `H`; cheap to clone.
#[derive(Debug)]
pub struct RequestSender<W, H> {
    requests: SyncSender<PendingRequest<W, H>>,
    in_force: watch::Receiver<Arc<H>>,
}

impl<W, H> Clone for RequestSender<W, H> {
    fn clone(&self) -> Self {
        Self { requests: self.requests.clone(), in_force: self.in_force.clone() }
    }
}

/// The engine's end of the queue.
#[derive(Debug)]
pub(super) struct RequestQueue<W, H> {
    requests: Receiver<PendingRequest<W, H>>,
    in_force: watch::Sender<Arc<H>>,
}

/// Both ends of the queue.
pub(super) fn request_queue<W, H: Default>() -> (RequestQueue<W, H>, RequestSender<W, H>) {
    let (sender, requests) = mpsc::sync_channel(QUEUE);
    let (in_force, watched) = watch::channel(Arc::default());
    (RequestQueue { requests, in_force }, RequestSender { requests: sender, in_force: watched })
}

impl<W, H> RequestSender<W, H> {
    /// Submits a request; the answer contains the decisions then in force.
    ///
    /// # Errors
    /// The queue is full, or the engine has ended.
    pub fn submit(
        &self,
        request: W,
    ) -> Result<oneshot::Receiver<Result<Arc<H>, RequestError>>, RequestError> {
        let (answer, answered) = oneshot::channel();
        match self.requests.try_send(PendingRequest { request, answer }) {
            Ok(()) => Ok(answered),
            Err(TrySendError::Full(_)) => Err(RequestError::Busy),
            Err(TrySendError::Disconnected(_)) => Err(RequestError::Gone),
        }
    }

    /// Decisions in force, as of the latest slot or decision.
    pub fn in_force(&self) -> Arc<H> {
        self.in_force.borrow().clone()
    }

    /// Subscribes to the decisions in force.
    pub fn changes(&self) -> watch::Receiver<Arc<H>> {
        self.in_force.clone()
    }
}

impl<W, H> RequestQueue<W, H> {
    /// Carries out the waiting requests, each with `carry_out`, which returns the decision and the decisions then in force.
    /// Returns the decisions.
    pub(super) fn carry_out_all<T>(
        &self,
        mut carry_out: impl FnMut(&W) -> Result<(T, H), RequestError>,
    ) -> Vec<T> {
        let mut decisions = Vec::new();
        while let Ok(PendingRequest { request, answer }) = self.requests.try_recv() {
            // The caller timed out and reported that nothing was decided.
            if answer.is_closed() {
                continue;
            }
            let answered = carry_out(&request).map(|(decision, in_force)| {
                decisions.push(decision);
                let in_force = Arc::new(in_force);
                self.in_force.send_replace(in_force.clone());
                in_force
            });
            // Fails if the caller has gone.
            let _ = answer.send(answered);
        }
        decisions
    }

    /// Publishes the decisions in force if `is_new` returns `true` for those published before. Returns whether it did.
    pub(super) fn publish_if_changed(
        &self,
        is_new: impl FnOnce(&H) -> bool,
        in_force: impl FnOnce() -> H,
    ) -> bool {
        self.in_force.send_if_modified(|known| {
            let is_new = is_new(known);
            if is_new {
                *known = Arc::new(in_force());
            }
            is_new
        })
    }
}
