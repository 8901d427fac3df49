//! Members with recent reports. Invalid octets that replace a report for a moment do not make a member missing.
#![expect(clippy::disallowed_methods, reason = "who is silent is told by a clock that nobody sets")]

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::gateway_report::GatewayReport;
use crate::report::CellReport;
use service::live::SensorStatus;
use site::territory::CellName;

/// Time without a new report after which a member is missing.
const REPORT_TIMEOUT: Duration = Duration::from_secs(3);
/// Maximum time counted per check: while the log was away no member could report.
const MAX_PER_CHECK: Duration = Duration::from_millis(1500);
/// Time without a report after which an owner was suspended or replaced.
const PAUSE_ABOVE: Duration = Duration::from_millis(2500);

/// The gateways by name: the last report, and the time without a new one while the log answered.
#[derive(Debug, Default)]
pub(super) struct PresentGateways {
    gateways: BTreeMap<String, (GatewayReport, Duration)>,
    last_check: Option<Instant>,
}

impl PresentGateways {
    /// Notes the reports. Returns the last report of each gateway that is not missing.
    pub(super) fn note(&mut self, reports: Vec<GatewayReport>) -> Vec<GatewayReport> {
        let now = Instant::now();
        let passed = self
            .last_check
            .replace(now)
            .map_or(Duration::ZERO, |last_check| (now - last_check).min(MAX_PER_CHECK));
        for (_, silent) in self.gateways.values_mut() {
            *silent += passed;
        }
        for report in reports {
            let last = self.gateways.get(&report.node);
            if last.is_none_or(|(last, _)| last.report_number != report.report_number) {
                self.gateways.insert(report.node.clone(), (report, Duration::ZERO));
            }
        }
        self.gateways.retain(|_, (_, silent)| *silent < REPORT_TIMEOUT);
        self.gateways.values().map(|(report, _)| report.clone()).collect()
    }

    /// Whether an expected gateway is missing.
    pub(super) fn is_missing(&self, name: &str) -> bool {
        !self.gateways.contains_key(name)
    }
}

/// The last report of each cell with its time of arrival, and whether one arrived after a pause.
#[derive(Debug, Default)]
pub(super) struct CellReports(BTreeMap<CellName, (CellReport, Instant)>, bool);

impl CellReports {
    /// Notes a cell's report and returns the current one, unless another owner has replaced its author: `epoch` is the greatest
    /// lease number of the cell's published slots.
    pub(super) fn note(
        &mut self,
        cell: &CellName,
        reports: Option<CellReport>,
        epoch: u64,
    ) -> Option<CellReport> {
        let last = self.0.get(cell).map(|(last, at)| (last.epoch, last.status.at, at.elapsed()));
        if let Some(reports) = reports.filter(|reports| reports.epoch >= epoch)
            && last.is_none_or(|(epoch, at, _)| (epoch, at) != (reports.epoch, reports.status.at))
        {
            self.0.insert(cell.clone(), (reports, Instant::now()));
            self.1 |= last.is_some_and(|(.., age)| age > PAUSE_ABOVE);
        }
        let (last, at) = self.0.get(cell)?;
        (at.elapsed() < REPORT_TIMEOUT).then(|| last.clone())
    }

    /// Whether a report noted since the last call arrived after a pause, or reports are missing.
    pub(super) fn are_old(&mut self) -> bool {
        std::mem::take(&mut self.1) || self.0.values().any(|(_, at)| at.elapsed() > PAUSE_ABOVE)
    }
}

/// Sensor states during and after an interruption: reports then describe the time without data, so a worse state is shown only
/// after it has lasted.
#[derive(Debug, Default)]
pub(super) struct SensorSettling {
    note_disturbance: Option<Instant>,
    before: Vec<SensorStatus>,
}

impl SensorSettling {
    /// Notes that no reports arrived for some time.
    pub(super) fn note_disturbance(&mut self) {
        self.note_disturbance = Some(Instant::now());
    }

    /// Replaces the states by those to be shown.
    pub(super) fn settle(&mut self, sensors: &mut [SensorStatus]) {
        if self.note_disturbance.is_some_and(|at| at.elapsed() < REPORT_TIMEOUT) {
            for (now, before) in sensors.iter_mut().zip(&self.before) {
                if now.state > before.state {
                    now.clone_from(before);
                }
            }
        }
        self.before = sensors.to_vec();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway_report::GatewayCounts;
    use fusion::time::Time;

    fn report(node: &str, report_number: u64) -> GatewayReport {
        let (counts, lines, heard) = (GatewayCounts::default(), Vec::new(), Vec::new());
        let clock = crate::GatewayClock::default();
        let (sent, ahead_s) = (Time::default(), None);
        GatewayReport {
            node: node.to_owned(),
            counts,
            lines,
            report_number,
            clock,
            recent_datagrams: heard,
            config: 0,
            sent,
            ahead_s,
        }
    }

    #[test]
    fn gateway_is_missing_after_three_seconds_of_checks() {
        let mut present = PresentGateways::default();
        assert_eq!(present.note(vec![report("g0", 1), report("g1", 1)]).len(), 2);
        assert!(present.is_missing("g2") && !present.is_missing("g1"));
        // A long time without a check counts as one check.
        present.last_check = Some(Instant::now() - Duration::from_secs(60));
        assert_eq!(present.note(vec![report("g0", 1), report("g1", 2)]).len(), 2);
        for _ in 0..2 {
            present.last_check = Some(Instant::now() - Duration::from_secs(1));
            present.note(vec![report("g1", 3)]);
        }
        assert!(present.is_missing("g0") && !present.is_missing("g1"));
    }
}
