//! The states of cells that are kept in the log.

use std::time::Duration;

use base64::Engine as _;

use async_nats::jetstream::Context;
use async_nats::jetstream::object_store::{self, GetErrorKind, InfoErrorKind, Object, ObjectStore};
use serde::{Deserialize, Serialize};
use tokio::io::AsyncReadExt;
use tokio::time::{Instant, timeout};

use super::{Log, LogError, Mark, PATIENCE, is_gone};

/// Where nothing comes, it is looked so often whether another one has taken its place.
const LOOK: Duration = Duration::from_millis(100);

/// Attempts to read a checkpoint whose octets do not match its description.
const TRIES: u32 = 3;
/// Octets of most checkpoints, and the most that are read of one.
const LIKELY: usize = 1 << 20;
const LARGEST: usize = 512 << 20;

/// A state of a cell, as it is kept in the log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Which streams the sequences are of ([`Log::mark`]).
    pub mark: Mark,
    /// Sequences of the last input that is handled in it, and of the last output that is made.
    pub handled: u64,
    /// The last output.
    pub published: u64,
    /// The engine.
    pub engine: Vec<u8>,
}

impl Log {
    /// Whether the sequences of a checkpoint are of the streams as they are, and what they stand for is there.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn knows(&self, kept: &Checkpoint) -> Result<bool, LogError> {
        Ok(self.mark(kept.handled, kept.published).await? == Some(kept.mark))
    }

    /// Keeps a checkpoint of a cell, in place of the one before.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn keep(&self, cell: &str, checkpoint: &Checkpoint) -> Result<(), LogError> {
        let octets = postcard::to_stdvec(checkpoint).map_err(LogError::unanswered)?;
        self.checkpoints.put(cell, &mut octets.as_slice()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// The newest checkpoint of a cell; `None` where there is none that can be read.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn checkpoint(&self, cell: &str) -> Result<Option<Checkpoint>, LogError> {
        let mut tries = 0;
        loop {
            let mut object = match self.checkpoints.get(cell).await {
                Ok(object) => object,
                Err(error) if error.kind() == GetErrorKind::NotFound => return Ok(None),
                Err(error) if matches!(error.kind(), GetErrorKind::Other | GetErrorKind::BucketLink) => {
                    if self.has_description(cell).await? {
                        return Err(LogError::unanswered(error));
                    }
                    self.skips.note("checkpoint", "a description that cannot be read");
                    return Ok(None);
                }
                Err(error) => return Err(LogError::unanswered(error)),
            };
            let octets = match self.whole(cell, &mut object).await {
                Err(_) if tries == TRIES => {
                    self.skips
                        .note("checkpoint", "octets that do not come, or are not those that are described");
                    return Ok(None);
                }
                Err(LogError::Unanswered(_)) => {
                    tries += 1;
                    tokio::time::sleep(LOOK).await;
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

    /// Whether what describes a checkpoint is the description of an object.
    async fn has_description(&self, cell: &str) -> Result<bool, LogError> {
        let stream = self.context.get_stream_no_info(format!("OBJ_UTM_CK_{}", self.region)).await;
        let name = base64::engine::general_purpose::URL_SAFE.encode(cell);
        let subject = format!("$O.UTM_CK_{}.M.{name}", self.region);
        let described = stream.map_err(LogError::unanswered)?;
        match described.get_last_raw_message_by_subject(&subject).await {
            Ok(message) => {
                let info = serde_json::from_slice::<object_store::ObjectInfo>(&message.payload);
                Ok(info.is_ok_and(|info| info.options.is_none_or(|options| options.link.is_none())))
            }
            Err(error) if is_gone(&error.kind()) => Ok(false),
            Err(error) => Err(LogError::unanswered(error)),
        }
    }

    /// The octets of an object; `None` where another one has taken its place, with which they go: the client would wait for them
    /// for ever.
    async fn whole(&self, cell: &str, object: &mut Object) -> Result<Option<Vec<u8>>, LogError> {
        let (mut octets, mut heard) = (Vec::with_capacity(object.info().size.min(LIKELY)), Instant::now());
        loop {
            let trouble = match timeout(LOOK, object.read_buf(&mut octets)).await {
                Ok(Ok(0)) => return Ok(Some(octets)),
                Ok(Ok(_)) if octets.len() > LARGEST => Some("a checkpoint is too large".to_owned()),
                Ok(Ok(_)) => {
                    heard = Instant::now();
                    continue;
                }
                Ok(Err(error)) => Some(error.to_string()),
                Err(_) => (heard.elapsed() > PATIENCE).then(|| "a checkpoint does not come".to_owned()),
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

/// The store of them, which is made where it is missing.
pub(super) async fn made(context: &Context, wanted: object_store::Config) -> Result<ObjectStore, LogError> {
    match context.get_object_store(&wanted.bucket).await {
        Ok(store) => Ok(store),
        Err(_) => context.create_object_store(wanted).await.map_err(LogError::unanswered),
    }
}
