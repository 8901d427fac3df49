//! Comparison of a member's clock with reference time, by the reports that all members write each second. Sans-IO except for
//! [`report_times`].

use std::collections::BTreeMap;

use fusion::time::Time;
use jiff::SignedDuration;

use super::gateway_report::GatewayReport;
use super::log::{Log, LogError};
use super::node_report::NodeReport;
use super::reference_clock::{BOUND, ClockReading, ReferenceClock};

/// Time window of the compared reports. Members report each second.
const COMPARISON_WINDOW: SignedDuration = SignedDuration::from_secs(3);
/// Error below which a wrong clock is right again.
const RIGHT_BELOW: SignedDuration = SignedDuration::from_millis(800);
/// Change relative to the steady clock above which a clock was set.
const CLOCK_SET_ABOVE: SignedDuration = SignedDuration::from_millis(250);
/// Number of consecutive checks after which a clock is wrong, or right again: a report may be delayed.
const CHECKS: u32 = 2;

/// Time of a report: the log's timestamp, and the sending time by the member's own clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportTime {
    /// Name of the member.
    pub member: String,
    /// Whether the member is a gateway. Clocks of gateways have a vote.
    pub is_gateway: bool,
    /// The log's timestamp.
    pub stamp: Time,
    /// Sending time by the member's clock.
    pub sent: Time,
}

/// Error of this process's clock.
#[derive(Debug)]
pub struct MemberClock {
    reference: ReferenceClock,
    /// Timestamp of each member's last report.
    known: BTreeMap<(bool, String), Time>,
    ahead: Option<SignedDuration>,
    is_wrong: bool,
    contradictions: u32,
    /// Difference between the machine's clock and the steady clock.
    set: Option<SignedDuration>,
}

impl Default for MemberClock {
    fn default() -> Self {
        Self {
            reference: ReferenceClock::new(COMPARISON_WINDOW),
            known: BTreeMap::new(),
            ahead: None,
            is_wrong: false,
            contradictions: 0,
            set: None,
        }
    }
}

impl MemberClock {
    /// Evaluates the reports once, for the member of that name, which is a gateway or another member.
    pub fn update(
        &mut self,
        (name, is_gateway): (&str, bool),
        mut written: Vec<ReportTime>,
        at: ClockReading,
    ) {
        let set = at.wall - Time::default() - at.steady;
        if self.set.replace(set).is_some_and(|before| (set - before).abs() > CLOCK_SET_ABOVE) {
            self.reference.forget(name);
        }
        // A report that was read before contains nothing new.
        written.retain(|report| {
            let member = (report.is_gateway, report.member.clone());
            self.known.insert(member, report.stamp) != Some(report.stamp)
        });
        written.sort_by_key(|report| report.stamp);
        for ReportTime { member, is_gateway: of_gateway, stamp, sent } in &written {
            if *of_gateway {
                self.reference.note(member, *stamp, *sent);
            }
            if !is_gateway && !of_gateway && member == name {
                self.reference.note_sent(*stamp, *sent);
            }
        }
        let now_ahead = if is_gateway { self.reference.ahead(name) } else { self.reference.own_ahead() };
        self.ahead = now_ahead.or(self.ahead);
        let Some(ahead) = now_ahead else { return };
        let is_contradiction = if self.is_wrong { ahead.abs() < RIGHT_BELOW } else { ahead.abs() > BOUND };
        self.contradictions = if is_contradiction { self.contradictions + 1 } else { 0 };
        if self.contradictions >= CHECKS {
            (self.is_wrong, self.contradictions) = (!self.is_wrong, 0);
        }
    }

    /// Notes the log's timestamp of a message that was read without delay, and the time of reading by this process's clock.
    pub fn note_reading(&mut self, stamp: Time, read: Time) {
        self.reference.note_read(stamp, read);
    }

    /// Time by which the clock is ahead of reference time, negative if it is behind; `None` if not known yet.
    pub const fn ahead(&self) -> Option<SignedDuration> {
        self.ahead
    }

    /// Time by which the clock is ahead of reference time, in seconds; `None` if not known yet.
    pub fn ahead_s(&self) -> Option<f64> {
        self.ahead.map(|ahead| ahead.as_secs_f64())
    }

    /// Whether the log stamped an output more than a second before its slot was due, by reference time. No owner has written such
    /// an output.
    pub fn is_early(&self, due: Time, stamp: Time) -> bool {
        self.reference.at(stamp).is_some_and(|at| due - at > BOUND)
    }

    /// Whether the clock's error exceeds the bound.
    pub const fn is_wrong(&self) -> bool {
        self.is_wrong
    }
}

/// Reads the reports of the gateways and the times in them, and the times in the report of `node`, if given.
///
/// # Errors
/// The log does not answer.
pub async fn report_times(
    log: &Log,
    node: Option<&str>,
) -> Result<(Vec<ReportTime>, Vec<GatewayReport>), LogError> {
    let (mut written, mut reports) = (Vec::new(), Vec::new());
    for (stamp, report) in GatewayReport::all_stamped(log).await? {
        written.push(ReportTime { member: report.node.clone(), is_gateway: true, stamp, sent: report.sent });
        reports.push(report);
    }
    if let Some(node) = node
        && let Some((stamp, octets)) = log.stamped_entry(&format!("node.{node}")).await?
        && let Ok(NodeReport { sent, .. }) = postcard::from_bytes(&octets)
    {
        written.push(ReportTime { member: node.to_owned(), is_gateway: false, stamp, sent });
    }
    Ok((written, reports))
}
