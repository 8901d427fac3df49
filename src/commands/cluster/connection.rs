//! Connections of the commands to the log, and the checks of `check`.

use fusion::slots::SlotGrid;

use super::PATIENCE;
use crate::app::{AppError, runtime};
use cluster::{Log, check, reach};
use site::config::{Cluster, Config};

/// Opens the log, if it answers in time.
pub(super) async fn opened(cluster: &Cluster, config: &Config) -> Result<Log, AppError> {
    if let Ok(opened) = tokio::time::timeout(PATIENCE, Log::open(cluster)).await {
        let mut log = opened?;
        log.grid = SlotGrid::new(config.fusion.slot);
        return Ok(log);
    }
    let mut said = Vec::new();
    for (server, reached) in reach(cluster).await {
        said.push(match reached {
            Ok(()) => format!("{server}: it takes the connection"),
            Err(why) => format!("{server}: {why}"),
        });
    }
    Err(format!("the log does not answer within {} s: {}", PATIENCE.as_secs(), said.join("; ")).into())
}

/// Checks certificates, keys and credentials. Returns a warning about a connection to another machine without TLS.
pub(in crate::commands) fn checked_proofs(config: &Config) -> Result<Option<String>, AppError> {
    let Some(cluster) = &config.cluster else { return Ok(None) };
    check(cluster)?;
    let is_open = |server: &&String| {
        let host = server.split_once("://").map_or("", |(_, host)| host);
        !server.starts_with("tls:") && !["127.", "localhost", "[::1]"].iter().any(|own| host.starts_with(own))
    };
    let open = cluster.servers.iter().find(is_open).filter(|_| !cluster.requires_tls());
    Ok(open.map(|server| {
        format!(
            "cluster.servers: the connection to {server} is neither encrypted nor authenticated; set ca, certificate and key \
             (docs/SCALING.md, Locked down)"
        )
    }))
}

/// Servers, each with the reason if the connection failed.
pub(in crate::commands) type Reached = Vec<(String, Result<(), String>)>;

/// Connects once to each server of the log, for `check --network`.
pub(in crate::commands) fn reached(config: &Config) -> Result<Reached, AppError> {
    let Some(cluster) = &config.cluster else { return Ok(Vec::new()) };
    Ok(runtime(1)?.block_on(reach(cluster)))
}
