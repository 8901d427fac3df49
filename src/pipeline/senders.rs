//! Which sender speaks for a sensor. Of two that say different things under one SAC/SIC, the one heard first counts while it
//! speaks; the other is refused. Sans-IO.
//!
//! A sender is an address with its port, since two programs on one machine differ in nothing else. But
//! * a port that is younger than 2 s stands for its host: some senders take a new port for each datagram;
//! * from a host that a sensor's `source` names everything is one sender: the operator vouches for it.
//!
//! Redundant lines are two senders that bring the same datagrams; they complete each other ([`Senders::bring_the_same`]).

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};

use asterix::{DataSource, Record, cat034, cat048};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use fusion::time::{SECOND, Time};
use fusion::{Identity, SensorIndex};

/// A sender that is silent for this long, nanoseconds, and for [`SILENT_PERIODS`] of the sensor's periods, speaks no longer.
const SILENT_NS: i64 = 3 * SECOND;
const SILENT_PERIODS: f64 = 3.0;
/// Two senders of a radar contradict each other when both have spoken for this long since the second one was first refused,
/// nanoseconds: lines whose first datagrams were lost are known to be redundant by then. Two of a transponder do when both have
/// spoken again: it reports every 2 s or so.
const CONTESTED_NS: i64 = SECOND;
/// A contest is over when the refused sender has been silent for this long, and for [`SILENT_PERIODS`], nanoseconds.
const OVER_NS: i64 = 5 * SECOND;
/// A port that has been in use for less than this stands for its host, nanoseconds.
const STEADY_NS: i64 = 2 * SECOND;
/// Addresses, and that two of them bring the same, are remembered for this long, nanoseconds.
const REMEMBERED_NS: i64 = 60 * SECOND;
/// Most addresses, and pairs of them, that are remembered: a flood of made-up ones must not fill the memory.
const ADDRESSES: usize = 4096;
/// Most refused senders of one subject that are distinguished.
const RIVALS: usize = 8;

/// What one sender speaks of at a time: a radar's plots, a radar's service messages, or one transponder. Receivers share
/// SAC/SIC 0/0, and drones may send for themselves: so transponders are judged one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct Subject {
    pub(super) sensor: SensorIndex,
    pub(super) category: u8,
    /// The transponder; `None` of a radar.
    pub(super) identity: Option<Identity>,
}

/// Two senders that say different things under one SAC/SIC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contest {
    /// The sensor.
    pub sensor: SensorIndex,
    /// Its SAC and SIC.
    pub source: DataSource,
    /// The category of what both send.
    pub category: u8,
    /// The sender that was heard first and counts.
    pub counts: SocketAddr,
    /// The sender that is refused.
    pub refused: SocketAddr,
    /// The transponder that both report; `None` where they speak for a radar.
    pub identity: Option<Identity>,
}

/// The verdict on a sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    /// It counts.
    Counts,
    /// Another sender speaks for this sensor; the contest, where it is to be told.
    Refused(Option<Contest>),
}

/// The rule for a sensor.
#[derive(Clone, Debug)]
struct Rule {
    source: DataSource,
    period_ns: i64,
    /// The hosts that its inputs name.
    vouched: Vec<IpAddr>,
}

/// The senders that have spoken of a subject.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Heard {
    owner: SocketAddr,
    last: Time,
    rivals: Vec<Rival>,
}

/// A sender that was refused.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Rival {
    address: SocketAddr,
    /// First and last refusal.
    first: Time,
    last: Time,
    told: bool,
}

/// An address that datagrams come from.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Port {
    first: Time,
    last: Time,
}

/// The addresses that datagrams have come from lately.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Ports(BTreeMap<SocketAddr, Port>);

impl Ports {
    fn hear(&mut self, from: SocketAddr, now: Time) {
        let known = self.0.get(&from).filter(|port| is_within(now, port.last, REMEMBERED_NS));
        let first = known.map_or(now, |port| port.first);
        self.0.insert(from, Port { first, last: now });
    }

    /// What a sender is known by: its host alone, until its port has been in use for some time.
    fn name(&self, address: SocketAddr) -> SocketAddr {
        if self.is_steady(address) { address } else { SocketAddr::new(address.ip(), 0) }
    }

    fn is_steady(&self, address: SocketAddr) -> bool {
        self.0.get(&address).is_some_and(|port| port.last.nanos() - port.first.nanos() >= STEADY_NS)
    }

    fn forget(&mut self, now: Time) {
        self.0.retain(|_, port| is_within(now, port.last, REMEMBERED_NS));
        if self.0.len() > ADDRESSES {
            self.0.clear();
        }
    }
}

/// Senders that have brought the same datagrams lately.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Same(BTreeMap<(SocketAddr, SocketAddr), Time>);

