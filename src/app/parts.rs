//! Parts of a cluster process: gateway, node and picture, by its roles.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;
use tracing::{info, warn};

use super::{AppError, Signals};
use cluster::{
    Cells, ClusterNode, ConfigurationDifference, Gateway, GatewayReport, Holder, Log, LogError, NodeReport,
    PictureReader, SharedConfiguration, run_number,
};
use fusion::slots::SlotGrid;
use service::live::{OperatorDecision, ViewerInput, decisions};
use site::areas::Areas;
use site::config::{Cluster, Config, Role};
use site::territory::CellName;

/// Pause before the log is tried again.
const RETRY_PAUSE: Duration = Duration::from_millis(250);

/// The running parts.
pub struct Parts {
    gateway: Option<Gateway>,
    node: Option<ClusterNode>,
    picture: Option<PictureReader>,
    /// Pictures received from the nodes, and the sender of operator decisions, until the service takes them.
    pub seen: Option<(Receiver<ViewerInput>, Sender<OperatorDecision>)>,
}

impl Parts {
    /// Joins the cluster as soon as the log answers. `None` if a signal arrived first.
    ///
    /// # Errors
    /// The log cannot be used, or the system cannot start a thread.
    pub async fn join(
        config: &Arc<Config>,
        cluster: &Cluster,
        areas: &Areas,
        signals: &mut Signals,
    ) -> Result<Option<Self>, AppError> {
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
        let mut is_logged = false;
        let different = loop {
            let members = tokio::select! {
                members = compare_with_members(&log, &shared) => members,
                () = signals.stop() => return Ok(None),
            };
            match members {
                Ok(different) => break different,
                Err(error) if !std::mem::replace(&mut is_logged, true) => warn!(%error, "waits for the log"),
                Err(_) => tokio::time::sleep(RETRY_PAUSE).await,
            }
        };
        if let Some(different) = different {
            return Err(Box::new(JoinRefused(different)));
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
            ClusterNode::start(config, cluster, areas, &cells, &me, &log)
        };
        let (picture, seen) = cluster
            .does(Role::Picture)
            .then(|| {
                let ((sender, seen), (decided, decisions)) = (channel(), decisions());
                (
                    PictureReader::open(&log, config, cluster, &cells, shared.clone(), (sender, decisions)),
                    (seen, decided),
                )
            })
            .unzip();
        Ok(Some(Self {
            gateway: cluster.does(Role::Gateway).then(gateway).transpose()?,
            node: cluster.does(Role::Node).then(node),
            picture,
            seen,
        }))
    }

    /// Whether a part has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.gateway.as_ref().is_some_and(Gateway::has_ended)
            || self.node.as_ref().is_some_and(ClusterNode::has_ended)
    }

    /// Stops the parts. Cells are given up first, so that their standby takes over at once.
    pub async fn leave(self) {
        let Self { gateway, node, picture, .. } = self;
        if let Some(node) = node {
            node.stop().await;
        }
        if let Some(gateway) = gateway {
            gateway.stop().await;
        }
        drop(picture);
    }
}

/// Differences from the configuration of the other members. `None` if there are none; then this configuration is stored for
/// comparison.
async fn compare_with_members(log: &Log, shared: &SharedConfiguration) -> Result<Option<String>, LogError> {
    let (nodes, gateways) = (NodeReport::all(log).await?, GatewayReport::all(log).await?);
    let different = shared.differing_members(log, &nodes, &gateways).await?;
    if let Some(ConfigurationDifference { member, text }) = different.first() {
        return Ok(Some(format!("{member} has another configuration: {text}")));
    }
    log.put_configuration(shared).await.map(|()| None)
}

/// The configuration differs from that of the members, so this process does not join them.
#[derive(Debug, thiserror::Error)]
#[error("this region's members need the same site, sensors, fusion settings and cells, and {0}")]
pub struct JoinRefused(String);

/// Reports names in `owns` that are not cells of the region.
fn unknown(cells: &Cells, cluster: &Cluster) -> Option<String> {
    let is_known =
        |own: &&String| *own == "*" || cells.names().iter().any(|cell| cell.as_str() == own.as_str());
    let name = cluster.owns.iter().find(|own| !is_known(own))?;
    let names: Vec<&str> = cells.names().iter().map(CellName::as_str).collect();
    Some(format!("cluster.owns: there is no cell {name}; the region has {}", names.join(", ")))
}
