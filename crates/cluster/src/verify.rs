//! Verification from outside: each slot is published once, in time, and with the picture that its inputs produce.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use jiff::SignedDuration;
use serde::Serialize;

use super::cell::{Cell, CellLoss};
use super::cells::Cells;
use super::engine::SiteEngine;
use super::log::{Log, LogError};
use super::message::{CellOutput, LoggedMessage};
use super::reference_clock::ClockReading;
use fusion::slots::SlotGrid;
use service::live::now;
use site::areas::Areas;
use site::config::{Cluster, Config};
use site::territory::CellName;

/// Lateness from which on a slot counts as late, in seconds.
const LATE_S: f64 = 1.0;

/// Result of the verification of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verification {
    /// Number of slots published.
    pub slots: u64,
    /// Number of slots published more than once.
    pub doubled: u64,
    /// Number of slots missing between others.
    pub missing: u64,
    /// Number of slots published more than a second after they were due.
    pub late: u64,
    /// Greatest lateness, in seconds.
    pub latest_s: f64,
    /// Number of slots published more than a second before they were due.
    pub early: u64,
    /// Number of outputs and inputs that cannot be read, or that no member can have written.
    pub skipped: u64,
    /// Number of outputs that differ from the slot made here, while another output of the same slot matches.
    pub foreign: u64,
    /// Number of slots made here from the same inputs.
    pub made: u64,
    /// Whether one of them differs from the owner's. `None` if there was no checkpoint to start from.
    pub differs: Option<bool>,
    /// Number of inputs.
    pub inputs: u64,
    /// Number of datagrams in the inputs.
    pub datagrams: u64,
    /// Lease numbers of the owners.
    pub epochs: Vec<u64>,
}

impl Verification {
    /// Whether no problem was found.
    pub fn is_good(&self) -> bool {
        let Self { slots, differs, .. } = *self;
        let bad = [self.doubled, self.missing, self.late, self.early, self.skipped, self.foreign];
        slots > 0 && bad == [0; 6] && differs != Some(true)
    }
}

/// Watches a cell for the time `lasts`, and makes its slots again.
///
/// # Errors
/// The log does not answer.
pub async fn verify(
    log: &Log,
    cluster: &Cluster,
    config: &Arc<Config>,
    areas: &Areas,
    (cells, name): (&Cells, &CellName),
    lasts: Duration,
) -> Result<Verification, LogError> {
    let (cell, audience) = (name.as_str(), cells.audience(config, name));
    let grid = SlotGrid::new(config.fusion.slot);
    let due_after = config.fusion.latency() - config.fusion.slot / 2;
    let kept = log.checkpoint(cell).await?;
    let is_known = match &kept {
        Some(kept) => log.matches_streams(kept).await?,
        None => false,
    };
    let kept = kept.filter(|_| is_known);
    let began = kept.and_then(|kept| {
        let engine = cells.engine(config, areas.masks(), now(), name);
        let engine = engine.restored(areas.masks(), &kept.engine).ok()?;
        let wait = SignedDuration::from_nanos((cluster.wait_s * 1e9) as i64);
        Some((Cell::new(engine, grid, wait, kept.handled, kept.published), kept.handled, kept.published))
    });
    let (reproduced, handled, published) = match began {
        Some((reproduced, handled, published)) => (Some(reproduced), handled, published),
        None => (None, 0, 0),
    };
    // Slots from before the start are needed for the state, but not for their time.
    let last = log.last(cell).await?.map_or(0, |(sequence, _)| sequence);
    let after = |sequence: u64| if reproduced.is_some() { sequence + 1 } else { 0 };
    let (mut inputs, mut outputs) = (log.inputs(after(handled)), log.outputs(cell, after(published)));
    let mut verdict = Verification { differs: reproduced.as_ref().map(|_| false), ..Verification::default() };
    let reproducer = reproduced.map(Reproducer::start).transpose()?;
    let mut seen = BTreeMap::new();
    let ends = tokio::time::sleep(lasts);
    tokio::pin!(ends);
    loop {
        tokio::select! {
            () = &mut ends => break,
            input = inputs.next() => {
                let Some((sequence, octets)) = input else { break };
                log.note_input(sequence);
                let logged = match LoggedMessage::parse(&octets, name, &audience) {
                    Ok(Some(logged)) => logged,
                    Ok(None) => continue,
                    Err(_) => {
                        verdict.skipped += 1;
                        continue;
                    }
                };
                verdict.inputs += 1;
                if let LoggedMessage::Input(input) = &logged {
                    verdict.datagrams += input.datagrams.len() as u64;
                }
                reproducer.iter().for_each(|reproducer| reproducer.send(VerifierInput::Input(sequence, logged.clone())));
            }
            output = outputs.next() => {
                let Some((sequence, octets)) = output else { break };
                let Some(output) = log.validated_when_available(cell, &octets).await else {
                    verdict.skipped += u64::from(sequence > last);
                    continue;
                };
                if sequence > last {
                    let due = grid.centre(output.slot) + due_after;
                    let late_s = (now() - due).as_secs_f64();
                    verdict.slots += 1;
                    verdict.late += u64::from(late_s > LATE_S);
                    verdict.early += u64::from(late_s < -LATE_S);
                    verdict.latest_s = verdict.latest_s.max(late_s);
                    verdict.doubled += u64::from(seen.insert(output.slot, ()).is_some());
                    if verdict.epochs.last() != Some(&output.epoch) {
                        verdict.epochs.push(output.epoch);
                    }
                }
                reproducer.iter().for_each(|reproducer| reproducer.send(VerifierInput::Output(sequence, output.clone())));
            }
        }
    }
    if let Some(reproducer) = reproducer {
        let ended = tokio::task::spawn_blocking(|| reproducer.end()).await;
        let Reproduction { made, foreign, differs } =
            ended.map_err(|panic| LogError::Unusable(panic.to_string()))?;
        (verdict.made, verdict.foreign, verdict.differs) = (made, foreign, Some(differs));
    }
    if let (Some((first, ())), Some((last, ()))) = (seen.first_key_value(), seen.last_key_value()) {
        verdict.missing = (last.0 - first.0 + 1).unsigned_abs() - seen.len() as u64;
    }
    Ok(verdict)
}