impl Same {
    /// Notes that both have; whether that is new.
    fn note(&mut self, one: SocketAddr, other: SocketAddr, now: Time) -> bool {
        one != other && self.0.insert((one.min(other), one.max(other)), now).is_none()
    }

    /// Whether both have, or both have brought what a third has.
    fn joins(&self, one: SocketAddr, other: SocketAddr, now: Time) -> bool {
        let third = |&(a, b): &(SocketAddr, SocketAddr)| match one {
            _ if a == one => Some(b),
            _ if b == one => Some(a),
            _ => None,
        };
        self.holds(one, other, now)
            || self
                .0
                .keys()
                .filter_map(third)
                .any(|third| self.holds(one, third, now) && self.holds(third, other, now))
    }

    fn holds(&self, one: SocketAddr, other: SocketAddr, now: Time) -> bool {
        let last = self.0.get(&(one.min(other), one.max(other)));
        last.is_some_and(|last| is_within(now, *last, REMEMBERED_NS))
    }

    fn forget(&mut self, now: Time) {
        self.0.retain(|_, last| is_within(now, *last, REMEMBERED_NS));
        if self.0.len() > ADDRESSES {
            self.0.clear();
        }
    }
}

/// Judges which sender speaks for which sensor.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Senders {
    /// Of the configuration: no checkpoint has them.
    #[serde(skip)]
    rules: Vec<Rule>,
    heard: BTreeMap<Subject, Heard>,
    ports: Ports,
    same: Same,
    tidied: Time,
}

impl Senders {
    /// No sender heard yet.
    pub(super) fn new(config: &Config) -> Self {
        let rule = |sensor: &crate::config::Sensor| Rule {
            source: DataSource { sac: sensor.sac, sic: sensor.sic },
            period_ns: (sensor.period_s.unwrap_or(sensor.kind.usual_period_s()) * SECOND as f64) as i64,
            vouched: sensor.inputs.iter().filter_map(|input| input.source.map(IpAddr::from)).collect(),
        };
        Self {
            rules: config.sensors.iter().map(rule).collect(),
            heard: BTreeMap::new(),
            ports: Ports::default(),
            same: Same::default(),
            tidied: Time::from_nanos(i64::MIN),
        }
    }

    /// No sender heard yet, by the same rules.
    pub(super) fn start_afresh(&mut self) {
        *self = Self {
            rules: std::mem::take(&mut self.rules),
            heard: BTreeMap::new(),
            ports: Ports::default(),
            same: Same::default(),
            tidied: Time::from_nanos(i64::MIN),
        };
    }

    /// The same who knows who was heard before.
    pub(super) fn going_on(self, before: Self) -> Self {
        Self { rules: self.rules, ..before }
    }

    /// A datagram has come from this address; `now` never decreases.
    pub(super) fn hear(&mut self, from: SocketAddr, now: Time) {
        self.tidy(now);
        self.ports.hear(from, now);
    }

    /// Both have brought the same datagram, which holds reports: they are lines of one sensor, for a minute.
    pub(super) fn bring_the_same(&mut self, one: SocketAddr, other: SocketAddr, now: Time) {
        let is_new = self.same.note(one, other, now);
        // A young port may be another one the next time; one that stays has brought the same already.
        self.same.note(self.ports.name(one), self.ports.name(other), now);
        if is_new {
            // What was refused before was no contest.
            let Self { heard, ports, same, .. } = self;
            for heard in heard.values_mut() {
                let owner = heard.owner;
                heard.rivals.retain(|rival| !are_redundant(ports, same, owner, rival.address, now));
            }
        }
    }

    /// Whether what this sender says of the subject counts.
    pub(super) fn judge(&mut self, subject: Subject, from: SocketAddr, now: Time) -> Judged {
        let Some(heard) = self.heard.get(&subject) else {
            self.heard.insert(subject, Heard { owner: from, last: now, rivals: Vec::new() });
            return Judged::Counts;
        };
        let rule = &self.rules[usize::from(subject.sensor.0)];
        let speaks = is_within(now, heard.last, rule.silence_ns());
        if !speaks || are_one(&self.ports, rule, heard.owner, from) {
            if let Some(heard) = self.heard.get_mut(&subject) {
                (heard.owner, heard.last) = (from, now);
                heard.rivals.retain(|rival| !are_one(&self.ports, rule, rival.address, from));
            }
            if subject.identity.is_none() {
                // A radar with nothing in sight still speaks of itself.
                for category in [cat034::Record::CATEGORY, cat048::Record::CATEGORY] {
                    self.still_speaks(Subject { category, ..subject }, from, now);
                }
            }
            return Judged::Counts;
        }
        if are_redundant(&self.ports, &self.same, heard.owner, from, now) {
            return Judged::Counts;
        }
        self.refuse(subject, from, now)
    }

