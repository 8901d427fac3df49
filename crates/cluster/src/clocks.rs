//! Clocks of gateways, which stamp all sensor data: each gateway's estimate of its clock's error, its reaction to a bad clock,
//! and the differences between gateways by the datagrams that both received. Sans-IO except for [`ClockQuery`]; times count from the
//! start of the process.

mod clock_query;
mod comparison;
mod stamps;

use std::collections::BTreeMap;
use std::time::Duration;

use super::gateway_report::{ClockState, GatewayClock, GatewayReport};
use service::live::{ClockStanding, LineStatus};

pub use clock_query::ClockQuery;
pub use comparison::{ClockComparison, differences};
pub use stamps::DatagramStamps;

/// Error bound above which a clock raises a warning, in seconds.
const WARNING_S: f64 = 0.020;
/// Error bound above which a clock is degraded, in seconds.
const DEGRADED_S: f64 = 0.100;
/// Share of a limit below which the bound has to fall before the limit's condition ends.
const HYSTERESIS: f64 = 0.8;
/// Time without synchronisation after which a clock is unfit.
const UNFIT_AFTER: Duration = Duration::from_secs(60);
/// Time without a new report after which a gateway is considered gone. Gateways report each second.
const GATEWAY_TIMEOUT: Duration = Duration::from_secs(3);
/// Maximum time for which the last state of other gateways is kept while the log does not answer.
const KEPT_WITHOUT_ANSWER: Duration = Duration::from_secs(10);
/// Time after which another gateway does not carry a line, if this gateway has received a datagram on it and that one has not.
const LINE_TIMEOUT: Duration = Duration::from_secs(3);

/// Decides how a gateway reacts to its clock.
#[derive(Debug, Default)]
pub struct ClockRule {
    clock: GatewayClock,
    unsynchronised_since: Option<Duration>,
    /// Times of the last check of the other gateways, and of the last check that the log answered.
    last_check: Duration,
    last_answer: Duration,
    /// Datagrams received on each own line at the last check.
    own: BTreeMap<LineKey, u64>,
    others: BTreeMap<String, OtherGateway>,
}

/// A line as identified by two gateways: its sensors, and its index among the lines of the same sensors. Interface addresses
/// differ.
type LineKey = (Vec<usize>, usize);

/// State of another gateway by its reports.
#[derive(Debug)]
struct OtherGateway {
    /// Number of its last report, and the time at which that report was first read.
    report_number: u64,
    last_heard: Duration,
    /// Datagrams received on each of its lines.
    received: BTreeMap<LineKey, u64>,
    /// Time since when a datagram is missing on each line: this gateway has received one, the other has not.
    missing_since: BTreeMap<LineKey, Duration>,
    is_fit: bool,
}

impl ClockRule {
    /// Updates the state of the own clock.
    pub fn update_clock(&mut self, state: ClockState, now: Duration) -> GatewayClock {
        let standing = standing(state, self.clock.standing);
        match state.is_synchronised {
            Some(true) => self.unsynchronised_since = None,
            Some(false) => {
                self.unsynchronised_since.get_or_insert(now);
            }
            // An unknown state does not end the condition.
            None => {}
        }
        let since = self.unsynchronised_since;
        self.clock.is_unfit = since.is_some_and(|since| now.saturating_sub(since) >= UNFIT_AFTER);
        self.clock.is_silent &= self.clock.is_unfit;
        (self.clock.state, self.clock.standing) = (state, standing);
        self.clock
    }

    /// Whether the other gateways' state matters. It has to be observed for a while before it is relied upon.
    pub fn needs_others(&self) -> bool {
        self.unsynchronised_since.is_some()
    }

    /// Decides whether this gateway publishes nothing: its clock is unfit, and other gateways that are alive, synchronised and
    /// publishing carry all of its lines. `lines` are its own lines. `others` is `None` if the log did not answer; on a busy
    /// machine that does not mean that a gateway is gone.
    pub fn decide(
        &mut self,
        lines: &[(Vec<usize>, LineStatus)],
        others: Option<&[GatewayReport]>,
        now: Duration,
    ) -> GatewayClock {
        let passed = now.saturating_sub(std::mem::replace(&mut self.last_check, now));
        if others.is_none() && now.saturating_sub(self.last_answer) < KEPT_WITHOUT_ANSWER {
            for other in self.others.values_mut() {
                other.last_heard += passed;
                other.missing_since.values_mut().for_each(|since| *since += passed);
            }
            return self.clock;
        }
        if others.is_some() {
            self.last_answer = now;
        }
        let own = counted(lines);
        let hears: Vec<&LineKey> = own
            .iter()
            .filter(|(key, count)| self.own.get(key).is_some_and(|before| before < count))
            .map(|(key, _)| key)
            .collect();
        // The log drops a report when the gateway is suspended for a moment.
        self.others.retain(|_, other| now.saturating_sub(other.last_heard) < 2 * GATEWAY_TIMEOUT);
        for report in others.unwrap_or_default() {
            let received = counted(&report.lines);
            let other = self.others.entry(report.node.clone()).or_insert_with(|| OtherGateway {
                report_number: report.report_number,
                // The report may be left over from a gateway that is gone; the gateway counts as alive once the next report is
                // read.
                last_heard: now.checked_sub(GATEWAY_TIMEOUT).unwrap_or_default(),
                received: received.clone(),
                missing_since: BTreeMap::new(),
                is_fit: false,
            });
            if other.report_number != report.report_number {
                (other.report_number, other.last_heard) = (report.report_number, now);
            }
            let clock = report.clock;
            other.is_fit = clock.state.is_synchronised == Some(true) && !clock.is_silent;
            for key in &hears {
                other.missing_since.entry((*key).clone()).or_insert(now);
            }
            other.missing_since.retain(|key, _| other.received.get(key) == received.get(key));
            other.received = received;
        }
        let is_carried = |key: &LineKey| self.others.values().any(|other| other.has_line(key, now));
        // A line that is not open here is not required.
        let open = lines.iter().zip(keys(lines)).filter(|((_, line), _)| line.joined).map(|(_, key)| key);
        let mut open = open.peekable();
        self.clock.is_silent =
            self.clock.is_unfit && open.peek().is_some() && open.all(|key| is_carried(&key));
        self.own = own;
        self.clock
    }
}

impl OtherGateway {
    fn has_line(&self, line: &LineKey, now: Duration) -> bool {
        let is_alive = now.saturating_sub(self.last_heard) < GATEWAY_TIMEOUT;
        let is_heard =
            self.missing_since.get(line).is_none_or(|since| now.saturating_sub(*since) < LINE_TIMEOUT);
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

/// Number of datagrams received on each open line.
fn counted(lines: &[(Vec<usize>, LineStatus)]) -> BTreeMap<LineKey, u64> {
    let open = keys(lines).zip(lines).filter(|(_, (_, line))| line.joined);
    open.map(|(key, (_, line))| (key, line.received)).collect()
}

/// Rating of a clock's state, with hysteresis below each limit.
fn standing(state: ClockState, before: ClockStanding) -> ClockStanding {
    let is_above = |bound_s: f64, limit_s: f64, was_above: bool| {
        bound_s > if was_above { limit_s * HYSTERESIS } else { limit_s }
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
