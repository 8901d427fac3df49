//! The picture role of a cluster: merges the outputs and reports of all owners for display.

mod presence;
mod reports;
mod slot_merger;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use jiff::SignedDuration;
use tokio::sync::mpsc::Receiver;
use tokio::task::JoinSet;
use tracing::{info, warn};

use super::cell_thread::clocks;
use super::cells::Cells;
use super::clocks::ClockComparison;
use super::differing_members::ConfigurationDifference;
use super::engine::pictures;
use super::gateway_report::GatewayReport;
use super::log::{Holder, Log, LogError};
use super::member_clock::{MemberClock, report_times};
use super::node_report::NodeReport;
use super::overload::SheddingLevel;
use super::region::{CellMessage, CellMessageContent};
use super::report::CellReport;
use super::shared_configuration::SharedConfiguration;
use fusion::slots::SlotGrid;
use picture::TrackNames;
use presence::{CellReports, PresentGateways, SensorSettling};
use reports::merge_reports;
use service::live::{CellState, ClusterMembers, LineStatus, OperatorDecision, ViewerInput, now};
use site::config::{Cluster, Config};
use site::territory::CellName;
use slot_merger::SlotMerger;

/// Interval at which the states of the members are read.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);
/// Additional waiting time for a cell whose owner is lost, beyond lease and wait, in seconds.
const TAKEOVER_S: f64 = 2.0;
/// Change of the clock's error after which the picture's time is corrected again.
const CORRECTION_THRESHOLD: SignedDuration = SignedDuration::from_millis(100);
/// Maximum interval of checks whether a slot has waited long enough.
const WAIT_CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Reads a cluster until dropped.
#[derive(Debug)]
pub struct PictureReader {
    #[expect(dead_code, reason = "its tasks end with it")]
    tasks: JoinSet<()>,
}

impl PictureReader {
    /// Starts the tasks: forwards each slot of the region, and each second the members' states; writes operator decisions to all
    /// cells. Must be called within a Tokio runtime.
    pub fn open(
        log: &Log,
        config: &Config,
        cluster: &Cluster,
        cells: &Arc<Cells>,
        shared: SharedConfiguration,
        (seen, decisions): (Sender<ViewerInput>, Receiver<OperatorDecision>),
    ) -> Self {
        let patience_s = cluster.lease_s + cluster.wait_s + TAKEOVER_S;
        let merger = SlotMerger::new(
            cells.names(),
            SlotGrid::new(config.fusion.slot),
            config.fusion.latency() - config.fusion.slot / 2,
            SignedDuration::from_nanos((patience_s * 1e9) as i64),
        );
        let (merger, clock) = (Arc::new(Mutex::new(merger)), Arc::<Mutex<MemberClock>>::default());
        let mut tasks = JoinSet::new();
        tasks.spawn(forward_slots(
            log.clone(),
            cluster.clone(),
            (merger.clone(), clock.clone()),
            seen.clone(),
        ));
        tasks.spawn(compare_clocks(log.clone(), clock, seen.clone()));
        tasks.spawn(write_decisions(log.clone(), cluster.node.clone(), cells.names().to_vec(), decisions));
        let homes = cells.homes(config);
        let shared = (cells.clone(), homes, shared);
        tasks.spawn(forward_states(log.clone(), cluster.clone(), shared, merger, seen));
        Self { tasks }
    }
}

/// Writes each decision to all cells until it is in the log, because the aircraft may fly into any of them.
async fn write_decisions(
    log: Log,
    node: String,
    cells: Vec<CellName>,
    mut decisions: Receiver<OperatorDecision>,
) {
    let Ok(from) = CellName::new(&node) else { return };
    let mut index = 0_u16;
    while let Some(decision) = decisions.recv().await {
        let (slot, content) = match decision {
            OperatorDecision::Correlate(from, correlation) => {
                (from, CellMessageContent::Correlate { from, correlation })
            }
            OperatorDecision::SetTrust(from, decision) => {
                (from, CellMessageContent::SetTrust { from, decision })
            }
        };
        info!(slot = slot.0, "decided, and written to the cells");
        for to in &cells {
            let message =
                CellMessage { from: from.clone(), to: to.clone(), slot, index, content: content.clone() };
            while let Err(error) = log.publish_message(&message).await {
                warn!(%error, cell = %to, "a decision is not written: tried again");
                tokio::time::sleep(CHECK_INTERVAL).await;
            }
        }
        index = index.wrapping_add(1);
    }
}

