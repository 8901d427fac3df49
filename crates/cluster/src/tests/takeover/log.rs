//! The log as the take-over rules use it: outputs of a cell, and the entry of its lease.
//!
//! A log of one server checks and stores a request at once. With several copies the leader checks a request before the servers agree
//! on it, so two requests can both pass; only the name of an output is checked again when it is stored.

use std::hash::{Hash, Hasher};

use super::recorder::Recorder;
use crate::cell::AppendResult;
use crate::lease_rules::{EntryAnswer, EntryRequest};
use crate::log::{EntryState, HeldEntry, Holder, Renewal};
use crate::message::CellOutput;

/// Lease time in ticks of one second.
pub(super) const LEASE_TICKS: u8 = 2;
/// Numbers of entries from one lease to the next. A renewal takes one of the numbers between, so that the number of an earlier
/// renewal does not fit.
const NUMBERS_PER_LEASE: u64 = 4;

/// A rule of the log that a model leaves out, to show that the checker finds the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum LogMutant {
    /// Appends without regard to the expected sequence, and to the name.
    Unconditional,
    /// Outputs have no names.
    Nameless,
}

/// A node's run, as the log knows it.
pub(super) type Run = (usize, u8);

pub(super) fn holder((node, run): Run) -> Holder {
    Holder { node: format!("n{node}"), run: run.into(), ..Holder::default() }
}

/// A request to the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    Entry(EntryRequest),
    /// Replaces the entry with this number. The node has no lease, and the number is that of a new one.
    Claim(u64),
    /// Deletes the entry with this number.
    Delete(u64),
    /// Reads the outputs after this sequence.
    Tail(u64),
    Append {
        expected: u64,
        output: CellOutput,
    },
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Entry(EntryAnswer),
    /// The outputs from the first sequence on, without it, up to the second one.
    Tail(u64, u64),
    Appended(AppendResult),
    /// No answer, or none that a node waits for.
    Nothing,
}

/// A request that has passed the checks of a log with several copies, and is not stored yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Agreed {
    pub(super) by: Run,
    pub(super) operation: Operation,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct LeaseEntry {
    pub(super) by: Run,
    number: u64,
    /// Ticks since it was written.
    age: u8,
}

#[derive(Clone, Debug, Default)]
pub(super) struct ModelLog {
    pub(super) inputs: u64,
    pub(super) outputs: Vec<CellOutput>,
    pub(super) lease: Option<LeaseEntry>,
    /// Number of leases given.
    pub(super) leases: u64,
    pub(super) agreed: Vec<Agreed>,
}

pub(super) fn write_output(output: &CellOutput, hasher: &mut impl Hasher) {
    (output.slot, output.epoch, output.after_input, &output.picture).hash(hasher);
}

impl Operation {
    /// Whether it changes the log.
    pub(super) const fn is_write(&self) -> bool {
        !matches!(self, Self::Tail(_) | Self::Entry(EntryRequest::Read))
    }
}

impl Hash for Operation {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        match self {
            Self::Entry(request) => (0, request).hash(hasher),
            Self::Claim(number) => (4, number).hash(hasher),
            Self::Delete(number) => (1, number).hash(hasher),
            Self::Tail(after) => (2, after).hash(hasher),
            Self::Append { expected, output } => {
                (3, expected).hash(hasher);
                write_output(output, hasher);
            }
        }
    }
}

impl Hash for Answer {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        match self {
            Self::Entry(answer) => (0, answer).hash(hasher),
            Self::Tail(after, last) => (1, after, last).hash(hasher),
            Self::Appended(appended) => (2, format!("{appended:?}")).hash(hasher),
            Self::Nothing => 3.hash(hasher),
        }
    }
}

impl Hash for ModelLog {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        (self.inputs, self.outputs.len(), &self.lease, self.leases, self.agreed.len()).hash(hasher);
        self.outputs.iter().for_each(|output| write_output(output, hasher));
        self.agreed.iter().for_each(|Agreed { by, operation }| (by, operation).hash(hasher));
    }
}

impl ModelLog {
    /// Lets a second pass: an entry that is not renewed expires.
    pub(super) fn tick(&mut self) {
        self.lease.iter_mut().for_each(|lease| lease.age += 1);
        self.lease.take_if(|lease| lease.age >= LEASE_TICKS);
    }

    pub(super) fn entry_state(&self) -> EntryState {
        match &self.lease {
            Some(LeaseEntry { by, number, .. }) => {
                EntryState::Held(HeldEntry { by: holder(*by), revision: *number })
            }
            None => EntryState::Free,
        }
    }

    /// Whether the request would give a lease to another run than its present holder.
    pub(super) fn gives_lease(&self, by: Run, operation: &Operation) -> bool {
        let is_own = self.lease.as_ref().is_some_and(|lease| lease.by == by);
        let is_given = match operation {
            Operation::Entry(EntryRequest::Create | EntryRequest::Replace(_)) => !is_own,
            Operation::Claim(_) => true,
            _ => false,
        };
        is_given && self.refusal(operation, None).is_none()
    }

