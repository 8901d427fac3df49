//! `cluster`: inspection and operation of a cluster.

mod connection;
mod status;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::join_all;
use jiff::SignedDuration;
use serde_json::json;

use super::moment::duration;
use super::table::grouped;
use super::{CommandResult, Outcome, Usage};
use crate::app::{AppError, Signals, runtime};
use cluster::{
    Cells, ConfigurationDifference, GatewayReport, Log, NodeReport, NodeRole, SharedConfiguration,
    record as recorded, record_region, verify,
};
use site::areas::Areas;
use site::config::{Cluster, Config};
use site::territory::CellName;

use connection::opened;
pub(super) use connection::{checked_proofs, reached};
use status::ClusterStatus;

/// Timeout for the servers to answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Timeout for a node to give up its cells.
const DRAINS: Duration = Duration::from_secs(15);

/// Shows the state of a cluster (docs/SCALING.md), drains a node, or verifies the published slots.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Subcommand.
    #[command(subcommand)]
    pub command: ClusterCommand,
    /// Configuration file of any process of the cluster.
    #[arg(long, value_name = "FILE", global = true, required = false, default_value = "site.toml")]
    pub config: PathBuf,
}

/// Subcommands.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum ClusterCommand {
    /// Shows owners and standbys of the cells, the counters of nodes and gateways, and the clocks of gateways. Exit code 1 if there
    /// is a problem: a cell that is late, early, or without an owner or a standby; a missing gateway; a member with another
    /// configuration; unreadable messages; or a clock that is not to be trusted.
    Status {
        /// Prints JSON.
        #[arg(long)]
        json: bool,
    },
    /// Shows the cells with owner, standby and lateness.
    Cells,
    /// Makes a node give up its cells and take no others, so that its process can be stopped without an interruption.
    Drain {
        /// Name of the node.
        node: String,
    },
    /// Stops reporting a gateway as missing that was removed for good.
    Forget {
        /// Name of the gateway.
        gateway: String,
    },
    /// Compares the published slots with slots computed again from the inputs, for some time. Reports slots that are missing,
    /// doubled, late, early or different, and messages that cannot be read. Exit code 5 if there are any.
    Verify {
        /// Name of the cell. All cells if not given.
        #[arg(long, value_name = "NAME")]
        cell: Option<String>,
        /// Duration of the comparison, such as 60s or 10m.
        #[arg(long, value_name = "D", value_parser = duration, default_value = "60s")]
        duration: SignedDuration,
        /// Prints JSON.
        #[arg(long)]
        json: bool,
    },
}

/// Runs `record --cluster`: records the inputs of the cell, or of all sensors in a region of several cells, until Ctrl-C.
pub(super) fn record(config: &Config, directory: &Path, lasts: Option<SignedDuration>) -> CommandResult {
    let Some(cluster) = &config.cluster else {
        return Err(Usage("the configuration has no [cluster] to record".to_owned()).into());
    };
    let areas = Areas::load(&config.areas)?;
    let is_whole = Cells::of(config)?.is_whole();
    let counts = runtime(1)?.block_on(async {
        let log = opened(cluster, config).await?;
        let mut signals = Signals::listen()?;
        let ends = async {
            match lasts {
                Some(lasts) => tokio::select! {
                    () = tokio::time::sleep(lasts.unsigned_abs()) => {}
                    () = signals.stop() => {}
                },
                None => signals.stop().await,
            }
        };
        Ok::<_, AppError>(match is_whole {
            true => recorded(&log, cluster, config, &areas, directory, ends).await?,
            false => record_region(&log, config, directory, ends).await?,
        })
    })?;
    let lost = counts.unwritten + counts.lost;
    tracing::info!(recorded = counts.written, lost, "stopped");
    Ok(if lost > 0 { Outcome::Incomplete } else { Outcome::Done })
}

/// Lines of `check` about a divided region: its cells, and the sensors that each one uses.
pub(super) fn cells(config: &Config) -> Result<Vec<String>, AppError> {
    let cells = Cells::of(config)?;
    let Some(cluster) = config.cluster.as_ref().filter(|_| !cells.is_whole()) else { return Ok(Vec::new()) };
    let of = |cell: &CellName| {
        let of_use = |index: &usize| cells.of_sensor(config, *index).contains(&cell);
        let sensors: Vec<&str> =
            (0..config.sensors.len()).filter(of_use).map(|index| config.sensors[index].id.as_str()).collect();
        format!(
            "cell {cell}: {}",
            if sensors.is_empty() { "no sensor".to_owned() } else { sensors.join(", ") }
        )
    };
    let count = cells.names().len();
    let (halo_m, hysteresis_m) = (cluster.halo_m, cluster.hysteresis_m);
    let first =
        format!("{count} cells, each with {halo_m} m around it; an aircraft stays {hysteresis_m} m outside");
    Ok([first].into_iter().chain(cells.names().iter().map(of)).collect())
}

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = Arc::new(Config::load(&args.config)?);
    let Some(cluster) = &config.cluster else {
        let file = args.config.display();
        return Err(
            Usage(format!("{file} has no [cluster]: there is one machine, and nothing to ask")).into()
        );
    };
    let cells = Cells::of(&config)?;
    runtime(1)?.block_on(async {
        let log = opened(cluster, &config).await?;
        let mut out = io::stdout().lock();
        match &args.command {
            ClusterCommand::Status { json } => {
                let areas = Areas::load(&config.areas)?;
                let status =
                    ClusterStatus::read(&log, &cells, &SharedConfiguration::of(&config, &areas)?).await?;
                match json {
                    true => writeln!(out, "{:#}", status.json(&config))?,
                    false => {
                        write!(out, "{}\n{}\n{}", status.cells(&config), status.nodes(), status.gateways())?;
                    }
                }
                let wrong = status.wrong(&config);
                wrong.iter().for_each(|wrong| tracing::warn!("{wrong}"));
                Ok(if wrong.is_empty() { Outcome::Done } else { Outcome::Incomplete })
            }
            ClusterCommand::Cells => {
                let areas = Areas::load(&config.areas)?;
                let status =
                    ClusterStatus::read(&log, &cells, &SharedConfiguration::of(&config, &areas)?).await?;
                write!(out, "{}", status.cells(&config))?;
                Ok(Outcome::Done)
            }
            ClusterCommand::Drain { node } => drain(&log, node, &mut out).await,
            ClusterCommand::Forget { gateway } => forget(&log, cluster, gateway, &mut out).await,
            ClusterCommand::Verify { cell, duration, json } => {
                let areas = Areas::load(&config.areas)?;
                let names = chosen(&cells, cell.as_deref())?;
                checked(&log, cluster, (&config, &areas), (&cells, &names), (*duration, *json), &mut out)
                    .await
            }
        }
    })
}

