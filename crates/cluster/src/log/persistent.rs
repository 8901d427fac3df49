//! Entries that survive a restart of the servers: expected gateways, and the shared configuration.

use super::{Log, LogError, keys};
use crate::shared_configuration::SharedConfiguration;
use async_nats::jetstream::kv::Operation;
use site::config::Cluster;

/// Prefix of a gateway's key in the table.
const GATEWAY: &str = "gateway.";

impl Log {
    /// Registers a gateway as expected: an alert is raised if it does not report.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn expect_gateway(&self, name: &str) -> Result<(), LogError> {
        let key = format!("{GATEWAY}{name}");
        self.numbers.put(key, "runs".into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// Removes a gateway from the expected ones, because it was stopped.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn forget_gateway(&self, name: &str) -> Result<(), LogError> {
        self.numbers.delete(format!("{GATEWAY}{name}")).await.map_err(LogError::unanswered)
    }

    /// Names of the expected gateways.
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

    /// Stores a member's shared configuration, so that members with another one can list the differences.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn put_configuration(&self, shared: &SharedConfiguration) -> Result<(), LogError> {
        let key = format!("config.{:016x}", shared.hash());
        self.numbers.put(key, shared.octets().into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// Reads the shared configuration with this hash. `None` if it is missing, or if the octets have another hash.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn configuration(&self, hash: u64) -> Result<Option<SharedConfiguration>, LogError> {
        let entry = self.numbers.entry(format!("config.{hash:016x}")).await.map_err(LogError::unanswered)?;
        Ok(entry.and_then(|entry| SharedConfiguration::parse(&entry.value, hash)))
    }
}
