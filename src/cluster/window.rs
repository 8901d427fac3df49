//! The picture of a cluster: what its owners publish and say, put together, and handed on to be shown.

mod merging;
mod present;
mod reports;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use jiff::SignedDuration;
use tokio::sync::mpsc::Receiver;
use tokio::task::JoinSet;
use tracing::{info, warn};

use super::cells::Cells;
use super::clocks::Comparison;
use super::engine::pictures;
use super::gateway::GatewayReport;
use super::log::{Holder, Log, LogError};
use super::member_clock::{MemberClock, written};
use super::node::NodeReport;
use super::region::{Letter, Word};
use super::relief::Step;
use super::report::CellReport;
use super::seat::clocks;
use super::shared::{Different, SharedConfiguration};
use crate::config::{Cluster, Config};
use crate::live::{CellState, Decision, LineStatus, Members, Seen, now};
use crate::territory::CellName;
use fusion::slots::SlotGrid;
use merging::Merging;
use present::{Present, Reports, Settling};
use reports::joined;

/// How often it is looked how those are who make the picture.
const LOOKS: Duration = Duration::from_secs(1);
/// Beyond the lease: how long a cell is waited for whose owner is lost.
const TAKES_OVER_S: f64 = 2.0;
/// The time of the picture is corrected again where its error has changed by more than this.
const CORRECTED: SignedDuration = SignedDuration::from_millis(100);
/// Longest time between two looks at whether a slot has been waited for.
const LOOK_UP: Duration = Duration::from_millis(20);

/// Looks into a cluster, until it is dropped.
#[derive(Debug)]
pub struct Window {
    #[expect(dead_code, reason = "its tasks end with it")]
    tasks: JoinSet<()>,
}

impl Window {
    /// Hands on each slot of the region from now on, and each second how it is; writes decisions to all cells; within a runtime.
    pub fn open(
        log: &Log,
        config: &Config,
        cluster: &Cluster,
        cells: &Arc<Cells>,
        shared: SharedConfiguration,
        (seen, decided): (Sender<Seen>, Receiver<Decision>),
    ) -> Self {
        let patience_s = cluster.lease_s + cluster.wait_s + TAKES_OVER_S;
        let merging = Merging::new(
            cells.names(),
            SlotGrid::new(config.fusion.slot),
            config.fusion.latency() - config.fusion.slot / 2,
            SignedDuration::from_nanos((patience_s * 1e9) as i64),
        );
        let (merging, clock) = (Arc::new(Mutex::new(merging)), Arc::<Mutex<MemberClock>>::default());
        let mut tasks = JoinSet::new();
        tasks.spawn(slots(log.clone(), cluster.clone(), (merging.clone(), clock.clone()), seen.clone()));
        tasks.spawn(compare(log.clone(), clock, seen.clone()));
        tasks.spawn(decide(log.clone(), cluster.node.clone(), cells.names().to_vec(), decided));
        let homes = cells.homes(config);
        let shared = (cells.clone(), homes, shared);
        tasks.spawn(states(log.clone(), cluster.clone(), shared, merging, seen));
        Self { tasks }
    }
}

/// Writes each decision to all cells, until it is in the log: also to those in which the aircraft will be later.
async fn decide(log: Log, node: String, cells: Vec<CellName>, mut decided: Receiver<Decision>) {
    let Ok(from) = CellName::new(&node) else { return };
    let mut index = 0_u16;
    while let Some(decision) = decided.recv().await {
        let (slot, word) = match decision {
            Decision::Correlate(from, correlation) => (from, Word::Correlate { from, correlation }),
            Decision::Say(from, word) => (from, Word::Say { from, word }),
        };
        info!(slot = slot.0, "decided, and written to the cells");
        for to in &cells {
            let letter = Letter { from: from.clone(), to: to.clone(), slot, index, word: word.clone() };
            while let Err(error) = log.post(&letter).await {
                warn!(%error, cell = %to, "a decision is not written: tried again");
                tokio::time::sleep(LOOKS).await;
            }
        }
        index = index.wrapping_add(1);
    }
}

