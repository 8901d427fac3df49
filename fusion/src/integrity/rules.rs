//! Rules that use a transponder's reports alone, without radar and without smoothing.
//!
//! Reports are kept by identity and receiver, since two receivers stamp one report differently. A [`ReportStream`] has the
//! reports of one identity at one receiver. `docs/INTEGRITY.md` describes what each rule detects and what it cannot
//! detect.

mod duplicate;
mod edge;
mod finding;
mod frozen;
mod history;
mod jamming;
mod jump;
mod ledger;
mod places;
mod replay;
mod silence;
mod stream;
mod swapped;
#[cfg(test)]
mod tests;
mod velocity;

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::state::Reason;
use crate::frames::Enu;
use crate::report::{Fix, Identity};
use crate::time::Time;
use history::TimedReport;
use jamming::Jamming;
use ledger::{IdentityLedger, ReportedHeights};
use places::ReportPlaces;
use replay::SiblingStreams;
use swapped::PendingBreaks;

pub(crate) use finding::Finding;
pub(crate) use jamming::Jammed;

/// Time after its last report at which an identity is forgotten.
const FORGOTTEN_AFTER: SignedDuration = SignedDuration::from_hours(1);
/// Maximum number of remembered identities, which bounds the memory of a flood. The service is designed for 4,000
/// aircraft.
const IDENTITIES_MAX: usize = 16_384;
/// Maximum number of reports of an identity that is dropped first: identities of a flood report no more often.
const PASSING_REPORTS: usize = 2;

/// The reports of every identity as received, and the state of the rules.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct ReportRules {
    ledgers: BTreeMap<Identity, IdentityLedger>,
    places: ReportPlaces,
    breaks: PendingBreaks,
    jamming: Jamming,
    /// Number of streams that were created.
    numbers: u32,
    /// Deadline up to which reports were evaluated.
    deadline: Time,
}

impl Default for ReportRules {
    fn default() -> Self {
        Self {
            ledgers: BTreeMap::new(),
            places: ReportPlaces::default(),
            breaks: PendingBreaks::default(),
            jamming: Jamming::default(),
            numbers: 0,
            deadline: Time::from_nanos(i64::MIN),
        }
    }
}

impl ReportRules {
    /// Adds the reports since the last slot, by time, then identity. Their times are as received, without correction.
    /// Reports of one identity and time may be in any order.
    pub(crate) fn add_reports(&mut self, fixes: &[Fix]) {
        for same in fixes.chunk_by(|one, next| (one.time, one.identity) == (next.time, next.identity)) {
            if let [fix] = same {
                self.add_report(fix);
            } else {
                let mut ordered: Vec<&Fix> = same.iter().collect();
                ordered.sort_by_key(|fix| (fix.sensor, TimedReport::new(fix).order()));
                ordered.into_iter().for_each(|fix| self.add_report(fix));
            }
        }
    }

    fn add_report(&mut self, fix: &Fix) {
        let heard = TimedReport::new(fix);
        let ledger = self.ledgers.entry(fix.identity).or_default();
        let at = ledger.at(fix.sensor, &mut self.numbers);
        let IdentityLedger { streams, numbers, .. } = ledger;
        if !streams[at].add_report(heard, &mut self.places, SiblingStreams(numbers)) {
            return;
        }
        for found in streams[at].breaks() {
            self.breaks.add(fix.identity, found);
        }
        ReportedHeights::update(&mut ledger.heights, heard.position.z);
        ledger.newest = ledger.newest.max(heard.time);
        ledger.duplicate.add_report(heard, fix.sensor, &ledger.streams);
    }

    /// Evaluates all identities at a slot's deadline. Call it before [`ReportRules::finding`].
    pub(crate) fn evaluate(&mut self, deadline: Time) {
        self.deadline = deadline;
        self.places.forget_before(deadline - replay::REMEMBERED);
        self.breaks.evaluate(&mut self.ledgers, deadline);
        self.forget(deadline);
        for ledger in self.ledgers.values_mut() {
            ledger.silence.evaluate(&ledger.streams, ledger.newest, deadline);
        }
        self.jamming.evaluate(&self.ledgers, deadline);
    }

    /// Restarts the rules with the engine: time before the restart does not count as silence.
    pub(crate) fn restart(&mut self) {
        self.ledgers.values_mut().for_each(|ledger| ledger.silence.restart());
    }

    /// Forgets identities without recent reports. If too many remain, those with one or two reports are dropped first,
    /// then those with the oldest reports.
    fn forget(&mut self, deadline: Time) {
        self.ledgers.retain(|_, ledger| ledger.newest >= deadline - FORGOTTEN_AFTER);
        let over = self.ledgers.len().saturating_sub(IDENTITIES_MAX);
        if over == 0 {
            return;
        }
        let worth = |(identity, ledger): (&Identity, &IdentityLedger)| {
            let lasts = ledger.streams.iter().any(|stream| stream.history.len() > PASSING_REPORTS);
            (lasts, ledger.newest, *identity)
        };
        let mut all: Vec<(bool, Time, Identity)> = self.ledgers.iter().map(worth).collect();
        let (out, _, _) = all.select_nth_unstable(over);
        for (_, _, identity) in out {
            self.ledgers.remove(identity);
        }
    }

    /// Result for an identity at the last evaluated deadline.
    pub(crate) fn finding(&self, identity: Identity) -> Finding {
        let mut finding = Finding::default();
        let Some(ledger) = self.ledgers.get(&identity) else { return finding };
        for stream in &ledger.streams {
            stream.add_findings(self.deadline, &mut finding);
        }
        if ledger.duplicate.is_active(self.deadline) {
            finding.failed.insert(Reason::Duplicate);
        }
        if ledger.swap.as_ref().is_some_and(|swap| swap.is_active(self.deadline)) {
            finding.failed.insert(Reason::Swapped);
        }
        finding.suspect = finding.suspect.or(finding.failed);
        finding.silent_since = ledger.silence.is_silent.then_some(ledger.newest);
        finding
    }

    /// Each recent identity, the time and position of its newest report, and whether it reported often enough for its
    /// silence to count.
    pub(crate) fn newest(&self) -> impl Iterator<Item = (Identity, Time, Enu, bool)> {
        self.ledgers.iter().filter_map(|(&identity, ledger)| {
            let newest = ledger.latest()?.newest()?;
            Some((identity, newest.time, Enu::from(newest.position), ledger.silence.is_known))
        })
    }

    /// Whether an identity alone has been silent for longer than usual gaps; `false` if it is jammed with many others.
    pub(crate) fn is_missed(&self, identity: Identity) -> bool {
        let is_long = self.ledgers.get(&identity).is_some_and(|ledger| ledger.silence.long_since.is_some());
        is_long && self.jammed().is_none_or(|jammed| !jammed.identities.contains(&identity))
    }

    /// The identities that fell silent at the same time, while that lasts.
    pub(crate) fn jammed(&self) -> Option<&Jammed> {
        self.jamming.jammed()
    }
}
