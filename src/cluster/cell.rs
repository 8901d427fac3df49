//! A cell on one node: it follows the owner's output, or owns it.

mod inputs;
mod outputs;

use std::collections::VecDeque;

use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use super::message::{Heard, Logged, Output};
use super::reference_clock::{EARLY, Moment, NodeTime};
use super::region::Letter;
use super::relief::{Relief, Step};
use super::watermarks::Watermarks;
pub use inputs::{Read, Refusals};
use outputs::{Made, Unmatched};

/// What is handled after a slot was made is handled this much later than it was due, and before the next one is by as much.
const APART: SignedDuration = SignedDuration::from_micros(1);
/// Inputs that are refused within a slot, at most: its output is to fit a message. More are handled with the next slot.
const MOST_REFUSED: usize = 10_000;
/// Slots that an owner makes before it looks up.
const AT_ONCE: usize = 4;

/// What a cell does with its inputs: told the same at the same times it makes the same, to the byte.
pub trait Fusing {
    /// Takes in a datagram as received at `at`, which is before the next slot is due.
    fn receive(&mut self, heard: &Heard, at: Time);

    /// Makes the slots that are due by `now`.
    fn tick(&mut self, now: Time);

    /// When the next slot is due; `None` before the first datagram.
    fn next_due(&self) -> Option<Time>;

    /// The next slot that was made, with its picture.
    fn poll(&mut self) -> Option<(Slot, Vec<u8>)>;

    /// Leaves out what a step says from now on, because the machine cannot keep up.
    fn relieve(&mut self, _step: Step) {}

    /// Takes in a letter to this cell.
    fn letter(&mut self, _letter: &Letter) {}

    /// What the slot that was polled last writes to others.
    fn letters(&mut self) -> Vec<Letter> {
        Vec::new()
    }

    /// What the slots of the last 20 s have written: who takes over writes it again.
    fn recent_letters(&self) -> Vec<Letter> {
        Vec::new()
    }
}

/// Why a node has to begin this cell anew, from a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Lost {
    /// The owner has published another picture than this node would have.
    #[error("the state differs from the owner's")]
    Diverged,
    /// Somebody else owns the cell now.
    #[error("another node owns the cell")]
    Fenced,
    /// What the owner has published needs a state that this node has not.
    #[error("the state is too old to follow the owner")]
    Behind,
}

/// What a cell asks of the log; each is answered once, before it asks for another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Create the lease, which nobody holds: [`Cell::leased`].
    Lease,
    /// The cell's outputs behind this sequence: [`Cell::last`].
    Last(u64),
    /// Append, if the last message of the cell's outputs has this sequence (0: there is none): [`Cell::appended`].
    Append {
        /// The sequence.
        expected: u64,
        /// What is published.
        output: Output,
    },
}

/// What has become of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Appended {
    /// It is in the log, with this sequence.
    Stored(u64),
    /// The last output is another one than the expected.
    Refused,
    /// Nobody answered in time.
    Unknown,
}

/// A cell's outputs behind a sequence, as the leader of the stream knows them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tail {
    /// Outputs with their sequences, in order. Messages that are no outputs are left out.
    pub outputs: Vec<(u64, Output)>,
    /// The sequence of the last message that was looked at, whatever it holds; 0: there is none.
    pub last: u64,
    /// Whether there is nothing behind it.
    pub is_whole: bool,
    /// Whether this node certainly holds the lease, so that no other node can have one of a greater number.
    pub is_mine: bool,
}

/// What a node is for a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// It stands by.
    Follows,
    /// It has the lease of this number; `until`: the last output that there was then, once that is known.
    Claims { epoch: u64, until: Option<u64> },
    /// It publishes.
    Owns { epoch: u64 },
}

