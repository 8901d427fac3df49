//! A node: for each cell it holds, a thread with the engine, and tasks that speak with the log for it.
//!
//! Who wants a cell takes the seat beside its owner first, and follows; so nobody owns a cell whose state it has not. There is one
//! such seat a cell: others wait until it is free. Who has more cells than another node leaves seats, and in time cells, to it.

mod balance;
mod counts;
mod desk;
mod disk;
mod grant;
mod heard;
mod hold;
mod inputs;
mod keep;
mod post;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tracing::{Instrument, error_span, info, warn};

use super::cells::Cells;
use super::log::{Holder, Log};
use super::member_clock::{MemberClock, written};
use super::relief::Step;
use super::seat::clocks;
use crate::areas::Areas;
use crate::config::{Cluster, Config};
use crate::live::now;
use crate::state::StateHealth;
use balance::Peer;
use desk::Desk;
use heard::Heard;
use hold::Hold;

pub use counts::{CellCounts, NodeReport, Part};

/// How often it says how it is.
const SAYS: Duration = Duration::from_secs(1);

/// A running node.
#[derive(Debug)]
pub struct Node {
    stop: Arc<watch::Sender<bool>>,
    say: JoinHandle<()>,
    parts: Vec<JoinHandle<()>>,
    shared: Arc<Shared>,
}

/// What all of a node's tasks know.
#[derive(Debug, Default)]
struct Shared {
    counts: Mutex<BTreeMap<String, CellCounts>>,
    /// All nodes that speak, this one included.
    peers: Mutex<Vec<Peer>>,
    /// Their reports.
    nodes: Mutex<Heard>,
    /// When a seat or a cell was left to another node.
    moved: Mutex<Option<Instant>>,
    /// The clock of this machine, compared with reference time.
    clock: Mutex<MemberClock>,
    /// When a gateway whose messages are refused was named last.
    refused: Mutex<BTreeMap<String, Instant>>,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Node {
    /// Takes part in the cells that its configuration names; within a runtime.
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
        let (stop, shared) = (Arc::new(stop), Arc::<Shared>::default());
        let own = cells.names().iter().filter(|cell| cluster.may_own(cell.as_str()));
        let desks = own.map(|cell| Desk {
            log: log.clone(),
            cluster: cluster.clone(),
            audience: Arc::new(cells.audience(config, cell)),
            config: config.clone(),
            areas: areas.clone(),
            cells: cells.clone(),
            cell: cell.clone(),
            me: me.clone(),
            shared: shared.clone(),
            hold: Arc::<Hold>::default(),
            stop: stopped.clone(),
            health: health.clone(),
        });
        let desks: Vec<Desk> = desks.collect();
        desks.iter().for_each(|desk| desk.note(|_| {}));
        let say = tokio::spawn(say(log.clone(), cluster.clone(), me.clone(), shared.clone(), stop.clone()));
        let part = |desk: Desk| {
            let span = error_span!("cell", name = %desk.cell);
            tokio::spawn(desk.take_part().instrument(span))
        };
        Self { stop, say, parts: desks.into_iter().map(part).collect(), shared }
    }

    /// What it counts, by cell.
    pub fn counts(&self) -> Vec<(String, CellCounts)> {
        self.shared.counts()
    }

    /// Whether one of its tasks has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        let is_stopped = *self.stop.borrow();
        self.say.is_finished() || (!is_stopped && self.parts.iter().any(JoinHandle::is_finished))
    }

    /// Gives up its cells, so that whoever stands by goes on at once, and ends.
    pub async fn stop(self) {
        self.stop.send_replace(true);
        for part in self.parts {
            drop(part.await);
        }
        self.say.abort();
    }
}

impl Shared {
    fn counts(&self) -> Vec<(String, CellCounts)> {
        locked(&self.counts).iter().map(|(cell, counts)| (cell.clone(), *counts)).collect()
    }

    fn owned(&self) -> usize {
        locked(&self.counts).values().filter(|counts| counts.part == Part::Owner).count()
    }

    /// Whether a cell that this node owns has come to that step.
    fn is_relieved(&self, step: Step) -> bool {
        locked(&self.counts).values().any(|counts| counts.part == Part::Owner && counts.step >= step.0)
    }
}

/// Says each second how this node is, hears how the others are, and looks whether it is to give up its cells.
async fn say(log: Log, cluster: Cluster, me: Holder, shared: Arc<Shared>, stop: Arc<watch::Sender<bool>>) {
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
        // Who hears nothing of it for some seconds takes it to be gone.
        _ = log.say(&format!("node.{}", me.node), octets).await;
        if let Ok((written, _)) = written(&log, Some(&me.node)).await {
            let mut clock = locked(&shared.clock);
            clock.look((&me.node, false), written, clocks());
            let (is_wrong, ahead_s) = (clock.is_wrong(), clock.ahead_s().unwrap_or_default());
            match (is_wrong, std::mem::replace(&mut was_wrong, is_wrong)) {
                (true, false) => warn!(ahead_s, "the clock of this machine is wrong: it decides nothing"),
                (false, true) => info!(ahead_s, "the clock of this machine is right again"),
                _ => {}
            }
        }
        if let Ok(said) = NodeReport::said(&log).await {
            locked(&shared.nodes).note(&said);
            let reports = said.iter().filter_map(|(_, report)| report.as_ref());
            *locked(&shared.peers) = reports.map(Peer::from).collect();
        }
        if let Ok(Some(run)) = log.said(&drained).await
            && *run == *me.run.to_string().as_bytes()
            && !stop.send_replace(true)
        {
            info!("drained: it takes no cell until it is started anew");
        }
        tokio::time::sleep(SAYS).await;
    }
}

/// A number that no other run of a node has.
pub fn run_number() -> u64 {
    u64::try_from(now().nanos()).unwrap_or_default()
}
