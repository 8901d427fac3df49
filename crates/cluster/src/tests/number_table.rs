//! Model of a region's table of numbers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::region::{BLOCK, CellMessage, CellMessageContent, FIRST_BLOCK, LAST_BLOCK, number_table};
use fusion::Identity;
use fusion::slots::Slot;
use site::territory::CellName;

/// Assigns each block of numbers once, and stores the numbers of identities.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NumberTable {
    /// Number of assigned blocks.
    given: u32,
    numbers: BTreeMap<Identity, u32>,
    /// Slot and index of the last handled message of each cell.
    handled: BTreeMap<CellName, (Slot, u16)>,
    /// Number of its own messages.
    written: u16,
}

impl NumberTable {
    /// Handles a message. Returns the answer. A repeated message is not answered: a cell that still waits sends a new request.
    pub fn answer(&mut self, message: &CellMessage) -> Option<CellMessage> {
        let this = (message.slot, message.index);
        if self.handled.get(&message.from).is_some_and(|last| this <= *last) {
            return None;
        }
        self.handled.insert(message.from.clone(), this);
        let content = match message.content {
            CellMessageContent::RequestBlock => CellMessageContent::Block { first: self.next_block()? },
            CellMessageContent::Number { identity, number: Some(number) } => {
                let known = *self.numbers.entry(identity).or_insert(number);
                // Another cell has assigned a number before.
                (known != number).then_some(CellMessageContent::Number { identity, number: Some(known) })?
            }
            CellMessageContent::Number { identity, number: None } => {
                self.numbers.remove(&identity);
                return None;
            }
            _ => return None,
        };
        self.written = self.written.wrapping_add(1);
        let (slot, index) = (message.slot, self.written);
        Some(CellMessage { from: number_table(), to: message.from.clone(), slot, index, content })
    }

    /// The first number of the next block; `None` if all blocks are assigned.
    fn next_block(&mut self) -> Option<u32> {
        let first = FIRST_BLOCK + self.given * BLOCK;
        (first <= LAST_BLOCK).then(|| {
            self.given += 1;
            first
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_is_assigned_once_and_identity_keeps_its_number() {
        let cell = |name: &str| CellName::new(name).unwrap();
        let mut table = NumberTable::default();
        let mut ask = |from: &str, index, content| {
            let message = CellMessage { from: cell(from), to: number_table(), slot: Slot(5), index, content };
            table.answer(&message).map(|answer| {
                assert_eq!((&answer.from, &answer.to), (&message.to, &message.from));
                answer.content
            })
        };
        assert_eq!(
            ask("a", 0, CellMessageContent::RequestBlock),
            Some(CellMessageContent::Block { first: FIRST_BLOCK })
        );
        assert_eq!(ask("a", 0, CellMessageContent::RequestBlock), None, "the same letter");
        assert_eq!(
            ask("b", 0, CellMessageContent::RequestBlock),
            Some(CellMessageContent::Block { first: FIRST_BLOCK + BLOCK })
        );
        let identity = Identity::of_address(7);
        let number = |number| CellMessageContent::Number { identity, number };
        assert_eq!(ask("a", 1, number(Some(4100))), None);
        assert_eq!(ask("b", 1, number(Some(4161))), Some(number(Some(4100))));
        assert_eq!(ask("a", 2, number(None)), None);
        assert_eq!(ask("b", 2, number(Some(4161))), None, "it had ended");
        let blocks =
            (3..u16::MAX).map_while(|index| ask("a", index, CellMessageContent::RequestBlock)).count();
        assert_eq!(blocks as u32, (LAST_BLOCK - FIRST_BLOCK) / BLOCK - 1);
    }
}