    /// Executes a request at once. `None` if the servers have to agree on it first.
    pub(super) fn execute(
        &mut self,
        by: Run,
        operation: &Operation,
        is_replicated: bool,
        mutant: Option<LogMutant>,
    ) -> Option<Answer> {
        if let Some(refused) = self.refusal(operation, mutant) {
            return Some(refused);
        }
        if is_replicated && operation.is_write() {
            self.agreed.push(Agreed { by, operation: operation.clone() });
            return None;
        }
        Some(self.store(by, operation, mutant))
    }

    /// The answer to a request that does not pass the checks.
    fn refusal(&self, operation: &Operation, mutant: Option<LogMutant>) -> Option<Answer> {
        match operation {
            Operation::Entry(EntryRequest::Create) if self.lease.is_some() => {
                Some(Answer::Entry(EntryAnswer::Created(None)))
            }
            Operation::Entry(EntryRequest::Replace(number)) | Operation::Claim(number)
                if !self.is_number(*number) =>
            {
                Some(Answer::Entry(EntryAnswer::Replaced(Renewal::Lost)))
            }
            Operation::Delete(number) if !self.is_number(*number) => Some(Answer::Nothing),
            Operation::Append { expected, output } => match self.named(output, mutant) {
                Some(sequence) => self.judge_name(sequence, *expected, output),
                None => {
                    let is_next = *expected == self.outputs.len() as u64;
                    (!is_next && mutant != Some(LogMutant::Unconditional))
                        .then_some(Answer::Appended(AppendResult::Refused))
                }
            },
            _ => None,
        }
    }

    fn is_number(&self, number: u64) -> bool {
        self.lease.as_ref().is_some_and(|lease| lease.number == number)
    }

    /// Sequence of the output that has taken the name of this one.
    fn named(&self, output: &CellOutput, mutant: Option<LogMutant>) -> Option<u64> {
        if matches!(mutant, Some(LogMutant::Unconditional | LogMutant::Nameless)) {
            return None;
        }
        (1..).zip(&self.outputs).find(|(_, known)| known.slot == output.slot).map(|(sequence, _)| sequence)
    }

    /// `None`: the owner sends the output again under another name, which passes if the sequence is the expected one.
    fn judge_name(&self, there: u64, expected: u64, output: &CellOutput) -> Option<Answer> {
        let is_same = self.outputs[there as usize - 1] == *output;
        let result = AppendResult::of_taken_name(there, expected, true, is_same);
        let is_next = expected == self.outputs.len() as u64;
        result.or((!is_next).then_some(AppendResult::Refused)).map(Answer::Appended)
    }

    /// Stores what has passed the checks.
    pub(super) fn store(&mut self, by: Run, operation: &Operation, mutant: Option<LogMutant>) -> Answer {
        match operation {
            Operation::Entry(EntryRequest::Read) => {
                Answer::Entry(EntryAnswer::State(Some(self.entry_state())))
            }
            Operation::Entry(EntryRequest::Create) => {
                Answer::Entry(EntryAnswer::Created(Some(self.give_lease(by))))
            }
            Operation::Entry(EntryRequest::Replace(_)) => {
                Answer::Entry(EntryAnswer::Replaced(Renewal::Until(self.write_lease(by))))
            }
            Operation::Claim(_) => Answer::Entry(EntryAnswer::Replaced(Renewal::Until(self.give_lease(by)))),
            Operation::Delete(_) => {
                self.lease = None;
                Answer::Nothing
            }
            Operation::Tail(after) => Answer::Tail(*after, self.outputs.len() as u64),
            Operation::Append { expected, output } => {
                if let Some(there) = self.named(output, mutant)
                    && let Some(answer) = self.judge_name(there, *expected, output)
                {
                    return answer;
                }
                self.outputs.push(output.clone());
                Answer::Appended(AppendResult::Stored(self.outputs.len() as u64))
            }
        }
    }

    fn give_lease(&mut self, by: Run) -> u64 {
        self.leases += 1;
        let number = self.leases * NUMBERS_PER_LEASE;
        self.lease = Some(LeaseEntry { by, number, age: 0 });
        number
    }

    fn write_lease(&mut self, by: Run) -> u64 {
        match &mut self.lease {
            Some(lease) if lease.by == by => {
                let first = lease.number / NUMBERS_PER_LEASE * NUMBERS_PER_LEASE;
                lease.number = first + (lease.number - first) % (NUMBERS_PER_LEASE - 1) + 1;
                lease.age = 0;
                lease.number
            }
            _ => self.give_lease(by),
        }
    }

    /// Whether the outputs of each two neighbours satisfy a rule.
    pub(super) fn all_pairs(&self, rule: impl Fn(&CellOutput, &CellOutput) -> bool) -> bool {
        self.outputs.windows(2).all(|pair| rule(&pair[0], &pair[1]))
    }

    /// Whether an uninterrupted engine makes the same pictures.
    pub(super) fn is_reproducible(&self) -> bool {
        let mut alone = Recorder::default();
        let is_other = |output: &CellOutput| {
            alone.expected(output.slot, output.after_input).as_ref() != Some(&output.picture)
        };
        !self.outputs.iter().any(is_other)
    }
}
