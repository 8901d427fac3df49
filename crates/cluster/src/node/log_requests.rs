//! Requests of a cell to the log.

use std::sync::mpsc::Sender;
use std::time::Duration;

use super::cell_member::CellMember;
use crate::cell::{AppendResult, LogRequest, Tail};
use crate::cell_thread::{CellInput, send};

/// Pause before the log is asked again while a slot waits.
const RETRY_PAUSE: Duration = Duration::from_millis(50);

impl CellMember {
    /// Sends the cell's request to the log, and returns the answer to the cell.
    pub(super) async fn execute(self, request: LogRequest, to_cell: Sender<CellInput>) {
        match request {
            LogRequest::Lease => self.take_lease(&to_cell).await,
            LogRequest::Tail(after) => {
                let behind = self.log.outputs_after(self.cell.as_str(), after).await;
                // While it is locked, the lease does not change before the answer.
                let lease = self.hold.lease.lock().await;
                let is_mine = self.is_mine(*lease).await;
                let tail = behind.and_then(|(outputs, last, is_complete)| {
                    Ok(Tail { outputs, last, is_complete, is_mine: is_mine? })
                });
                if tail.is_err() {
                    tokio::time::sleep(RETRY_PAUSE).await;
                }
                send(&to_cell, CellInput::Tail(tail.map_err(drop)));
            }
            LogRequest::Append { expected, output } => {
                let appended = self.log.append(self.cell.as_str(), expected, &output).await;
                match appended {
                    AppendResult::Stored(_) => self.update_counts(|counts| counts.published += 1),
                    AppendResult::Refused => {}
                    // Servers without a leader answer at once.
                    AppendResult::Unknown => tokio::time::sleep(RETRY_PAUSE).await,
                }
                send(&to_cell, CellInput::Appended(appended));
            }
        }
    }
}
