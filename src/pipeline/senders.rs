//! Which sender speaks for a sensor. Sans-IO.
//!
//! A sender is an address with its port, since two programs on one machine differ in nothing else. But
//! * a port that is younger than 2 s stands for its host: some senders take a new port for each datagram;
//! * all ports of a host that a sensor's `source` names are one sender: the operator vouches for it.
//!
//! Where an input of a sensor names a `source`, only the hosts that its inputs name may speak for it, on whatever line they
//! are received. Two named hosts that bring the same datagrams are redundant lines and complete each other.
//!
//! Without a `source` nothing proves who a sender is, and a copy of a datagram is easily made: so the sender that was heard
//! first counts while it speaks. Another one that brings the same datagrams costs nothing and takes over when the first is
//! silent. As soon as it brings a datagram that the first does not bring it is a rival: refused, and named.

mod ports;
mod rivals;

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use asterix::{DataSource, Record, cat034, cat048};
use serde::{Deserialize, Serialize};

use crate::config::{Config, ConnectionFormat, Sensor};
use fusion::time::{SECOND, Time};
use fusion::{Identity, SensorIndex};
use ports::Ports;
use rivals::{Rival, Rivals};

/// A sender that is silent for this long, nanoseconds, and for [`SILENT_PERIODS`] of the sensor's periods, speaks no longer.
const SILENT_NS: i64 = 3 * SECOND;
const SILENT_PERIODS: f64 = 3.0;
/// Two senders of a radar contradict each other when the first has spoken for this long since the second brought a datagram of
/// its own, nanoseconds: a first one that has fallen silent is replaced, not contradicted. A transponder reports every 2 s or
/// so: there the first one's next report is enough.
const CONTESTED_NS: i64 = SECOND;
/// A contest is over when the refused sender has brought nothing of its own for this long, and for [`SILENT_PERIODS`],
/// nanoseconds.
const OVER_NS: i64 = 5 * SECOND;
/// Hosts that bring the same datagrams are redundant lines for this long, nanoseconds.
const REMEMBERED_NS: i64 = 60 * SECOND;
/// Most hosts of each sensor that are refused for its `source` and distinguished.
const STRANGERS: usize = 8;

/// What one sender speaks of at a time: a radar's plots, a radar's service messages, or one transponder. Receivers share
/// SAC/SIC 0/0, and drones may send for themselves: so transponders are judged one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct Subject {
    pub(super) sensor: SensorIndex,
    pub(super) category: u8,
    /// The transponder; `None` of a radar.
    pub(super) identity: Option<Identity>,
}

impl Subject {
    /// A radar's service messages beside its plots, and the reverse.
    fn peer(self) -> Option<Self> {
        let category = match self.category {
            cat034::Record::CATEGORY => cat048::Record::CATEGORY,
            cat048::Record::CATEGORY => cat034::Record::CATEGORY,
            _ => return None,
        };
        Some(Self { category, ..self })
    }
}

/// Why a sender is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ContestReason {
    /// Another sender speaks for the sensor.
    OtherSender,
    /// Its host is not one that the sensor's inputs name as `source`.
    ForeignSource,
}

fusion::interface_names!(ContestReason { OtherSender = "other_sender", ForeignSource = "foreign_source" });

/// Two senders under one SAC/SIC, of which one is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contest {
    /// The sensor.
    pub sensor: SensorIndex,
    /// Its SAC and SIC.
    pub source: DataSource,
    /// The category of what the refused one sends; 0 for Remote ID.
    pub category: u8,
    /// The sender that counts; with port 0 the host that `source` names.
    pub counts: SocketAddr,
    /// The sender that is refused.
    pub refused: SocketAddr,
    /// Why it is refused.
    pub reason: ContestReason,
    /// The transponder that both report; `None` where they speak for a radar.
    pub identity: Option<Identity>,
}

/// A sender has taken the place of another one, which had fallen silent, for a radar or a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Takeover {
    /// The sensor.
    pub sensor: SensorIndex,
    /// Its SAC and SIC.
    pub source: DataSource,
    /// The sender that spoke for it before.
    pub before: SocketAddr,
    /// The sender that speaks for it now.
    pub after: SocketAddr,
}

/// The verdict on a sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    /// It counts; whose place it has taken with this record.
    Counts(Option<Takeover>),
    /// Another sender speaks for this sensor.
    Refused,
}

/// A datagram that was refused from one sender before it came from another: that sender, and when.
pub(super) type Earlier = (SocketAddr, Time);

/// The rule for a sensor.
#[derive(Clone, Debug)]
struct Rule {
    source: DataSource,
    period_ns: i64,
    /// The hosts that its inputs name. Empty: any host may speak for it.
    sources: Vec<IpAddr>,
    /// Senders of its connections, which may speak for it beside these.
    connections: Vec<SocketAddr>,
}

/// The senders that have spoken of a subject.
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

/// Pairs of hosts that have brought the same datagram, and when they did last; only hosts that a `source` names.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Same(BTreeMap<(IpAddr, IpAddr), Time>);

impl Same {
    fn note(&mut self, one: IpAddr, other: IpAddr, now: Time) {
        if one != other {
            self.0.insert((one.min(other), one.max(other)), now);
        }
    }

