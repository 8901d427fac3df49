//! A cell on a node: the engine on a thread of its own, which knows neither network nor log.

use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use jiff::SignedDuration;
use tokio::sync::mpsc::UnboundedSender;

use super::cell::{Appended, Cell, Lost, Read, Refusals, Tail, Wish};
use super::engine::SiteEngine;
use super::message::Output;
use super::reference_clock::Moment;
use super::region::Letter;
use super::relief::Step;
use super::report::CellReport;
use crate::live::now;
use fusion::Identity;
use fusion::time::{SECOND, Time};

/// Longest time between two looks at the clock: a slot that nobody was heard for is made this late at most.
const LOOK_UP: Duration = Duration::from_millis(20);
/// How often it says which numbers are its own, so that they are written anew where the table of them was lost.
const CLAIMS: SignedDuration = SignedDuration::from_secs(60);
/// Most of what waits that is taken in before slots are looked for.
const AT_ONCE: usize = 1000;

/// What the cell is told.
#[derive(Debug)]
pub(super) enum Told {
    /// A message of the input, and its sequence.
    Input(u64, Box<Read>),
    /// A message of the input that cannot be read; whether the log held more.
    NoInput(bool),
    /// An output of the cell, and its sequence.
    Output(u64, Output),
    /// A message among the outputs of the cell that is none.
    Skipped(u64),
    /// Whether somebody holds the lease.
    Lease(bool),
    /// Whether another name stands in the lease, and nothing is to be published until it is known whose it is.
    HoldBack(bool),
    /// Answers to what it wished.
    Leased(Option<u64>),
    /// The outputs behind the sequence that was asked for.
    Last(Result<Tail, ()>),
    /// What has become of its own.
    Appended(Appended),
    /// The lease ran out, and is held anew.
    LeasedAgain(u64),
    /// Somebody else has the seat beside the owner.
    Unseated,
    /// A checkpoint is wanted.
    Write,
    /// The cell, or the seat, is left to another node.
    Move,
    /// It is to end.
    Stop,
}

/// What the cell says.
#[derive(Debug)]
pub(super) enum Says {
    /// It asks the log.
    Wish(Wish),
    /// It owns the cell from now on, under this number.
    Owns(u64),
    /// A checkpoint: sequences of the last input and of the last output, and the engine.
    Written(u64, u64, Vec<u8>),
    /// How the cell is; of an owner.
    Report(Box<CellReport>),
    /// Slots that wait to be made as the owner has made them.
    Behind(u64),
    /// It has to begin anew; the last output that it had made as it was published.
    Lost(Lost, u64),
    /// Somebody else has its seat.
    Unseated,
    /// It leaves the cell, or the seat, to another node.
    Moved,
    /// What is left out from now on.
    Relieved(Step),
    /// Outputs that were left out because no owner can have made them.
    Foreign(u64),
    /// Messages that were refused within the last second.
    Refused(Refusals),
    /// Letters to others.
    Post(Vec<Letter>),
    /// What of the region's numbers is the cell's: blocks, and those of identities.
    Claims(Vec<u32>, Vec<(Identity, u32)>),
}

/// Works until it is stopped, or lost.
pub(super) fn work(
    mut cell: Cell<SiteEngine>,
    node: &str,
    told: &Receiver<Told>,
    says: &UnboundedSender<Says>,
) {
    let (mut owned, mut next_report, mut is_wanted) = (None, Time::default(), false);
    let (mut next_claims, mut step, mut foreign) = (Time::default(), Step::default(), 0);
    loop {
        let patience = if cell.is_pressed() { Duration::ZERO } else { LOOK_UP };
        let first = match told.recv_timeout(patience) {
            Ok(told) => Some(told),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        let at_once = first.into_iter().chain(told.try_iter().take(AT_ONCE));
        for told in at_once {
            let heard = match told {
                Told::Stop => return,
                Told::Unseated => {
                    _ = says.send(Says::Unseated);
                    return;
                }
                Told::Move => {
                    _ = says.send(Says::Moved);
                    return;
                }
                Told::Write => {
                    is_wanted = true;
                    Ok(())
                }
                told => hear(&mut cell, told),
            };
            if let Err(lost) = heard {
                _ = says.send(Says::Lost(lost, cell.published()));
                return;
            }
        }
        cell.want_rest(is_wanted);
        if let Err(lost) = cell.pump(clocks()) {
            _ = says.send(Says::Lost(lost, cell.published()));
            return;
        }
        cell.look(clocks());
        // By reference time: whatever is said of the cell is as if this machine's clock were right.
        let at = cell.now(clocks());
        if cell.step() != step {
            step = cell.step();
            _ = says.send(Says::Relieved(step));
        }
        if cell.epoch() != owned {
            owned = cell.epoch();
            owned.into_iter().for_each(|epoch| _ = says.send(Says::Owns(epoch)));
            next_claims = at;
        }
        if cell.foreign() != foreign {
            foreign = cell.foreign();
            _ = says.send(Says::Foreign(foreign));
        }
        let letters: Vec<Letter> = std::iter::from_fn(|| cell.post()).collect();
        if !letters.is_empty() {
            _ = says.send(Says::Post(letters));
        }
        cell.wish().into_iter().for_each(|wish| _ = says.send(Says::Wish(wish)));
        // Before the first output there is nothing to go on from.
        if is_wanted && let Some((handled, published @ 1..)) = cell.rests_at() {
            is_wanted = false;
            _ = says.send(Says::Written(handled, published, cell.engine().checkpoint()));
        }
        // Also where the clock was set back.
        if at >= next_report || next_report.nanos() - at.nanos() > SECOND {
            next_report = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
            let refusals = cell.refusals();
            if !refusals.is_empty() {
                _ = says.send(Says::Refused(refusals));
            }
            if owned.is_some() && (at >= next_claims || next_claims - at > CLAIMS) {
                next_claims = at + CLAIMS;
                let (blocks, numbers) = cell.engine().claims();
                if !blocks.is_empty() {
                    _ = says.send(Says::Claims(blocks, numbers));
                }
            }
            _ = match owned {
                Some(epoch) => says.send(Says::Report(cell.engine_mut().report(node, epoch, at).into())),
                None => says.send(Says::Behind(cell.behind())),
            };
        }
    }
}

fn hear(cell: &mut Cell<SiteEngine>, told: Told) -> Result<(), Lost> {
    match told {
        Told::Input(sequence, read) => cell.read(sequence, *read),
        Told::NoInput(has_more) => cell.more(has_more),
        Told::Output(sequence, output) => cell.output(sequence, output)?,
        Told::Skipped(sequence) => cell.skip(sequence),
        Told::Lease(is_held) => cell.lease(is_held),
        Told::HoldBack(is_held_back) => cell.hold_back(is_held_back),
        Told::Leased(epoch) => cell.leased(epoch),
        Told::LeasedAgain(epoch) => cell.leased_again(epoch),
        Told::Last(last) => cell.last(last)?,
        Told::Appended(appended) => cell.appended(appended),
        Told::Write | Told::Stop | Told::Unseated | Told::Move => {}
    }
    Ok(())
}

/// The clocks of this process.
#[expect(clippy::disallowed_methods, reason = "what is due is timed by a clock that nobody sets")]
pub(super) fn clocks() -> Moment {
    static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
    let steady = SignedDuration::try_from(BEGAN.elapsed()).unwrap_or(SignedDuration::MAX);
    Moment { steady, wall: now() }
}

/// Tells the cell; whether it still listens.
pub(super) fn tell(seat: &Sender<Told>, told: Told) -> bool {
    seat.send(told).is_ok()
}