/// A cell on a node.
#[derive(Debug)]
pub struct Cell<E> {
    engine: E,
    grid: SlotGrid,
    /// How long after a slot is due sensors are waited for.
    wait: SignedDuration,
    role: Role,
    /// Read and not handled yet, with their sequences, and whether an owner refuses them.
    inputs: VecDeque<(u64, Logged, bool)>,
    /// Hash of the shared configuration; 0: inputs of any are used.
    config: u64,
    /// Reference time, by what was read.
    time: NodeTime,
    /// Sequences of inputs that this owner has refused since the slot before, and what is to be said of that.
    refused: Vec<u64>,
    refusals: Refusals,
    /// Sequences of the last input that was read, and of the last that was handled.
    read: u64,
    handled: u64,
    /// Whether the log held more input than was read of it.
    has_more: bool,
    watermarks: Watermarks,
    /// What others published and this node has not made yet.
    outputs: VecDeque<(u64, Output)>,
    /// Sequence of the last output that this node has made, too, or published.
    published: u64,
    /// Sequence of the last message among the outputs that is known, whatever it holds.
    told: u64,
    /// A slot that this node made to compare it, where the outputs read so far hold another picture or an earlier slot.
    unmatched: Option<Unmatched>,
    /// The last slot that is published.
    slot: Option<Slot>,
    /// An output stood behind an input before the last one that was handled, and was left out.
    is_past: bool,
    /// Outputs that were left out because no owner can have made them.
    foreign: u64,
    /// The lease under which an owner's last output was stored.
    stored_epoch: Option<u64>,
    /// Another node publishes under this greater number; whether it holds the lease is not known yet.
    rival: Option<u64>,
    /// Whether that was read before the log was asked last.
    is_rival_asked: bool,
    /// The greatest number of a lease among the outputs that were read.
    greatest_epoch: u64,
    /// The lease names another node: nothing is published until it is known whether that node owns the cell.
    is_held_back: bool,
    /// Own slots that are not in the log yet.
    made: VecDeque<Made>,
    /// Letters that are to be sent.
    post: VecDeque<Letter>,
    /// Slots up to this one are not this node's to publish.
    silent_until: Option<Slot>,
    /// What is left out.
    relief: Relief,
    step: Step,
    is_lease_free: bool,
    /// A state without slots or refused inputs that are not in the log yet is wanted.
    is_rest_wanted: bool,
    /// An answer is awaited; whether the fate of the output in front is in doubt.
    is_asking: bool,
    /// Whether more could be made at once than was.
    is_pressed: bool,
    is_in_doubt: bool,
}

impl<E: Fusing> Cell<E> {
    /// A cell whose engine has handled the inputs up to the sequence `handled` and made the outputs up to `published`; 0: none.
    pub fn new(engine: E, grid: SlotGrid, wait: SignedDuration, handled: u64, published: u64) -> Self {
        Self {
            engine,
            grid,
            wait,
            role: Role::Follows,
            inputs: VecDeque::new(),
            config: 0,
            time: NodeTime::default(),
            refused: Vec::new(),
            refusals: Refusals::default(),
            read: handled,
            handled,
            has_more: false,
            watermarks: Watermarks::default(),
            outputs: VecDeque::new(),
            published,
            told: published,
            unmatched: None,
            slot: None,
            is_past: false,
            foreign: 0,
            stored_epoch: None,
            rival: None,
            is_rival_asked: false,
            greatest_epoch: 0,
            is_held_back: false,
            made: VecDeque::new(),
            post: VecDeque::new(),
            silent_until: None,
            relief: Relief::default(),
            step: Step::default(),
            is_lease_free: false,
            is_rest_wanted: false,
            is_asking: false,
            is_pressed: false,
            is_in_doubt: false,
        }
    }

    /// The same, which publishes no slot up to this one: whoever knew what was in them is gone.
    pub fn silent_until(self, slot: Slot) -> Self {
        Self { silent_until: Some(slot), ..self }
    }

    /// The same, which as an owner refuses inputs of members with another shared configuration than that of this hash.
    pub fn configured(self, config: u64) -> Self {
        Self { config, ..self }
    }

    /// Whether this node publishes.
    pub const fn owns(&self) -> bool {
        matches!(self.role, Role::Owns { .. })
    }

    /// The number under which it does.
    pub const fn epoch(&self) -> Option<u64> {
        match self.role {
            Role::Owns { epoch } => Some(epoch),
            Role::Follows | Role::Claims { .. } => None,
        }
    }

    /// The sequence of the last output that this node has made, too, or published.
    pub const fn published(&self) -> u64 {
        self.published
    }

