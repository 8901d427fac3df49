//! A node: for each of its cells, a thread with the engine, and tasks that exchange messages with the log.
//!
//! A node that wants a cell first takes the standby role beside its owner, and follows it; so no node owns a cell without its
//! state. A cell has one standby; other nodes wait until the role is free. A node with more cells than another leaves standby
//! roles, and later cells, to it.

mod balance;
mod cell_member;
mod delivery;
mod disk_copy;
mod held_role;
mod inputs;
mod log_requests;
mod node_reports;
mod renewal;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tracing::{Instrument, error_span, info, warn};

use super::cell_thread::clocks;
use super::cells::Cells;
use super::log::{Holder, Log};
use super::member_clock::{MemberClock, report_times};
use super::node_report::{CellCounts, NodeReport, NodeRole};
use super::overload::SheddingLevel;
use balance::PeerNode;
use cell_member::CellMember;
use held_role::HeldRole;
use node_reports::NodeReports;
use service::live::now;
use service::state::StateHealth;
use site::areas::Areas;
use site::config::{Cluster, Config};

/// Interval of the node's reports.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);

/// A running node.
#[derive(Debug)]
pub struct ClusterNode {
    stop: Arc<watch::Sender<bool>>,
    report_each_second: JoinHandle<()>,
    tasks: Vec<JoinHandle<()>>,
    shared: Arc<NodeShared>,
}

/// State shared by all tasks of a node.
#[derive(Debug, Default)]
struct NodeShared {
    counts: Mutex<BTreeMap<String, CellCounts>>,
    /// All nodes that report, including this one.
    peers: Mutex<Vec<PeerNode>>,
    /// Their reports.
    nodes: Mutex<NodeReports>,
    /// Time at which this node last left a standby role or a cell to another node.
    moved: Mutex<Option<Instant>>,
    /// The machine's clock compared with reference time.
    clock: Mutex<MemberClock>,
    /// Time at which each gateway with refused messages was last logged.
    refused: Mutex<BTreeMap<String, Instant>>,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ClusterNode {
    /// Joins the cells that the configuration names. Must be called within a Tokio runtime.
    pub fn start(
        config: &Arc<Config>,
        cluster: &Cluster,
        areas: &Areas,
        cells: &Arc<Cells>,
        me: &Holder,
        log: &Log,
    ) -> Self {
        let health = StateHealth::default();
        let (stop, stopped) = watch::channel(false);
        let (stop, shared) = (Arc::new(stop), Arc::<NodeShared>::default());
        let own = cells.names().iter().filter(|cell| cluster.may_own(cell.as_str()));
        let members = own.map(|cell| CellMember {
            log: log.clone(),
            cluster: cluster.clone(),
            audience: Arc::new(cells.audience(config, cell)),
            config: config.clone(),
            areas: areas.clone(),
            cells: cells.clone(),
            cell: cell.clone(),
            me: me.clone(),
            shared: shared.clone(),
            hold: Arc::<HeldRole>::default(),
            stop: stopped.clone(),
            health: health.clone(),
        });
        let members: Vec<CellMember> = members.collect();
        members.iter().for_each(|member| member.update_counts(|_| {}));
        let report_each_second = tokio::spawn(report_each_second(
            log.clone(),
            cluster.clone(),
            me.clone(),
            shared.clone(),
            stop.clone(),
        ));
        let part = |member: CellMember| {
            let span = error_span!("cell", id = %member.cell);
            tokio::spawn(member.run().instrument(span))
        };
        Self { stop, report_each_second, tasks: members.into_iter().map(part).collect(), shared }
    }

    /// Counters by cell.
    pub fn counts(&self) -> Vec<(String, CellCounts)> {
        self.shared.counts()
    }

    /// Whether a task has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        let is_stopped = *self.stop.borrow();
        self.report_each_second.is_finished()
            || (!is_stopped && self.tasks.iter().any(JoinHandle::is_finished))
    }

    /// Gives up the node's cells, so that their standbys continue at once, and ends.
    pub async fn stop(self) {
        self.stop.send_replace(true);
        for part in self.tasks {
            drop(part.await);
        }
        self.report_each_second.abort();
    }
}

impl NodeShared {
    fn counts(&self) -> Vec<(String, CellCounts)> {
        locked(&self.counts).iter().map(|(cell, counts)| (cell.clone(), *counts)).collect()
    }

    fn owned(&self) -> usize {
        locked(&self.counts).values().filter(|counts| counts.part == NodeRole::Owner).count()
    }

    /// Whether a cell owned by this node has reached this level of load shedding.
    fn is_relieved(&self, step: SheddingLevel) -> bool {
        locked(&self.counts).values().any(|counts| counts.part == NodeRole::Owner && counts.step >= step.0)
    }
}

/// Each second, writes this node's report, reads the other nodes' reports, and checks whether the node is to be drained.
async fn report_each_second(
    log: Log,
    cluster: Cluster,
    me: Holder,
    shared: Arc<NodeShared>,
    stop: Arc<watch::Sender<bool>>,
) {
    let drained = format!("drain.{}", me.node);
    let mut was_wrong = false;
    loop {
        let report = NodeReport {
            sent: now(),
            ahead_s: locked(&shared.clock).ahead_s(),
            holder: me.clone(),
            cells: shared.counts(),
            owns: cluster.owns.clone(),
            is_draining: *stop.borrow(),
            skipped: log.skips.all(),
        };
        let octets = postcard::to_stdvec(&report).expect("it can be written");
        // Other nodes consider this one gone if its reports are missing for some seconds.
        _ = log.put_entry(&format!("node.{}", me.node), octets).await;
        if let Ok((written, _)) = report_times(&log, Some(&me.node)).await {
            let mut clock = locked(&shared.clock);
            clock.update((&me.node, false), written, clocks());
            let (is_wrong, ahead_s) = (clock.is_wrong(), clock.ahead_s().unwrap_or_default());
            match (is_wrong, std::mem::replace(&mut was_wrong, is_wrong)) {
                (true, false) => warn!(ahead_s, "the clock of this machine is wrong: it decides nothing"),
                (false, true) => info!(ahead_s, "the clock of this machine is right again"),
                _ => {}
            }
        }
        if let Ok(all) = NodeReport::all_by_name(&log).await {
            locked(&shared.nodes).update(&all);
            let reports = all.iter().filter_map(|(_, report)| report.as_ref());
            *locked(&shared.peers) = reports.map(PeerNode::from).collect();
        }
        if let Ok(Some(run)) = log.entry(&drained).await
            && *run == *me.run.to_string().as_bytes()
            && !stop.send_replace(true)
        {
            info!("drained: it takes no cell until it is started anew");
        }
        tokio::time::sleep(REPORT_INTERVAL).await;
    }
}

/// A number that is unique to this run of the node.
pub fn run_number() -> u64 {
    u64::try_from(now().nanos()).unwrap_or_default()
}
