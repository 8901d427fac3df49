//! Decides which sender speaks for a sensor. Sans-IO.
//!
//! A sender is an address with its port, because two programs on one host differ only in the port. There are two exceptions:
//! * A port used for less than 2 s represents its host: some senders use a new port for each datagram.
//! * All ports of a host that a sensor's `source` names are one sender: the operator vouches for the host.
//!
//! If an input of a sensor names a `source`, only the hosts named by its inputs may speak for it, on whichever line they are
//! received. Two named hosts that send the same datagrams are redundant lines and complete each other.
//!
//! Without a `source` the identity of a sender is not proven, and a datagram is easily copied. The sender that was received
//! first is therefore the owner while it is active. Another sender with the same datagrams is harmless and takes over when the
//! owner is silent. Once it sends a datagram that the owner does not send, it is a rival: refused, and reported.

mod ports;
mod rivals;

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use asterix::{DataSource, Record, cat034, cat048};
use serde::{Deserialize, Serialize};

use fusion::time::{SECOND, Time};
use fusion::{Identity, SensorIndex};
use ports::Ports;
use rivals::{Rival, Rivals};
use site::config::{Config, ConnectionFormat, Sensor};

/// Time of silence after which a sender is inactive, in nanoseconds; at least [`SILENT_PERIODS`] of the sensor's periods.
const SILENT_NS: i64 = 3 * SECOND;
const SILENT_PERIODS: f64 = 3.0;
/// A radar's senders contradict each other if the owner was active for this time, in nanoseconds, after the rival sent a datagram
/// of its own. An owner that falls silent sooner is replaced, not contradicted. A transponder reports about every 2 s; its
/// owner's next report is sufficient.
const CONTESTED_NS: i64 = SECOND;
/// A contest is over when the rival has sent nothing of its own for this time, in nanoseconds, and for [`SILENT_PERIODS`].
const OVER_NS: i64 = 5 * SECOND;
/// Time for which hosts that have sent the same datagram count as redundant lines, in nanoseconds.
const REMEMBERED_NS: i64 = 60 * SECOND;
/// Maximum number of hosts per sensor that are refused because of `source` and distinguished.
const STRANGERS: usize = 8;

/// The subject of a sender: a radar's plots, a radar's service messages, or one transponder. Transponders are checked one by one,
/// because receivers share SAC/SIC 0/0, and drones may send directly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct Subject {
    pub(super) sensor: SensorIndex,
    pub(super) category: u8,
    /// The transponder; `None` for a radar.
    pub(super) identity: Option<Identity>,
}

impl Subject {
    /// A radar's service messages for its plots, and its plots for its service messages.
    fn peer(self) -> Option<Self> {
        let category = match self.category {
            cat034::Record::CATEGORY => cat048::Record::CATEGORY,
            cat048::Record::CATEGORY => cat034::Record::CATEGORY,
            _ => return None,
        };
        Some(Self { category, ..self })
    }
}

/// Reason for which a sender is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ContestReason {
    /// Another sender speaks for the sensor.
    OtherSender,
    /// The sensor's inputs name other hosts as `source`.
    ForeignSource,
}

fusion::interface_names!(ContestReason { OtherSender = "other_sender", ForeignSource = "foreign_source" });

/// Two senders with one SAC/SIC, one of which is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contest {
    /// The sensor.
    pub sensor: SensorIndex,
    /// Its SAC and SIC.
    pub source: DataSource,
    /// Category sent by the refused sender; 0 for Remote ID.
    pub category: u8,
    /// The accepted sender; with port 0 the host that `source` names.
    pub counts: SocketAddr,
    /// The refused sender.
    pub refused: SocketAddr,
    /// Reason of the refusal.
    pub reason: ContestReason,
    /// The transponder that both report; `None` for a radar.
    pub identity: Option<Identity>,
}

