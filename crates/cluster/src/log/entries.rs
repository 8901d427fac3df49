//! Entries that expire unless renewed: leases, standby roles, and reports of members.

use async_nats::jetstream::kv::{Operation, UpdateErrorKind};
use serde::{Deserialize, Serialize};

use super::reader::stamped;
use super::{Log, LogError, keys};
use fusion::time::Time;

/// Holder of an entry, until the entry expires.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Holder {
    /// Name of the node.
    pub node: String,
    /// Name of its machine.
    pub machine: String,
    /// Number of this run of its process.
    pub run: u64,
    /// Hash of its shared configuration; 0 if not stated.
    #[serde(default)]
    pub config: u64,
}

/// An entry with its holder.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct HeldEntry {
    /// The holder.
    pub by: Holder,
    /// Number of the entry, greater than that of any earlier entry.
    pub revision: u64,
}

/// State of an entry that a node may hold.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum EntryState {
    /// No entry exists.
    Free,
    /// The entry contains octets that name no holder. The value is its number.
    Foreign(u64),
    /// The entry has a holder.
    Held(HeldEntry),
}

/// Result of an attempt to renew an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Renewal {
    /// The entry is renewed, under this number.
    Until(u64),
    /// The entry has expired, or has other contents.
    Lost,
    /// The log did not answer.
    Unknown,
}

impl Log {
    /// Creates an entry. Returns its number; `None` if another node holds it or the log did not answer.
    pub async fn create_entry(&self, key: &str, holder: &Holder) -> Option<u64> {
        self.held.create(key, serialised(holder)).await.ok()
    }

    /// Renews the entry with this number, or replaces its contents.
    pub async fn renew_entry(&self, key: &str, holder: &Holder, revision: u64) -> Renewal {
        match self.held.update(key, serialised(holder), revision).await {
            Ok(revision) => Renewal::Until(revision),
            Err(error) if error.kind() == UpdateErrorKind::WrongLastRevision => Renewal::Lost,
            Err(_) => Renewal::Unknown,
        }
    }

    /// Deletes the entry with this number.
    ///
    /// # Errors
    /// The log does not answer, or the entry has changed. The entry then expires by itself.
    pub async fn delete_entry(&self, key: &str, revision: u64) -> Result<(), LogError> {
        let given = self.held.delete_expect_revision(key, Some(revision)).await;
        given.map_err(LogError::unanswered)
    }

    /// Reads an entry. Octets that name no holder are counted as skipped.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn entry_state(&self, key: &str) -> Result<EntryState, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        let Some(entry) = entry.filter(|entry| entry.operation == Operation::Put) else {
            return Ok(EntryState::Free);
        };
        let revision = entry.revision;
        Ok(match serde_json::from_slice(&entry.value) {
            Ok(by) => EntryState::Held(HeldEntry { by, revision }),
            Err(_) => {
                self.skips.note(key, "octets that name no holder");
                EntryState::Foreign(revision)
            }
        })
    }

    /// Reads the holder of an entry.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn holder(&self, key: &str) -> Result<Option<HeldEntry>, LogError> {
        Ok(match self.entry_state(key).await? {
            EntryState::Held(held) => Some(held),
            EntryState::Free | EntryState::Foreign(_) => None,
        })
    }

    /// Writes an entry that expires unless it is written again.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn put_entry(&self, key: &str, what: Vec<u8>) -> Result<(), LogError> {
        self.held.put(key, what.into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// Reads the octets of an entry.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn entry(&self, key: &str) -> Result<Option<Vec<u8>>, LogError> {
        Ok(self.stamped_entry(key).await?.map(|(_, said)| said))
    }

    /// Reads the octets of an entry, with the log's timestamp.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn stamped_entry(&self, key: &str) -> Result<Option<(Time, Vec<u8>)>, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        let put = entry.filter(|entry| entry.operation == Operation::Put);
        Ok(put.map(|entry| (stamped(entry.created.unix_timestamp_nanos()), entry.value.to_vec())))
    }

    /// Reads all entries whose keys have this prefix: the rest of the key, the log's timestamp, and the octets. Keys that are no
    /// valid member names are skipped.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn entries(&self, beginning: &str) -> Result<Vec<(String, Time, Vec<u8>)>, LogError> {
        let mut all = Vec::new();
        for key in keys(&self.held, &self.held_stream, beginning).await? {
            let Some(name) = key.strip_prefix(beginning) else { continue };
            if !site::config::Cluster::is_name(name) {
                self.skips.note(beginning.trim_end_matches('.'), "under a name that no member can have");
                continue;
            }
            all.extend(self.stamped_entry(&key).await?.map(|(stamp, said)| (name.to_owned(), stamp, said)));
        }
        Ok(all)
    }
}

fn serialised(holder: &Holder) -> bytes::Bytes {
    serde_json::to_vec(holder).expect("it can be written").into()
}
