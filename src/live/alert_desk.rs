//! The way of operators' decisions about alerts: from readers to the observer, who owns the alerts, and on to the engine's
//! thread, which has the recorder and the keepers.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use tokio::sync::{Mutex, mpsc, oneshot, watch};
use tracing::warn;

use super::alerts::{Alert, AlertWish, NotDone};

/// Most wishes that may wait for the observer.
const WISHES: usize = 64;
/// Most lines that may wait for the engine's thread, which takes them ten times a second.
const LINES: usize = 1_024;

/// A wish, and who waits for what comes of it.
#[derive(Debug)]
pub(super) struct Asked {
    pub(super) wish: AlertWish,
    pub(super) answer: oneshot::Sender<Result<Alert, NotDone>>,
}

/// The readers' side; cheap to clone.
#[derive(Clone, Debug)]
pub struct AlertDesk {
    asked: mpsc::Sender<Asked>,
    /// For the one observer.
    wishes: Arc<Mutex<mpsc::Receiver<Asked>>>,
    lines: SyncSender<Arc<str>>,
    shelves: Arc<watch::Sender<Arc<str>>>,
}

/// The engine's side.
#[derive(Debug)]
pub struct AlertRecords {
    lines: Receiver<Arc<str>>,
    shelves: watch::Receiver<Arc<str>>,
}

/// Both sides.
pub(super) fn alert_desk() -> (AlertRecords, AlertDesk) {
    let (asked, wishes) = mpsc::channel(WISHES);
    let (line_sender, lines) = sync_channel(LINES);
    let (shelf_sender, shelves) = watch::channel(Arc::from(""));
    let wishes = Arc::new(Mutex::new(wishes));
    let desk = AlertDesk { asked, wishes, lines: line_sender, shelves: Arc::new(shelf_sender) };
    (AlertRecords { lines, shelves }, desk)
}

impl AlertDesk {
    /// Asks for something to be done; the answer holds the alert as it is then.
    ///
    /// # Errors
    /// Too many wait.
    pub fn ask(&self, wish: AlertWish) -> Result<oneshot::Receiver<Result<Alert, NotDone>>, NotDone> {
        let (answer, answered) = oneshot::channel();
        let sent = self.asked.try_send(Asked { wish, answer });
        sent.map(|()| answered).map_err(|_| NotDone::Busy)
    }

    /// What is asked for; there is one observer.
    pub(super) async fn wishes(&self) -> tokio::sync::OwnedMutexGuard<mpsc::Receiver<Asked>> {
        self.wishes.clone().lock_owned().await
    }

    /// Hands on the line of a decision.
    pub(super) fn record(&self, line: String) {
        if self.lines.try_send(line.into()).is_err() {
            warn!("a decision about an alert is not recorded: the engine takes none");
        }
    }

    /// Hands on the lines of what is shelved.
    pub(super) fn keep(&self, shelves: String) {
        self.shelves.send_replace(shelves.into());
    }
}

impl AlertRecords {
    /// The lines of the decisions since the last call.
    pub(super) fn lines(&self) -> impl Iterator<Item = Arc<str>> {
        self.lines.try_iter()
    }

    /// The lines of what is shelved.
    pub(super) fn shelves(&self) -> Arc<str> {
        self.shelves.borrow().clone()
    }
}
