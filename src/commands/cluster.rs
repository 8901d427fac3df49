//! `cluster`: how a cluster is, from outside.

mod connection;

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::join_all;
use jiff::SignedDuration;
use serde_json::{Value, json};

use super::moment::duration;
use super::table::{Table, grouped};
use super::{CommandResult, Outcome, Usage};
use crate::app::{Failure, Signals, runtime};
use crate::areas::Areas;
use crate::cluster::{
    CellReport, Cells, Different, GatewayReport, Holder, Log, NodeReport, Part, SharedConfiguration, Skipped,
    differences, record as recorded, record_region, verify,
};
use crate::config::{Cluster, Config};
use crate::live::{ClockDifference, Members, milliseconds, now};
use crate::territory::CellName;
use fusion::time::Time;

use connection::opened;
pub(super) use connection::{checked_proofs, reached};

/// A picture older than this beyond its latency is late, seconds.
const LATE_S: f64 = 1.0;
/// Longest time for which is waited for the servers, and for a node to give up its cells.
const PATIENCE: Duration = Duration::from_secs(5);
const DRAINS: Duration = Duration::from_secs(15);

/// Shows how a cluster is (docs/SCALING.md), drains a node, or verifies what is published.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// The configuration of any process of the cluster.
    #[arg(long, value_name = "FILE", global = true, required = false, default_value = "site.toml")]
    pub config: PathBuf,
}

/// What can be done.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum Command {
    /// Who owns what and stands by, what nodes and gateways count, how good gateways' clocks are. Exit code 1 where a cell is
    /// late or early, or has no owner or nobody beside it, a gateway is missing, a member has another configuration, messages
    /// cannot be read, or a clock is not to be trusted.
    Status {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// The cells: owner, standby, lateness.
    Cells,
    /// Lets a node give up its cells and take no others, so that its process can be stopped and nobody notices.
    Drain {
        /// The node.
        node: String,
    },
    /// Misses a gateway no longer that does not come back.
    Forget {
        /// The gateway.
        gateway: String,
    },
    /// Reads what is published for some time, and makes it once more from what was received: slots missing, doubled, late, early
    /// or different, messages that cannot be read. Exit code 5 where there is one.
    Verify {
        /// One cell; else all of them.
        #[arg(long, value_name = "NAME")]
        cell: Option<String>,
        /// For how long: 60s, 10m.
        #[arg(long, value_name = "D", value_parser = duration, default_value = "60s")]
        duration: SignedDuration,
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
}

/// `record --cluster`: what the cell handles, or what the sensors of a region of several cells send, until Ctrl-C.
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
        Ok::<_, Failure>(match is_whole {
            true => recorded(&log, cluster, config, &areas, directory, ends).await?,
            false => record_region(&log, config, directory, ends).await?,
        })
    })?;
    let lost = counts.unwritten + counts.lost;
    tracing::info!(recorded = counts.written, lost, "stopped");
    Ok(if lost > 0 { Outcome::Incomplete } else { Outcome::Done })
}