/// The cell `name`, or all cells.
fn chosen(cells: &Cells, name: Option<&str>) -> Result<Vec<CellName>, Usage> {
    let Some(name) = name else { return Ok(cells.names().to_vec()) };
    let found = cells.names().iter().find(|cell| cell.as_str() == name).cloned();
    let names = || cells.names().iter().map(CellName::as_str).collect::<Vec<_>>().join(", ");
    found
        .map(|cell| vec![cell])
        .ok_or_else(|| Usage(format!("no cell is called {name}: there are {}", names())))
}

/// Removes a gateway from the list of expected ones.
async fn forget(log: &Log, cluster: &Cluster, gateway: &str, out: &mut impl Write) -> CommandResult {
    if cluster.gateways.iter().any(|name| name == gateway) {
        return Err(Usage(format!("gateway {gateway} is in cluster.gateways: remove it there")).into());
    }
    if GatewayReport::all(log).await?.iter().any(|report| report.node == gateway) {
        return Err(Usage(format!("gateway {gateway} runs: stop it, and nobody misses it")).into());
    }
    if !log.expected_gateways().await?.iter().any(|name| name == gateway) {
        return Err(Usage(format!("no gateway called {gateway} is missed")).into());
    }
    log.forget_gateway(gateway).await?;
    writeln!(out, "gateway {gateway} is not missed any more")?;
    Ok(Outcome::Done)
}

/// Asks a node to give up its cells, and waits until it has.
async fn drain(log: &Log, node: &str, out: &mut impl Write) -> CommandResult {
    let key = format!("node.{node}");
    let report = async || -> Result<Option<NodeReport>, cluster::LogError> {
        Ok(log.entry(&key).await?.and_then(|said| postcard::from_bytes(&said).ok()))
    };
    let Some(found) = report().await? else {
        return Err(Usage(format!(
            "no node is called {node}; utm-fusion cluster status shows those that there are"
        ))
        .into());
    };
    let drained = async {
        loop {
            log.put_entry(&format!("drain.{node}"), found.holder.run.to_string().into_bytes()).await?;
            let is_drained = report().await?.is_none_or(|report| {
                report.is_draining && report.cells.iter().all(|(_, counts)| counts.part == NodeRole::None)
            });
            if is_drained {
                return Ok::<(), cluster::LogError>(());
            }
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
    };
    match tokio::time::timeout(DRAINS, drained).await {
        Ok(drained) => drained?,
        Err(_) => {
            return Err(format!("node {node} did not give up its cells within {} s", DRAINS.as_secs()).into());
        }
    }
    writeln!(out, "node {node} is drained: it takes no cell until it is started anew")?;
    Ok(Outcome::Done)
}

async fn checked(
    log: &Log,
    cluster: &Cluster,
    (config, areas): (&Arc<Config>, &Areas),
    (cells, names): (&Cells, &[CellName]),
    (lasts, as_json): (SignedDuration, bool),
    out: &mut impl Write,
) -> CommandResult {
    let verdict = |name| verify(log, cluster, config, areas, (cells, name), lasts.unsigned_abs());
    let verdicts = join_all(names.iter().map(verdict)).await;
    let (mut shown, mut is_good) = (serde_json::Map::new(), true);
    let shared = SharedConfiguration::of(config, areas)?;
    let (nodes, gateways) = (NodeReport::all(log).await?, GatewayReport::all(log).await?);
    for ConfigurationDifference { member, text } in shared.differing_members(log, &nodes, &gateways).await? {
        tracing::warn!("{member} has another configuration: {text}");
        is_good = false;
    }
    for (cell, verdict) in names.iter().zip(verdicts) {
        let verdict = verdict?;
        is_good &= verdict.is_good();
        if as_json {
            shown.insert(cell.to_string(), json!(verdict));
            continue;
        }
        let made = match verdict.differs {
            Some(false) => format!("{} made here, too: all the same", grouped(verdict.made)),
            Some(true) => "made here, too: they DIFFER".to_owned(),
            None => "not made here: there is no checkpoint to begin from".to_owned(),
        };
        writeln!(
            out,
            "cell {cell}: {} slots, {} doubled, {} missing, {} late (latest {:.3} s), {} early; {made}; {} datagrams in {} messages; {} messages skipped, {} outputs of nobody",
            grouped(verdict.slots),
            verdict.doubled,
            verdict.missing,
            verdict.late,
            verdict.latest_s,
            verdict.early,
            grouped(verdict.datagrams),
            grouped(verdict.inputs),
            verdict.skipped,
            verdict.foreign,
        )?;
    }
    if as_json {
        writeln!(out, "{:#}", json!({ "cells": shown }))?;
    }
    Ok(if is_good { Outcome::Done } else { Outcome::ThresholdMissed })
}
