//! Delivery of a cell's messages to other cells: in order, each until it is in the log.

use std::time::Duration;

use tokio::sync::mpsc::UnboundedReceiver;
use tracing::debug;

use crate::log::{Log, LogError};
use crate::region::{CellMessage, number_table};

/// Pause before a failed delivery is repeated.
const RETRY_PAUSE: Duration = Duration::from_millis(100);

/// Delivers the messages until the channel is closed. A new owner sends the latest again, so those lost with this node are not
/// missing.
pub(super) async fn deliver(log: Log, mut messages: UnboundedReceiver<CellMessage>) {
    while let Some(message) = messages.recv().await {
        while let Err(error) = deliver_message(&log, &message).await {
            debug!(%error, to = %message.to, "a letter is not sent: tried again");
            tokio::time::sleep(RETRY_PAUSE).await;
        }
    }
}

/// Delivers a message. The table of numbers answers requests itself; the answer is delivered like any other message.
async fn deliver_message(log: &Log, message: &CellMessage) -> Result<(), LogError> {
    if message.to != number_table() {
        return log.publish_message(message).await;
    }
    match log.answer_number_request(message).await? {
        Some(answer) => log.publish_message(&answer).await,
        None => Ok(()),
    }
}
