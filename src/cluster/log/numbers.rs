//! The region's table of numbers: which cell has which block of them, and which identity has which number. What stands there
//! stays: two cells that want the same get what the first one has written.

use async_nats::jetstream::kv::{CreateErrorKind, Operation};
use tracing::warn;

use super::{Log, LogError, keys};
use crate::cluster::region::{BLOCK, FIRST_BLOCK, LAST_BLOCK, Letter, Word, numbers_office};
use crate::territory::CellName;
use fusion::Identity;

/// Blocks that there are.
const BLOCKS: u32 = (LAST_BLOCK - FIRST_BLOCK) / BLOCK + 1;
/// So many of the blocks that were taken last are looked at: who takes over asks again for what was given already.
const LATEST: usize = 4;

impl Log {
    /// Does what a letter asks of who keeps the numbers; the answer, where there is one. Asked twice, it is the same.
    ///
    /// # Errors
    /// The log does not answer: the letter is to be asked again.
    pub async fn answer(&self, letter: &Letter) -> Result<Option<Letter>, LogError> {
        let word = match letter.word {
            Word::Wanted => self.block(letter).await?.map(|first| Word::Block { first }),
            Word::Number { identity, number: Some(number) } => {
                let known = self.number(identity, number).await?;
                // Another cell has given it one before.
                (known != number).then_some(Word::Number { identity, number: Some(known) })
            }
            Word::Number { identity, number: None } => {
                self.numbers.delete(key(identity)).await.map_err(LogError::unanswered)?;
                None
            }
            _ => None,
        };
        let Letter { slot, index, .. } = *letter;
        Ok(word.map(|word| Letter { from: numbers_office(), to: letter.from.clone(), slot, index, word }))
    }

    /// When the table was made, nanoseconds since 1970: another time is another table, and what stood in the first is lost.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn table(&self) -> Result<i128, LogError> {
        let info = self.numbers_stream.get_info().await.map_err(LogError::unanswered)?;
        Ok(info.created.unix_timestamp_nanos())
    }

    /// Writes down again what is a cell's, where that was lost: a question for each block and each identity.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn claim(
        &self,
        cell: &CellName,
        blocks: &[u32],
        numbers: &[(Identity, u32)],
    ) -> Result<(), LogError> {
        for first in blocks {
            let name = format!("b.{}", (first - FIRST_BLOCK) / BLOCK);
            let whose = self.created(&name, &format!("{cell}.")).await?;
            if !whose.starts_with(&format!("{cell}.")) {
                warn!(
                    first,
                    whose, "numbers from here on are also another cell's: the table was lost, and given anew"
                );
            }
        }
        for (identity, number) in numbers {
            self.number(*identity, *number).await?;
        }
        Ok(())
    }

    /// The number of an identity: this one, if it has none yet.
    async fn number(&self, identity: Identity, number: u32) -> Result<u32, LogError> {
        let stands = self.created(&key(identity), &number.to_string()).await?;
        // Any other octets there are no number.
        let is_number = |known: &u32| (1..LAST_BLOCK + BLOCK).contains(known);
        Ok(stands.parse().ok().filter(is_number).unwrap_or(number))
    }

    /// A block for who has written that letter, by its first number; `None`: all are taken.
    async fn block(&self, letter: &Letter) -> Result<Option<u32>, LogError> {
        let taken = keys(&self.numbers, &self.numbers_stream, "b.").await?;
        let mut taken: Vec<u32> =
            taken.iter().filter_map(|key| key.strip_prefix("b.")?.parse().ok()).collect();
        taken.retain(|block| *block < BLOCKS);
        taken.sort_unstable();
        let name = |block: u32| format!("b.{block}");
        for &block in taken.iter().rev().take(LATEST) {
            if self.stands(&name(block)).await?.is_some_and(|whose| whose == letter.id()) {
                return Ok(Some(FIRST_BLOCK + block * BLOCK));
            }
        }
        for block in (0..BLOCKS).filter(|block| taken.binary_search(block).is_err()) {
            if self.created(&name(block), &letter.id()).await? == letter.id() {
                return Ok(Some(FIRST_BLOCK + block * BLOCK));
            }
        }
        warn!("all numbers of the region are taken");
        Ok(None)
    }

    /// What stands there, which is this if there was nothing.
    async fn created(&self, key: &str, text: &str) -> Result<String, LogError> {
        loop {
            match self.numbers.create(key, text.to_owned().into()).await {
                Ok(_) => return Ok(text.to_owned()),
                Err(error) if error.kind() == CreateErrorKind::AlreadyExists => {
                    // It may have gone since.
                    if let Some(stands) = self.stands(key).await? {
                        return Ok(stands);
                    }
                }
                Err(error) => return Err(LogError::unanswered(error)),
            }
        }
    }

    async fn stands(&self, key: &str) -> Result<Option<String>, LogError> {
        let entry = self.numbers.entry(key).await.map_err(LogError::unanswered)?;
        let entry = entry.filter(|entry| entry.operation == Operation::Put);
        Ok(entry.map(|entry| String::from_utf8_lossy(&entry.value).into_owned()))
    }
}

fn key(identity: Identity) -> String {
    let octets = postcard::to_stdvec(&identity).expect("an identity can be written down");
    format!("s.{}", crate::hex::text(&octets))
}