/// The slots. Where the stream was lost, and made anew, they go on with those in it.
async fn slots(
    mut log: Log,
    cluster: Cluster,
    (merging, clock): (Arc<Mutex<Merging>>, Arc<Mutex<MemberClock>>),
    seen: Sender<Seen>,
) {
    let locked = || merging.lock().unwrap_or_else(PoisonError::into_inner);
    let compared = || clock.lock().unwrap_or_else(PoisonError::into_inner);
    let mut reading = log.all_outputs(0);
    loop {
        // A slot that waits for a cell that is away is looked at again soon.
        let waits = locked().waits_until().is_some();
        let read = match waits {
            true => tokio::time::timeout(LOOK_UP, reading.next_of()).await,
            false => Ok(reading.next_of().await),
        };
        match read {
            Ok(Some((_, cell, octets))) => {
                if !reading.has_more() {
                    compared().read(reading.stamp(), now());
                }
                let Some(cell) = CellName::new(&cell).ok().filter(|cell| locked().has(cell)) else {
                    log.skips.note("out", "of no cell of the configuration");
                    continue;
                };
                let Some(output) = log.worth(cell.as_str(), &octets).await else { continue };
                let Some(part) = pictures(&output.picture) else { continue };
                let due = locked().due(output.slot);
                if compared().is_early(due, reading.stamp()) {
                    log.skips.note(&format!("out.{cell}"), "published before it was due");
                    continue;
                }
                locked().take(&cell, output.epoch, part);
            }
            Ok(None) => {
                // The stream was lost, and is made anew.
                if let Ok(again) = log.again(&cluster).await {
                    log = again;
                }
                locked().forget();
                reading = log.all_outputs(1);
                continue;
            }
            Err(_) => {}
        }
        let (before, mut ready) = (locked().away().clone(), Vec::new());
        {
            let (mut merging, now) = (locked(), now() + -corrected(&clock));
            ready.extend(std::iter::from_fn(|| merging.next(now)));
        }
        let away = locked().away().clone();
        away.difference(&before)
            .for_each(|cell| warn!(%cell, "the picture goes on without the cell: nobody publishes it"));
        before.difference(&away).for_each(|cell| info!(%cell, "the cell is part of the picture again"));
        for (picture, now) in ready {
            if seen.send(Seen::Slot(picture.into(), now.map(Box::new))).is_err() {
                return;
            }
        }
    }
}

/// By how much the clock of this machine is ahead of reference time, where it is wrong.
fn corrected(clock: &Mutex<MemberClock>) -> SignedDuration {
    let clock = clock.lock().unwrap_or_else(PoisonError::into_inner);
    clock.ahead().filter(|_| clock.is_wrong()).unwrap_or_default()
}

/// Compares the clock of this machine with those of the gateways, each second: where it is wrong the picture is timed by theirs.
async fn compare(log: Log, clock: Arc<Mutex<MemberClock>>, seen: Sender<Seen>) {
    let mut was = SignedDuration::ZERO;
    let mut looks = tokio::time::interval(LOOKS);
    loop {
        looks.tick().await;
        let Ok((written, _)) = written(&log, None).await else { continue };
        clock.lock().unwrap_or_else(PoisonError::into_inner).look(("", false), written, clocks());
        let ahead = corrected(&clock);
        if (ahead - was).abs() > CORRECTED {
            let ahead_s = ahead.as_secs_f64();
            match ahead.is_zero() {
                false => warn!(
                    ahead_s,
                    "the clock of this machine is wrong: the picture is timed by the gateways'"
                ),
                true => info!("the clock of this machine is right again"),
            }
            was = ahead;
            if seen.send(Seen::Ahead(ahead)).is_err() {
                return;
            }
        }
    }
}