/// Forwards the slots. If the stream was lost and created again, continues with the slots in it.
async fn forward_slots(
    mut log: Log,
    cluster: Cluster,
    (merger, clock): (Arc<Mutex<SlotMerger>>, Arc<Mutex<MemberClock>>),
    seen: Sender<ViewerInput>,
) {
    let locked = || merger.lock().unwrap_or_else(PoisonError::into_inner);
    let compared = || clock.lock().unwrap_or_else(PoisonError::into_inner);
    let mut reading = log.all_outputs(0);
    let mut names = TrackNames::default();
    loop {
        // A slot that waits for a missing cell is checked again soon.
        let waits = locked().waits_until().is_some();
        let read = match waits {
            true => tokio::time::timeout(WAIT_CHECK_INTERVAL, reading.next_with_subject()).await,
            false => Ok(reading.next_with_subject().await),
        };
        match read {
            Ok(Some((_, cell, octets))) => {
                if !reading.has_more() {
                    compared().note_reading(reading.stamp(), now());
                }
                let Some(cell) = CellName::new(&cell).ok().filter(|cell| locked().has(cell)) else {
                    log.skips.note("out", "of no cell of the configuration");
                    continue;
                };
                let Some(output) = log.validated_when_available(cell.as_str(), &octets).await else {
                    continue;
                };
                let Some(part) = pictures(&output.picture) else { continue };
                let due = locked().due(output.slot);
                if compared().is_early(due, reading.stamp()) {
                    log.skips.note(&format!("out.{cell}"), "published before it was due");
                    continue;
                }
                locked().add_slot(&cell, output.epoch, part);
            }
            Ok(None) => {
                // The stream was lost, and is created again.
                if let Ok(again) = log.reopen(&cluster).await {
                    log = again;
                }
                locked().discard_all();
                reading = log.all_outputs(1);
                continue;
            }
            Err(_) => {}
        }
        let (before, mut ready) = (locked().away().clone(), Vec::new());
        {
            let (mut merger, now) = (locked(), now() + -correction(&clock));
            ready.extend(std::iter::from_fn(|| merger.next(now)));
        }
        let away = locked().away().clone();
        away.difference(&before)
            .for_each(|cell| warn!(%cell, "the picture goes on without the cell: nobody publishes it"));
        before.difference(&away).for_each(|cell| info!(%cell, "the cell is part of the picture again"));
        for (mut picture, mut now) in ready {
            names.name(&mut picture);
            now.iter_mut().for_each(|now| names.label(now));
            if seen.send(ViewerInput::Slot(picture.into(), now.map(Box::new))).is_err() {
                return;
            }
        }
    }
}

/// Time by which this machine's clock is ahead of reference time, if it is wrong; else zero.
fn correction(clock: &Mutex<MemberClock>) -> SignedDuration {
    let clock = clock.lock().unwrap_or_else(PoisonError::into_inner);
    clock.ahead().filter(|_| clock.is_wrong()).unwrap_or_default()
}

/// Compares this machine's clock with the gateways' each second. If it is wrong, the picture is timed by the gateways' clocks.
async fn compare_clocks(log: Log, clock: Arc<Mutex<MemberClock>>, seen: Sender<ViewerInput>) {
    let mut was = SignedDuration::ZERO;
    let mut checks = tokio::time::interval(CHECK_INTERVAL);
    loop {
        checks.tick().await;
        let Ok((written, _)) = report_times(&log, None).await else { continue };
        clock.lock().unwrap_or_else(PoisonError::into_inner).update(("", false), written, clocks());
        let ahead = correction(&clock);
        if (ahead - was).abs() > CORRECTION_THRESHOLD {
            let ahead_s = ahead.as_secs_f64();
            match ahead.is_zero() {
                false => warn!(
                    ahead_s,
                    "the clock of this machine is wrong: the picture is timed by the gateways'"
                ),
                true => info!("the clock of this machine is right again"),
            }
            was = ahead;
            if seen.send(ViewerInput::Ahead(ahead)).is_err() {
                return;
            }
        }
    }
}

