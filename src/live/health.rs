//! The state of each sensor: when it was last heard, its rate, its clock's offset, and what is wrong with it. Sans-IO.

use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};

use asterix::DataSource;
use asterix::cat063::{self, Connection};
use serde::{Deserialize, Serialize};

use super::contests::Contested;
use super::registration::RegistrationStatus;
use crate::config::Config;
use crate::names::known;
use crate::net::listen::LineCounters;
use crate::normalise::{Refusal, Service};
use crate::pipeline::{Event, Takeover};
use fusion::SensorIndex;
use fusion::learning::LearntType;
use fusion::report::TransponderType;
use fusion::time::{SECOND, Time};

/// A sensor that is silent for this long, nanoseconds, and for [`SILENT_PERIODS`] of its periods, has an outage.
const SILENT_NS: i64 = 5 * SECOND;
const SILENT_PERIODS: f64 = 3.0;
/// Time over which a rate is taken, nanoseconds.
const RATE_NS: i64 = 10 * SECOND;
/// Most reports that a rate is taken from; more come in that time only where the clock stands still.
const RECENT: usize = 1 << 17;
/// Latest delays that the clock offset is taken from, as their minimum: latency only adds.
const DELAYS: usize = 256;
/// Offset of a clock that is right, seconds: even the fastest report of a wrong one is early or late.
const CLOCK_EARLY_S: f64 = -0.2;
const CLOCK_LATE_S: f64 = 5.0;
/// A radar is displaced when it reports a position farther than this from the configured one, metres (I034/120 resolves
/// 2.4 m, and a metre of height).
const DISPLACED_M: u32 = 30;
/// Most unknown sources that are distinguished.
const UNKNOWN_KEPT: usize = 64;
/// A change of the sender of a sensor is a warning for this long, nanoseconds: long enough to be seen, and to look at the
/// sender.
const TAKEOVER_NS: i64 = 60 * SECOND;

/// State of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SensorState {
    /// It works.
    Operational,
    /// It works, and something is wrong.
    Degraded,
    /// Nothing comes, or nothing that may be used.
    Outage,
}

fusion::interface_names!(SensorState {
    Operational = "operational",
    Degraded = "degraded",
    Outage = "outage",
});

/// Status of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorStatus {
    /// Its id.
    pub id: String,
    /// Its state.
    pub state: SensorState,
    /// Why, where it is not operational.
    pub reasons: Vec<String>,
    /// The reception of its last record of any kind.
    pub last_seen: Option<Time>,
    /// Reports accepted since the start.
    pub accepted: u64,
    /// Reports per second, over the last 10 s.
    pub rate_hz: f64,
    /// Offset of its clock, seconds: the least delay of its latest reports, from their own time to their reception.
    pub clock_offset_s: Option<f64>,
    /// Refused records, by reason.
    #[serde(deserialize_with = "known")]
    pub refused: BTreeMap<&'static str, u64>,
    /// Senders that are refused because another one speaks for it.
    pub contested: Vec<Contested>,
    /// Whether it is heard.
    pub connected: bool,
    /// What it says of itself (CAT034).
    pub said: Service,
    /// Its registration, where it is a radar in the operational profile.
    pub registration: Option<RegistrationStatus>,
    /// What was learnt of the types of transponders that it hears.
    pub types: Vec<(TransponderType, LearntType)>,
    /// Its lines.
    pub lines: Vec<LineStatus>,
}

impl SensorStatus {
    /// As I063/060.
    pub fn item(&self) -> cat063::SensorStatus {
        let connection = match self.state {
            _ if !self.connected => Connection::NotConnected,
            SensorState::Operational => Connection::Operational,
            SensorState::Degraded | SensorState::Outage => Connection::Degraded,
        };
        let item = cat063::SensorStatus::default()
            .with_connection(connection)
            .with_psr_nogo(self.said.nogo == Some(true));
        // The second octet only where there is something to say.
        if self.said.time_invalid == Some(true) { item.with_time_invalid(true) } else { item }
    }
}

/// Status of a line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineStatus {
    /// Group or address, port and interface.
    pub name: String,
    /// Whether the socket is open and the group joined.
    pub joined: bool,
    /// Datagrams since the start.
    pub received: u64,
    /// Of these, copies of another line's.
    pub duplicates: u64,
    /// Datagrams from a source that is not configured.
    pub foreign: u64,
    /// Datagrams lost in the engine's queue.
    pub queue_full: u64,
    /// Datagrams lost in the kernel.
    pub kernel_dropped: u64,
    /// The last datagram.
    pub last_received: Option<Time>,
    /// What a translator at the door has dropped, by reason; empty where there is none.
    #[serde(deserialize_with = "known")]
    pub untranslated: Vec<(&'static str, u64)>,
}

