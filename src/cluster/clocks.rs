//! Gateways' clocks, which stamp all that the picture is made of: how good each says that its own is, what it does about a bad
//! one, and how far apart they are by what they both heard. Sans-IO but for [`Keeper`]; times are since the process began.

mod compared;
mod keeper;
mod stamps;

use std::collections::BTreeMap;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::gateway::GatewayReport;
use crate::live::{ClockSource, ClockStanding, LineStatus};

pub use compared::{Comparison, differences};
pub use keeper::Keeper;
pub use stamps::Stamps;

/// A clock that may be off by more than this is worth a warning, seconds.
const WARNING_S: f64 = 0.020;
/// And by more than this it is degraded, seconds.
const DEGRADED_S: f64 = 0.100;
/// Below this share of a limit it is kept again.
const WELL_AGAIN: f64 = 0.8;
/// A clock that is not synchronised for so long is not to be used, where another one can be.
const UNSYNCHRONISED: Duration = Duration::from_secs(60);
/// A gateway that has said nothing new for so long is gone: it speaks each second.
const GONE: Duration = Duration::from_secs(3);
/// While the log does not answer, the other gateways are taken to be as they were, for no longer than this.
const UNANSWERED: Duration = Duration::from_secs(10);
/// A line on which another gateway has heard nothing for so long since this one did is not carried by it.
const UNHEARD: Duration = Duration::from_secs(3);

/// What is said of a machine's clock by whatever keeps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClockState {
    /// Whether it follows a better one; `None`: nobody knows.
    pub is_synchronised: Option<bool>,
    /// It is off by no more than this, seconds; `None`: nobody knows.
    pub bound_s: Option<f64>,
    /// Who says so; `None`: nobody does.
    pub by: Option<ClockSource>,
}

/// What a gateway says of its clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GatewayClock {
    /// What is known of it.
    pub state: ClockState,
    /// What that is worth.
    pub standing: ClockStanding,
    /// It is not synchronised for a minute and longer.
    pub is_unfit: bool,
    /// Nothing is published, because of that: others carry all that is heard here.
    pub is_silent: bool,
}

/// What follows for a gateway from its clock.
#[derive(Debug, Default)]
pub struct ClockRule {
    clock: GatewayClock,
    unsynchronised_since: Option<Duration>,
    /// Time of the last look at the other gateways, and of the last one that the log answered.
    looked: Duration,
    answered: Duration,
    /// Datagrams of each own line at the last look.
    own: BTreeMap<LineKey, u64>,
    others: BTreeMap<String, Other>,
}

/// A line as two gateways know it: the sensors on it, and which one of these sensors' lines it is. Addresses of interfaces differ.
type LineKey = (Vec<usize>, usize);

/// What is known of another gateway from its reports.
#[derive(Debug)]
struct Other {
    /// Its last report, and when that was new.
    said: u64,
    heard_of: Duration,
    /// Datagrams of each of its lines.
    received: BTreeMap<LineKey, u64>,
    /// Since when it owes a datagram on a line: this gateway has heard one.
    owes: BTreeMap<LineKey, Duration>,
    is_fit: bool,
}

impl ClockRule {
    /// Takes note of what is said of the own clock.
    pub fn note(&mut self, state: ClockState, now: Duration) -> GatewayClock {
        let standing = standing(state, self.clock.standing);
        match state.is_synchronised {
            Some(true) => self.unsynchronised_since = None,
            Some(false) => {
                self.unsynchronised_since.get_or_insert(now);
            }
            // Nobody has said that it is well again.
            None => {}
        }
        let since = self.unsynchronised_since;
        self.clock.is_unfit = since.is_some_and(|since| now.saturating_sub(since) >= UNSYNCHRONISED);
        self.clock.is_silent &= self.clock.is_unfit;
        (self.clock.state, self.clock.standing) = (state, standing);
        self.clock
    }

    /// Whether it matters how the other gateways are. Those are to be known for a while before anybody relies on them.
    pub fn wants_others(&self) -> bool {
        self.unsynchronised_since.is_some()
    }