/// What `check` says of a region that is divided: its cells, and the sensors of use to each.
pub(super) fn cells(config: &Config) -> Result<Vec<String>, Failure> {
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

/// What is said of a cell.
struct CellSaid {
    cell: String,
    owner: Option<Holder>,
    standby: Option<Holder>,
    report: Option<CellReport>,
    /// The newest slot, and when it is of.
    latest: Option<Time>,
}

/// What those of a cluster say.
struct Said {
    cells: Vec<CellSaid>,
    nodes: Vec<NodeReport>,
    gateways: Vec<GatewayReport>,
    /// Gateways that were not ended in order.
    expected: Vec<String>,
    /// Members with another configuration than that of the command.
    different: Vec<Different>,
    /// The messages that this command could not read.
    skipped: Vec<Skipped>,
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
            Command::Status { json } => {
                let areas = Areas::load(&config.areas)?;
                let said = Said::hear(&log, &cells, &SharedConfiguration::of(&config, &areas)?).await?;
                match json {
                    true => writeln!(out, "{:#}", said.json(&config))?,
                    false => write!(out, "{}\n{}\n{}", said.cells(&config), said.nodes(), said.gateways())?,
                }
                let wrong = said.wrong(&config);
                wrong.iter().for_each(|wrong| tracing::warn!("{wrong}"));
                Ok(if wrong.is_empty() { Outcome::Done } else { Outcome::Incomplete })
            }
            Command::Cells => {
                let areas = Areas::load(&config.areas)?;
                let said = Said::hear(&log, &cells, &SharedConfiguration::of(&config, &areas)?).await?;
                write!(out, "{}", said.cells(&config))?;
                Ok(Outcome::Done)
            }
            Command::Drain { node } => drain(&log, node, &mut out).await,
            Command::Forget { gateway } => forget(&log, cluster, gateway, &mut out).await,
            Command::Verify { cell, duration, json } => {
                let areas = Areas::load(&config.areas)?;
                let names = chosen(&cells, cell.as_deref())?;
                checked(&log, cluster, (&config, &areas), (&cells, &names), (*duration, *json), &mut out)
                    .await
            }
        }
    })
}

/// That cell, or all.
fn chosen(cells: &Cells, name: Option<&str>) -> Result<Vec<CellName>, Usage> {
    let Some(name) = name else { return Ok(cells.names().to_vec()) };
    let found = cells.names().iter().find(|cell| cell.as_str() == name).cloned();
    let names = || cells.names().iter().map(CellName::as_str).collect::<Vec<_>>().join(", ");
    found
        .map(|cell| vec![cell])
        .ok_or_else(|| Usage(format!("no cell is called {name}: there are {}", names())))
}

impl CellSaid {
    async fn hear(log: &Log, cell: &CellName) -> Result<Self, crate::cluster::LogError> {
        let holder = async |part: &str| log.holder(&format!("{cell}.{part}")).await;
        let report = log.said(&format!("{cell}.report")).await?;
        let latest = log.last(cell.as_str()).await?;
        Ok(Self {
            cell: cell.to_string(),
            owner: holder("owner").await?.map(|held| held.by),
            standby: holder("standby").await?.map(|held| held.by),
            report: report.and_then(|report| CellReport::parse(&report)),
            latest: latest
                .and_then(|(_, output)| crate::cluster::pictures(&output.picture))
                .map(|(of, _)| of.time),
        })
    }

    /// How late the newest slot is, seconds: beyond the latency that is configured, and the slot after it.
    fn late_s(&self, config: &Config) -> Option<f64> {
        let latest = self.latest?;
        let due = latest + config.fusion.latency() + config.fusion.slot;
        Some((now() - due).as_secs_f64().max(0.0))
    }

    /// How long before it is due the newest slot was published, seconds.
    fn early_s(&self, config: &Config) -> f64 {
        let due = self.latest.map(|latest| latest + config.fusion.latency() - config.fusion.slot / 2);
        due.map_or(0.0, |due| (due - now()).as_secs_f64().max(0.0))
    }

    fn wrong(&self, config: &Config) -> Vec<String> {
        let (mut wrong, cell) = (Vec::new(), &self.cell);
        if self.owner.is_none() {
            wrong.push(format!("nobody owns cell {cell}"));
        }
        if self.standby.is_none() {
            wrong.push(format!("nobody stands by for cell {cell}"));
        }
        let early_s = self.early_s(config);
        if early_s > LATE_S {
            wrong.push(format!("the newest slot of cell {cell} is {early_s:.1} s early: a clock is wrong"));
        }
        match self.late_s(config) {
            None => wrong.push(format!("nothing has been published of cell {cell}")),
            Some(late_s) if late_s > LATE_S => {
                wrong.push(format!("the newest slot of cell {cell} is {late_s:.1} s late"));
            }
            Some(_) => {}
        }
        wrong
    }
}