/// A source that is heard and not configured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unknown {
    /// Category of its records.
    pub category: u8,
    /// Its SAC and SIC.
    pub source: DataSource,
    /// Whether that is the service's own: its output comes back.
    pub own: bool,
    /// Records since the start.
    pub records: u64,
    /// The last one.
    pub last_seen: Time,
}

impl LineStatus {
    /// The status that follows from its counters.
    pub fn of(name: String, counters: &LineCounters, duplicates: u64) -> Self {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let last = counters.last_received.load(Ordering::Relaxed);
        Self {
            name,
            joined: counters.joined.load(Ordering::Relaxed),
            received: count(&counters.received),
            duplicates,
            foreign: count(&counters.foreign),
            queue_full: count(&counters.queue_full),
            kernel_dropped: count(&counters.kernel_dropped),
            last_received: (last > 0).then(|| Time::from_nanos(last)),
            untranslated: counters.untranslated(),
        }
    }
}

/// Keeps the state of all sensors.
#[derive(Clone, Debug)]
pub struct Health {
    sensors: Vec<Sensor>,
    unknown: BTreeMap<(u8, DataSource), (u64, Time)>,
    own: DataSource,
    started: Time,
    /// Reports that are later than this are of no use for the picture, seconds.
    late_s: f64,
}

#[derive(Clone, Debug)]
struct Sensor {
    id: String,
    period_s: f64,
    last_seen: Option<Time>,
    accepted: u64,
    /// Reception of the latest accepted report, and why a later one was refused for its time.
    taken: Option<Time>,
    untimely: Option<Refusal>,
    /// Receptions of the last reports.
    recent: VecDeque<Time>,
    /// Receptions of the latest reports, and from each report's own time to its reception, nanoseconds.
    delays_ns: VecDeque<(Time, i64)>,
    refused: BTreeMap<&'static str, u64>,
    service: Service,
    /// The sender of the last message that says NOGO.
    nogo_from: Option<SocketAddr>,
    /// The last change of its sender, and when.
    takeover: Option<(Takeover, Time)>,
    restarted: Option<Time>,
    /// Peak of a flood of new identities, per second, while it lasts.
    flood: Option<u32>,
    /// Most new identities admitted, per second.
    max_new_per_s: u32,
}

impl Health {
    /// Nothing heard yet.
    pub fn new(config: &Config, started: Time) -> Self {
        let sensor = |sensor: &crate::config::Sensor| Sensor {
            id: sensor.id.clone(),
            period_s: sensor.period_s.unwrap_or(sensor.kind.usual_period_s()),
            last_seen: None,
            accepted: 0,
            taken: None,
            untimely: None,
            recent: VecDeque::new(),
            delays_ns: VecDeque::new(),
            refused: BTreeMap::new(),
            service: Service::default(),
            nogo_from: None,
            takeover: None,
            restarted: None,
            flood: None,
            max_new_per_s: sensor.kind.receiver().map_or(0, |receiver| receiver.max_new_per_s),
        };
        Self {
            sensors: config.sensors.iter().map(sensor).collect(),
            unknown: BTreeMap::new(),
            own: DataSource { sac: config.site.sac, sic: config.site.sic },
            started,
            late_s: config.fusion.latency().as_secs_f64().max(CLOCK_LATE_S),
        }
    }

    /// Notes what became of a record received at `now`.
    pub fn note(&mut self, event: &Event, now: Time) {
        match *event {
            // A sensor is as well as it is, wherever its aircraft are.
            Event::Accepted { sensor, report }
            | Event::Elsewhere { sensor, report }
            | Event::Shed { sensor, report } => {
                let sensor = self.heard(sensor, now);
                sensor.accepted += 1;
                (sensor.taken, sensor.untimely) = (Some(now), None);
                sensor.recent.push_back(now);
                if sensor.delays_ns.len() == DELAYS {
                    sensor.delays_ns.pop_front();
                }
                sensor.delays_ns.push_back((now, now.nanos() - report.time().nanos()));
                sensor.forget(now);
            }
            Event::Refused { refusal: Refusal::UnknownSource { category, source }, .. }
                if self.unknown.len() < UNKNOWN_KEPT || self.unknown.contains_key(&(category, source)) =>
            {
                let (records, last_seen) = self.unknown.entry((category, source)).or_insert((0, now));
                (*records, *last_seen) = (*records + 1, now);
            }
            // A sender that does not speak for the sensor is no sign of life of it.
            Event::Refused {
                sensor: Some(sensor),
                refusal: refusal @ (Refusal::OtherSender | Refusal::ForeignSource),
            } => {
                let sensor = &mut self.sensors[usize::from(sensor.0)];
                *sensor.refused.entry(refusal.name()).or_default() += 1;
            }
            Event::Refused { sensor: Some(sensor), refusal, .. } => {
                let sensor = self.heard(sensor, now);
                *sensor.refused.entry(refusal.name()).or_default() += 1;
                if matches!(refusal, Refusal::Late | Refusal::Future) {
                    sensor.untimely = Some(refusal);
                }
            }
            Event::Service { sensor, service, from } => self.heard(sensor, now).serve(service, from, now),
            Event::TookOver(takeover) => {
                let sensor = &mut self.sensors[usize::from(takeover.sensor.0)];
                // The former sender's statements about itself do not hold for another one.
                (sensor.service, sensor.nogo_from) = (Service::default(), None);
                sensor.takeover = Some((takeover, now));
            }
            Event::Newcomers(newcomers) => {
                self.sensors[usize::from(newcomers.sensor.0)].flood = newcomers.flood;
            }
            Event::Restarted => {
                // The clock may have been set back: nothing was heard in the future.
                self.started = self.started.min(now);
                self.sensors.iter_mut().for_each(|sensor| sensor.start_afresh(now));
                self.unknown.values_mut().for_each(|(_, last_seen)| *last_seen = now.min(*last_seen));
            }
            _ => {}
        }
    }

