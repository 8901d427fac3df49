//! A model of the table in which a region's numbers are kept.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::cluster::region::{BLOCK, FIRST_BLOCK, LAST_BLOCK, Letter, Word, numbers_office};
use crate::territory::CellName;
use fusion::Identity;
use fusion::slots::Slot;

/// Gives blocks of numbers, each once, and knows which number an identity has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Office {
    /// Blocks that were given.
    given: u32,
    numbers: BTreeMap<Identity, u32>,
    /// The letter of each cell that was handled last.
    handled: BTreeMap<CellName, (Slot, u16)>,
    /// Its own letters.
    written: u16,
}

impl Office {
    /// Handles a letter; what it answers. A letter that was handled is not answered again: who still wants something asks again.
    pub fn letter(&mut self, letter: &Letter) -> Option<Letter> {
        let this = (letter.slot, letter.index);
        if self.handled.get(&letter.from).is_some_and(|last| this <= *last) {
            return None;
        }
        self.handled.insert(letter.from.clone(), this);
        let word = match letter.word {
            Word::Wanted => Word::Block { first: self.block()? },
            Word::Number { identity, number: Some(number) } => {
                let known = *self.numbers.entry(identity).or_insert(number);
                // Another cell has given it one before.
                (known != number).then_some(Word::Number { identity, number: Some(known) })?
            }
            Word::Number { identity, number: None } => {
                self.numbers.remove(&identity);
                return None;
            }
            _ => return None,
        };
        self.written = self.written.wrapping_add(1);
        let (slot, index) = (letter.slot, self.written);
        Some(Letter { from: numbers_office(), to: letter.from.clone(), slot, index, word })
    }

    /// The next block; `None`: all are given.
    fn block(&mut self) -> Option<u32> {
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
    fn a_block_is_given_once_and_an_identity_keeps_its_number() {
        let cell = |name: &str| CellName::new(name).unwrap();
        let mut office = Office::default();
        let mut ask = |from: &str, index, word| {
            let letter = Letter { from: cell(from), to: numbers_office(), slot: Slot(5), index, word };
            office.letter(&letter).map(|answer| {
                assert_eq!((&answer.from, &answer.to), (&letter.to, &letter.from));
                answer.word
            })
        };
        assert_eq!(ask("a", 0, Word::Wanted), Some(Word::Block { first: FIRST_BLOCK }));
        assert_eq!(ask("a", 0, Word::Wanted), None, "the same letter");
        assert_eq!(ask("b", 0, Word::Wanted), Some(Word::Block { first: FIRST_BLOCK + BLOCK }));
        let identity = Identity::of_address(7);
        let number = |number| Word::Number { identity, number };
        assert_eq!(ask("a", 1, number(Some(4100))), None);
        assert_eq!(ask("b", 1, number(Some(4161))), Some(number(Some(4100))));
        assert_eq!(ask("a", 2, number(None)), None);
        assert_eq!(ask("b", 2, number(Some(4161))), None, "it had ended");
        let blocks = (3..u16::MAX).map_while(|index| ask("a", index, Word::Wanted)).count();
        assert_eq!(blocks as u32, (LAST_BLOCK - FIRST_BLOCK) / BLOCK - 1);
    }
}
