//! What shows by a transponder's reports alone: no radar is asked, and no place is smoothed.
//!
//! Reports are kept by identity and receiver, since two receivers stamp one report differently: a [`Stream`] is what one
//! receiver hears of one identity. What a rule looks for and what it cannot see is in `docs/INTEGRITY.md`.

mod duplicate;
mod edge;
mod frozen;
mod history;
mod jamming;
mod jump;
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

use super::{Reason, Reasons};
use crate::frames::Enu;
use crate::report::{Fix, Identity, SensorIndex};
use crate::time::Time;
use duplicate::Duplicate;
use history::{Heard, History};
use jamming::Jamming;
use places::Places;
use replay::Kin;
use silence::Silence;
use stream::Stream;
use swapped::{Breaks, Swap};

/// An identity not heard for so long is forgotten.
const FORGOTTEN_AFTER: SignedDuration = SignedDuration::from_hours(1);
/// Identities that are remembered: what a flood of invented ones can take up. The service is built for 4,000 aircraft.
const IDENTITIES_MAX: usize = 16_384;
/// A flood's identities are heard so often and no more, and go first.
const PASSING_REPORTS: usize = 2;

/// What has landed is as low as it ever was, within this, metres,
const LANDED_HEIGHT_M: f64 = 5.0;
/// was so much higher before, but not where it was heard first, metres,
const LANDED_DESCENT_M: f64 = 10.0;
/// and is slow, m/s, beside what its receiver wanders, metres.
const LANDED_SPEED_M_S: f64 = 0.5;
const LANDED_WANDER_M: f64 = 2.0;

/// What the rules find of an identity: it holds while the rules do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Finding {
    /// Rules that make it a suspect.
    pub(crate) suspect: Reasons,
    /// Rules that are certain: it has failed.
    pub(crate) failed: Reasons,
    /// Since when its place has stood still to the octet, while it does: 12 s and five reports at least. It has failed where a
    /// radar sees it move.
    pub(crate) still_since: Option<Time>,
    /// Its last report, where it has fallen silent.
    pub(crate) silent_since: Option<Time>,
}

/// Who fell silent at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Jammed {
    pub(crate) identities: Vec<Identity>,
    /// Where they were heard last, in the order of `identities`.
    pub(crate) places: Vec<Enu>,
    /// The first of their last reports.
    pub(crate) since: Time,
}

/// The reports of every identity, as received, and what they show.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct ReportRules {
    ledgers: BTreeMap<Identity, Ledger>,
    places: Places,
    breaks: Breaks,
    jamming: Jamming,
    /// How many streams there were.
    numbers: u32,
    /// Until when reports have been looked at.
    deadline: Time,
}

/// What is kept of an identity.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Ledger {
    /// By receiver, in the order in which they came.
    streams: Vec<Stream>,
    /// Their numbers.
    numbers: Vec<u32>,
    duplicate: Duplicate,
    swap: Option<Swap>,
    /// Time stamp of its newest report.
    newest: Time,
    silence: Silence,
    heights: Option<Heights>,
}

impl Default for ReportRules {
    fn default() -> Self {
        Self {
            ledgers: BTreeMap::new(),
            places: Places::default(),
            breaks: Breaks::default(),
            jamming: Jamming::default(),
            numbers: 0,
            deadline: Time::from_nanos(i64::MIN),
        }
    }
}

impl ReportRules {
    /// Takes the reports that came since the last slot, by time, then identity, as received: nothing is taken off their
    /// times. Reports of one identity and time may come in any order.
    pub(crate) fn take(&mut self, fixes: &[Fix]) {
        for same in fixes.chunk_by(|one, next| (one.time, one.identity) == (next.time, next.identity)) {
            if let [fix] = same {
                self.hear(fix);
            } else {
                let mut ordered: Vec<&Fix> = same.iter().collect();
                ordered.sort_by_key(|fix| (fix.sensor, Heard::new(fix).order()));
                ordered.into_iter().for_each(|fix| self.hear(fix));
            }
        }
    }

    fn hear(&mut self, fix: &Fix) {
        let heard = Heard::new(fix);
        let ledger = self.ledgers.entry(fix.identity).or_default();
        let at = ledger.at(fix.sensor, &mut self.numbers);
        let Ledger { streams, numbers, .. } = ledger;
        if !streams[at].hear(heard, &mut self.places, Kin(numbers)) {
            return;
        }
        for found in streams[at].breaks() {
            self.breaks.add(fix.identity, found);
        }
        Heights::hear(&mut ledger.heights, heard.position.z);
        ledger.newest = ledger.newest.max(heard.time);
        ledger.duplicate.hear(heard, fix.sensor, &ledger.streams);
    }

    /// Looks at all identities at a slot's deadline, before [`ReportRules::finding`] is asked.
    pub(crate) fn look(&mut self, deadline: Time) {
        self.deadline = deadline;
        self.places.forget_before(deadline - replay::REMEMBERED);
        self.breaks.look(&mut self.ledgers, deadline);
        self.forget(deadline);
        for ledger in self.ledgers.values_mut() {
            ledger.silence.look(&ledger.streams, ledger.newest, deadline);
        }
        self.jamming.look(&self.ledgers, deadline);
    }

