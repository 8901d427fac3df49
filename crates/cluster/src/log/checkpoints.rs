//! Checkpoints of cells in the log.

use std::time::Duration;

use base64::Engine as _;

use async_nats::jetstream::Context;
use async_nats::jetstream::object_store::{self, GetErrorKind, InfoErrorKind, Object, ObjectStore};
use serde::{Deserialize, Serialize};
use tokio::io::AsyncReadExt;
use tokio::time::{Instant, timeout};

use super::{Log, LogError, Mark, REQUEST_TIMEOUT, is_gone};

/// Interval at which the reader checks whether a stalled checkpoint has been replaced.
const REPLACEMENT_CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// Maximum number of retries if a checkpoint's octets do not match its description.
const MAX_RETRIES: u32 = 3;
/// Expected size of a checkpoint, and its maximum size, in octets.
const EXPECTED_OCTETS: usize = 1 << 20;
const MAX_OCTETS: usize = 512 << 20;

/// State of a cell, as stored in the log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Identifies the streams that the sequences refer to ([`Log::mark`]).
    pub mark: Mark,
    /// Sequence of the last input handled.
    pub handled: u64,
    /// Sequence of the last output made.
    pub published: u64,
    /// State of the engine.
    pub engine: Vec<u8>,
}

impl Log {
    /// Whether the sequences of a checkpoint refer to the current streams, and their messages are still stored.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn matches_streams(&self, kept: &Checkpoint) -> Result<bool, LogError> {
        Ok(self.mark(kept.handled, kept.published).await? == Some(kept.mark))
    }

    /// Stores a checkpoint of a cell in place of the previous one.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn put_checkpoint(&self, cell: &str, checkpoint: &Checkpoint) -> Result<(), LogError> {
        let octets = postcard::to_stdvec(checkpoint).map_err(LogError::unanswered)?;
        self.checkpoints.put(cell, &mut octets.as_slice()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// Reads the newest checkpoint of a cell; `None` if there is no readable one.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn checkpoint(&self, cell: &str) -> Result<Option<Checkpoint>, LogError> {
        let mut tries = 0;
        loop {
            let mut object = match self.checkpoints.get(cell).await {
                Ok(object) => object,
                // Any server may answer, even one that lacks the latest checkpoint: check with the leader.
                Err(error) if error.kind() == GetErrorKind::NotFound => {
                    if !self.has_description(cell).await? {
                        return Ok(None);
                    }
                    if tries == MAX_RETRIES {
                        return Err(LogError::unanswered(error));
                    }
                    tries += 1;
                    tokio::time::sleep(REPLACEMENT_CHECK_INTERVAL).await;
                    continue;
                }
                Err(error) if matches!(error.kind(), GetErrorKind::Other | GetErrorKind::BucketLink) => {
                    if self.has_description(cell).await? {
                        return Err(LogError::unanswered(error));
                    }
                    self.skips.note("checkpoint", "a description that cannot be read");
                    return Ok(None);
                }
                Err(error) => return Err(LogError::unanswered(error)),
            };
            let octets = match self.octets_of(cell, &mut object).await {
                Err(_) if tries == MAX_RETRIES => {
                    self.skips
                        .note("checkpoint", "octets that do not come, or are not those that are described");
                    return Ok(None);
                }
                Err(LogError::Unanswered(_)) => {
                    tries += 1;
                    tokio::time::sleep(REPLACEMENT_CHECK_INTERVAL).await;
                    continue;
                }
                octets => octets?,
            };
            if let Some(octets) = octets {
                let checkpoint = postcard::from_bytes(&octets).ok();
                if checkpoint.is_none() {
                    self.skips.note("checkpoint", "octets that are none of this version");
                }
                return Ok(checkpoint);
            }
        }
    }

    /// Whether the description of a cell's checkpoint is a valid object description.
    async fn has_description(&self, cell: &str) -> Result<bool, LogError> {
        let stream = self.context.get_stream_no_info(format!("OBJ_UTM_CK_{}", self.region)).await;
        let name = base64::engine::general_purpose::URL_SAFE.encode(cell);
        let subject = format!("$O.UTM_CK_{}.M.{name}", self.region);
        let described = stream.map_err(LogError::unanswered)?;
        match described.get_last_raw_message_by_subject(&subject).await {
            Ok(message) => {
                let info = serde_json::from_slice::<object_store::ObjectInfo>(&message.payload);
                Ok(info.is_ok_and(|info| {
                    !info.deleted && info.options.is_none_or(|options| options.link.is_none())
                }))
            }
            Err(error) if is_gone(&error.kind()) => Ok(false),
            Err(error) => Err(LogError::unanswered(error)),
        }
    }

    /// Reads the octets of an object. `None` if the object has been replaced: its octets are deleted then, and the client would
    /// wait for them for ever.
    async fn octets_of(&self, cell: &str, object: &mut Object) -> Result<Option<Vec<u8>>, LogError> {
        let (mut octets, mut heard) =
            (Vec::with_capacity(object.info().size.min(EXPECTED_OCTETS)), Instant::now());
        loop {
            let trouble = match timeout(REPLACEMENT_CHECK_INTERVAL, object.read_buf(&mut octets)).await {
                Ok(Ok(0)) => return Ok(Some(octets)),
                Ok(Ok(_)) if octets.len() > MAX_OCTETS => Some("a checkpoint is too large".to_owned()),
                Ok(Ok(_)) => {
                    heard = Instant::now();
                    continue;
                }
                Ok(Err(error)) => Some(error.to_string()),
                Err(_) => {
                    (heard.elapsed() > REQUEST_TIMEOUT).then(|| "a checkpoint does not come".to_owned())
                }
            };
            match self.checkpoints.info(cell).await {
                Ok(now) if now.nuid == object.info().nuid => {}
                Ok(_) => return Ok(None),
                Err(error) if error.kind() == InfoErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(LogError::unanswered(error)),
            }
            if let Some(trouble) = trouble {
                return Err(LogError::Unanswered(trouble));
            }
        }
    }
}

/// Opens the store of checkpoints, and creates it if it is missing.
pub(super) async fn open_store(
    context: &Context,
    wanted: object_store::Config,
) -> Result<ObjectStore, LogError> {
    match context.get_object_store(&wanted.bucket).await {
        Ok(store) => Ok(store),
        Err(_) => context.create_object_store(wanted).await.map_err(LogError::unanswered),
    }
}
