//! Members that reported lately: octets that replace a report for a moment silence no member.
#![expect(clippy::disallowed_methods, reason = "who is silent is told by a clock that nobody sets")]

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::cluster::gateway::GatewayReport;
use crate::cluster::report::CellReport;
use crate::live::SensorStatus;
use crate::territory::CellName;

/// A member without a new report for this long is missing.
const SILENT: Duration = Duration::from_secs(3);
/// A look counts for no more than this: while the log was away no member could report.
const LOOK: Duration = Duration::from_millis(1500);
/// An owner that says nothing for this long has stood still, or is another one now.
const OLD: Duration = Duration::from_millis(2500);

/// The gateways, by name, with their last report and for how long nothing new has come while the log answered.
#[derive(Debug, Default)]
pub(super) struct Present {
    gateways: BTreeMap<String, (GatewayReport, Duration)>,
    looked: Option<Instant>,
}

impl Present {
    /// The last report of each gateway that is not missing.
    pub(super) fn note(&mut self, said: Vec<GatewayReport>) -> Vec<GatewayReport> {
        let now = Instant::now();
        let passed = self.looked.replace(now).map_or(Duration::ZERO, |looked| (now - looked).min(LOOK));
        for (_, silent) in self.gateways.values_mut() {
            *silent += passed;
        }
        for report in said {
            let last = self.gateways.get(&report.node);
            if last.is_none_or(|(last, _)| last.said != report.said) {
                self.gateways.insert(report.node.clone(), (report, Duration::ZERO));
            }
        }
        self.gateways.retain(|_, (_, silent)| *silent < SILENT);
        self.gateways.values().map(|(report, _)| report.clone()).collect()
    }

    /// Whether a gateway that ought to be heard of is not.
    pub(super) fn misses(&self, name: &str) -> bool {
        !self.gateways.contains_key(name)
    }
}

/// The last report of each cell and when it came, and whether one came after a pause.
#[derive(Debug, Default)]
pub(super) struct Reports(BTreeMap<CellName, (CellReport, Instant)>, bool);

impl Reports {
    /// The present report of a cell, unless another owner has replaced its writer: the greatest lease under which something was
    /// published is `epoch`.
    pub(super) fn note(
        &mut self,
        cell: &CellName,
        said: Option<CellReport>,
        epoch: u64,
    ) -> Option<CellReport> {
        let last = self.0.get(cell).map(|(last, at)| (last.epoch, last.status.at, at.elapsed()));
        if let Some(said) = said.filter(|said| said.epoch >= epoch)
            && last.is_none_or(|(epoch, at, _)| (epoch, at) != (said.epoch, said.status.at))
        {
            self.0.insert(cell.clone(), (said, Instant::now()));
            self.1 |= last.is_some_and(|(.., age)| age > OLD);
        }
        let (last, at) = self.0.get(cell)?;
        (at.elapsed() < SILENT).then(|| last.clone())
    }

    /// Whether one that was noted since this was asked last came after a pause, or none comes.
    pub(super) fn are_old(&mut self) -> bool {
        std::mem::take(&mut self.1) || self.0.values().any(|(_, at)| at.elapsed() > OLD)
    }
}

/// After the log was away, or a cell without an owner, what is said of sensors is of the time without them: a state that is worse
/// than before is shown once it has lasted.
#[derive(Debug, Default)]
pub(super) struct Settling {
    disturbed: Option<Instant>,
    before: Vec<SensorStatus>,
}

impl Settling {
    /// No report came for some time.
    pub(super) fn disturbed(&mut self) {
        self.disturbed = Some(Instant::now());
    }

    /// The sensors as they are to be shown.
    pub(super) fn settle(&mut self, sensors: &mut [SensorStatus]) {
        if self.disturbed.is_some_and(|at| at.elapsed() < SILENT) {
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
    use crate::cluster::gateway::GatewayCounts;
    use fusion::time::Time;

    fn report(node: &str, said: u64) -> GatewayReport {
        let (counts, lines, heard) = (GatewayCounts::default(), Vec::new(), Vec::new());
        let clock = crate::cluster::GatewayClock::default();
        let (sent, ahead_s) = (Time::default(), None);
        GatewayReport { node: node.to_owned(), counts, lines, said, clock, heard, config: 0, sent, ahead_s }
    }

    #[test]
    fn gateway_is_missed_after_three_seconds_of_looks() {
        let mut present = Present::default();
        assert_eq!(present.note(vec![report("g0", 1), report("g1", 1)]).len(), 2);
        assert!(present.misses("g2") && !present.misses("g1"));
        // A long time without a look counts as one look.
        present.looked = Some(Instant::now() - Duration::from_secs(60));
        assert_eq!(present.note(vec![report("g0", 1), report("g1", 2)]).len(), 2);
        for _ in 0..2 {
            present.looked = Some(Instant::now() - Duration::from_secs(1));
            present.note(vec![report("g1", 3)]);
        }
        assert!(present.misses("g0") && !present.misses("g1"));
    }
}