    fn heard(&mut self, sensor: SensorIndex, now: Time) -> &mut Sensor {
        let sensor = &mut self.sensors[usize::from(sensor.0)];
        sensor.last_seen = Some(now);
        sensor
    }

    /// The sensors at `now`, each with its lines; their registration and rival senders are noted elsewhere.
    pub fn sensors(&self, now: Time, lines: impl Fn(usize) -> Vec<LineStatus>) -> Vec<SensorStatus> {
        let of = |(index, sensor): (usize, &Sensor)| sensor.status(now, self.started, lines(index));
        self.sensors.iter().enumerate().map(of).collect()
    }

    /// The error where nothing that any sensor reports at `now` can be used for its time: most likely this machine's
    /// clock. `None`: a sensor is used, or none is received.
    pub fn wrong_clock(&self, now: Time) -> Option<String> {
        let is_received = |sensor: &&Sensor| {
            sensor.last_seen.is_some_and(|last| now.nanos() - last.nanos() <= sensor.allowed_ns())
        };
        let mut received = self.sensors.iter().filter(is_received).peekable();
        received.peek()?;
        let is_old = |sensor: &Sensor| sensor.clock_offset_s().is_some_and(|offset_s| offset_s > self.late_s);
        let wrong = received.map(|sensor| {
            sensor.untimely(now, self.started).or_else(|| is_old(sensor).then_some(Refusal::Late))
        });
        let wrong: Option<Vec<Refusal>> = wrong.collect();
        let wrong = match &wrong?[..] {
            all if all.iter().all(|refusal| *refusal == Refusal::Late) => "too old",
            all if all.iter().all(|refusal| *refusal == Refusal::Future) => "ahead of it",
            _ => "too old or ahead of it",
        };
        Some(format!("the clock of this machine seems wrong: the times of all sensors are {wrong}"))
    }

    /// The sources that are heard and not configured.
    pub fn unknown(&self) -> Vec<Unknown> {
        let one = |(&(category, source), &(records, last_seen)): (&(u8, DataSource), &(u64, Time))| Unknown {
            category,
            source,
            own: source == self.own,
            records,
            last_seen,
        };
        self.unknown.iter().map(one).collect()
    }
}

impl Sensor {
    /// An absent item keeps its earlier value.
    fn serve(&mut self, said: Service, from: Option<SocketAddr>, now: Time) {
        if said.nogo == Some(true) {
            self.nogo_from = from;
        }
        let Service { nogo, reset, time_invalid, displaced_m, .. } = said;
        if reset == Some(true) && self.service.reset != Some(true) {
            self.restarted = Some(now);
        }
        self.service.nogo = nogo.or(self.service.nogo);
        self.service.reset = reset.or(self.service.reset);
        self.service.time_invalid = time_invalid.or(self.service.time_invalid);
        self.service.displaced_m = displaced_m.or(self.service.displaced_m);
    }

    fn forget(&mut self, now: Time) {
        let is_old = |time: &Time| now.nanos() - time.nanos() > RATE_NS;
        while self.recent.front().is_some_and(is_old) || self.recent.len() > RECENT {
            self.recent.pop_front();
        }
        // Older delays would hide a step of the clock.
        while self.delays_ns.len() > 1 && self.delays_ns.front().is_some_and(|(received, _)| is_old(received))
        {
            self.delays_ns.pop_front();
        }
    }

    /// The engine starts afresh at `now`, which may be earlier than times that were noted.
    fn start_afresh(&mut self, now: Time) {
        // New identities that waited to be let in are forgotten.
        self.flood = None;
        for time in [&mut self.last_seen, &mut self.taken, &mut self.restarted].into_iter().flatten() {
            *time = now.min(*time);
        }
        self.recent.retain(|&time| time <= now);
        self.delays_ns.clear();
    }