    /// Slots that others have published and this node has not made yet.
    pub fn behind(&self) -> u64 {
        self.outputs.len() as u64
    }

    /// Sequences of the last input handled and the last output made, where the engine's state is that of just these.
    pub fn rests_at(&self) -> Option<(u64, u64)> {
        (self.made.is_empty() && self.unmatched.is_none() && self.refused.is_empty())
            .then_some((self.handled, self.published))
    }

    /// Whether such a state is wanted: an owner then handles nothing between a slot and the next look.
    pub const fn want_rest(&mut self, is_wanted: bool) {
        self.is_rest_wanted = is_wanted;
    }

    /// Whether the last slot that was made here is another one than what is published of it so far.
    pub fn differs(&self) -> bool {
        self.unmatched.as_ref().is_some_and(|unmatched| unmatched.has_other)
    }

    /// Outputs that were left out because no owner can have made them.
    pub const fn foreign(&self) -> u64 {
        self.foreign
    }

    /// What is left out, because the owner cannot keep up.
    pub const fn step(&self) -> Step {
        self.step
    }

    /// Looks, after [`Cell::pump`], whether an owner keeps up at `now`: whether what could be made by then is made.
    pub fn look(&mut self, now: Moment) {
        if !self.owns() || !self.time.is_settled() {
            return;
        }
        let now = self.now(now);
        let waits = self.engine.next_due().filter(|due| self.is_time_for(*due, now));
        let behind = waits.map_or(SignedDuration::ZERO, |due| now - due - self.wait);
        self.step = self.relief.look(behind, now);
    }

    /// Leaves that out, as if it could not keep up.
    #[cfg(test)]
    pub(super) fn relieved(&mut self, step: Step) {
        self.step = step;
        self.relief.follow(step);
    }

    /// The engine, to write it down.
    pub const fn engine(&self) -> &E {
        &self.engine
    }

    /// The engine, to ask it how it is.
    pub const fn engine_mut(&mut self) -> &mut E {
        &mut self.engine
    }

    /// Whether the log held more input when the last was read. As long as it does no sensor is given up: what it sent may be there.
    pub const fn more(&mut self, has_more: bool) {
        self.has_more = has_more;
    }

    /// The next letter to another cell that is to be written into the log: at least once, in this order, until it is there.
    pub fn post(&mut self) -> Option<Letter> {
        self.post.pop_front()
    }

    /// Whether anybody holds the lease.
    pub const fn lease(&mut self, is_held: bool) {
        self.is_lease_free = !is_held;
    }

    /// Handles inputs and makes slots at `now`. An owner makes a few of them, so that
    /// what is made is published, and what is left out is looked at, however much there is to be made.
    ///
    /// # Errors
    /// This node has to begin anew.
    pub fn pump(&mut self, now: Moment) -> Result<(), Lost> {
        self.is_pressed = false;
        if !self.owns() {
            self.follow()?;
        }
        if let Role::Claims { epoch, until: Some(until) } = self.role
            && self.outputs.is_empty()
            && self.told >= until
        {
            self.role = Role::Owns { epoch };
            self.is_in_doubt = self.rival.is_some();
            self.own(epoch);
            // Whether who owned it before has sent them is not known.
            self.post.extend(self.engine.recent_letters());
        }
        if let Role::Owns { epoch } = self.role {
            self.lead(epoch, self.now(now));
        }
        Ok(())
    }

    /// Whether there is more to be made at once.
    pub const fn is_pressed(&self) -> bool {
        self.is_pressed
    }

    /// What is to be asked of the log now.
    pub fn wish(&mut self) -> Option<Wish> {
        if self.is_asking {
            return None;
        }
        let wish = match self.role {
            Role::Follows => self.is_lease_free.then_some(Wish::Lease),
            Role::Claims { until: None, .. } => Some(self.ask()),
            Role::Claims { .. } => None,
            Role::Owns { .. } if self.is_in_doubt => Some(self.ask()),
            Role::Owns { .. } if self.is_held_back => None,
            Role::Owns { .. } => {
                let output = self.made.front().map(|made| made.output.clone());
                output.map(|output| Wish::Append { expected: self.told, output })
            }
        };
        self.is_asking = wish.is_some();
        wish
    }

