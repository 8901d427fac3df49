//! A node's reading of the log for a cell.

use std::sync::mpsc::Sender;
use std::time::Duration;

use tracing::warn;

use super::desk::{Desk, moment};
use super::locked;
use crate::cluster::cell::{Read, Refusals};
use crate::cluster::cells::Audience;
use crate::cluster::log::{Log, Reading};
use crate::cluster::message::{Header, Logged};
use crate::cluster::seat::{Told, clocks, tell};
use crate::territory::CellName;
use fusion::time::Time;

/// A gateway whose messages are refused is named at most this often.
const NAMED_AGAIN: Duration = Duration::from_secs(60);

/// Tells the cell what comes in a stream.
pub(super) async fn read(
    mut reading: Reading,
    to_cell: Sender<Told>,
    of: impl AsyncFn(u64, bytes::Bytes, (Time, bool)) -> Told,
) {
    loop {
        let Some((sequence, octets)) = reading.next().await else {
            warn!("the log has lost what it held: begun anew");
            tell(&to_cell, Told::Unseated);
            return;
        };
        let place = (reading.stamp(), reading.has_more());
        if !tell(&to_cell, of(sequence, octets, place).await) {
            return;
        }
    }
}

/// A message of the input, for that cell: its octets and their sequence, when the log stamped it, and whether the log held more.
pub(super) fn input(
    log: &Log,
    (cell, audience): (&CellName, &Audience),
    (sequence, octets): (u64, &[u8]),
    (stamp, has_more): (Time, bool),
) -> Told {
    let at = clocks();
    log.note_input(sequence);
    let read = Header::of(octets).and_then(|header| {
        let logged = Logged::parse(octets, cell, audience)?;
        Ok(Read { stamp, at, header, logged, has_more })
    });
    match read {
        Ok(read) => Told::Input(sequence, read.into()),
        Err(_) => {
            log.skips.unreadable("in", octets);
            Told::NoInput(has_more)
        }
    }
}

impl Desk {
    /// Counts messages that were refused, and names their gateways: once a minute.
    pub(super) fn refused(&self, refusals: &Refusals) {
        for ((gateway, why), (messages, by)) in refusals {
            self.note(|counts| counts.refused += messages);
            let mut named = locked(&self.shared.refused);
            let is_due = named.get(gateway).is_none_or(|at| at.elapsed() > NAMED_AGAIN);
            if is_due {
                named.insert(gateway.clone(), moment());
                let (by_s, why) = (by.as_secs_f64(), why.words());
                warn!(gateway, messages, by_s, "inputs are refused: {why}");
            }
        }
    }
}