    /// Longest silence that is none, nanoseconds.
    fn allowed_ns(&self) -> i64 {
        SILENT_NS.max((SILENT_PERIODS * self.period_s * SECOND as f64) as i64)
    }

    /// Offset of its clock, seconds.
    fn clock_offset_s(&self) -> Option<f64> {
        self.delays_ns.iter().map(|&(_, delay)| delay).min().map(|delay| delay as f64 * 1e-9)
    }

    /// Why nothing of it is used, where that is for its times.
    fn untimely(&self, now: Time, started: Time) -> Option<Refusal> {
        let untaken_ns = now.nanos() - self.taken.unwrap_or(started).nanos();
        self.untimely.filter(|_| untaken_ns > self.allowed_ns())
    }

    fn status(&self, now: Time, started: Time, lines: Vec<LineStatus>) -> SensorStatus {
        let mut state = SensorState::Operational;
        let mut reasons = Vec::new();
        let mut find = |worse: SensorState, reason: String| {
            state = state.max(worse);
            reasons.push(reason);
        };
        let silent_ns = now.nanos() - self.last_seen.unwrap_or(started).nanos();
        let allowed_ns = self.allowed_ns();
        if silent_ns > allowed_ns {
            let ever = if self.last_seen.is_some() { "" } else { " since the start" };
            find(SensorState::Outage, format!("nothing received for {} s{ever}", silent_ns / SECOND));
        } else if self.last_seen.is_none() {
            find(SensorState::Outage, "nothing received yet".to_owned());
        }
        if !lines.is_empty() && !lines.iter().any(|line| line.joined) {
            find(SensorState::Outage, "no line is open".to_owned());
        }
        for line in lines.iter().filter(|line| !line.joined) {
            find(SensorState::Degraded, format!("line {} is not open", line.name));
        }
        if self.service.nogo == Some(true) {
            let from = self.nogo_from.map(|from| format!(" from {from}")).unwrap_or_default();
            find(
                SensorState::Outage,
                format!("it says that its data must not be used (NOGO in I034/050{from})"),
            );
        }
        if let Some((Takeover { before, after, .. }, at)) = self.takeover
            && now.nanos() - at.nanos() < TAKEOVER_NS
        {
            find(
                SensorState::Degraded,
                format!("{after} speaks for it in place of {before}, which had fallen silent"),
            );
        }
        if self.service.time_invalid == Some(true) {
            find(SensorState::Degraded, "its time source is invalid (TSV in I034/050)".to_owned());
        }
        if self.restarted.is_some_and(|at| now.nanos() - at.nanos() < 30 * SECOND) {
            find(SensorState::Degraded, "its processor restarted (RDPR in I034/050)".to_owned());
        }
        if let Some(metres) = self.service.displaced_m.filter(|&metres| metres > DISPLACED_M) {
            find(
                SensorState::Degraded,
                format!("it says that it stands {metres} m from its configured place (I034/120)"),
            );
        }
        if let Some(refusal) = self.untimely(now, started) {
            let wrong =
                if refusal == Refusal::Late { "older than the window" } else { "ahead of this machine's" };
            find(
                SensorState::Degraded,
                format!("nothing of it is used: its times are {wrong}, so one of the clocks is wrong"),
            );
        }
        if let Some(most) = self.flood {
            let max = self.max_new_per_s;
            find(
                SensorState::Degraded,
                format!(
                    "a flood of new identities, up to {most} a second: those that are heard once are not used, and of the \
                     others at most {max} a second are let in (max_new_per_s)"
                ),
            );
        }
        let clock_offset_s = self.clock_offset_s();
        if let Some(offset_s) =
            clock_offset_s.filter(|offset| !(CLOCK_EARLY_S..=CLOCK_LATE_S).contains(offset))
        {
            let wrong = if offset_s < 0.0 { "ahead" } else { "behind" };
            find(SensorState::Degraded, format!("its clock is {:.1} s {wrong}", offset_s.abs()));
        }
        let recent = self.recent.iter().filter(|time| now.nanos() - time.nanos() <= RATE_NS).count();
        let over_s = (now.nanos() - started.nanos()).clamp(SECOND, RATE_NS) as f64 * 1e-9;
        SensorStatus {
            id: self.id.clone(),
            state,
            reasons,
            last_seen: self.last_seen,
            accepted: self.accepted,
            rate_hz: recent as f64 / over_s,
            clock_offset_s,
            refused: self.refused.clone(),
            contested: Vec::new(),
            connected: self.last_seen.is_some() && silent_ns <= allowed_ns,
            said: self.service,
            registration: None,
            types: Vec::new(),
            lines,
        }
    }
}
