//! State of each sensor: last reception, report rate, clock offset, and faults. Sans-IO.

use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};

use asterix::DataSource;
use asterix::cat063::{self, Connection};
use serde::{Deserialize, Serialize};

use super::contests::Contested;
use super::registration::RegistrationStatus;
use crate::net::listen::LineCounters;
use fusion::SensorIndex;
use fusion::learning::LearntType;
use fusion::operational::OrientedCamera;
use fusion::report::TransponderType;
use fusion::time::{SECOND, Time};
use input::names::known;
use input::normalise::{Refusal, Service};
use input::pipeline::{Event, Takeover};
use site::config::Config;

/// A sensor has an outage when it has been silent for this time, in nanoseconds, and for [`SILENT_PERIODS`] of its periods.
const SILENT_NS: i64 = 5 * SECOND;
const SILENT_PERIODS: f64 = 3.0;
/// Reason of a sensor that has sent nothing since the start, and is not silent long enough for an outage.
const AWAITED: &str = "nothing received yet";
/// Reason of a radar whose tracks contradict its position.
const MISPLACED: &str = "its tracks contradict its position";
/// Averaging time of a report rate, in nanoseconds.
const RATE_NS: i64 = 10 * SECOND;
/// Maximum number of reports for a rate; exceeded only if the clock stands still.
const RECENT: usize = 1 << 17;
/// Number of latest delays of which the minimum is the clock offset: latency only adds to the offset.
const DELAYS: usize = 256;
/// Range of the offset of a correct clock, in seconds. With a wrong clock even the fastest report is outside it.
const CLOCK_EARLY_S: f64 = -0.2;
const CLOCK_LATE_S: f64 = 5.0;
/// A radar counts as displaced if it reports a position farther than this from the configured one, in metres. I034/120
/// resolves 2.4 m, and 1 m of height.
const DISPLACED_M: u32 = 30;
/// Maximum number of unknown sources that are distinguished.
const UNKNOWN_KEPT: usize = 64;
/// Time for which a radar is degraded after tracks were discarded because their numbers jump, in nanoseconds.
const JUMPING_NS: i64 = 10 * SECOND;
/// Time for which a change of a sensor's sender is reported as a warning, in nanoseconds: long enough for an operator to
/// notice and to check the sender.
const TAKEOVER_NS: i64 = 60 * SECOND;

/// State of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SensorState {
    /// The sensor works.
    Operational,
    /// The sensor works, with a fault.
    Degraded,
    /// No usable data is received from the sensor.
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
    /// Id of the sensor.
    pub id: String,
    /// State of the sensor.
    pub state: SensorState,
    /// Reasons, if it is not operational.
    pub reasons: Vec<String>,
    /// Time of reception of its last record of any kind.
    pub last_seen: Option<Time>,
    /// Reports accepted since the start.
    pub accepted: u64,
    /// Reports per second, over the last 10 s.
    pub rate_hz: f64,
    /// Offset of its clock, in seconds: the smallest delay among its latest reports, from their time stamp to their
    /// reception.
    pub clock_offset_s: Option<f64>,
    /// Rejected records, by reason.
    #[serde(deserialize_with = "known")]
    pub refused: BTreeMap<&'static str, u64>,
    /// Senders that are rejected because another sender is accepted for this sensor.
    pub contested: Vec<Contested>,
    /// Whether data from the sensor is received.
    pub connected: bool,
    /// State that the sensor reports of itself (CAT034).
    pub said: Service,
    /// Registration, if the sensor is a radar in the operational profile.
    pub registration: Option<RegistrationStatus>,
    /// Orientation, if the sensor is a camera that has sent bearings.
    pub orientation: Option<OrientedCamera>,
    /// Learned errors of the types of transponders that the sensor receives.
    pub types: Vec<(TransponderType, LearntType)>,
    /// Lines of the sensor.
    pub lines: Vec<LineStatus>,
}

impl SensorStatus {
    /// Whether the sensor has no fault but that its first data is awaited after the start.
    pub fn is_awaited(&self) -> bool {
        self.state == SensorState::Degraded && self.reasons == [AWAITED]
    }

