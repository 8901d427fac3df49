//! Queue of operators' decisions about alerts. The API sends them to the observer, which owns the alerts. The observer
//! passes the records on to the engine's thread, which owns the recorder and the state files.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use tokio::sync::{Mutex, mpsc, oneshot, watch};
use tracing::warn;

use super::alerts::{Alert, AlertRequest, AlertRequestError};

/// Maximum number of requests waiting for the observer.
const PENDING: usize = 64;
/// Maximum number of lines waiting for the engine's thread, which takes them ten times a second.
const LINES: usize = 1_024;

/// A request, and the channel for its result.
#[derive(Debug)]
pub(super) struct PendingAlertRequest {
    pub(super) request: AlertRequest,
    pub(super) answer: oneshot::Sender<Result<Alert, AlertRequestError>>,
}

/// The API's end of the queue; cheap to clone.
#[derive(Clone, Debug)]
pub struct AlertRequests {
    requests: mpsc::Sender<PendingAlertRequest>,
    /// Receiving end, for the only observer.
    pending: Arc<Mutex<mpsc::Receiver<PendingAlertRequest>>>,
    lines: SyncSender<Arc<str>>,
    shelves: Arc<watch::Sender<Arc<str>>>,
}

/// The end of the engine's thread.
#[derive(Debug)]
pub struct AlertRecordQueue {
    lines: Receiver<Arc<str>>,
    shelves: watch::Receiver<Arc<str>>,
}

/// Both ends of the queue.
pub(super) fn alert_requests() -> (AlertRecordQueue, AlertRequests) {
    let (requests, pending) = mpsc::channel(PENDING);
    let (line_sender, lines) = sync_channel(LINES);
    let (shelf_sender, shelves) = watch::channel(Arc::from(""));
    let pending = Arc::new(Mutex::new(pending));
    let api_end = AlertRequests { requests, pending, lines: line_sender, shelves: Arc::new(shelf_sender) };
    (AlertRecordQueue { lines, shelves }, api_end)
}

impl AlertRequests {
    /// Submits a request; the answer contains the alert after the change.
    ///
    /// # Errors
    /// The queue is full.
    pub fn submit(
        &self,
        request: AlertRequest,
    ) -> Result<oneshot::Receiver<Result<Alert, AlertRequestError>>, AlertRequestError> {
        let (answer, answered) = oneshot::channel();
        let sent = self.requests.try_send(PendingAlertRequest { request, answer });
        sent.map(|()| answered).map_err(|_| AlertRequestError::Busy)
    }

    /// Pending requests, for the only observer.
    pub(super) async fn pending(&self) -> tokio::sync::OwnedMutexGuard<mpsc::Receiver<PendingAlertRequest>> {
        self.pending.clone().lock_owned().await
    }

    /// Sends the line of a decision to the recorder.
    pub(super) fn record(&self, line: String) {
        if self.lines.try_send(line.into()).is_err() {
            warn!("a decision about an alert is not recorded: the engine takes none");
        }
    }

    /// Replaces the lines of the shelved alerts, for the state file.
    pub(super) fn keep_shelves(&self, shelves: String) {
        self.shelves.send_replace(shelves.into());
    }
}

impl AlertRecordQueue {
    /// Lines of the decisions since the last call.
    pub(super) fn lines(&self) -> impl Iterator<Item = Arc<str>> {
        self.lines.try_iter()
    }

    /// Lines of the shelved alerts.
    pub(super) fn shelves(&self) -> Arc<str> {
        self.shelves.borrow().clone()
    }
}
