//! Requests of a cell to the log.

use std::sync::mpsc::Sender;
use std::time::Duration;

use super::desk::Desk;
use crate::cluster::cell::{Appended, Tail, Wish};
use crate::cluster::seat::{Told, tell};

/// Pause before the log is asked again where a slot waits for it.
const SOON: Duration = Duration::from_millis(50);

impl Desk {
    /// Asks the log for what the cell wishes, and tells it the answer.
    pub(super) async fn grant(self, wish: Wish, to_cell: Sender<Told>) {
        match wish {
            Wish::Lease => self.take_lease(&to_cell).await,
            Wish::Last(after) => {
                let behind = self.log.behind(self.cell.as_str(), after).await;
                // The lease does not change between this look and the answer.
                let lease = self.hold.lease.lock().await;
                let is_mine = self.is_mine(*lease).await;
                let tail = behind.and_then(|(outputs, last, is_whole)| {
                    Ok(Tail { outputs, last, is_whole, is_mine: is_mine? })
                });
                if tail.is_err() {
                    tokio::time::sleep(SOON).await;
                }
                tell(&to_cell, Told::Last(tail.map_err(drop)));
            }
            Wish::Append { expected, output } => {
                let appended = self.log.append(self.cell.as_str(), expected, &output).await;
                match appended {
                    Appended::Stored(_) => self.note(|counts| counts.published += 1),
                    Appended::Refused => {}
                    // Servers that choose a leader say so at once.
                    Appended::Unknown => tokio::time::sleep(SOON).await,
                }
                tell(&to_cell, Told::Appended(appended));
            }
        }
    }
}