    /// A record of the subject was not taken for another reason; its sender speaks all the same.
    pub(super) fn still_speaks(&mut self, subject: Subject, from: SocketAddr, now: Time) {
        let Self { heard, ports, rules, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        if let Some(heard) = heard.get_mut(&subject).filter(|heard| are_one(ports, rule, heard.owner, from)) {
            heard.last = now;
        }
    }

    /// The contests that last.
    pub(super) fn contests(&self, now: Time) -> Vec<Contest> {
        let of = |(subject, heard): (&Subject, &Heard)| {
            let rule = &self.rules[usize::from(subject.sensor.0)];
            let lasts = |rival: &&Rival| heard.is_contested(subject, rival) && rule.lasts(rival, now);
            let contest = |rival: &Rival| rule.contest(*subject, heard.owner, rival.address);
            heard.rivals.iter().filter(lasts).map(contest).collect::<Vec<_>>()
        };
        self.heard.iter().flat_map(of).collect()
    }

    fn refuse(&mut self, subject: Subject, from: SocketAddr, now: Time) -> Judged {
        let Self { heard: all, rules, ports, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        let Some(heard) = all.get_mut(&subject) else { return Judged::Refused(None) };
        heard.rivals.retain(|rival| rule.lasts(rival, now));
        // One that takes a new port for each datagram is one rival.
        let known = heard.rivals.iter().position(|rival| are_one(ports, rule, rival.address, from));
        let mut rival = match known {
            Some(index) => heard.rivals.remove(index),
            None => Rival { address: from, first: now, last: now, told: false },
        };
        if heard.rivals.len() == RIVALS {
            heard.rivals.remove(0);
        }
        (rival.address, rival.last) = (from, now);
        let is_new = heard.is_contested(&subject, &rival) && !rival.told;
        rival.told |= is_new;
        let owner = heard.owner;
        heard.rivals.push(rival);
        // The same two senders may contest many transponders: that is reported once.
        let is_known = |(other, heard): (&Subject, &Heard)| {
            let is_told = |rival: &Rival| rival.told && rival.address == from && rule.lasts(rival, now);
            *other != subject
                && other.sensor == subject.sensor
                && heard.owner == owner
                && heard.rivals.iter().any(is_told)
        };
        let is_told = is_new && !all.iter().any(is_known);
        Judged::Refused(is_told.then(|| rule.contest(subject, owner, from)))
    }

    /// Forgets what is over, once a second.
    fn tidy(&mut self, now: Time) {
        if is_within(now, self.tidied, SECOND) {
            return;
        }
        self.tidied = now;
        self.ports.forget(now);
        self.same.forget(now);
        let Self { rules, heard, .. } = self;
        heard.retain(|subject, heard| {
            is_within(now, heard.last, rules[usize::from(subject.sensor.0)].silence_ns())
        });
    }
}

impl Heard {
    /// Whether both have spoken for some time since the rival was first refused.
    fn is_contested(&self, subject: &Subject, rival: &Rival) -> bool {
        let least_ns = if subject.identity.is_some() { 1 } else { CONTESTED_NS };
        self.last.min(rival.last).nanos() - rival.first.nanos() >= least_ns
    }
}

impl Rule {
    fn silence_ns(&self) -> i64 {
        SILENT_NS.max((SILENT_PERIODS * self.period_ns as f64) as i64)
    }

    fn lasts(&self, rival: &Rival, now: Time) -> bool {
        is_within(now, rival.last, OVER_NS.max(self.silence_ns()))
    }

    fn contest(&self, subject: Subject, counts: SocketAddr, refused: SocketAddr) -> Contest {
        let Subject { sensor, category, identity } = subject;
        Contest { sensor, source: self.source, category, counts, refused, identity }
    }
}

/// Whether two addresses are one sender; `known` was heard earlier.
fn are_one(ports: &Ports, rule: &Rule, known: SocketAddr, from: SocketAddr) -> bool {
    let is_of_its_host = || rule.vouched.contains(&from.ip()) || !ports.is_steady(known);
    known == from || (known.ip() == from.ip() && is_of_its_host())
}

/// Whether two addresses are lines of one sensor.
fn are_redundant(ports: &Ports, same: &Same, one: SocketAddr, other: SocketAddr, now: Time) -> bool {
    same.joins(one, other, now) || same.joins(ports.name(one), ports.name(other), now)
}

fn is_within(now: Time, then: Time, span_ns: i64) -> bool {
    now.nanos().saturating_sub(then.nanos()) <= span_ns
}

#[cfg(test)]
mod tests;