impl Said {
    async fn hear(log: &Log, cells: &Cells, shared: &SharedConfiguration) -> Result<Self, Failure> {
        let (nodes, gateways) = (NodeReport::all(log).await?, GatewayReport::all(log).await?);
        let different = shared.different(log, &nodes, &gateways).await?;
        let expected = log.expected_gateways().await?;
        let mut said = Vec::new();
        for cell in cells.names() {
            said.push(CellSaid::hear(log, cell).await?);
        }
        Ok(Self { cells: said, nodes, gateways, expected, different, skipped: log.skips.all() })
    }

    fn wrong(&self, config: &Config) -> Vec<String> {
        let clocks = self.clocks().troubles().into_iter().map(|trouble| trouble.text);
        let missing = self.missing(config).into_iter().map(|name| format!("gateway {name} says nothing"));
        let different = self.different.iter().map(|Different { member, text }| {
            format!("{member} has another configuration than {}: {text}", "this command's")
        });
        let all = self.cells.iter().flat_map(|cell| cell.wrong(config)).chain(missing).chain(different);
        all.chain(self.unreadable()).chain(clocks).collect()
    }

    /// Gateways that ought to be heard of, and are not.
    fn missing(&self, config: &Config) -> BTreeSet<String> {
        let configured = config.cluster.iter().flat_map(|cluster| &cluster.gateways);
        let is_missing = |name: &&String| self.gateways.iter().all(|gateway| gateway.node != **name);
        self.expected.iter().chain(configured).filter(is_missing).cloned().collect()
    }

    /// Messages that were skipped within the last minute, by those who tell.
    fn unreadable(&self) -> Vec<String> {
        let nodes = self.nodes.iter().flat_map(|node| {
            node.skipped.iter().map(move |skipped| (format!("node {}", node.holder.node), skipped))
        });
        let own = self.skipped.iter().map(|skipped| ("this command".to_owned(), skipped));
        let recent = nodes.chain(own).filter(|(_, skipped)| skipped.is_recent);
        let text = |(who, Skipped { place, reason, count, .. }): (String, &Skipped)| {
            format!("{who} skips messages of the log: {place}: {reason} ({count} so far)")
        };
        recent.map(text).collect()
    }

    /// The members with their clocks, by this one look.
    fn clocks(&self) -> Members {
        Members {
            nodes: self.nodes.iter().map(NodeReport::state).collect(),
            gateways: self.gateways.iter().map(GatewayReport::state).collect(),
            clocks: differences(&self.gateways),
            ..Members::default()
        }
    }

    fn cells(&self, config: &Config) -> Table {
        let names = ["cell", "owner", "lease", "standby", "behind", "published", "late"];
        let mut table = Table::new("llrlrrr", &names);
        let name = |of: &Option<Holder>| of.as_ref().map_or("nobody".to_owned(), |of| of.node.clone());
        for said in &self.cells {
            let counts = |of: &Option<Holder>| {
                let node = self.nodes.iter().find(|node| Some(&node.holder) == of.as_ref());
                node.map(|node| node.counts(&said.cell)).unwrap_or_default()
            };
            let (owner, standby) = (counts(&said.owner), counts(&said.standby));
            table.row([
                said.cell.clone(),
                name(&said.owner),
                owner.epoch.to_string(),
                name(&said.standby),
                format!("{} slots", standby.behind),
                grouped(owner.published),
                said.late_s(config).map_or("nothing yet".to_owned(), |late_s| format!("{late_s:.2} s")),
            ]);
        }
        table
    }

    fn nodes(&self) -> Table {
        let names = [
            "node",
            "machine",
            "is",
            "owns",
            "beside",
            "take-overs",
            "fenced",
            "diverged",
            "checkpoints",
            "clock",
        ];
        let mut table = Table::new("lllrrrrrrr", &names);
        for node in &self.nodes {
            let sum = node.sum();
            table.row([
                node.holder.node.clone(),
                node.holder.machine.clone(),
                node.part().to_owned(),
                node.cells_as(Part::Owner).count().to_string(),
                node.cells_as(Part::Standby).count().to_string(),
                sum.takeovers.to_string(),
                sum.fenced.to_string(),
                sum.diverged.to_string(),
                sum.checkpoints.to_string(),
                ahead(node.ahead_s),
            ]);
        }
        table
    }

