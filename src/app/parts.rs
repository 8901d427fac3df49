//! What a process of a cluster does: gateway, node, picture, as its roles say.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;
use tracing::{info, warn};

use super::{Failure, Signals};
use crate::areas::Areas;
use crate::cluster::{
    Cells, Different, Gateway, GatewayReport, Holder, Log, LogError, Node, NodeReport, SharedConfiguration,
    Window, run_number,
};
use crate::config::{Cluster, Config, Role};
use crate::live::{Decision, Seen, decisions};
use crate::territory::CellName;
use fusion::slots::SlotGrid;

/// Pause before the log is asked again.
const AGAIN: Duration = Duration::from_millis(250);

/// The running parts.
pub struct Parts {
    gateway: Option<Gateway>,
    node: Option<Node>,
    window: Option<Window>,
    /// What the window shows, and where decisions go, until somebody takes them.
    pub seen: Option<(Receiver<Seen>, Sender<Decision>)>,
}

impl Parts {
    /// Joins the cluster, as soon as its log answers. `None`: a signal came first.
    ///
    /// # Errors
    /// The log cannot be used as it is, or the system gives no thread.
    pub async fn join(
        config: &Arc<Config>,
        cluster: &Cluster,
        areas: &Areas,
        signals: &mut Signals,
    ) -> Result<Option<Self>, Failure> {
        let cells = Arc::new(Cells::of(config)?);
        if let Some(none) = unknown(&cells, cluster) {
            return Err(none.into());
        }
        let mut log = tokio::select! {
            log = Log::open(cluster) => log?,
            () = signals.stop() => return Ok(None),
        };
        let shared = SharedConfiguration::of(config, areas)?;
        (log.config, log.grid) = (shared.hash(), SlotGrid::new(config.fusion.slot));
        let mut is_told = false;
        let different = loop {
            let joined = tokio::select! {
                joined = joined(&log, &shared) => joined,
                () = signals.stop() => return Ok(None),
            };
            match joined {
                Ok(different) => break different,
                Err(error) if !std::mem::replace(&mut is_told, true) => warn!(%error, "waits for the log"),
                Err(_) => tokio::time::sleep(AGAIN).await,
            }
        };
        if let Some(different) = different {
            return Err(Box::new(Refused(different)));
        }
        info!(region = cluster.region, cells = cells.names().len(), "joined the log");
        let gateway =
            || -> io::Result<Gateway> { Gateway::start(config, cluster, log.clone(), &Handle::current()) };
        let node = || {
            let me = Holder {
                node: cluster.node.clone(),
                machine: cluster.machine().to_owned(),
                run: run_number(),
                config: shared.hash(),
            };
            Node::start(config, cluster, areas, &cells, &me, &log)
        };
        let (window, seen) = cluster
            .does(Role::Picture)
            .then(|| {
                let ((sender, seen), (decided, decisions)) = (channel(), decisions());
                (
                    Window::open(&log, config, cluster, &cells, shared.clone(), (sender, decisions)),
                    (seen, decided),
                )
            })
            .unzip();
        Ok(Some(Self {
            gateway: cluster.does(Role::Gateway).then(gateway).transpose()?,
            node: cluster.does(Role::Node).then(node),
            window,
            seen,
        }))
    }

    /// Whether one of them has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.gateway.as_ref().is_some_and(Gateway::has_ended)
            || self.node.as_ref().is_some_and(Node::has_ended)
    }

    /// Ends them: cells are given up first, so that whoever stands by goes on at once.
    pub async fn leave(self) {
        let Self { gateway, node, window, .. } = self;
        if let Some(node) = node {
            node.stop().await;
        }
        if let Some(gateway) = gateway {
            gateway.stop().await;
        }
        drop(window);
    }
}

/// The members that have another configuration; `None`: there are none, and this one is kept for others to compare.
async fn joined(log: &Log, shared: &SharedConfiguration) -> Result<Option<String>, LogError> {
    let (nodes, gateways) = (NodeReport::all(log).await?, GatewayReport::all(log).await?);
    let different = shared.different(log, &nodes, &gateways).await?;
    if let Some(Different { member, text }) = different.first() {
        return Ok(Some(format!("{member} has another configuration: {text}")));
    }
    log.keep_configuration(shared).await.map(|()| None)
}

/// This process differs from those that are there, and does not join them.
#[derive(Debug, thiserror::Error)]
#[error("this region's members need the same site, sensors, fusion settings and cells, and {0}")]
pub struct Refused(String);

/// What is wrong with the names of the cells that a node may have.
fn unknown(cells: &Cells, cluster: &Cluster) -> Option<String> {
    let is_known =
        |own: &&String| *own == "*" || cells.names().iter().any(|cell| cell.as_str() == own.as_str());
    let name = cluster.owns.iter().find(|own| !is_known(own))?;
    let names: Vec<&str> = cells.names().iter().map(CellName::as_str).collect();
    Some(format!("cluster.owns: there is no cell {name}; the region has {}", names.join(", ")))
}
