//! Letters of a cell, on their way: in order, each until it is in the log.

use std::time::Duration;

use tokio::sync::mpsc::UnboundedReceiver;
use tracing::debug;

use crate::cluster::log::{Log, LogError};
use crate::cluster::region::{Letter, numbers_office};

/// Pause before a letter is tried again.
const AGAIN: Duration = Duration::from_millis(100);

/// Sends what comes, until nobody writes any more. Whoever takes over sends the latest again: so what is lost with this node is
/// not lost.
pub(super) async fn deliver(log: Log, mut letters: UnboundedReceiver<Letter>) {
    while let Some(letter) = letters.recv().await {
        while let Err(error) = sent(&log, &letter).await {
            debug!(%error, to = %letter.to, "a letter is not sent: tried again");
            tokio::time::sleep(AGAIN).await;
        }
    }
}

/// Who keeps the numbers is a table of the log: what it answers comes as a letter like any other.
async fn sent(log: &Log, letter: &Letter) -> Result<(), LogError> {
    if letter.to != numbers_office() {
        return log.post(letter).await;
    }
    match log.answer(letter).await? {
        Some(answer) => log.post(&answer).await,
        None => Ok(()),
    }
}