    fn gateways(&self) -> Table {
        let names =
            ["gateway", "lines", "datagrams", "waiting", "dropped", "withheld", "clock", "ahead", "differs"];
        let mut table = Table::new("lrrrrrlrl", &names);
        let Members { gateways, clocks, .. } = self.clocks();
        for (GatewayReport { node, counts, lines, .. }, state) in self.gateways.iter().zip(&gateways) {
            let received = lines.iter().map(|(_, line)| line.received).sum();
            table.row([
                node.clone(),
                lines.len().to_string(),
                grouped(received),
                counts.waiting.to_string(),
                grouped(counts.dropped),
                grouped(counts.withheld),
                state.clock_text(),
                ahead(state.clock_ahead_s),
                worst(node, &clocks),
            ]);
        }
        table
    }

    fn json(&self, config: &Config) -> Value {
        let cell = |said: &CellSaid| {
            json!({
                "cell": said.cell,
                "owner": said.owner,
                "standby": said.standby,
                "late_s": said.late_s(config),
                "aircraft_numbers": said.report.as_ref().map(|report| report.status.numbers_used),
            })
        };
        let cells: Vec<Value> = self.cells.iter().map(cell).collect();
        let nodes: Vec<Value> = self.nodes.iter().map(|node| json!(node)).collect();
        let Members { gateways, clocks, .. } = self.clocks();
        let gateways = self.gateways.iter().zip(gateways).map(|(gateway, state)| {
            json!({ "node": gateway.node, "lines": gateway.lines.len(), "counts": gateway.counts, "clock": {
                "standing": state.clock, "bound_s": state.clock_bound_s, "by": state.clock_by, "unfit": state.unfit, "silent": state.silent, "ahead_s": state.clock_ahead_s,
            } })
        });
        let gateways: Vec<Value> = gateways.collect();
        let (wrong, missing) = (self.wrong(config), self.missing(config));
        json!({
            "cells": cells, "nodes": nodes, "gateways": gateways, "missing_gateways": missing, "clocks": clocks, "wrong": wrong,
        })
    }
}

/// How far a clock is ahead of reference time.
fn ahead(ahead_s: Option<f64>) -> String {
    ahead_s.map_or("not known".to_owned(), |ahead_s| format!("{ahead_s:+.2} s"))
}

/// By how much a gateway's clock differs most from another one's, and from which.
fn worst(node: &str, clocks: &[ClockDifference]) -> String {
    let own = clocks.iter().filter_map(|clock| match clock {
        ClockDifference { gateway, other, difference_s, .. } if gateway == node => {
            Some((other, *difference_s))
        }
        ClockDifference { gateway, other, difference_s, .. } if other == node => {
            Some((gateway, -difference_s))
        }
        _ => None,
    });
    let worst = own.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    worst.map_or("not known".to_owned(), |(other, by_s)| {
        let sign = if by_s < 0.0 { "-" } else { "+" };
        format!("{sign}{} ms from {other}", milliseconds(by_s.abs()))
    })
}

/// Misses a gateway no longer.
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

/// Asks a node to give up its cells, until it has.
async fn drain(log: &Log, node: &str, out: &mut impl Write) -> CommandResult {
    let key = format!("node.{node}");
    let report = async || -> Result<Option<NodeReport>, crate::cluster::LogError> {
        Ok(log.said(&key).await?.and_then(|said| postcard::from_bytes(&said).ok()))
    };
    let Some(found) = report().await? else {
        return Err(Usage(format!(
            "no node is called {node}; utm-fusion cluster status shows those that there are"
        ))
        .into());
    };
    let drained = async {
        loop {
            log.say(&format!("drain.{node}"), found.holder.run.to_string().into_bytes()).await?;
            let is_drained = report().await?.is_none_or(|report| {
                report.is_draining && report.cells.iter().all(|(_, counts)| counts.part == Part::None)
            });
            if is_drained {
                return Ok::<(), crate::cluster::LogError>(());
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
    for Different { member, text } in shared.different(log, &nodes, &gateways).await? {
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
