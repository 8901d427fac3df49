//! A node's reading of the log for a cell.

use std::sync::mpsc::Sender;
use std::time::Duration;

use tracing::warn;

use super::cell_member::{CellMember, steady_now};
use super::locked;
use crate::audience::Audience;
use crate::cell::{InputRecord, InputRefusals};
use crate::cell_thread::{CellInput, clocks, send};
use crate::log::{Log, SubjectReader};
use crate::message::{InputHeader, LoggedMessage};
use fusion::time::Time;
use site::territory::CellName;

/// Minimum interval of the log lines about refused messages of a gateway.
const LOG_INTERVAL: Duration = Duration::from_secs(60);

/// Passes the messages of a stream to the cell.
pub(super) async fn read(
    mut reading: SubjectReader,
    to_cell: Sender<CellInput>,
    of: impl AsyncFn(u64, bytes::Bytes, (Time, bool)) -> CellInput,
) {
    loop {
        let Some((sequence, octets)) = reading.next().await else {
            warn!("the log has lost what it held: begun anew");
            send(&to_cell, CellInput::StandbyLost);
            return;
        };
        let place = (reading.stamp(), reading.has_more());
        if !send(&to_cell, of(sequence, octets, place).await) {
            return;
        }
    }
}

/// Parses an input for a cell. The arguments are its sequence and octets, the log's timestamp, and whether the log held more.
pub(super) fn input(
    log: &Log,
    (cell, audience): (&CellName, &Audience),
    (sequence, octets): (u64, &[u8]),
    (stamp, has_more): (Time, bool),
) -> CellInput {
    let at = clocks();
    log.note_input(sequence);
    let read = InputHeader::of(octets).and_then(|header| {
        let logged = LoggedMessage::parse(octets, cell, audience)?;
        Ok(InputRecord { stamp, at, header, logged, has_more })
    });
    match read {
        Ok(read) => CellInput::Input(sequence, read.into()),
        Err(_) => {
            log.skips.unreadable("in", octets);
            CellInput::UnreadableInput(has_more)
        }
    }
}

impl CellMember {
    /// Counts refused messages, and logs each of their gateways once a minute.
    pub(super) fn refused(&self, refusals: &InputRefusals) {
        for ((gateway, why), (messages, by)) in refusals {
            self.update_counts(|counts| counts.refused += messages);
            let mut named = locked(&self.shared.refused);
            let is_due = named.get(gateway).is_none_or(|at| at.elapsed() > LOG_INTERVAL);
            if is_due {
                named.insert(gateway.clone(), steady_now());
                let (by_s, why) = (by.as_secs_f64(), why.description());
                warn!(gateway, messages, by_s, "inputs are refused: {why}");
            }
        }
    }
}
