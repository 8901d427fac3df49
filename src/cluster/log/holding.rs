//! What is held or said until it is no longer renewed: leases, seats, and what everybody says of itself.

use async_nats::jetstream::kv::{Operation, UpdateErrorKind};
use serde::{Deserialize, Serialize};

use super::{Log, LogError, keys};

/// Who holds something until it is no longer renewed.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Holder {
    /// The node.
    pub node: String,
    /// Its machine.
    pub machine: String,
    /// A number of this run of its process.
    pub run: u64,
    /// Hash of its shared configuration; 0: not stated.
    #[serde(default)]
    pub config: u64,
}

/// What a name of the log stands for now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// By whom.
    pub by: Holder,
    /// Its number: greater than of whoever held it before.
    pub revision: u64,
}

/// What stands under a name that somebody may hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nothing.
    Free,
    /// Octets that name no holder, written under this number.
    Other(u64),
    /// A holder.
    Held(Held),
}

/// What became of an attempt to go on holding something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renewed {
    /// It goes on, under this number.
    Until(u64),
    /// Something else stands there, or it ended.
    Lost,
    /// Nobody answered.
    Unknown,
}

impl Log {
    /// Takes hold of what nobody holds; its number. `None`: somebody has it, or nobody answers.
    pub async fn take(&self, key: &str, holder: &Holder) -> Option<u64> {
        self.held.create(key, written(holder)).await.ok()
    }

    /// Goes on holding what is held under this number, or takes the place of what was written under it.
    pub async fn renew(&self, key: &str, holder: &Holder, revision: u64) -> Renewed {
        match self.held.update(key, written(holder), revision).await {
            Ok(revision) => Renewed::Until(revision),
            Err(error) if error.kind() == UpdateErrorKind::WrongLastRevision => Renewed::Lost,
            Err(_) => Renewed::Unknown,
        }
    }

    /// Gives up what is held under this number.
    ///
    /// # Errors
    /// The log does not answer, or it is no longer held: it ends by itself.
    pub async fn give_up(&self, key: &str, revision: u64) -> Result<(), LogError> {
        let given = self.held.delete_expect_revision(key, Some(revision)).await;
        given.map_err(LogError::unanswered)
    }

    /// What stands under a name now. Octets that name no holder are counted.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn place(&self, key: &str) -> Result<Place, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        let Some(entry) = entry.filter(|entry| entry.operation == Operation::Put) else {
            return Ok(Place::Free);
        };
        let revision = entry.revision;
        Ok(match serde_json::from_slice(&entry.value) {
            Ok(by) => Place::Held(Held { by, revision }),
            Err(_) => {
                self.skips.note(key, "octets that name no holder");
                Place::Other(revision)
            }
        })
    }

    /// Who holds something now.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn holder(&self, key: &str) -> Result<Option<Held>, LogError> {
        Ok(match self.place(key).await? {
            Place::Held(held) => Some(held),
            Place::Free | Place::Other(_) => None,
        })
    }

    /// Says something that is forgotten when it is not said again.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn say(&self, key: &str, what: Vec<u8>) -> Result<(), LogError> {
        self.held.put(key, what.into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// What was said so.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn said(&self, key: &str) -> Result<Option<Vec<u8>>, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        Ok(entry.filter(|entry| entry.operation == Operation::Put).map(|entry| entry.value.to_vec()))
    }

    /// What all say whose name begins so: the rest of their names, and what they say. A name that no member can have is skipped.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all_said(&self, beginning: &str) -> Result<Vec<(String, Vec<u8>)>, LogError> {
        let mut all = Vec::new();
        for key in keys(&self.held, &self.held_stream, beginning).await? {
            let Some(name) = key.strip_prefix(beginning) else { continue };
            if !crate::config::Cluster::is_name(name) {
                self.skips.note(beginning.trim_end_matches('.'), "under a name that no member can have");
                continue;
            }
            all.extend(self.said(&key).await?.map(|said| (name.to_owned(), said)));
        }
        Ok(all)
    }
}

fn written(holder: &Holder) -> bytes::Bytes {
    serde_json::to_vec(holder).expect("it can be written").into()
}
