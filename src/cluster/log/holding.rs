//! Entries that end unless they are renewed: leases, places of standbys, and reports of members.

use async_nats::jetstream::kv::{Operation, UpdateErrorKind};
use serde::{Deserialize, Serialize};

use super::reading::stamped;
use super::{Log, LogError, keys};
use fusion::time::Time;

/// The holder of an entry until it is no longer renewed.
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

/// The present holder of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// By whom.
    pub by: Holder,
    /// Its number: greater than that of the holder before.
    pub revision: u64,
}

/// The entry under a name that a node may hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// No entry.
    Free,
    /// Octets that name no holder, written under this number.
    Other(u64),
    /// A holder.
    Held(Held),
}

/// The result of an attempt to renew an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renewed {
    /// It goes on, under this number.
    Until(u64),
    /// Something else stands there, or it ended.
    Lost,
    /// No answer came.
    Unknown,
}

impl Log {
    /// Takes a name that is free; its number. `None`: another node holds it, or no answer came.
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

    /// The present entry under a name. Octets that name no holder are counted.
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

    /// The present holder of a name.
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

    /// The octets of an entry.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn said(&self, key: &str) -> Result<Option<Vec<u8>>, LogError> {
        Ok(self.said_at(key).await?.map(|(_, said)| said))
    }

    /// The same with the log's stamp.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn said_at(&self, key: &str) -> Result<Option<(Time, Vec<u8>)>, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        let put = entry.filter(|entry| entry.operation == Operation::Put);
        Ok(put.map(|entry| (stamped(entry.created.unix_timestamp_nanos()), entry.value.to_vec())))
    }

    /// All entries whose name begins so: the rest of their names, the log's stamps, and their octets. A name that no member can have
    /// is skipped.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all_said(&self, beginning: &str) -> Result<Vec<(String, Time, Vec<u8>)>, LogError> {
        let mut all = Vec::new();
        for key in keys(&self.held, &self.held_stream, beginning).await? {
            let Some(name) = key.strip_prefix(beginning) else { continue };
            if !crate::config::Cluster::is_name(name) {
                self.skips.note(beginning.trim_end_matches('.'), "under a name that no member can have");
                continue;
            }
            all.extend(self.said_at(&key).await?.map(|(stamp, said)| (name.to_owned(), stamp, said)));
        }
        Ok(all)
    }
}

fn written(holder: &Holder) -> bytes::Bytes {
    serde_json::to_vec(holder).expect("it can be written").into()
}
