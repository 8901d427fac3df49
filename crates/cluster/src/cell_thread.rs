//! A cell's thread on a node: runs the engine without access to network and log.

use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use jiff::SignedDuration;
use tokio::sync::mpsc::UnboundedSender;

use super::cell::{AppendResult, Cell, CellLoss, InputRecord, InputRefusals, LogRequest, Tail};
use super::engine::SiteEngine;
use super::message::CellOutput;
use super::overload::SheddingLevel;
use super::reference_clock::ClockReading;
use super::region::CellMessage;
use super::report::CellReport;
use fusion::Identity;
use fusion::time::{SECOND, Time};
use service::live::now;

/// Maximum time between two checks of the clock: a slot without sensor data is made at most this late.
const CLOCK_CHECK_INTERVAL: Duration = Duration::from_millis(20);
/// Interval at which the cell reports its numbers, so that they are written again if their table was lost.
const CLAIM_INTERVAL: SignedDuration = SignedDuration::from_secs(60);
/// Maximum number of queued messages handled before slots are made.
const MAX_QUEUED_INPUTS: usize = 1000;

/// Message to the cell's thread.
#[derive(Debug)]
pub(super) enum CellInput {
    /// An input, with its sequence.
    Input(u64, Box<InputRecord>),
    /// An unreadable input. The value states whether the log held more.
    UnreadableInput(bool),
    /// An output of the cell, with its sequence.
    Output(u64, CellOutput),
    /// A message among the cell's outputs that is not a valid output, by its sequence.
    Skipped(u64),
    /// Whether a node holds the lease.
    Lease(bool),
    /// Whether the lease names another node, so that publication is suspended until the owner is known.
    Suspend(bool),
    /// Answer to a request for the lease.
    LeaseAnswer(Option<u64>),
    /// Answer to a request for the outputs after a sequence.
    Tail(Result<Tail, ()>),
    /// Answer to a request to append an output.
    Appended(AppendResult),
    /// The lease expired, and was created again under this number.
    LeaseRecreated(u64),
    /// Another node has the standby role.
    StandbyLost,
    /// A checkpoint is requested.
    WriteCheckpoint,
    /// The cell, or the standby role, is left to another node.
    HandOver,
    /// The thread has to end.
    Stop,
}

/// Message from the cell's thread.
#[derive(Debug)]
pub(super) enum CellEvent {
    /// A request to the log.
    Request(LogRequest),
    /// This node owns the cell from now on, under this lease number.
    Owns(u64),
    /// A checkpoint: sequences of the last input and of the last output, and the engine's state.
    Checkpoint(u64, u64, Vec<u8>),
    /// The owner's report of the cell.
    Report(Box<CellReport>),
    /// Number of the owner's slots that this node has not reproduced yet.
    Behind(u64),
    /// The cell has to be restarted. The second value is the last output that was reproduced as published.
    Lost(CellLoss, u64),
    /// Another node has the standby role.
    StandbyLost,
    /// This node leaves the cell, or the standby role, to another node.
    HandedOver,
    /// Level of load shedding from now on.
    LevelChanged(SheddingLevel),
    /// Number of outputs skipped because no owner can have written them.
    Foreign(u64),
    /// Messages refused within the last second.
    Refused(InputRefusals),
    /// Messages to other cells.
    Messages(Vec<CellMessage>),
    /// The cell's share of the region's numbers: blocks, and numbers of identities.
    Claims(Vec<u32>, Vec<(Identity, u32)>),
}