    /// The engine starts afresh: the time before counts for no identity's silence.
    pub(crate) fn start_afresh(&mut self) {
        self.ledgers.values_mut().for_each(|ledger| ledger.silence.start_afresh());
    }

    /// Forgets who was not heard for long, and of too many those heard once or twice, then those not heard for longest.
    fn forget(&mut self, deadline: Time) {
        self.ledgers.retain(|_, ledger| ledger.newest >= deadline - FORGOTTEN_AFTER);
        let over = self.ledgers.len().saturating_sub(IDENTITIES_MAX);
        if over == 0 {
            return;
        }
        let worth = |(identity, ledger): (&Identity, &Ledger)| {
            let lasts = ledger.streams.iter().any(|stream| stream.history.len() > PASSING_REPORTS);
            (lasts, ledger.newest, *identity)
        };
        let mut all: Vec<(bool, Time, Identity)> = self.ledgers.iter().map(worth).collect();
        let (out, _, _) = all.select_nth_unstable(over);
        for (_, _, identity) in out {
            self.ledgers.remove(identity);
        }
    }

    /// What they show of an identity at the deadline that was looked at last.
    pub(crate) fn finding(&self, identity: Identity) -> Finding {
        let mut finding = Finding::default();
        let Some(ledger) = self.ledgers.get(&identity) else { return finding };
        for stream in &ledger.streams {
            stream.tell(self.deadline, &mut finding);
        }
        if ledger.duplicate.holds(self.deadline) {
            finding.failed.insert(Reason::Duplicate);
        }
        if ledger.swap.as_ref().is_some_and(|swap| swap.holds(self.deadline)) {
            finding.failed.insert(Reason::Swapped);
        }
        finding.suspect = finding.suspect.or(finding.failed);
        finding.silent_since = ledger.silence.is_silent.then_some(ledger.newest);
        finding
    }

    /// Each identity heard lately, the time of its newest report, where it was, and whether it was heard often enough to be
    /// missed.
    pub(crate) fn newest(&self) -> impl Iterator<Item = (Identity, Time, Enu, bool)> {
        self.ledgers.iter().filter_map(|(&identity, ledger)| {
            let newest = ledger.latest()?.newest()?;
            Some((identity, newest.time, Enu::from(newest.position), ledger.silence.is_known))
        })
    }

    /// Whether an identity has been silent for longer than gaps of a single transponder last, and not with many others.
    pub(crate) fn is_missed(&self, identity: Identity) -> bool {
        let is_long = self.ledgers.get(&identity).is_some_and(|ledger| ledger.silence.long_since.is_some());
        is_long && self.jammed().is_none_or(|jammed| !jammed.identities.contains(&identity))
    }

    /// Who fell silent at once, while it lasts.
    pub(crate) fn jammed(&self) -> Option<&Jammed> {
        self.jamming.jammed()
    }
}

/// Heights at which an identity was heard, metres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Heights {
    first_m: f64,
    lowest_m: f64,
    highest_m: f64,
}

impl Heights {
    fn hear(heights: &mut Option<Self>, height_m: f64) {
        let first = Self { first_m: height_m, lowest_m: height_m, highest_m: height_m };
        let heights = heights.get_or_insert(first);
        heights.lowest_m = heights.lowest_m.min(height_m);
        heights.highest_m = heights.highest_m.max(height_m);
    }

    /// Whether this is the ground from which it took off.
    fn is_ground(&self, height_m: f64) -> bool {
        height_m <= self.lowest_m + LANDED_HEIGHT_M
            && height_m <= self.highest_m - LANDED_DESCENT_M
            && self.first_m <= height_m + LANDED_DESCENT_M
    }
}

impl Ledger {
    /// Where among its streams that of a receiver is.
    fn at(&mut self, sensor: SensorIndex, numbers: &mut u32) -> usize {
        let known = self.streams.iter().position(|stream| stream.sensor == sensor);
        known.unwrap_or_else(|| {
            self.streams.push(Stream::new(sensor, *numbers));
            self.numbers.push(*numbers);
            *numbers = numbers.wrapping_add(1);
            self.streams.len() - 1
        })
    }

    /// The stream with its newest report.
    fn latest(&self) -> Option<&History> {
        let histories = self.streams.iter().map(|stream| &stream.history);
        histories.max_by_key(|history| history.newest().map(Heard::order))
    }

    /// Whether more than one aircraft is behind it, so that its motion says nothing.
    fn is_several(&self, deadline: Time) -> bool {
        self.duplicate.holds(deadline) || self.streams.iter().any(Stream::is_replay)
    }

    /// Whether its last reports look like a landing: slow, and back on the ground.
    fn has_landed(&self) -> bool {
        let Some(history) = self.latest() else { return false };
        let mut last = history.before(history.len());
        let (Some(newest), Some(before)) = (last.next(), last.next()) else { return false };
        let rest_m = LANDED_WANDER_M + LANDED_SPEED_M_S * newest.apart_s(before);
        let is_low = self.heights.is_some_and(|heights| heights.is_ground(newest.position.z));
        is_low && newest.distance_m(before) <= rest_m
    }
}