/// A sender has replaced another sender of a radar or camera, which had fallen silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Takeover {
    /// The sensor.
    pub sensor: SensorIndex,
    /// Its SAC and SIC.
    pub source: DataSource,
    /// The previous sender.
    pub before: SocketAddr,
    /// The present sender.
    pub after: SocketAddr,
}

/// The decision on a sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    /// The sender is accepted; with the takeover that this record causes, if any.
    Counts(Option<Takeover>),
    /// Another sender speaks for this sensor.
    Refused,
}

/// A sender from which the same datagram was refused earlier, and the time.
pub(super) type Earlier = (SocketAddr, Time);

/// The rules of a sensor.
#[derive(Clone, Debug)]
struct Rule {
    source: DataSource,
    period_ns: i64,
    /// Hosts named by its inputs; if there are none, any host may speak for it.
    sources: Vec<IpAddr>,
    /// Senders of its connections, which may speak for it, too.
    connections: Vec<SocketAddr>,
}

/// The senders of a subject.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Heard {
    owner: SocketAddr,
    last: Time,
    rivals: Rivals,
}

/// A sender that is refused because of a sensor's `source`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Stranger {
    address: SocketAddr,
    category: u8,
    last: Time,
}

/// Pairs of hosts that have sent the same datagram, and the last time they did; only hosts named by a `source`.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Same(BTreeMap<(IpAddr, IpAddr), Time>);

impl Same {
    fn note(&mut self, one: IpAddr, other: IpAddr, now: Time) {
        if one != other {
            self.0.insert((one.min(other), one.max(other)), now);
        }
    }

    /// Whether both hosts have sent the same datagrams, directly or through a third host.
    fn joins(&self, one: IpAddr, other: IpAddr, now: Time) -> bool {
        let third = |&(a, b): &(IpAddr, IpAddr)| match one {
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

    fn holds(&self, one: IpAddr, other: IpAddr, now: Time) -> bool {
        let last = self.0.get(&(one.min(other), one.max(other)));
        last.is_some_and(|last| is_within(now, *last, REMEMBERED_NS))
    }
}

/// Decides which sender speaks for which sensor.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Senders {
    /// Rules from the configuration; not part of a checkpoint.
    #[serde(skip)]
    rules: Vec<Rule>,
    heard: BTreeMap<Subject, Heard>,
    strangers: BTreeMap<(SensorIndex, IpAddr), Stranger>,
    ports: Ports,
    same: Same,
    tidied: Time,
}

impl Senders {
    /// No sender received yet.
    pub(super) fn new(config: &Config) -> Self {
        Self {
            rules: config.sensors.iter().map(Rule::new).collect(),
            heard: BTreeMap::new(),
            strangers: BTreeMap::new(),
            ports: Ports::default(),
            same: Same::default(),
            tidied: Time::from_nanos(i64::MIN),
        }
    }

    /// Forgets all senders and keeps the rules.
    pub(super) fn start_afresh(&mut self) {
        *self = Self {
            rules: std::mem::take(&mut self.rules),
            heard: BTreeMap::new(),
            strangers: BTreeMap::new(),
            ports: Ports::default(),
            same: Same::default(),
            tidied: Time::from_nanos(i64::MIN),
        };
    }

    /// The state of `before` with the rules of this configuration.
    pub(super) fn going_on(self, before: Self) -> Self {
        Self { rules: self.rules, ..before }
    }

    /// Notes a datagram from this address; `now` never decreases. Returns the contests to report, each once.
    pub(super) fn hear(&mut self, from: SocketAddr, now: Time) -> Vec<Contest> {
        let contests = self.tidy(now);
        self.ports.hear(from, now);
        contests
    }

    /// Notes that both hosts have sent the same datagram with reports: they are redundant lines if `source` names both.
    pub(super) fn bring_the_same(&mut self, one: IpAddr, other: IpAddr, now: Time) {
        if self.rules.iter().any(|rule| rule.names(one) && rule.names(other)) {
            self.same.note(one, other, now);
        }
    }

