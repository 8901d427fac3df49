//! The clock of a member of the cluster, compared with reference time by what all members write each second. Sans-IO but for
//! [`written`].

use std::collections::BTreeMap;

use fusion::time::Time;
use jiff::SignedDuration;

use super::gateway::GatewayReport;
use super::log::{Log, LogError};
use super::node::NodeReport;
use super::reference_clock::{BOUND, Moment, ReferenceClock};

/// Members report each second: the reports of this time are compared.
const COMPARED: SignedDuration = SignedDuration::from_secs(3);
/// A clock that was wrong is right again below this.
const RIGHT: SignedDuration = SignedDuration::from_millis(800);
/// A clock that moves by more than this against the steady one was set.
const SET: SignedDuration = SignedDuration::from_millis(250);
/// Looks in a row after which a clock is wrong, or right again: a word may be held up on its way.
const LOOKS: u32 = 2;

/// A word of a member: when the log stamped it, and when it was sent by the member's own clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The member.
    pub member: String,
    /// Whether it is a gateway, whose clock has a vote.
    pub is_gateway: bool,
    /// The log's stamp.
    pub stamp: Time,
    /// Its own.
    pub sent: Time,
}

/// How far the clock of this process is ahead.
#[derive(Debug)]
pub struct MemberClock {
    reference: ReferenceClock,
    /// The last stamp of each member.
    known: BTreeMap<(bool, String), Time>,
    ahead: Option<SignedDuration>,
    is_wrong: bool,
    otherwise: u32,
    /// How far the machine's clock was ahead of the steady one.
    set: Option<SignedDuration>,
}

impl Default for MemberClock {
    fn default() -> Self {
        Self {
            reference: ReferenceClock::new(COMPARED),
            known: BTreeMap::new(),
            ahead: None,
            is_wrong: false,
            otherwise: 0,
            set: None,
        }
    }
}

impl MemberClock {
    /// Looks once at what is written, as the member of that name, which is a gateway or another one.
    pub fn look(&mut self, (name, is_gateway): (&str, bool), mut written: Vec<Written>, at: Moment) {
        let set = at.wall - Time::default() - at.steady;
        if self.set.replace(set).is_some_and(|before| (set - before).abs() > SET) {
            self.reference.forget(name);
        }
        // A report that was read before says nothing new.
        written.retain(|word| {
            let member = (word.is_gateway, word.member.clone());
            self.known.insert(member, word.stamp) != Some(word.stamp)
        });
        written.sort_by_key(|word| word.stamp);
        for Written { member, is_gateway: of_gateway, stamp, sent } in &written {
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
        let is_otherwise = if self.is_wrong { ahead.abs() < RIGHT } else { ahead.abs() > BOUND };
        self.otherwise = if is_otherwise { self.otherwise + 1 } else { 0 };
        if self.otherwise >= LOOKS {
            (self.is_wrong, self.otherwise) = (!self.is_wrong, 0);
        }
    }

    /// A message that was read at once, when it was read by this process's clock.
    pub fn read(&mut self, stamp: Time, read: Time) {
        self.reference.note_read(stamp, read);
    }

    /// How far its clock is ahead of reference time, negative where it is behind; `None`: not known yet.
    pub const fn ahead(&self) -> Option<SignedDuration> {
        self.ahead
    }

    /// The same, seconds.
    pub fn ahead_s(&self) -> Option<f64> {
        self.ahead.map(|ahead| ahead.as_secs_f64())
    }

    /// Whether a slot that is due then is due more than a second after the log stamped its output, by reference time: no owner has
    /// written it.
    pub fn is_early(&self, due: Time, stamp: Time) -> bool {
        self.reference.at(stamp).is_some_and(|at| due - at > BOUND)
    }

    /// Whether its clock is further from reference time than the bound.
    pub const fn is_wrong(&self) -> bool {
        self.is_wrong
    }
}

/// The reports of the gateways, as words of their clocks, too; with them that of a node, if it is named.
///
/// # Errors
/// The log does not answer.
pub async fn written(log: &Log, node: Option<&str>) -> Result<(Vec<Written>, Vec<GatewayReport>), LogError> {
    let (mut written, mut reports) = (Vec::new(), Vec::new());
    for (stamp, report) in GatewayReport::all_stamped(log).await? {
        written.push(Written { member: report.node.clone(), is_gateway: true, stamp, sent: report.sent });
        reports.push(report);
    }
    if let Some(node) = node
        && let Some((stamp, said)) = log.said_at(&format!("node.{node}")).await?
        && let Ok(NodeReport { sent, .. }) = postcard::from_bytes(&said)
    {
        written.push(Written { member: node.to_owned(), is_gateway: false, stamp, sent });
    }
    Ok((written, reports))
}