    /// Whether both have, or both have brought what a third has.
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

/// Judges which sender speaks for which sensor.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Senders {
    /// Of the configuration: no checkpoint has them.
    #[serde(skip)]
    rules: Vec<Rule>,
    heard: BTreeMap<Subject, Heard>,
    strangers: BTreeMap<(SensorIndex, IpAddr), Stranger>,
    ports: Ports,
    same: Same,
    tidied: Time,
}

impl Senders {
    /// No sender heard yet.
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

    /// No sender heard yet, by the same rules.
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

    /// The rules of this configuration with the senders that were heard before.
    pub(super) fn going_on(self, before: Self) -> Self {
        Self { rules: self.rules, ..before }
    }

    /// A datagram has come from this address; `now` never decreases. Returns the contests that are to be reported, each once.
    pub(super) fn hear(&mut self, from: SocketAddr, now: Time) -> Vec<Contest> {
        let contests = self.tidy(now);
        self.ports.hear(from, now);
        contests
    }

    /// Both have brought the same datagram, which holds reports: they are redundant lines, if `source` names both.
    pub(super) fn bring_the_same(&mut self, one: IpAddr, other: IpAddr, now: Time) {
        if self.rules.iter().any(|rule| rule.names(one) && rule.names(other)) {
            self.same.note(one, other, now);
        }
    }

    /// Whether a sender may speak for the sensor at all; otherwise the contest, where it is to be reported.
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

    /// Whether what this sender says of the subject counts. `earlier`: senders from which the same datagram was refused.
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
        // A radar's plots and service messages may come from several ports, and from several hosts only where `source` names them.
        let peer = subject.peer().and_then(|peer| Some((peer, heard.get(&peer)?)));
        let is_of_peer =
            |owner: SocketAddr| owner.ip() == from.ip() || (rule.names(owner.ip()) && rule.names(from.ip()));
        if let Some((peer, _)) = peer.filter(|(_, heard)| speaks(heard) && !is_of_peer(heard.owner)) {
            return self.refuse(peer, from, now);
        }
        // A redundant line whose copies come first is no news while the other one is still received.
        let is_gone = |owner| {
            !rule.are_redundant(same, owner, from, now)
                || ports.last(owner).is_none_or(|last| !is_within(now, last, rule.silence_ns()))
        };
        let is_known = peer.is_some_and(|(_, heard)| speaks(heard) && rule.are_one(ports, heard.owner, from));
        let before = own.map(|own| own.owner).filter(|&owner| {
            // A sender that restarts on its own host has another port.
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
            // A radar with nothing in sight still speaks of itself.
            self.still_speaks(peer, from, now);
            self.excuse(peer, from, earlier);
        }
        Judged::Counts(takeover)
    }

    /// A record of the subject was not taken for another reason; its sender speaks all the same.
    pub(super) fn still_speaks(&mut self, subject: Subject, from: SocketAddr, now: Time) {
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

    /// The contest of a sender that is refused because of `source`, with the sender that speaks for the sensor.
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
            // One that takes a new port for each datagram is one rival.
            heard.rivals.refuse(from, now, rule.over_ns(), |known| rule.are_one(ports, known, from));
        }
        Judged::Refused
    }

    /// The owner has brought a datagram that was refused from others before: they have brought nothing of their own with it.
    fn excuse(&mut self, subject: Subject, from: SocketAddr, earlier: &[Earlier]) {
        let Self { heard, ports, rules, .. } = self;
        let rule = &rules[usize::from(subject.sensor.0)];
        if let Some(heard) = heard.get_mut(&subject).filter(|heard| rule.are_one(ports, heard.owner, from)) {
            earlier.iter().for_each(|&(rival, at)| heard.rivals.excuse(rival, at));
        }
    }

    /// Forgets what is over, once a second, and returns the contests that are to be reported.
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
            // The last sender of a radar is remembered, so that a takeover is known however long the silence.
            subject.identity.is_none() || is_within(now, heard.last, rule.silence_ns())
        });
        // The same two senders may contest many transponders: that is reported once.
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
    /// Whether a rival has lately brought a datagram of its own while the owner spoke on.
    fn is_contested(&self, subject: &Subject, rival: &Rival, rule: &Rule, now: Time) -> bool {
        let least_ns = if subject.identity.is_some() { 1 } else { CONTESTED_NS };
        let own = rival.own(now, rule.over_ns());
        own.is_some_and(|first| self.last.nanos() - first.nanos() >= least_ns)
    }
}

impl Rule {
    fn new(sensor: &Sensor) -> Self {
        // A connection's datagrams bear the address that it was made to, or that of no host where a broker is between.
        let sender = |connection: &crate::config::Connection| match connection.format {
            ConnectionFormat::Beast | ConnectionFormat::Avr | ConnectionFormat::Asterix => {
                connection.socket().map(SocketAddr::V4)
            }
            ConnectionFormat::Mqtt => {
                connection.broker().map(|broker| (Ipv4Addr::UNSPECIFIED, broker.port).into())
            }
            ConnectionFormat::Http | ConnectionFormat::Mavlink => None,
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

    /// Whether two addresses are one sender; `known` was heard earlier.
    fn are_one(&self, ports: &Ports, known: SocketAddr, from: SocketAddr) -> bool {
        let is_of_its_host = || self.names(from.ip()) || !ports.is_steady(known);
        known == from || (known.ip() == from.ip() && is_of_its_host())
    }

    /// Whether two addresses are redundant lines of the sensor: the operator names both, and they bring the same.
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