    /// Decides whether to be silent: where the clock is not fit, and all that is heard here is heard by others that are alive,
    /// synchronised and not silent themselves. `lines` are the own ones; `others` is `None` where the log did not answer, which
    /// says nothing of the other gateways: on a busy machine an answer is late, and no gateway is gone.
    pub fn decide(
        &mut self,
        lines: &[(Vec<usize>, LineStatus)],
        others: Option<&[GatewayReport]>,
        now: Duration,
    ) -> GatewayClock {
        let passed = now.saturating_sub(std::mem::replace(&mut self.looked, now));
        if others.is_none() && now.saturating_sub(self.answered) < UNANSWERED {
            for other in self.others.values_mut() {
                other.heard_of += passed;
                other.owes.values_mut().for_each(|since| *since += passed);
            }
            return self.clock;
        }
        if others.is_some() {
            self.answered = now;
        }
        let own = counted(lines);
        let hears: Vec<&LineKey> = own
            .iter()
            .filter(|(key, count)| self.own.get(key).is_some_and(|before| before < count))
            .map(|(key, _)| key)
            .collect();
        // A report is forgotten by the log while the gateway stands still for a moment.
        self.others.retain(|_, other| now.saturating_sub(other.heard_of) < 2 * GONE);
        for report in others.unwrap_or_default() {
            let received = counted(&report.lines);
            let other = self.others.entry(report.node.clone()).or_insert_with(|| Other {
                said: report.said,
                // Until it says something else it may be a word that it left behind.
                heard_of: now.checked_sub(GONE).unwrap_or_default(),
                received: received.clone(),
                owes: BTreeMap::new(),
                is_fit: false,
            });
            if other.said != report.said {
                (other.said, other.heard_of) = (report.said, now);
            }
            let clock = report.clock;
            other.is_fit = clock.state.is_synchronised == Some(true) && !clock.is_silent;
            for key in &hears {
                other.owes.entry((*key).clone()).or_insert(now);
            }
            other.owes.retain(|key, _| other.received.get(key) == received.get(key));
            other.received = received;
        }
        let is_carried = |key: &LineKey| self.others.values().any(|other| other.carries(key, now));
        // What is not heard here either cannot be missed.
        let open = lines.iter().zip(keys(lines)).filter(|((_, line), _)| line.joined).map(|(_, key)| key);
        let mut open = open.peekable();
        self.clock.is_silent =
            self.clock.is_unfit && open.peek().is_some() && open.all(|key| is_carried(&key));
        self.own = own;
        self.clock
    }
}

impl Other {
    fn carries(&self, line: &LineKey, now: Duration) -> bool {
        let is_alive = now.saturating_sub(self.heard_of) < GONE;
        let is_heard = self.owes.get(line).is_none_or(|since| now.saturating_sub(*since) < UNHEARD);
        self.is_fit && is_alive && is_heard && self.received.contains_key(line)
    }
}

fn keys(lines: &[(Vec<usize>, LineStatus)]) -> impl Iterator<Item = LineKey> {
    let mut known = BTreeMap::<&[usize], usize>::new();
    lines.iter().map(move |(sensors, _)| {
        let place = known.entry(sensors).or_default();
        *place += 1;
        (sensors.clone(), *place)
    })
}

/// What was received on each line that is open.
fn counted(lines: &[(Vec<usize>, LineStatus)]) -> BTreeMap<LineKey, u64> {
    let open = keys(lines).zip(lines).filter(|(_, (_, line))| line.joined);
    open.map(|(key, (_, line))| (key, line.received)).collect()
}

/// What a clock is worth. A limit that it was above is left a little below it.
fn standing(state: ClockState, before: ClockStanding) -> ClockStanding {
    let is_above = |bound_s: f64, limit_s: f64, was_above: bool| {
        bound_s > if was_above { limit_s * WELL_AGAIN } else { limit_s }
    };
    match (state.is_synchronised, state.bound_s) {
        (None, _) => ClockStanding::Unknown,
        (Some(false), _) => ClockStanding::Unsynchronised,
        (Some(true), None) => ClockStanding::Unbounded,
        (Some(true), Some(bound_s)) => {
            let was_degraded = before == ClockStanding::Degraded;
            let had_warning = was_degraded || before == ClockStanding::Warning;
            if is_above(bound_s, DEGRADED_S, was_degraded) {
                ClockStanding::Degraded
            } else if is_above(bound_s, WARNING_S, had_warning) {
                ClockStanding::Warning
            } else {
                ClockStanding::Good
            }
        }
    }
}

#[cfg(test)]
mod tests;
