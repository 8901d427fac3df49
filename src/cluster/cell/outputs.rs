//! A cell's handling of the messages among its outputs: its own, those of another owner, and those that no owner has written.

use fusion::slots::Slot;

use super::{Cell, Fusing, Lost, Role, Tail};
use crate::cluster::message::{Logged, Output};
use crate::cluster::region::Letter;

/// A slot that this node has made, and what it writes to other cells.
#[derive(Clone, Debug)]
pub(super) struct Made {
    pub(super) output: Output,
    pub(super) letters: Vec<Letter>,
}

/// A slot that was made to compare it with what the owner published.
#[derive(Clone, Debug)]
pub(super) struct Unmatched {
    pub(super) slot: Slot,
    pub(super) picture: Vec<u8>,
    pub(super) letters: Vec<Letter>,
    /// Sequences of the inputs that were not used for it.
    pub(super) refused: Vec<u64>,
    /// Whether an output of this slot was left out.
    pub(super) has_other: bool,
}

impl<E: Fusing> Cell<E> {
    /// An output of the cell, in order of its sequence; again is as good as once.
    ///
    /// # Errors
    /// Another node publishes.
    pub fn output(&mut self, sequence: u64, output: Output) -> Result<(), Lost> {
        if sequence <= self.told {
            return Ok(());
        }
        self.told = sequence;
        self.greatest_epoch = self.greatest_epoch.max(output.epoch);
        match self.role {
            Role::Owns { epoch } => self.other(epoch, sequence, &output),
            Role::Follows | Role::Claims { .. } => {
                if let Role::Claims { epoch, .. } = self.role
                    && output.epoch > epoch
                {
                    self.note_rival(output.epoch);
                }
                self.outputs.push_back((sequence, output));
                Ok(())
            }
        }
    }

    /// A message among the outputs of the cell that is none, in the same order.
    pub const fn skip(&mut self, sequence: u64) {
        if sequence > self.told {
            self.told = sequence;
        }
    }

    /// An output that an owner has not published, or whose acknowledgement is on its way.
    fn other(&mut self, epoch: u64, sequence: u64, output: &Output) -> Result<(), Lost> {
        if self.made.front().is_some_and(|made| made.output == *output) {
            self.stored(sequence);
            return Ok(());
        }
        if output.epoch > epoch {
            self.note_rival(output.epoch);
            self.is_in_doubt = true;
        } else if output.epoch == epoch || self.stored_epoch.is_some_and(|stored| output.epoch <= stored) {
            // The former owner is refused since the first output of this node.
            self.foreign += 1;
        } else {
            return Err(Lost::Fenced);
        }
        Ok(())
    }

    fn note_rival(&mut self, epoch: u64) {
        (self.rival, self.is_rival_asked) = (self.rival.max(Some(epoch)), false);
    }

    /// An owner in whose place another name stands in the lease publishes nothing, until it is known whether that one publishes.
    pub const fn hold_back(&mut self, is_held_back: bool) {
        self.is_held_back = is_held_back;
    }

    /// The outputs behind the sequence that was asked for. `Err`: no answer came.
    ///
    /// # Errors
    /// Another node has published.
    pub fn last(&mut self, tail: Result<Tail, ()>) -> Result<(), Lost> {
        self.is_asking = false;
        let Ok(Tail { outputs, last, is_whole, is_mine }) = tail else { return Ok(()) };
        // The lease may have changed between the answer and an output that was read meanwhile: it is asked for again.
        let is_current = self.rival.is_none() || self.is_rival_asked;
        for (sequence, output) in outputs {
            self.output(sequence, output)?;
        }
        self.skip(last);
        if !is_whole || !is_current {
            return Ok(());
        }
        match &mut self.role {
            Role::Follows => {}
            Role::Claims { until, .. } => {
                // The lease has come late: another node has been given it since.
                if self.rival.take().is_some() && !is_mine {
                    return Err(Lost::Fenced);
                }
                *until = Some(self.told);
            }
            Role::Owns { epoch } => {
                if let Some(rival) = self.rival.take() {
                    // A lease that was taken since says nothing of the time before it.
                    if !is_mine || rival < *epoch {
                        return Err(Lost::Fenced);
                    }
                    self.foreign += 1;
                }
                self.is_in_doubt = false;
            }
        }
        Ok(())
    }

    /// Begins to publish. A slot that was made to compare it is published now, unless the log holds another one of it.
    pub(super) fn own(&mut self, epoch: u64) {
        let Some(Unmatched { slot, picture, letters, refused, has_other }) = self.unmatched.take() else {
            return;
        };
        if !has_other {
            let output = Output { slot, epoch, behind: self.handled, refused, step: self.step, picture };
            self.made.push_back(Made { output, letters });
        }
    }

    pub(super) fn stored(&mut self, sequence: u64) {
        let Some(Made { output, letters }) = self.made.pop_front() else { return };
        self.post.extend(letters);
        (self.published, self.slot, self.stored_epoch) = (sequence, Some(output.slot), Some(output.epoch));
        self.skip(sequence);
        self.is_in_doubt = self.rival.is_some();
    }

    /// Makes what the owner has published, each slot behind the same input. An output that differs is left out where one of the
    /// same slot follows that does not: another process has written it.
    pub(super) fn follow(&mut self) -> Result<(), Lost> {
        while let Some((sequence, output)) = self.outputs.front() {
            let sequence = *sequence;
            let Some(unmatched) = &mut self.unmatched else {
                if self.slot.is_some_and(|last| output.slot <= last) {
                    self.leave_out();
                } else if output.behind < self.handled {
                    self.is_past = true;
                    self.leave_out();
                } else if output.behind > self.read {
                    break;
                } else {
                    let (behind, refused) = (output.behind, output.refused.clone());
                    self.compare(behind, refused)?;
                }
                continue;
            };
            if output.slot > unmatched.slot {
                return Err(if self.is_past { Lost::Behind } else { Lost::Diverged });
            }
            let is_other = output.slot == unmatched.slot;
            if !is_other || output.picture != unmatched.picture {
                unmatched.has_other |= is_other;
                self.leave_out();
                continue;
            }
            (self.slot, self.published, self.step) = (Some(output.slot), sequence, output.step);
            (self.unmatched, self.is_past) = (None, false);
            self.outputs.pop_front();
            self.relief.follow(self.step);
            self.engine.relieve(self.step);
        }
        Ok(())
    }

    fn leave_out(&mut self) {
        self.outputs.pop_front();
        self.foreign += 1;
    }

    /// Makes the next slot behind that input, without those that the owner has refused, to compare it. What is not used is the
    /// owner's to say: each node has read the input at another time.
    fn compare(&mut self, behind: u64, refused: Vec<u64>) -> Result<(), Lost> {
        let is_before = |(sequence, ..): &(u64, Logged, bool)| *sequence <= behind;
        while self.inputs.front().is_some_and(is_before) {
            let Some((sequence, logged, _)) = self.inputs.pop_front() else { break };
            self.handled = sequence;
            if refused.binary_search(&sequence).is_err() {
                self.handle(logged);
            }
        }
        let due = self.engine.next_due().ok_or(Lost::Behind)?;
        let (slot, picture) = self.make(due).ok_or(Lost::Diverged)?;
        let letters = self.engine.letters();
        self.unmatched = Some(Unmatched { slot, picture, letters, refused, has_other: false });
        Ok(())
    }
}
