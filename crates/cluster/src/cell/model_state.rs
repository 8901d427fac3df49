//! The state of a cell as a model checker compares it.

use std::hash::{Hash, Hasher};

use super::outputs::{OwnSlot, UnmatchedSlot};
use super::{Cell, CellRole};
use crate::message::CellOutput;

fn write_output(output: &CellOutput, hasher: &mut impl Hasher) {
    let CellOutput { slot, epoch, after_input, refused, level, picture } = output;
    (slot, epoch, after_input, refused, level.0, picture).hash(hasher);
}

impl<E: Hash> Cell<E> {
    /// Number of slots that the owner has made and not published.
    pub(crate) fn unpublished(&self) -> u64 {
        self.made.len() as u64
    }

    /// Writes all that decides what the cell does next. Two cells are equal if they have the same engine, inputs with the same
    /// sequences, and the same rest. Clocks, watermarks and load shedding are left out: a model that reads no gateway's
    /// messages leaves them unchanged. `foreign` only counts.
    pub(crate) fn write_state(&self, hasher: &mut impl Hasher) {
        let Self {
            engine,
            grid: _,
            wait: _,
            role,
            inputs,
            config: _,
            time: _,
            refused,
            refusals: _,
            read,
            handled,
            has_more,
            watermarks: _,
            outputs,
            published,
            last_known_output,
            unmatched,
            slot,
            has_skipped_past,
            foreign: _,
            stored_epoch,
            greater_epoch,
            is_tail_requested,
            greatest_epoch,
            is_suspended,
            made,
            outbox: _,
            silent_until,
            overload: _,
            level: _,
            is_lease_free,
            is_rest_requested: _,
            is_request_pending,
            has_due_slots: _,
            is_tail_unknown,
            log_state,
        } = self;
        engine.hash(hasher);
        let (kind, epoch, until) = match role {
            CellRole::Standby => (0, None, &None),
            CellRole::Candidate { epoch, until } => (1, Some(epoch), until),
            CellRole::Owner { epoch } => (2, Some(epoch), &None),
        };
        (kind, epoch, until).hash(hasher);
        (inputs.len(), outputs.len()).hash(hasher);
        inputs.iter().for_each(|(sequence, _, is_refused)| (sequence, is_refused).hash(hasher));
        (refused, read, handled, has_more, published, last_known_output, slot).hash(hasher);
        for (sequence, output) in outputs {
            sequence.hash(hasher);
            write_output(output, hasher);
        }
        if let Some(UnmatchedSlot { slot, picture, messages: _, refused, has_other }) = unmatched {
            (slot, picture, refused, has_other).hash(hasher);
        }
        (unmatched.is_some(), has_skipped_past, stored_epoch, greater_epoch, is_tail_requested).hash(hasher);
        (greatest_epoch, is_suspended, silent_until, is_lease_free).hash(hasher);
        (is_request_pending, is_tail_unknown, log_state, made.len()).hash(hasher);
        made.iter().for_each(|OwnSlot { output, messages: _ }| write_output(output, hasher));
    }
}