    const fn ask(&mut self) -> Wish {
        self.is_rival_asked = true;
        Wish::Last(self.told)
    }

    /// The lease has been created under this number; `None`: somebody else was first, or nobody answered.
    pub fn leased(&mut self, epoch: Option<u64>) {
        self.is_asking = false;
        self.is_lease_free = false;
        if let Some(epoch) = epoch {
            self.role = Role::Claims { epoch, until: None };
            self.rival = Some(self.greatest_epoch).filter(|greatest| *greatest > epoch);
        }
    }

    /// The lease ran out, nobody took it, and it was created anew under this number: an owner goes on with it.
    pub const fn leased_again(&mut self, number: u64) {
        if let Role::Owns { epoch } | Role::Claims { epoch, .. } = &mut self.role {
            *epoch = number;
        }
    }

    /// What has become of the output that was to be appended.
    pub fn appended(&mut self, appended: Appended) {
        self.is_asking = false;
        match appended {
            // It may have been read before it was acknowledged.
            Appended::Stored(sequence) if sequence <= self.published => {}
            Appended::Stored(sequence) => self.stored(sequence),
            Appended::Refused | Appended::Unknown => self.is_in_doubt = true,
        }
    }

    /// Handles what is there, and makes each slot once every sensor has been heard until it is due, or was waited for.
    fn lead(&mut self, epoch: u64, now: Time) {
        if !self.time.is_settled() {
            return;
        }
        let mut left = AT_ONCE;
        loop {
            if let Some(due) = self.engine.next_due()
                && self.is_time_for(due, now)
            {
                if left == 0 {
                    self.is_pressed = true;
                    return;
                }
                left -= 1;
                while let Some((slot, picture)) = self.make(due) {
                    let letters = self.engine.letters();
                    self.engine.relieve(self.step);
                    if self.silent_until.is_some_and(|until| slot <= until) {
                        continue;
                    }
                    let (behind, step) = (self.handled, self.step);
                    let refused = std::mem::take(&mut self.refused);
                    let output = Output { slot, epoch, behind, refused, step, picture };
                    self.made.push_back(Made { output, letters });
                }
            } else if self.refused.len() >= MOST_REFUSED
                || self.is_rest_wanted && self.published > 0 && self.refused.is_empty()
            {
                return;
            } else {
                let Some((sequence, logged, is_refused)) = self.inputs.pop_front() else { return };
                self.handled = sequence;
                match is_refused {
                    true => self.refused.push(sequence),
                    false => self.handle(logged),
                }
            }
        }
    }

    /// Whether a slot is made, `now` by reference time.
    fn is_time_for(&self, due: Time, now: Time) -> bool {
        if due - now > EARLY {
            return false;
        }
        let latest = due + self.wait;
        let is_whole = self.watermarks.whole().is_some_and(|slot| self.grid.open(slot.plus(1)) >= due);
        // What is that new would not be in the log if older things were still on their way.
        let is_passed = match self.inputs.front() {
            Some((_, Logged::Input(input), false)) => self.grid.open(input.slot) >= latest,
            Some(_) | None => false,
        };
        // Who is late with reading must not take it for silence.
        let is_all_heard = self.inputs.is_empty() && !self.has_more || self.refused.len() >= MOST_REFUSED;
        is_whole || is_passed || is_all_heard && now >= latest
    }

    fn handle(&mut self, logged: Logged) {
        let input = match logged {
            Logged::Input(input) => input,
            Logged::Letter(letter) => return self.engine.letter(&letter),
        };
        let slot = self.grid.slot();
        for heard in &input.heard {
            // Between the slot that was made last and the next, by what the engine knows: so on every node.
            let at = self
                .engine
                .next_due()
                .map_or(heard.received, |due| heard.received.clamp(due + -slot + APART, due + -APART));
            self.engine.receive(heard, at);
        }
        if input.is_last {
            self.watermarks.note(input.sensor, input.slot);
        }
    }

    fn make(&mut self, due: Time) -> Option<(Slot, Vec<u8>)> {
        self.engine.tick(due);
        self.engine.poll()
    }
}