/// Runs the cell until it is stopped or lost.
pub(super) fn run_cell(
    mut cell: Cell<SiteEngine>,
    node: &str,
    inputs: &Receiver<CellInput>,
    events: &UnboundedSender<CellEvent>,
) {
    let (mut owned, mut next_report, mut is_checkpoint_wanted) = (None, Time::default(), false);
    let (mut next_claims, mut level, mut foreign) = (Time::default(), SheddingLevel::default(), 0);
    loop {
        let timeout = if cell.has_due_slots() { Duration::ZERO } else { CLOCK_CHECK_INTERVAL };
        let first = match inputs.recv_timeout(timeout) {
            Ok(inputs) => Some(inputs),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        let at_once = first.into_iter().chain(inputs.try_iter().take(MAX_QUEUED_INPUTS));
        for inputs in at_once {
            let result = match inputs {
                CellInput::Stop => return,
                CellInput::StandbyLost => {
                    _ = events.send(CellEvent::StandbyLost);
                    return;
                }
                CellInput::HandOver => {
                    _ = events.send(CellEvent::HandedOver);
                    return;
                }
                CellInput::WriteCheckpoint => {
                    is_checkpoint_wanted = true;
                    Ok(())
                }
                inputs => handle(&mut cell, inputs),
            };
            if let Err(lost) = result {
                _ = events.send(CellEvent::Lost(lost, cell.published()));
                return;
            }
        }
        cell.request_rest(is_checkpoint_wanted);
        if let Err(lost) = cell.pump(clocks()) {
            _ = events.send(CellEvent::Lost(lost, cell.published()));
            return;
        }
        cell.update_level(clocks());
        // Use reference time, so that reports do not depend on this machine's clock.
        let at = cell.now(clocks());
        if cell.level() != level {
            level = cell.level();
            _ = events.send(CellEvent::LevelChanged(level));
        }
        if cell.epoch() != owned {
            owned = cell.epoch();
            owned.into_iter().for_each(|epoch| _ = events.send(CellEvent::Owns(epoch)));
            next_claims = at;
        }
        if cell.foreign() != foreign {
            foreign = cell.foreign();
            _ = events.send(CellEvent::Foreign(foreign));
        }
        let messages: Vec<CellMessage> = std::iter::from_fn(|| cell.next_message()).collect();
        if !messages.is_empty() {
            _ = events.send(CellEvent::Messages(messages));
        }
        cell.next_request().into_iter().for_each(|request| _ = events.send(CellEvent::Request(request)));
        // Before the first output there is no state to continue from.
        if is_checkpoint_wanted && let Some((handled, published @ 1..)) = cell.rest_sequences() {
            is_checkpoint_wanted = false;
            _ = events.send(CellEvent::Checkpoint(handled, published, cell.engine().checkpoint()));
        }
        // The clock was set back.
        if at >= next_report || next_report.nanos() - at.nanos() > SECOND {
            next_report = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
            let refusals = cell.refusals();
            if !refusals.is_empty() {
                _ = events.send(CellEvent::Refused(refusals));
            }
            if owned.is_some() && (at >= next_claims || next_claims - at > CLAIM_INTERVAL) {
                next_claims = at + CLAIM_INTERVAL;
                let (blocks, numbers) = cell.engine().claims();
                if !blocks.is_empty() {
                    _ = events.send(CellEvent::Claims(blocks, numbers));
                }
            }
            _ = match owned {
                Some(epoch) => {
                    events.send(CellEvent::Report(cell.engine_mut().report(node, epoch, at).into()))
                }
                None => events.send(CellEvent::Behind(cell.outstanding())),
            };
        }
    }
}

fn handle(cell: &mut Cell<SiteEngine>, inputs: CellInput) -> Result<(), CellLoss> {
    match inputs {
        CellInput::Input(sequence, read) => cell.read_input(sequence, *read),
        CellInput::UnreadableInput(has_more) => cell.set_has_more(has_more),
        CellInput::Output(sequence, output) => cell.handle_output(sequence, output)?,
        CellInput::Skipped(sequence) => cell.skip_output(sequence),
        CellInput::Lease(is_held) => cell.set_lease_held(is_held),
        CellInput::Suspend(is_held_back) => cell.set_suspended(is_held_back),
        CellInput::LeaseAnswer(epoch) => cell.handle_lease(epoch),
        CellInput::LeaseRecreated(epoch) => cell.handle_recreated_lease(epoch),
        CellInput::Tail(last) => cell.handle_tail(last)?,
        CellInput::Appended(appended) => cell.handle_append(appended),
        CellInput::WriteCheckpoint | CellInput::Stop | CellInput::StandbyLost | CellInput::HandOver => {}
    }
    Ok(())
}

/// The clocks of this process.
pub(super) fn clocks() -> ClockReading {
    ClockReading { steady: steady(), wall: now() }
}

/// Time since the process started, by a clock that is never set.
#[expect(clippy::disallowed_methods, reason = "what is due is timed by a clock that nobody sets")]
pub(super) fn steady() -> SignedDuration {
    static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
    SignedDuration::try_from(BEGAN.elapsed()).unwrap_or(SignedDuration::MAX)
}

/// Sends a message to the cell's thread. Returns whether the thread is still running.
pub(super) fn send(cell_thread: &Sender<CellInput>, inputs: CellInput) -> bool {
    cell_thread.send(inputs).is_ok()
}
