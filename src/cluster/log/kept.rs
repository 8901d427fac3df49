//! Entries that outlive a restart of the servers: expected gateways, and the shared configuration.

use super::{Log, LogError, keys};
use crate::cluster::shared::SharedConfiguration;
use crate::config::Cluster;
use async_nats::jetstream::kv::Operation;

/// Beginning of a gateway's key in the table.
const GATEWAY: &str = "gateway.";

impl Log {
    /// A gateway runs, and is missed where it says nothing.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn expect_gateway(&self, name: &str) -> Result<(), LogError> {
        let key = format!("{GATEWAY}{name}");
        self.numbers.put(key, "runs".into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// It was ended, and is not missed.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn forget_gateway(&self, name: &str) -> Result<(), LogError> {
        self.numbers.delete(format!("{GATEWAY}{name}")).await.map_err(LogError::unanswered)
    }

    /// The gateways that ought to be heard of.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn expected_gateways(&self) -> Result<Vec<String>, LogError> {
        let mut expected = Vec::new();
        for key in keys(&self.numbers, &self.numbers_stream, GATEWAY).await? {
            let Some(name) = key.strip_prefix(GATEWAY).filter(|name| Cluster::is_name(name)) else {
                self.skips.note("gateway", "under a name that no member can have");
                continue;
            };
            let entry = self.numbers.entry(&key).await.map_err(LogError::unanswered)?;
            if entry.is_some_and(|entry| entry.operation == Operation::Put) {
                expected.push(name.to_owned());
            }
        }
        Ok(expected)
    }

    /// Keeps what a member has, for those that differ.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn keep_configuration(&self, shared: &SharedConfiguration) -> Result<(), LogError> {
        let key = format!("config.{:016x}", shared.hash());
        self.numbers.put(key, shared.octets().into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// The shared configuration with this hash; `None`: it is not there, or the octets are another.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn configuration(&self, hash: u64) -> Result<Option<SharedConfiguration>, LogError> {
        let entry = self.numbers.entry(format!("config.{hash:016x}")).await.map_err(LogError::unanswered)?;
        Ok(entry.and_then(|entry| SharedConfiguration::parse(&entry.value, hash)))
    }
}
