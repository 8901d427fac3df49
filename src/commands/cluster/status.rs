//! `cluster status` and `cluster cells`: state of the members and cells.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::app::AppError;
use crate::commands::table::{TextTable, grouped};
use cluster::{
    CellReport, Cells, ConfigurationDifference, GatewayReport, Holder, Log, NodeReport, NodeRole,
    SharedConfiguration, Skipped, differences,
};
use fusion::time::Time;
use service::live::{ClockDifference, ClusterMembers, milliseconds, now};
use site::config::Config;
use site::territory::CellName;

/// Lateness beyond the latency at which a cell is reported as late, in seconds; also the limit for early cells.
const LATE_S: f64 = 1.0;

/// State of a cell, as read from the log.
struct CellStatus {
    cell: String,
    owner: Option<Holder>,
    standby: Option<Holder>,
    report: Option<CellReport>,
    /// Time of the newest slot.
    latest: Option<Time>,
}

/// State of the cluster, as reported by its members.
pub(super) struct ClusterStatus {
    cells: Vec<CellStatus>,
    nodes: Vec<NodeReport>,
    gateways: Vec<GatewayReport>,
    /// Gateways that did not shut down in order.
    expected: Vec<String>,
    /// Members whose configuration differs from that of this command.
    different: Vec<ConfigurationDifference>,
    /// Messages that this command could not read.
    skipped: Vec<Skipped>,
}

impl CellStatus {
    async fn read(log: &Log, cell: &CellName) -> Result<Self, cluster::LogError> {
        let holder = async |part: &str| log.holder(&format!("{cell}.{part}")).await;
        let report = log.entry(&format!("{cell}.report")).await?;
        let latest = log.last(cell.as_str()).await?;
        Ok(Self {
            cell: cell.to_string(),
            owner: holder("owner").await?.map(|holder| holder.by),
            standby: holder("standby").await?.map(|holder| holder.by),
            report: report.and_then(|report| CellReport::parse(&report)),
            latest: latest.and_then(|(_, output)| cluster::pictures(&output.picture)).map(|(of, _)| of.time),
        })
    }

    /// Lateness of the newest slot, in seconds, beyond the configured latency and one slot.
    fn late_s(&self, config: &Config) -> Option<f64> {
        let latest = self.latest?;
        let due = latest + config.fusion.latency() + config.fusion.slot;
        Some((now() - due).as_secs_f64().max(0.0))
    }

    /// Time by which the newest slot was published before it was due, in seconds.
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

impl ClusterStatus {
    pub(super) async fn read(
        log: &Log,
        cells: &Cells,
        shared: &SharedConfiguration,
    ) -> Result<Self, AppError> {
        let (nodes, gateways) = (NodeReport::all(log).await?, GatewayReport::all(log).await?);
        let different = shared.differing_members(log, &nodes, &gateways).await?;
        let expected = log.expected_gateways().await?;
        let mut status = Vec::new();
        for cell in cells.names() {
            status.push(CellStatus::read(log, cell).await?);
        }
        Ok(Self { cells: status, nodes, gateways, expected, different, skipped: log.skips.all() })
    }

    pub(super) fn wrong(&self, config: &Config) -> Vec<String> {
        let clocks = self.clocks().troubles().into_iter().map(|trouble| trouble.text);
        let missing = self.missing(config).into_iter().map(|name| format!("gateway {name} says nothing"));
        let different = self.different.iter().map(|ConfigurationDifference { member, text }| {
            format!("{member} has another configuration than {}: {text}", "this command's")
        });
        let all = self.cells.iter().flat_map(|cell| cell.wrong(config)).chain(missing).chain(different);
        all.chain(self.unreadable()).chain(clocks).collect()
    }

    /// Gateways that are expected but have no report.
    fn missing(&self, config: &Config) -> BTreeSet<String> {
        let configured = config.cluster.iter().flat_map(|cluster| &cluster.gateways);
        let is_missing = |name: &&String| self.gateways.iter().all(|gateway| gateway.node != **name);
        self.expected.iter().chain(configured).filter(is_missing).cloned().collect()
    }

    /// Messages skipped within the last minute, by the member that reports them.
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

    /// Clocks of the members, from this snapshot.
    fn clocks(&self) -> ClusterMembers {
        ClusterMembers {
            nodes: self.nodes.iter().map(NodeReport::state).collect(),
            gateways: self.gateways.iter().map(GatewayReport::state).collect(),
            clocks: differences(&self.gateways),
            ..ClusterMembers::default()
        }
    }

    pub(super) fn cells(&self, config: &Config) -> TextTable {
        let names = ["cell", "owner", "lease", "standby", "behind", "published", "late"];
        let mut table = TextTable::new("llrlrrr", &names);
        let name = |of: &Option<Holder>| of.as_ref().map_or("nobody".to_owned(), |of| of.node.clone());
        for cell in &self.cells {
            let counts = |of: &Option<Holder>| {
                let node = self.nodes.iter().find(|node| Some(&node.holder) == of.as_ref());
                node.map(|node| node.counts(&cell.cell)).unwrap_or_default()
            };
            let (owner, standby) = (counts(&cell.owner), counts(&cell.standby));
            table.row([
                cell.cell.clone(),
                name(&cell.owner),
                owner.epoch.to_string(),
                name(&cell.standby),
                format!("{} slots", standby.behind),
                grouped(owner.published),
                cell.late_s(config).map_or("nothing yet".to_owned(), |late_s| format!("{late_s:.2} s")),
            ]);
        }
        table
    }

    pub(super) fn nodes(&self) -> TextTable {
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
        let mut table = TextTable::new("lllrrrrrrr", &names);
        for node in &self.nodes {
            let sum = node.sum();
            table.row([
                node.holder.node.clone(),
                node.holder.machine.clone(),
                node.part().to_owned(),
                node.cells_as(NodeRole::Owner).count().to_string(),
                node.cells_as(NodeRole::Standby).count().to_string(),
                sum.takeovers.to_string(),
                sum.fenced.to_string(),
                sum.diverged.to_string(),
                sum.checkpoints.to_string(),
                ahead(node.ahead_s),
            ]);
        }
        table
    }

    pub(super) fn gateways(&self) -> TextTable {
        let names =
            ["gateway", "lines", "datagrams", "waiting", "dropped", "withheld", "clock", "ahead", "differs"];
        let mut table = TextTable::new("lrrrrrlrl", &names);
        let ClusterMembers { gateways, clocks, .. } = self.clocks();
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

    pub(super) fn json(&self, config: &Config) -> Value {
        let cell = |cell: &CellStatus| {
            json!({
                "cell": cell.cell,
                "owner": cell.owner,
                "standby": cell.standby,
                "late_s": cell.late_s(config),
                "aircraft_numbers": cell.report.as_ref().map(|report| report.status.numbers_used),
            })
        };
        let cells: Vec<Value> = self.cells.iter().map(cell).collect();
        let nodes: Vec<Value> = self.nodes.iter().map(|node| json!(node)).collect();
        let ClusterMembers { gateways, clocks, .. } = self.clocks();
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

/// Text of a clock's offset from reference time.
fn ahead(ahead_s: Option<f64>) -> String {
    ahead_s.map_or("not known".to_owned(), |ahead_s| format!("{ahead_s:+.2} s"))
}

/// Text of the largest difference between a gateway's clock and another one's, with the name of the other.
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
