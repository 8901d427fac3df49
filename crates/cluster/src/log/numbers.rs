//! The region's table of numbers: which cell has which block of numbers, and which identity has which number. The first entry for
//! a key is permanent: a second cell that asks for it is given the existing entry.

use async_nats::jetstream::kv::{CreateErrorKind, Operation};
use tracing::warn;

use super::{Log, LogError, keys};
use crate::block_procedure::{BlockAnswer, BlockProcedure, BlockRequest, BlockStep};
use crate::region::{BLOCK, CellMessage, CellMessageContent, FIRST_BLOCK, LAST_BLOCK, number_table};
use fusion::Identity;
use site::territory::CellName;

/// Number of blocks.
const BLOCKS: u32 = (LAST_BLOCK - FIRST_BLOCK) / BLOCK + 1;

impl Log {
    /// Answers a request to the table of numbers. Returns the answer, if there is one. A repeated request has the same answer.
    ///
    /// # Errors
    /// The log does not answer; the request has to be repeated.
    pub async fn answer_number_request(
        &self,
        message: &CellMessage,
    ) -> Result<Option<CellMessage>, LogError> {
        let content = match message.content {
            CellMessageContent::RequestBlock => {
                self.take_block(message).await?.map(|first| CellMessageContent::Block { first })
            }
            CellMessageContent::Number { identity, number: Some(number) } => {
                let known = self.create_or_read_number(identity, number).await?;
                // Another cell has given the identity a number before.
                (known != number).then_some(CellMessageContent::Number { identity, number: Some(known) })
            }
            CellMessageContent::Number { identity, number: None } => {
                self.numbers.delete(key(identity)).await.map_err(LogError::unanswered)?;
                None
            }
            _ => None,
        };
        let CellMessage { slot, index, .. } = *message;
        Ok(content.map(|content| CellMessage {
            from: number_table(),
            to: message.from.clone(),
            slot,
            index,
            content,
        }))
    }

    /// Creation time of the table, in nanoseconds since 1970. A table with another time is a new one, without the entries of the
    /// old.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn number_table_created(&self) -> Result<i128, LogError> {
        let info = self.numbers_stream.get_info().await.map_err(LogError::unanswered)?;
        Ok(info.created.unix_timestamp_nanos())
    }

    /// Writes a cell's blocks and numbers into the table again if they were lost: one request for each block and each identity.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn claim_numbers(
        &self,
        cell: &CellName,
        blocks: &[u32],
        numbers: &[(Identity, u32)],
    ) -> Result<(), LogError> {
        for first in blocks {
            let name = format!("b.{}", (first - FIRST_BLOCK) / BLOCK);
            let whose = self.create_or_read(&name, &format!("{cell}.")).await?;
            if !whose.starts_with(&format!("{cell}.")) {
                warn!(
                    first,
                    whose, "numbers from here on are also another cell's: the table was lost, and given anew"
                );
            }
        }
        for (identity, number) in numbers {
            self.create_or_read_number(*identity, *number).await?;
        }
        Ok(())
    }

    /// Returns the number of an identity, and writes `number` if it has none.
    async fn create_or_read_number(&self, identity: Identity, number: u32) -> Result<u32, LogError> {
        let entry = self.create_or_read(&key(identity), &number.to_string()).await?;
        // Other octets in the table are not a number.
        let is_number = |known: &u32| (1..LAST_BLOCK + BLOCK).contains(known);
        Ok(entry.parse().ok().filter(is_number).unwrap_or(number))
    }

    /// Takes a block for the cell that sent this request. Returns its first number; `None` if all blocks are taken.
    async fn take_block(&self, message: &CellMessage) -> Result<Option<u32>, LogError> {
        let name = |block: u32| format!("b.{block}");
        let (mut procedure, mut request) = BlockProcedure::take(message.id(), BLOCKS);
        loop {
            let answer = match request {
                BlockRequest::List => {
                    let taken = keys(&self.numbers, &self.numbers_stream, "b.").await?;
                    BlockAnswer::Taken(
                        taken.iter().filter_map(|key| key.strip_prefix("b.")?.parse().ok()).collect(),
                    )
                }
                BlockRequest::Read(block) => BlockAnswer::Name(self.number_entry(&name(block)).await?),
                BlockRequest::Create(block) => match self.create_number(&name(block), &message.id()).await? {
                    true => BlockAnswer::Created,
                    false => BlockAnswer::Exists,
                },
            };
            match procedure.handle(answer) {
                BlockStep::Request(next) => request = next,
                BlockStep::End(block) => {
                    if block.is_none() {
                        warn!("all numbers of the region are taken");
                    }
                    return Ok(block.map(|block| FIRST_BLOCK + block * BLOCK));
                }
            }
        }
    }

    /// Returns the entry of a key, and creates it with `text` if it is missing.
    async fn create_or_read(&self, key: &str, text: &str) -> Result<String, LogError> {
        loop {
            if self.create_number(key, text).await? {
                return Ok(text.to_owned());
            }
            // The entry may have been deleted since.
            if let Some(entry) = self.number_entry(key).await? {
                return Ok(entry);
            }
        }
    }

    /// Creates the entry of a key. `false` if one exists.
    async fn create_number(&self, key: &str, text: &str) -> Result<bool, LogError> {
        match self.numbers.create(key, text.to_owned().into()).await {
            Ok(_) => Ok(true),
            Err(error) if error.kind() == CreateErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(LogError::unanswered(error)),
        }
    }

    async fn number_entry(&self, key: &str) -> Result<Option<String>, LogError> {
        let entry = self.numbers.entry(key).await.map_err(LogError::unanswered)?;
        let entry = entry.filter(|entry| entry.operation == Operation::Put);
        Ok(entry.map(|entry| String::from_utf8_lossy(&entry.value).into_owned()))
    }
}

fn key(identity: Identity) -> String {
    let octets = postcard::to_stdvec(&identity).expect("an identity can be written down");
    format!("s.{}", input::hex::text(&octets))
}
