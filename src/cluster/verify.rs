//! A look from outside: does each slot come once, in time, and is it what its inputs make?

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use jiff::SignedDuration;
use serde::Serialize;

use super::cell::{Cell, Lost};
use super::cells::Cells;
use super::engine::SiteEngine;
use super::log::{Log, LogError};
use super::message::{Logged, Output};
use super::reference_clock::Moment;
use crate::areas::Areas;
use crate::config::{Cluster, Config};
use crate::live::now;
use crate::territory::CellName;
use fusion::slots::SlotGrid;

/// A slot counts as late from here on, seconds.
const LATE_S: f64 = 1.0;

/// What was seen of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// Slots that came.
    pub slots: u64,
    /// Of these, such that had come before.
    pub doubled: u64,
    /// Slots between two that did not come.
    pub missing: u64,
    /// Slots that came more than a second after they were due.
    pub late: u64,
    /// The latest of them, seconds after it was due.
    pub latest_s: f64,
    /// Slots that came more than a second before they were due.
    pub early: u64,
    /// Messages among outputs and inputs that cannot be read, or that no member can have written.
    pub skipped: u64,
    /// Outputs that differ from what is made here, while another one of the same slot does not.
    pub foreign: u64,
    /// Slots that were made here, too, from the same inputs.
    pub made: u64,
    /// Whether one of these was another one than that of the owner. `None`: there was no checkpoint to begin from.
    pub differs: Option<bool>,
    /// Messages of the input that came, and datagrams in them.
    pub inputs: u64,
    /// Datagrams in these.
    pub datagrams: u64,
    /// Owners that were seen: the numbers of their leases.
    pub epochs: Vec<u64>,
}

impl Verdict {
    /// Whether nothing is wrong.
    pub fn is_good(&self) -> bool {
        let Self { slots, differs, .. } = *self;
        let bad = [self.doubled, self.missing, self.late, self.early, self.skipped, self.foreign];
        slots > 0 && bad == [0; 6] && differs != Some(true)
    }
}

/// Watches a cell for some time, and makes its slots once more.
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
) -> Result<Verdict, LogError> {
    let (cell, audience) = (name.as_str(), cells.audience(config, name));
    let grid = SlotGrid::new(config.fusion.slot);
    let due_after = config.fusion.latency() - config.fusion.slot / 2;
    let kept = log.checkpoint(cell).await?;
    let is_known = match &kept {
        Some(kept) => log.knows(kept).await?,
        None => false,
    };
    let kept = kept.filter(|_| is_known);
    let began = kept.and_then(|kept| {
        let engine = cells.engine(config, areas.masks(), now(), name);
        let engine = engine.restored(areas.masks(), &kept.engine).ok()?;
        let wait = SignedDuration::from_nanos((cluster.wait_s * 1e9) as i64);
        Some((Cell::new(engine, grid, wait, kept.handled, kept.published), kept.handled, kept.published))
    });
    let (alone, handled, published) = match began {
        Some((alone, handled, published)) => (Some(alone), handled, published),
        None => (None, 0, 0),
    };
    // Of what was before only the state is of interest, not whether it came in time.
    let last = log.last(cell).await?.map_or(0, |(sequence, _)| sequence);
    let after = |sequence: u64| if alone.is_some() { sequence + 1 } else { 0 };
    let (mut inputs, mut outputs) = (log.inputs(after(handled)), log.outputs(cell, after(published)));
    let mut verdict = Verdict { differs: alone.as_ref().map(|_| false), ..Verdict::default() };
    let maker = alone.map(Maker::start).transpose()?;
    let mut seen = BTreeMap::new();
    let ends = tokio::time::sleep(lasts);
    tokio::pin!(ends);
    loop {
        tokio::select! {
            () = &mut ends => break,
            input = inputs.next() => {
                let Some((sequence, octets)) = input else { break };
                log.note_input(sequence);
                let logged = match Logged::parse(&octets, name, &audience) {
                    Ok(Some(logged)) => logged,
                    Ok(None) => continue,
                    Err(_) => {
                        verdict.skipped += 1;
                        continue;
                    }
                };
                verdict.inputs += 1;
                if let Logged::Input(input) = &logged {
                    verdict.datagrams += input.heard.len() as u64;
                }
                maker.iter().for_each(|maker| maker.tell(Read::Input(sequence, logged.clone())));
            }
            output = outputs.next() => {
                let Some((sequence, octets)) = output else { break };
                let Some(output) = log.worth(cell, &octets).await else {
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
                maker.iter().for_each(|maker| maker.tell(Read::Output(sequence, output.clone())));
            }
        }
    }
    if let Some(maker) = maker {
        let ended = tokio::task::spawn_blocking(|| maker.end()).await;
        let Made { made, foreign, differs } = ended.map_err(|panic| LogError::Unusable(panic.to_string()))?;
        (verdict.made, verdict.foreign, verdict.differs) = (made, foreign, Some(differs));
    }
    if let (Some((first, ())), Some((last, ()))) = (seen.first_key_value(), seen.last_key_value()) {
        verdict.missing = (last.0 - first.0 + 1).unsigned_abs() - seen.len() as u64;
    }
    Ok(verdict)
}

/// What the log holds of a cell.
enum Read {
    Input(u64, Logged),
    Output(u64, Output),
}

/// Makes the slots once more, on a thread of its own: it begins up to a checkpoint's age ago, and while it catches up what comes
/// is to be looked at when it comes.
struct Maker {
    read: Sender<Read>,
    thread: JoinHandle<Made>,
}

impl Maker {
    fn start(alone: Cell<SiteEngine>) -> Result<Self, LogError> {
        let (read, reads) = channel();
        let thread = std::thread::Builder::new()
            .name("once more".to_owned())
            .spawn(move || make(alone, &reads))
            .map_err(|error| LogError::Unusable(error.to_string()))?;
        Ok(Self { read, thread })
    }

    /// Nobody hears it any more once the slots differ.
    fn tell(&self, read: Read) {
        _ = self.read.send(read);
    }

    /// The slots made from all that was read.
    fn end(self) -> Made {
        drop(self.read);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// The slots that were made once more.
struct Made {
    /// Slots.
    made: u64,
    /// Outputs that were left out because no owner can have made them.
    foreign: u64,
    /// Whether a slot is another one than the owner's.
    differs: bool,
}

fn make(mut alone: Cell<SiteEngine>, reads: &Receiver<Read>) -> Made {
    let mut read = 0;
    let made = |read: u64, alone: &Cell<SiteEngine>, differs| Made {
        made: read.saturating_sub(alone.behind() + alone.foreign()),
        foreign: alone.foreign(),
        differs,
    };
    while let Ok(first) = reads.recv() {
        for message in std::iter::once(first).chain(reads.try_iter()) {
            match message {
                Read::Input(sequence, logged) => alone.input(sequence, logged),
                Read::Output(sequence, output) => {
                    read += 1;
                    // It never owns anything: what comes is what others publish.
                    _ = alone.output(sequence, output);
                }
            }
        }
        if let Err(lost) = alone.pump(Moment::default()) {
            return made(read, &alone, lost == Lost::Diverged);
        }
    }
    // The last slot has no other one behind it that would show whose it is.
    made(read, &alone, alone.differs())
}