    /// Adds the registration. A radar that stands elsewhere than configured shows drones at wrong places.
    pub(super) fn note_registration(&mut self, registration: Option<RegistrationStatus>) {
        let is_misplaced = registration
            .as_ref()
            .is_some_and(|status| status.place.as_ref().is_some_and(|place| place.contradicts));
        if is_misplaced {
            self.state = self.state.max(SensorState::Degraded);
            self.reasons.push(MISPLACED.to_owned());
        }
        self.registration = registration;
    }

    /// The status as I063/060.
    pub fn item(&self) -> cat063::SensorStatus {
        let connection = match self.state {
            _ if !self.connected => Connection::NotConnected,
            SensorState::Operational => Connection::Operational,
            SensorState::Degraded | SensorState::Outage => Connection::Degraded,
        };
        let item = cat063::SensorStatus::default()
            .with_connection(connection)
            .with_psr_nogo(self.said.nogo == Some(true));
        // The second octet is sent only if it has content.
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
    /// Datagrams received since the start.
    pub received: u64,
    /// Datagrams among them that were copies of another line's.
    pub duplicates: u64,
    /// Datagrams from a source that is not configured.
    pub foreign: u64,
    /// Datagrams lost because the engine's queue was full.
    pub queue_full: u64,
    /// Datagrams lost in the kernel.
    pub kernel_dropped: u64,
    /// Time of the last datagram.
    pub last_received: Option<Time>,
    /// Number of items that the line's translator dropped, by reason; empty if the line has no translator.
    #[serde(deserialize_with = "known")]
    pub untranslated: Vec<(&'static str, u64)>,
}

/// A source that is received but not configured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnconfiguredSource {
    /// Category of its records.
    pub category: u8,
    /// SAC and SIC.
    pub source: DataSource,
    /// Whether it is the service's own source: its output comes back.
    pub own: bool,
    /// Records received since the start.
    pub records: u64,
    /// Time of the last record.
    pub last_seen: Time,
}

impl LineStatus {
    /// Derives the status from the line's counters.
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

/// State of all sensors.
#[derive(Clone, Debug)]
pub struct SensorMonitor {
    sensors: Vec<MonitoredSensor>,
    unknown: BTreeMap<(u8, DataSource), (u64, Time)>,
    own: DataSource,
    /// Start; `Time::default()` until a recording's first time of reception is known.
    started: Time,
    /// Maximum age of reports that are useful for the picture, in seconds.
    late_s: f64,
}

#[derive(Clone, Debug)]
struct MonitoredSensor {
    id: String,
    period_s: f64,
    last_seen: Option<Time>,
    accepted: u64,
    /// Reception of the latest accepted report, and the reason if a later one was rejected for its time.
    taken: Option<Time>,
    untimely: Option<Refusal>,
    /// Receptions of the last reports.
    recent: VecDeque<Time>,
    /// Reception of each of the latest reports, with its delay from time stamp to reception, in nanoseconds.
    delays_ns: VecDeque<(Time, i64)>,
    refused: BTreeMap<&'static str, u64>,
    service: Service,
    /// Sender of the last message with NOGO set.
    nogo_from: Option<SocketAddr>,
    /// Last change of the sender, with its time.
    takeover: Option<(Takeover, Time)>,
    restarted: Option<Time>,
    /// Peak rate of a flood of new identities, per second, while it lasts.
    flood: Option<u32>,
    /// Last time when tracks were discarded because their numbers jump.
    jumping: Option<Time>,
    /// Maximum rate of admitted new identities, per second.
    max_new_per_s: u32,
}

impl SensorMonitor {
    /// Starts without receptions.
    pub fn new(config: &Config, started: Time) -> Self {
        let sensor = |sensor: &site::config::Sensor| MonitoredSensor {
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
            jumping: None,
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

    /// States the present time. It is the start if that was not known.
    pub fn begin(&mut self, now: Time) {
        if self.started == Time::default() {
            self.started = now;
        }
    }

    /// Records an event about a record received at `now`.
    pub fn note(&mut self, event: &Event, now: Time) {
        match *event {
            // Reports from outside the area also show that the sensor works.
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
            // A record from a rejected sender does not show that the sensor works.
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
                // The former sender's state does not apply to the new one.
                (sensor.service, sensor.nogo_from) = (Service::default(), None);
                sensor.takeover = Some((takeover, now));
            }
            Event::Newcomers(newcomers) => {
                self.sensors[usize::from(newcomers.sensor.0)].flood = newcomers.flood;
            }
            Event::JumpingTracks(jumping) => {
                self.sensors[usize::from(jumping.sensor.0)].jumping = Some(now);
            }
            Event::Restarted => {
                // The clock may have been set back: no reception may lie in the future.
                self.started = self.started.min(now);
                self.sensors.iter_mut().for_each(|sensor| sensor.start_afresh(now));
                self.unknown.values_mut().for_each(|(_, last_seen)| *last_seen = now.min(*last_seen));
            }
            _ => {}
        }
    }

    fn heard(&mut self, sensor: SensorIndex, now: Time) -> &mut MonitoredSensor {
        let sensor = &mut self.sensors[usize::from(sensor.0)];
        sensor.last_seen = Some(now);
        sensor
    }

    /// Status of the sensors at `now`, each with its lines. Registration and rival senders are added by the caller.
    pub fn sensors(&self, now: Time, lines: impl Fn(usize) -> Vec<LineStatus>) -> Vec<SensorStatus> {
        let of = |(index, sensor): (usize, &MonitoredSensor)| sensor.status(now, self.started, lines(index));
        self.sensors.iter().enumerate().map(of).collect()
    }

    /// Error text if none of the sensors received at `now` has usable times: most likely this machine's clock is wrong.
    /// `None`: a sensor is used, or none is received.
    pub fn wrong_clock(&self, now: Time) -> Option<String> {
        let is_received = |sensor: &&MonitoredSensor| {
            sensor.last_seen.is_some_and(|last| now.nanos() - last.nanos() <= sensor.allowed_ns())
        };
        let mut received = self.sensors.iter().filter(is_received).peekable();
        received.peek()?;
        let is_old =
            |sensor: &MonitoredSensor| sensor.clock_offset_s().is_some_and(|offset_s| offset_s > self.late_s);
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

    /// Sources that are received but not configured.
    pub fn unknown(&self) -> Vec<UnconfiguredSource> {
        let one = |(&(category, source), &(records, last_seen)): (&(u8, DataSource), &(u64, Time))| {
            UnconfiguredSource { category, source, own: source == self.own, records, last_seen }
        };
        self.unknown.iter().map(one).collect()
    }
}

impl MonitoredSensor {
    /// Takes the state that the sensor reports. An absent item keeps its earlier value.
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

    /// Adapts to a restart of the engine at `now`, which may be earlier than recorded times.
    fn start_afresh(&mut self, now: Time) {
        // New identities that waited for admission are dropped.
        self.flood = None;
        let times = [&mut self.last_seen, &mut self.taken, &mut self.restarted, &mut self.jumping];
        for time in times.into_iter().flatten() {
            *time = now.min(*time);
        }
        self.recent.retain(|&time| time <= now);
        self.delays_ns.clear();
    }

    /// Longest silence that is not an outage, in nanoseconds.
    fn allowed_ns(&self) -> i64 {
        SILENT_NS.max((SILENT_PERIODS * self.period_s * SECOND as f64) as i64)
    }

    /// Offset of the sensor's clock, in seconds.
    fn clock_offset_s(&self) -> Option<f64> {
        self.delays_ns.iter().map(|&(_, delay)| delay).min().map(|delay| delay as f64 * 1e-9)
    }

    /// Reason for which no report is used, if it is their times.
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
            find(SensorState::Degraded, AWAITED.to_owned());
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
        if self.jumping.is_some_and(|at| now.nanos() - at.nanos() < JUMPING_NS) {
            find(
                SensorState::Degraded,
                "its track numbers jump: the tracks that they begin far from the last plot are discarded"
                    .to_owned(),
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
            orientation: None,
            types: Vec::new(),
            lines,
        }
    }
}

#[cfg(test)]
mod tests;
