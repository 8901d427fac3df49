//! Handling of the messages among a cell's outputs: the node's own, those of another owner, and those that no owner has written.

use fusion::slots::Slot;

use super::{Cell, CellEngine, CellLoss, CellRole, Tail};
use crate::message::{CellOutput, LoggedMessage};
use crate::region::CellMessage;

/// A slot made by this owner, with its messages to other cells.
#[derive(Clone, Debug)]
pub(super) struct OwnSlot {
    pub(super) output: CellOutput,
    pub(super) messages: Vec<CellMessage>,
}

/// A slot made for comparison with the owner's output.
#[derive(Clone, Debug)]
pub(super) struct UnmatchedSlot {
    pub(super) slot: Slot,
    pub(super) picture: Vec<u8>,
    pub(super) messages: Vec<CellMessage>,
    /// Sequences of the inputs that were left out.
    pub(super) refused: Vec<u64>,
    /// Whether an output of this slot was skipped because its picture differs.
    pub(super) has_other: bool,
}

impl<E: CellEngine> Cell<E> {
    /// Handles an output of the cell, in order of its sequence. Repeated outputs are ignored.
    ///
    /// # Errors
    /// Another node owns the cell.
    pub fn handle_output(&mut self, sequence: u64, output: CellOutput) -> Result<(), CellLoss> {
        if sequence <= self.last_known_output {
            return Ok(());
        }
        self.last_known_output = sequence;
        self.greatest_epoch = self.greatest_epoch.max(output.epoch);
        match self.role {
            CellRole::Owner { epoch } => self.handle_unexpected_output(epoch, sequence, &output),
            CellRole::Standby | CellRole::Candidate { .. } => {
                if let CellRole::Candidate { epoch, .. } = self.role
                    && output.epoch > epoch
                {
                    self.note_greater_epoch(output.epoch);
                }
                self.outputs.push_back((sequence, output));
                Ok(())
            }
        }
    }

    /// Notes a message among the cell's outputs that is not a valid output, in the same order.
    pub const fn skip_output(&mut self, sequence: u64) {
        if sequence > self.last_known_output {
            self.last_known_output = sequence;
        }
    }

    /// Handles an output that this owner has not published, or whose acknowledgement has not arrived yet.
    fn handle_unexpected_output(
        &mut self,
        epoch: u64,
        sequence: u64,
        output: &CellOutput,
    ) -> Result<(), CellLoss> {
        if self.made.front().is_some_and(|made| made.output == *output) {
            self.confirm_stored(sequence);
            return Ok(());
        }
        if output.epoch > epoch {
            self.note_greater_epoch(output.epoch);
            self.is_tail_unknown = true;
        } else if output.epoch == epoch || self.stored_epoch.is_some_and(|stored| output.epoch <= stored) {
            // The former owner's outputs are refused after this node's first output.
            self.foreign += 1;
        } else {
            return Err(CellLoss::Fenced);
        }
        Ok(())
    }

    fn note_greater_epoch(&mut self, epoch: u64) {
        (self.greater_epoch, self.is_tail_requested) = (self.greater_epoch.max(Some(epoch)), false);
    }

    /// Suspends publication by an owner while the lease names another node, until it is known which of the two publishes.
    pub const fn set_suspended(&mut self, is_suspended: bool) {
        self.is_suspended = is_suspended;
    }

    /// Handles the outputs after the requested sequence. `Err`: the log did not answer.
    ///
    /// # Errors
    /// Another node owns the cell.
    pub fn handle_tail(&mut self, tail: Result<Tail, ()>) -> Result<(), CellLoss> {
        self.is_request_pending = false;
        self.note_answer(tail.is_ok());
        let Ok(Tail { outputs, last, is_complete, is_mine }) = tail else { return Ok(()) };
        // The lease may have changed between this answer and an output read since: request it again.
        let is_current = self.greater_epoch.is_none() || self.is_tail_requested;
        for (sequence, output) in outputs {
            self.handle_output(sequence, output)?;
        }
        self.skip_output(last);
        if !is_complete || !is_current {
            return Ok(());
        }
        match &mut self.role {
            CellRole::Standby => {}
            CellRole::Candidate { until, .. } => {
                // The lease arrived late: another node holds one granted later.
                if self.greater_epoch.take().is_some() && !is_mine {
                    return Err(CellLoss::Fenced);
                }
                *until = Some(self.last_known_output);
            }
            CellRole::Owner { epoch } => {
                if let Some(greater_epoch) = self.greater_epoch.take() {
                    // A lease taken since then says nothing about the time before it.
                    if !is_mine || greater_epoch < *epoch {
                        return Err(CellLoss::Fenced);
                    }
                    self.foreign += 1;
                }
                self.is_tail_unknown = false;
            }
        }
        Ok(())
    }