/// Forwards the states of the cells with the lines of the gateways, and the members.
async fn forward_states(
    log: Log,
    cluster: Cluster,
    (cells, homes, shared): (Arc<Cells>, Vec<CellName>, SharedConfiguration),
    merger: Arc<Mutex<SlotMerger>>,
    seen: Sender<ViewerInput>,
) {
    let (mut gateways_present, mut reports_by_cell) = (PresentGateways::default(), CellReports::default());
    let mut settling = SensorSettling::default();
    let mut checks = tokio::time::interval(CHECK_INTERVAL);
    let mut clocks = ClockComparison::default();
    loop {
        checks.tick().await;
        let Ok((nodes, gateways)) = members(&log).await else {
            settling.note_disturbance();
            continue;
        };
        let gateways = gateways_present.note(gateways);
        let expected = log.expected_gateways().await.unwrap_or_default();
        let expected = expected.iter().chain(&cluster.gateways);
        let missing_gateways: BTreeSet<String> =
            expected.filter(|name| gateways_present.is_missing(name)).cloned().collect();
        // If the log does not answer, the next check repeats the comparison.
        let different = shared.differing_members(&log, &nodes, &gateways).await.unwrap_or_default();
        let (away, twice, too_late) = {
            let merger = merger.lock().unwrap_or_else(PoisonError::into_inner);
            (merger.away().clone(), merger.duplicates(), merger.late_slots())
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
            merger.lock().unwrap_or_else(PoisonError::into_inner).set_hidden(cell, is_foreign);
            let step = SheddingLevel(counts(owner.as_ref()).step);
            states.push(CellState {
                cell: cell.to_string(),
                step: step.0,
                left_out: step.description(),
                lease: counts(owner.as_ref()).epoch,
                behind: counts(standby.as_ref()).behind,
                owner: owner.map(|by| by.node),
                standby: standby.map(|by| by.node),
                is_missing: away.contains(cell),
                is_foreign,
                corners: cells.corners(cell),
            });
        }
        let members = ClusterMembers {
            region: cluster.region.clone(),
            cells: states,
            nodes: nodes.iter().map(NodeReport::state).collect(),
            gateways: gateways.iter().map(GatewayReport::state).collect(),
            clocks: clocks.update(&gateways),
            missing_gateways: missing_gateways.into_iter().collect(),
            different: different
                .into_iter()
                .map(|ConfigurationDifference { member, text }| format!("{member}: {text}"))
                .collect(),
            twice,
            too_late,
            ..ClusterMembers::default()
        };
        if seen.send(ViewerInput::Members(members.into())).is_err() {
            return;
        }
        let mut reports = Vec::new();
        for cell in cells.names() {
            let octets = log.entry(&format!("{cell}.report")).await.ok().flatten();
            let report = octets.as_ref().and_then(|octets| CellReport::parse(octets));
            if report.is_none() {
                octets.iter().for_each(|octets| log.skips.unreadable("report", octets));
            }
            let epoch = merger.lock().unwrap_or_else(PoisonError::into_inner).epoch(cell);
            reports.extend(reports_by_cell.note(cell, report, epoch).map(|report| (cell.clone(), report)));
        }
        if reports_by_cell.are_old() {
            settling.note_disturbance();
        }
        let Some(mut report) = merge_reports(&homes, reports) else { continue };
        let has_no_gateway = gateways.is_empty();
        let lines = lines(gateways);
        for (index, sensor) in report.status.sensors.iter_mut().enumerate() {
            sensor.lines = lines.get(&index).cloned().unwrap_or_default();
            if has_no_gateway {
                let name = "of a gateway (none is heard of)".to_owned();
                sensor.lines = vec![LineStatus { name, ..LineStatus::default() }];
            }
        }
        settling.settle(&mut report.status.sensors);
        let reports_by_cell =
            ViewerInput::Status(report.status.into(), report.integrities.into(), report.correlations);
        if seen.send(reports_by_cell).is_err() {
            return;
        }
    }
}

/// Reports of all nodes and gateways.
async fn members(log: &Log) -> Result<(Vec<NodeReport>, Vec<GatewayReport>), LogError> {
    Ok((NodeReport::all(log).await?, GatewayReport::all(log).await?))
}

/// Lines of all gateways, by sensor.
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