/// A message of the log for the cell.
enum VerifierInput {
    Input(u64, LoggedMessage),
    Output(u64, CellOutput),
}

/// Makes the slots again on a thread of its own. It starts from a checkpoint and has to catch up, while the arrival of new
/// messages has to be observed without delay.
struct Reproducer {
    read: Sender<VerifierInput>,
    thread: JoinHandle<Reproduction>,
}

impl Reproducer {
    fn start(reproduced: Cell<SiteEngine>) -> Result<Self, LogError> {
        let (read, reads) = channel();
        let thread = std::thread::Builder::new()
            .name("once more".to_owned())
            .spawn(move || reproduce(reproduced, &reads))
            .map_err(|error| LogError::Unusable(error.to_string()))?;
        Ok(Self { read, thread })
    }

    /// Passes a message to the thread, which has ended if the slots differ.
    fn send(&self, read: VerifierInput) {
        _ = self.read.send(read);
    }

    /// Result for all messages read.
    fn end(self) -> Reproduction {
        drop(self.read);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// The slots that were made again.
struct Reproduction {
    /// Number of slots.
    made: u64,
    /// Number of outputs skipped because no owner can have written them.
    foreign: u64,
    /// Whether a slot differs from the owner's.
    differs: bool,
}

fn reproduce(mut reproduced: Cell<SiteEngine>, reads: &Receiver<VerifierInput>) -> Reproduction {
    let mut read = 0;
    let made = |read: u64, reproduced: &Cell<SiteEngine>, differs| Reproduction {
        made: read.saturating_sub(reproduced.outstanding() + reproduced.foreign()),
        foreign: reproduced.foreign(),
        differs,
    };
    while let Ok(first) = reads.recv() {
        for message in std::iter::once(first).chain(reads.try_iter()) {
            match message {
                VerifierInput::Input(sequence, logged) => reproduced.add_input(sequence, logged),
                VerifierInput::Output(sequence, output) => {
                    read += 1;
                    // This cell never owns anything: all outputs are other nodes'.
                    _ = reproduced.handle_output(sequence, output);
                }
            }
        }
        if let Err(lost) = reproduced.pump(ClockReading::default()) {
            return made(read, &reproduced, lost == CellLoss::Diverged);
        }
    }
    // No output follows the last slot that would show whether another one matches.
    made(read, &reproduced, reproduced.differs())
}