    /// Checks whether a sender may speak for the sensor at all; if not, returns the contest if it is to be reported.
    pub(super) fn admit(
        &mut self,
        (sensor, category): (SensorIndex, u8),
        from: SocketAddr,
        now: Time,
    ) -> Result<(), Option<Contest>> {
        let rule = &self.rules[usize::from(sensor.0)];
        if rule.admits(from) {
            return Ok(());
        }
        let stranger = Stranger { address: from, category, last: now };
        let key = (sensor, from.ip());
        if let Some(known) = self.strangers.get_mut(&key) {
            let is_news = !rule.lasts(known.last, now);
            *known = stranger;
            return Err(is_news.then(|| self.foreign(sensor, &stranger, now)));
        }
        let of_sensor = (sensor, IpAddr::V4(Ipv4Addr::UNSPECIFIED))..;
        let count = self.strangers.range(of_sensor).take_while(|((of, _), _)| *of == sensor).count();
        if count >= STRANGERS {
            return Err(None);
        }
        self.strangers.insert(key, stranger);
        Err(Some(self.foreign(sensor, &stranger, now)))
    }

    /// Decides whether this sender speaks for the subject. `earlier`: senders from which the same datagram was refused.
    pub(super) fn judge(
        &mut self,
        subject: Subject,
        from: SocketAddr,
        earlier: &[Earlier],
        now: Time,
    ) -> Judged {
        let Self { heard, rules, ports, same, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        let speaks = |heard: &Heard| is_within(now, heard.last, rule.silence_ns());
        let own = heard.get(&subject);
        if let Some(own) = own.filter(|own| speaks(own) && !rule.are_one(ports, own.owner, from)) {
            if rule.are_redundant(same, own.owner, from, now) {
                return Judged::Counts(None);
            }
            return self.refuse(subject, from, now);
        }
        // A radar's plots and service messages may come from several ports of a host, or from hosts that `source` names.
        let peer = subject.peer().and_then(|peer| Some((peer, heard.get(&peer)?)));
        let is_of_peer =
            |owner: SocketAddr| owner.ip() == from.ip() || (rule.names(owner.ip()) && rule.names(from.ip()));
        if let Some((peer, _)) = peer.filter(|(_, heard)| speaks(heard) && !is_of_peer(heard.owner)) {
            return self.refuse(peer, from, now);
        }
        // A redundant line whose copies arrive first takes over only when the owner is no longer received.
        let is_gone = |owner| {
            !rule.are_redundant(same, owner, from, now)
                || ports.last(owner).is_none_or(|last| !is_within(now, last, rule.silence_ns()))
        };
        let is_known = peer.is_some_and(|(_, heard)| speaks(heard) && rule.are_one(ports, heard.owner, from));
        let before = own.map(|own| own.owner).filter(|&owner| {
            // After a restart a sender on the same host has another port.
            let is_elsewhere = owner.ip() != from.ip() && !rule.are_one(ports, owner, from);
            subject.identity.is_none() && !is_known && is_elsewhere && is_gone(owner)
        });
        let takeover = before.map(|before| Takeover {
            sensor: subject.sensor,
            source: rule.source,
            before,
            after: from,
        });
        let known = heard.entry(subject).or_insert_with(|| Heard {
            owner: from,
            last: now,
            rivals: Rivals::default(),
        });
        (known.owner, known.last) = (from, now);
        known.rivals.retain(|rival| !rule.are_one(ports, rival.address, from));
        self.excuse(subject, from, earlier);
        if let Some(peer) = subject.peer() {
            // A radar that sees no target still sends service messages.
            self.keep_active(peer, from, now);
            self.excuse(peer, from, earlier);
        }
        Judged::Counts(takeover)
    }

    /// Notes that the sender is active although a record was refused for another reason.
    pub(super) fn keep_active(&mut self, subject: Subject, from: SocketAddr, now: Time) {
        let Self { heard, ports, rules, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        if let Some(heard) = heard.get_mut(&subject).filter(|heard| rule.are_one(ports, heard.owner, from)) {
            heard.last = now;
        }
    }

    /// The contests that last.
    pub(super) fn contests(&self, now: Time) -> Vec<Contest> {
        let of = |(subject, heard): (&Subject, &Heard)| {
            let rule = &self.rules[usize::from(subject.sensor.0)];
            let lasting = heard.rivals.iter().filter(|rival| heard.is_contested(subject, rival, rule, now));
            lasting.map(|rival| rule.contest(*subject, heard.owner, rival.address)).collect::<Vec<_>>()
        };
        let lasts = |((sensor, _), stranger): &(&(SensorIndex, IpAddr), &Stranger)| {
            self.rules[usize::from(sensor.0)].lasts(stranger.last, now)
        };
        let strangers = self.strangers.iter().filter(lasts);
        let foreign = strangers.map(|((sensor, _), stranger)| self.foreign(*sensor, stranger, now));
        self.heard.iter().flat_map(of).chain(foreign).collect()
    }

    /// The contest between a sender that is refused because of `source` and the sender that speaks for the sensor.
    fn foreign(&self, sensor: SensorIndex, stranger: &Stranger, now: Time) -> Contest {
        let rule = &self.rules[usize::from(sensor.0)];
        let speaks = |heard: &&Heard| is_within(now, heard.last, rule.silence_ns());
        let subject = Subject { sensor, category: stranger.category, identity: None };
        let owner = self.heard.get(&subject).filter(speaks).map(|heard| heard.owner);
        let named = rule.sources.first().map(|&host| SocketAddr::new(host, 0));
        let counts = owner.or(named).unwrap_or(stranger.address);
        Contest { reason: ContestReason::ForeignSource, ..rule.contest(subject, counts, stranger.address) }
    }

    fn refuse(&mut self, subject: Subject, from: SocketAddr, now: Time) -> Judged {
        let Self { heard, rules, ports, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        if let Some(heard) = heard.get_mut(&subject) {
            // A sender that uses a new port for each datagram is one rival.
            heard.rivals.refuse(from, now, rule.over_ns(), |known| rule.are_one(ports, known, from));
        }
        Judged::Refused
    }

    /// Notes that the owner has sent a datagram refused from rivals before, so that it does not count as the rivals' own.
    fn excuse(&mut self, subject: Subject, from: SocketAddr, earlier: &[Earlier]) {
        let Self { heard, ports, rules, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        if let Some(heard) = heard.get_mut(&subject).filter(|heard| rule.are_one(ports, heard.owner, from)) {
            earlier.iter().for_each(|&(rival, at)| heard.rivals.excuse(rival, at));
        }
    }

    /// Once a second: removes expired state and returns the contests to report.
    fn tidy(&mut self, now: Time) -> Vec<Contest> {
        if is_within(now, self.tidied, SECOND) {
            return Vec::new();
        }
        self.tidied = now;
        self.ports.forget(now);
        self.same.0.retain(|_, last| is_within(now, *last, REMEMBERED_NS));
        let Self { rules, heard, strangers, .. } = self;
        strangers.retain(|(sensor, _), stranger| rules[usize::from(sensor.0)].lasts(stranger.last, now));
        heard.retain(|subject, heard| {
            let rule = &rules[usize::from(subject.sensor.0)];
            heard.rivals.settle(now, rule.over_ns());
            // The last sender of a radar is kept, so that a takeover is recognised after any silence.
            subject.identity.is_none() || is_within(now, heard.last, rule.silence_ns())
        });
        // Two senders may contest many transponders; this is reported once.
        let key =
            |subject: &Subject, heard: &Heard, rival: &Rival| (subject.sensor, heard.owner, rival.address);
        let mut reported = std::collections::BTreeSet::new();
        for (subject, heard) in &*heard {
            reported.extend(
                heard.rivals.iter().filter(|rival| rival.told).map(|rival| key(subject, heard, rival)),
            );
        }
        let mut contests = Vec::new();
        for (subject, known) in heard {
            let rule = &rules[usize::from(subject.sensor.0)];
            let is_new = |rival: &Rival| !rival.told && known.is_contested(subject, rival, rule, now);
            let new: Vec<SocketAddr> =
                known.rivals.iter().filter(|rival| is_new(rival)).map(|rival| rival.address).collect();
            for address in new {
                known.rivals.tell(address);
                if reported.insert((subject.sensor, known.owner, address)) {
                    contests.push(rule.contest(*subject, known.owner, address));
                }
            }
        }
        contests
    }
}

impl Heard {
    /// Whether the rival has recently sent a datagram of its own while the owner was active.
    fn is_contested(&self, subject: &Subject, rival: &Rival, rule: &Rule, now: Time) -> bool {
        let least_ns = if subject.identity.is_some() { 1 } else { CONTESTED_NS };
        let own = rival.own(now, rule.over_ns());
        own.is_some_and(|first| self.last.nanos() - first.nanos() >= least_ns)
    }
}

impl Rule {
    fn new(sensor: &Sensor) -> Self {
        // Datagrams of a connection have the address of the remote end, or an unspecified host if there is a broker between.
        let sender = |connection: &site::config::Connection| match connection.format {
            _ if connection.is_subscription() => {
                connection.broker().map(|broker| (Ipv4Addr::UNSPECIFIED, broker.port).into())
            }
            ConnectionFormat::Beast | ConnectionFormat::Avr | ConnectionFormat::Asterix => {
                connection.socket().map(SocketAddr::V4)
            }
            ConnectionFormat::Mqtt
            | ConnectionFormat::Http
            | ConnectionFormat::Mavlink
            | ConnectionFormat::Json
            | ConnectionFormat::Csv => None,
        };
        Self {
            source: DataSource { sac: sensor.sac, sic: sensor.sic },
            period_ns: (sensor.period_s.unwrap_or(sensor.kind.usual_period_s()) * SECOND as f64) as i64,
            sources: sensor.inputs.iter().filter_map(|input| input.source.map(IpAddr::from)).collect(),
            connections: sensor.connections.iter().filter_map(sender).collect(),
        }
    }

    /// Whether an input of the sensor names the host as its `source`.
    fn names(&self, host: IpAddr) -> bool {
        self.sources.contains(&host)
    }

    /// Whether a sender may speak for the sensor.
    fn admits(&self, from: SocketAddr) -> bool {
        self.sources.is_empty() || self.names(from.ip()) || self.connections.contains(&from)
    }

    fn silence_ns(&self) -> i64 {
        SILENT_NS.max((SILENT_PERIODS * self.period_ns as f64) as i64)
    }

    fn over_ns(&self) -> i64 {
        OVER_NS.max(self.silence_ns())
    }

    fn lasts(&self, last: Time, now: Time) -> bool {
        is_within(now, last, self.over_ns())
    }

    /// Whether two addresses are one sender; `known` was received earlier.
    fn are_one(&self, ports: &Ports, known: SocketAddr, from: SocketAddr) -> bool {
        let is_of_its_host = || self.names(from.ip()) || !ports.is_steady(known);
        known == from || (known.ip() == from.ip() && is_of_its_host())
    }

    /// Whether two addresses are redundant lines of the sensor: `source` names both, and they send the same datagrams.
    fn are_redundant(&self, same: &Same, one: SocketAddr, other: SocketAddr, now: Time) -> bool {
        self.names(one.ip()) && self.names(other.ip()) && same.joins(one.ip(), other.ip(), now)
    }

    fn contest(&self, subject: Subject, counts: SocketAddr, refused: SocketAddr) -> Contest {
        let Subject { sensor, category, identity } = subject;
        let reason = ContestReason::OtherSender;
        Contest { sensor, source: self.source, category, counts, refused, reason, identity }
    }
}

fn is_within(now: Time, then: Time, span_ns: i64) -> bool {
    now.nanos().saturating_sub(then.nanos()) <= span_ns
}

#[cfg(test)]
mod tests;
