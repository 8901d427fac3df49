//! The picture of a cluster: what its owners publish and say, handed on to be shown.

use std::collections::BTreeMap;
use std::sync::mpsc::Sender;
use std::time::Duration;

use tokio::task::JoinSet;
use tracing::warn;

use super::clocks::Comparison;
use super::engine::pictures;
use super::gateway::GatewayReport;
use super::log::{Held, Log, LogError};
use super::message::Output;
use super::node::NodeReport;
use super::report::CellReport;
use crate::config::Cluster;
use crate::live::{CellState, LineStatus, Members, Seen};

/// How often it is looked how those are who make the picture.
const LOOKS: Duration = Duration::from_secs(1);

/// Looks into a cluster, until it is dropped.
#[derive(Debug)]
pub struct Window {
    #[expect(dead_code, reason = "its tasks end with it")]
    tasks: JoinSet<()>,
}

impl Window {
    /// Hands on each slot of a cell from now on, and each second how it is; within a runtime.
    pub fn open(log: &Log, cluster: &Cluster, cell: &str, seen: Sender<Seen>) -> Self {
        let mut tasks = JoinSet::new();
        tasks.spawn(slots(log.clone(), cluster.clone(), cell.to_owned(), seen.clone()));
        tasks.spawn(states(log.clone(), cluster.clone(), cell.to_owned(), seen));
        Self { tasks }
    }
}

/// The slots. Where the stream was lost, and made anew, they go on with those in it.
async fn slots(mut log: Log, cluster: Cluster, cell: String, seen: Sender<Seen>) {
    let mut reading = log.outputs(&cell, 0);
    loop {
        let Some((_, octets)) = reading.next().await else {
            // The stream was lost, and is made anew.
            if let Ok(again) = log.again(&cluster).await {
                log = again;
            }
            reading = log.outputs(&cell, 1);
            continue;
        };
        let output = Output::parse(&octets).ok().and_then(|output| pictures(&output.picture));
        let Some((picture, now)) = output else {
            warn!("an output of the log is not one of this version");
            continue;
        };
        if seen.send(Seen::Slot(picture.into(), now.map(Box::new))).is_err() {
            return;
        }
    }
}

/// How the cell is, with the lines of the gateways, and who makes the picture.
async fn states(log: Log, cluster: Cluster, cell: String, seen: Sender<Seen>) {
    let mut looks = tokio::time::interval(LOOKS);
    let mut clocks = Comparison::default();
    loop {
        looks.tick().await;
        if let Ok((nodes, gateways)) = members(&log).await {
            let owner = log.holder(&format!("{cell}.owner")).await.ok().flatten();
            let standby = log.holder(&format!("{cell}.standby")).await.ok().flatten();
            let counts = |of: &Option<Held>| {
                let of = of.as_ref().map(|held| &held.by);
                let node = nodes.iter().find(|node| Some(&node.holder) == of);
                node.and_then(|node| node.cells.first()).map(|(_, counts)| *counts).unwrap_or_default()
            };
            let state = CellState {
                cell: cell.clone(),
                lease: counts(&owner).epoch,
                behind: counts(&standby).behind,
                owner: owner.map(|held| held.by.node),
                standby: standby.map(|held| held.by.node),
            };
            let members = Members {
                region: cluster.region.clone(),
                cells: vec![state],
                nodes: nodes.iter().map(NodeReport::state).collect(),
                gateways: gateways.iter().map(GatewayReport::state).collect(),
                clocks: clocks.look(&gateways),
                ..Members::default()
            };
            if seen.send(Seen::Members(members.into())).is_err() {
                return;
            }
            let Ok(Some(report)) = log.said(&format!("{cell}.report")).await else { continue };
            let Some(mut report) = CellReport::parse(&report) else {
                warn!("a report of the log is not one of this version");
                continue;
            };
            let is_deaf = gateways.is_empty();
            let lines = lines(gateways);
            for (index, sensor) in report.status.sensors.iter_mut().enumerate() {
                sensor.lines = lines.get(&index).cloned().unwrap_or_default();
                if is_deaf {
                    let name = "of a gateway (none is heard of)".to_owned();
                    sensor.lines = vec![LineStatus { name, ..LineStatus::default() }];
                }
            }
            let told = Seen::Told(report.status.into(), report.integrities.into(), report.correlations);
            if seen.send(told).is_err() {
                return;
            }
        }
    }
}

/// What all nodes and gateways say.
async fn members(log: &Log) -> Result<(Vec<NodeReport>, Vec<GatewayReport>), LogError> {
    let (mut nodes, mut gateways) = (Vec::new(), Vec::new());
    for key in log.keys().await? {
        if key.starts_with("node.") {
            let said = log.said(&key).await?;
            nodes.extend(said.and_then(|said| postcard::from_bytes::<NodeReport>(&said).ok()));
        } else if key.starts_with("gateway.") {
            let said = log.said(&key).await?;
            gateways.extend(said.and_then(|said| postcard::from_bytes::<GatewayReport>(&said).ok()));
        }
    }
    Ok((nodes, gateways))
}

/// The lines of all gateways, by sensor.
fn lines(gateways: Vec<GatewayReport>) -> BTreeMap<usize, Vec<LineStatus>> {
    let mut lines = BTreeMap::<usize, Vec<LineStatus>>::new();
    for report in gateways {
        for (sensors, line) in report.lines {
            let line = LineStatus { name: format!("{} at {}", line.name, report.node), ..line };
            sensors.iter().for_each(|sensor| lines.entry(*sensor).or_default().push(line.clone()));
        }
    }
    lines
}