/// How the cells are, with the lines of the gateways, and who makes the picture.
async fn states(
    log: Log,
    cluster: Cluster,
    (cells, homes, shared): (Arc<Cells>, Vec<CellName>, SharedConfiguration),
    merging: Arc<Mutex<Merging>>,
    seen: Sender<Seen>,
) {
    let (mut present, mut told) = (Present::default(), Reports::default());
    let mut settling = Settling::default();
    let mut looks = tokio::time::interval(LOOKS);
    let mut clocks = Comparison::default();
    loop {
        looks.tick().await;
        let Ok((nodes, gateways)) = members(&log).await else {
            settling.disturbed();
            continue;
        };
        let gateways = present.note(gateways);
        let expected = log.expected_gateways().await.unwrap_or_default();
        let expected = expected.iter().chain(&cluster.gateways);
        let missing_gateways: BTreeSet<String> =
            expected.filter(|name| present.misses(name)).cloned().collect();
        // Where the log does not answer, the next look finds it.
        let different = shared.different(&log, &nodes, &gateways).await.unwrap_or_default();
        let (away, twice, too_late) = {
            let merging = merging.lock().unwrap_or_else(PoisonError::into_inner);
            (merging.away().clone(), merging.twice(), merging.too_late())
        };
        let mut states = Vec::new();
        for cell in cells.names() {
            let name = cell.as_str();
            let holder = async |part: &str| log.holder(&format!("{name}.{part}")).await.ok().flatten();
            let (owner, standby) = (holder("owner").await, holder("standby").await);
            let counts = |of: Option<&Holder>| {
                let node = nodes.iter().find(|node| Some(&node.holder) == of);
                node.map(|node| node.counts(name)).unwrap_or_default()
            };
            let [owner, standby] = [owner, standby].map(|held| held.map(|held| held.by));
            let is_foreign =
                owner.as_ref().is_some_and(|owner| !SharedConfiguration::accepts(log.config, owner.config));
            merging.lock().unwrap_or_else(PoisonError::into_inner).leave_out(cell, is_foreign);
            let step = Step(counts(owner.as_ref()).step);
            states.push(CellState {
                cell: cell.to_string(),
                step: step.0,
                left_out: step.words(),
                lease: counts(owner.as_ref()).epoch,
                behind: counts(standby.as_ref()).behind,
                owner: owner.map(|by| by.node),
                standby: standby.map(|by| by.node),
                is_missing: away.contains(cell),
                is_foreign,
                corners: cells.corners(cell),
            });
        }
        let members = Members {
            region: cluster.region.clone(),
            cells: states,
            nodes: nodes.iter().map(NodeReport::state).collect(),
            gateways: gateways.iter().map(GatewayReport::state).collect(),
            clocks: clocks.look(&gateways),
            missing_gateways: missing_gateways.into_iter().collect(),
            different: different
                .into_iter()
                .map(|Different { member, text }| format!("{member}: {text}"))
                .collect(),
            twice,
            too_late,
            ..Members::default()
        };
        if seen.send(Seen::Members(members.into())).is_err() {
            return;
        }
        let mut reports = Vec::new();
        for cell in cells.names() {
            let said = log.said(&format!("{cell}.report")).await.ok().flatten();
            let report = said.as_ref().and_then(|octets| CellReport::parse(octets));
            if report.is_none() {
                said.iter().for_each(|octets| log.skips.unreadable("report", octets));
            }
            let epoch = merging.lock().unwrap_or_else(PoisonError::into_inner).epoch(cell);
            reports.extend(told.note(cell, report, epoch).map(|report| (cell.clone(), report)));
        }
        if told.are_old() {
            settling.disturbed();
        }
        let Some(mut report) = joined(&homes, reports) else { continue };
        let is_deaf = gateways.is_empty();
        let lines = lines(gateways);
        for (index, sensor) in report.status.sensors.iter_mut().enumerate() {
            sensor.lines = lines.get(&index).cloned().unwrap_or_default();
            if is_deaf {
                let name = "of a gateway (none is heard of)".to_owned();
                sensor.lines = vec![LineStatus { name, ..LineStatus::default() }];
            }
        }
        settling.settle(&mut report.status.sensors);
        let told = Seen::Told(report.status.into(), report.integrities.into(), report.correlations);
        if seen.send(told).is_err() {
            return;
        }
    }
}

/// What all nodes and gateways say.
async fn members(log: &Log) -> Result<(Vec<NodeReport>, Vec<GatewayReport>), LogError> {
    Ok((NodeReport::all(log).await?, GatewayReport::all(log).await?))
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