    /// Starts to publish. A slot made for comparison is published now, unless the log holds another picture of it.
    pub(super) fn start_publishing(&mut self, epoch: u64) {
        let Some(UnmatchedSlot { slot, picture, messages, refused, has_other }) = self.unmatched.take()
        else {
            return;
        };
        if !has_other {
            let output =
                CellOutput { slot, epoch, after_input: self.handled, refused, level: self.level, picture };
            self.made.push_back(OwnSlot { output, messages });
        }
    }

    pub(super) fn confirm_stored(&mut self, sequence: u64) {
        let Some(OwnSlot { output, messages }) = self.made.pop_front() else { return };
        self.outbox.extend(messages);
        (self.published, self.slot, self.stored_epoch) = (sequence, Some(output.slot), Some(output.epoch));
        self.skip_output(sequence);
        self.is_tail_unknown = self.greater_epoch.is_some();
    }

    /// Reproduces the owner's outputs, each slot after the same input. An output that differs is skipped if a matching output of
    /// the same slot follows: another process has written it.
    pub(super) fn run_standby(&mut self) -> Result<(), CellLoss> {
        while let Some((sequence, output)) = self.outputs.front() {
            let sequence = *sequence;
            let Some(unmatched) = &mut self.unmatched else {
                if self.slot.is_some_and(|last| output.slot <= last) {
                    self.skip_front();
                } else if output.after_input < self.handled {
                    self.has_skipped_past = true;
                    self.skip_front();
                } else if output.after_input > self.read {
                    break;
                } else {
                    let (after_input, refused) = (output.after_input, output.refused.clone());
                    self.make_unmatched(after_input, refused)?;
                }
                continue;
            };
            if output.slot > unmatched.slot {
                return Err(if self.has_skipped_past { CellLoss::Behind } else { CellLoss::Diverged });
            }
            let is_other = output.slot == unmatched.slot;
            if !is_other || output.picture != unmatched.picture {
                unmatched.has_other |= is_other;
                self.skip_front();
                continue;
            }
            (self.slot, self.published, self.level) = (Some(output.slot), sequence, output.level);
            (self.unmatched, self.has_skipped_past) = (None, false);
            self.outputs.pop_front();
            self.overload.adopt(self.level);
            self.engine.set_level(self.level);
        }
        Ok(())
    }

    fn skip_front(&mut self) {
        self.outputs.pop_front();
        self.foreign += 1;
    }

    /// Makes the next slot for comparison, after the input `after_input`, without the inputs in `refused`. The owner decides which
    /// inputs are refused, because each node reads them at another time.
    fn make_unmatched(&mut self, after_input: u64, refused: Vec<u64>) -> Result<(), CellLoss> {
        let is_before = |(sequence, ..): &(u64, LoggedMessage, bool)| *sequence <= after_input;
        while self.inputs.front().is_some_and(is_before) {
            let Some((sequence, logged, _)) = self.inputs.pop_front() else { break };
            self.handled = sequence;
            if refused.binary_search(&sequence).is_err() {
                self.handle(logged);
            }
        }
        let due = self.engine.next_due().ok_or(CellLoss::Behind)?;
        let (slot, picture) = self.make(due).ok_or(CellLoss::Diverged)?;
        let messages = self.engine.take_messages();
        self.unmatched = Some(UnmatchedSlot { slot, picture, messages, refused, has_other: false });
        Ok(())
    }
}
