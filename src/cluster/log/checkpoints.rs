//! The states of cells that are kept in the log.

use std::time::Duration;

use async_nats::jetstream::Context;
use async_nats::jetstream::object_store::{self, GetErrorKind, InfoErrorKind, Object, ObjectStore};
use serde::{Deserialize, Serialize};
use tokio::io::AsyncReadExt;
use tokio::time::{Instant, timeout};

use super::{Log, LogError, Mark, PATIENCE};

/// Where nothing comes, it is looked so often whether another one has taken its place.
const LOOK: Duration = Duration::from_millis(100);

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
        loop {
            let mut object = match self.checkpoints.get(cell).await {
                Ok(object) => object,
                Err(error) if error.kind() == GetErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(LogError::unanswered(error)),
            };
            if let Some(octets) = self.whole(cell, &mut object).await? {
                return Ok(postcard::from_bytes(&octets).ok());
            }
        }
    }

    /// The octets of an object; `None` where another one has taken its place, with which they go: the client would wait for them
    /// for ever.
    async fn whole(&self, cell: &str, object: &mut Object) -> Result<Option<Vec<u8>>, LogError> {
        let (mut octets, mut heard) = (Vec::with_capacity(object.info().size), Instant::now());
        loop {
            let trouble = match timeout(LOOK, object.read_buf(&mut octets)).await {
                Ok(Ok(0)) => return Ok(Some(octets)),
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
