//! The engine of the `reference` profile: told the time and the reports, it yields every slot once.
//!
//! Sans-IO: no clock, no socket, no randomness. [`Engine::advance`] first, drained; then [`Engine::handle`].

use std::collections::BTreeMap;

use super::association::{Evidence, Pairs};
use super::numbering::{Given, Numbered, Numbers};
use super::radar::{Detection, Detections};
use super::settings::Settings;
use super::slots::{Slot, SlotSet, Window};
use super::transponder::Curve;
use crate::normalise::{Enu, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, UasItems};
use crate::time::Time;

/// The one owner of the window.
#[derive(Debug)]
pub struct Engine {
    settings: Settings,
    clock: Option<Clock>,
    /// The newest slot that holds a report since the window was last empty.
    newest: Option<Slot>,
    detections: Detections,
    aircraft: BTreeMap<Identity, Aircraft>,
    numbers: Numbers,
    /// Points left out because no transponder number was left.
    unnumbered: u64,
}

#[derive(Clone, Copy, Debug)]
struct Clock {
    /// The latest time told, by a reception or a tick.
    now: Time,
    /// The latest reception.
    received: Time,
    /// The slot to be emitted next.
    next: Slot,
}

#[derive(Debug)]
struct Aircraft {
    curve: Curve,
    pairs: Pairs,
    items: UasItems,
    sensor: SensorIndex,
    /// Given with the first point in an emitted slot.
    numbered: Option<Numbered>,
}

/// Everything put out for one slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// The slot.
    pub slot: Slot,
    /// Its centre, the time of applicability.
    pub time: Time,
    /// Fused, then radar, then transponder; each by track number, equal numbers by sensor.
    pub points: Vec<Point>,
}

/// One output point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Track number: T · 10000 + R, R or T.
    pub number: u32,
    /// Position; its height is an assumed one where [`Source::height_measured`] is false.
    pub position: Enu,
    /// Centre of the first slot that was emitted with this radar track or, where it takes part, this transponder.
    pub first_seen: Time,
    /// What it is made of.
    pub source: Source,
}

/// What a point is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// An associated pair.
    Fused(RadarPart, TransponderPart, Association),
    /// A radar track that no transponder explains.
    Radar(RadarPart),
    /// A transponder that no radar track confirms.
    Transponder(TransponderPart),
}

/// The radar's part in a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarPart {
    /// The radar track.
    pub track: RadarTrackKey,
    /// Time of the plot.
    pub time: Time,
    /// Whether the radar measured a height.
    pub height_measured: bool,
    /// Probability that it is a UAV; `None` unknown.
    pub uav_probability: Option<f64>,
}

/// The transponder's part in a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransponderPart {
    /// Its number T.
    pub number: u32,
    /// Who it is.
    pub identity: Identity,
    /// The sensor that received it last.
    pub sensor: SensorIndex,
    /// Its identifying items as last received.
    pub items: UasItems,
}

/// Why a pair was fused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Association {
    /// Distance between the two, metres (horizontal where the radar measured no height).
    pub distance_m: f64,
    /// The threshold it had to stay within, metres.
    pub gate_m: f64,
    /// How often it did.
    pub evidence: Evidence,
}

/// Why the engine did not take a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// Its slot has already left the window.
    Late,
    /// Its slot is farther ahead of the window than reports may wait.
    Future,
}

impl Engine {
    /// An engine that knows nothing yet. The settings must fit the ring ([`Settings::fits_ring`]).
    pub fn new(settings: Settings) -> Self {
        assert!(settings.fits_ring(), "window and waiting reports do not fit the ring");
        Self {
            clock: None,
            newest: None,
            detections: Detections::new(settings.grid, settings.gate.clone()),
            aircraft: BTreeMap::new(),
            numbers: Numbers::new(settings.transponder_numbers.clone()),
            unnumbered: 0,
            settings,
        }
    }

    /// Tells the time of a reception; yields the slots that are due before what was received may be handled.
    ///
    /// The first call starts the clock: slots due by then are never emitted. A step backward changes nothing. A step of
    /// more than the window from one reception to the next emits what is owed and starts afresh with an empty window
    /// (numbers stay), whatever was told in between: who only has the receptions comes to the same slots.
    pub fn advance(&mut self, received: Time) -> Due<'_> {
        let Some(clock) = &mut self.clock else {
            self.start(received);
            return Due { engine: self, last: None, restart: None };
        };
        if received.nanos() - clock.received.nanos() > self.settings.window_ns() {
            return Due { last: self.newest, restart: Some(received), engine: self };
        }
        clock.received = clock.received.max(received);
        self.until(received)
    }

    /// Tells the time where nothing is received; yields the slots that are due by then. Nothing before the first
    /// reception. A step of more than the window forward from the latest time told starts afresh, as
    /// [`Engine::advance`] does.
    pub fn tick(&mut self, now: Time) -> Due<'_> {
        let window_ns = self.settings.window_ns();
        match self.clock {
            None => Due { engine: self, last: None, restart: None },
            Some(clock) if now.nanos() - clock.now.nanos() > window_ns => {
                Due { last: self.newest, restart: Some(now), engine: self }
            }
            Some(_) => self.until(now),
        }
    }

    fn until(&mut self, now: Time) -> Due<'_> {
        let last = self.clock.as_mut().map(|clock| {
            clock.now = clock.now.max(now);
            self.settings.grid.of(clock.now).plus(-self.settings.latency_slots)
        });
        Due { engine: self, last, restart: None }
    }

    /// The end of the input: yields every slot up to the last that holds a report.
    pub fn finish(&mut self) -> Due<'_> {
        Due { last: self.newest, engine: self, restart: None }
    }

    /// Whether a report of this time would be taken in.
    ///
    /// # Panics
    /// When no time was told before.
    pub fn accepts(&self, time: Time) -> Result<(), Refused> {
        let clock = self.clock.expect("advance() is told the reception before its reports are handled");
        let slot = self.settings.grid.of(time);
        let window = self.window(clock.next);
        if slot < window.first {
            return Err(Refused::Late);
        }
        if slot > window.last.plus(self.settings.waiting_slots()) {
            return Err(Refused::Future);
        }
        Ok(())
    }

    /// Takes a report in.
    ///
    /// # Panics
    /// When no time was told before.
    pub fn handle(&mut self, report: Report) -> Result<(), Refused> {
        self.accepts(report.time())?;
        self.newest = self.newest.max(Some(self.settings.grid.of(report.time())));
        match report {
            Report::Plot(plot) => self.detections.insert(plot),
            Report::Fix(fix) => {
                self.aircraft.entry(fix.identity).or_insert_with(|| Aircraft::new(&fix)).handle(&fix);
            }
        }
        Ok(())
    }

    /// How far a reception lies behind the engine's time, nanoseconds (0 when it does not).
    pub fn behind_ns(&self, received: Time) -> i64 {
        self.clock.map_or(0, |clock| (clock.now.nanos() - received.nanos()).max(0))
    }

    /// The next slot to be emitted, once the clock has started.
    pub fn next_slot(&self) -> Option<Slot> {
        self.clock.map(|clock| clock.next)
    }

    /// Points left out because all transponder numbers were used up.
    pub fn unnumbered(&self) -> u64 {
        self.unnumbered
    }

    /// The transponder numbers given so far.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// Takes over a number given in an earlier life; whether it did ([`Numbers::remember`]).
    pub fn remember(&mut self, given: Given) -> bool {
        self.numbers.remember(given)
    }

    fn start(&mut self, received: Time) {
        let next = self.settings.grid.of(received).plus(1 - self.settings.latency_slots);
        self.clock = Some(Clock { now: received, received, next });
    }

    fn restart(&mut self, received: Time) {
        self.newest = None;
        self.aircraft.clear();
        self.detections = Detections::new(self.settings.grid, self.settings.gate.clone());
        self.start(received);
    }

    fn window(&self, emitted: Slot) -> Window {
        let Settings { latency_slots, window_slots, suppress_slots, .. } = self.settings;
        let last = emitted.plus(latency_slots - 1);
        Window {
            first: emitted.plus(latency_slots - window_slots),
            emitted,
            horizon: emitted.plus(suppress_slots).min(last),
            last,
        }
    }

    /// Emits the next slot.
    fn emit(&mut self) -> Option<Emission> {
        let clock = self.clock.as_mut()?;
        let slot = clock.next;
        clock.next = slot.plus(1);
        let window = self.window(slot);
        let stale = self.detections.settle(&window);
        self.detections.remove(window.first.plus(-1));
        let Self { aircraft, detections, settings, .. } = self;
        aircraft.retain(|_, aircraft| {
            aircraft.update(&window, stale, detections, settings);
            !aircraft.curve.is_empty()
        });
        let points = self.points(&window);
        self.detections.mark_seen(slot);
        Some(Emission { slot, time: self.settings.grid.centre(slot), points })
    }

    fn points(&mut self, window: &Window) -> Vec<Point> {
        let Self { settings, detections, aircraft, numbers, unnumbered, .. } = self;
        let mut points = Vec::new();
        for (&identity, aircraft) in aircraft {
            if !aircraft.curve.present().contains(window.emitted) {
                continue;
            }
            aircraft.numbered = aircraft.numbered.or_else(|| numbers.of(identity, window.emitted));
            match aircraft.numbered {
                Some(numbered) => {
                    aircraft.put_out(identity, numbered, window, detections, settings, &mut points);
                }
                None => *unnumbered += 1,
            }
        }
        let mut explained: Vec<RadarTrackKey> =
            points.iter().filter_map(|point| point.source.radar()).map(|radar| radar.track).collect();
        explained.sort_unstable();
        let unexplained = |detection: &&Detection| explained.binary_search(&detection.plot.track).is_err();
        points.extend(
            detections
                .of_slot(window.emitted)
                .iter()
                .filter(unexplained)
                .filter_map(|detection| radar_only(detection, window, detections, settings)),
        );
        // Stable: points with one number, of two radars, stand by sensor already.
        points.sort_by_key(|point| (point.source.rank(), point.number));
        points
    }
}

impl Aircraft {
    fn new(fix: &Fix) -> Self {
        Self {
            curve: Curve::new(),
            pairs: Pairs::default(),
            items: fix.items,
            sensor: fix.sensor,
            numbered: None,
        }
    }

    fn handle(&mut self, fix: &Fix) {
        self.items = fix.items;
        self.sensor = fix.sensor;
        self.curve.insert(fix);
    }

    /// The points of the emitted slot, in which the curve has one: of every associated pair, or of the transponder alone
    /// where none was associated nearby.
    fn put_out(
        &self,
        identity: Identity,
        Numbered { number, since }: Numbered,
        window: &Window,
        detections: &Detections,
        settings: &Settings,
        points: &mut Vec<Point>,
    ) {
        let Self { curve, pairs, items, sensor, .. } = self;
        let slot = window.emitted;
        let position = curve.point(slot);
        let first_seen = settings.grid.centre(since);
        let transponder = TransponderPart { number, identity, sensor: *sensor, items: *items };
        let before = points.len();
        for pair in pairs.iter() {
            let both = curve.present().and(detections.track(pair.track).present);
            if let Some(evidence) = pair.associated(slot, window, both, settings)
                && let Some(detection) = detections.detection(pair.track, slot)
            {
                let distance_m = detection.distance_m(position);
                let association = Association { distance_m, gate_m: detection.gate_m, evidence };
                points.push(Point {
                    number: number * 10_000 + u32::from(pair.track.number),
                    position: fuse(detection, position, settings),
                    first_seen,
                    source: Source::Fused(RadarPart::of(detection), transponder, association),
                });
            }
        }
        let nearby = (slot.plus(-settings.suppress_slots).max(window.first), window.horizon);
        if points.len() == before && !pairs.any_associated(nearby, window, curve, detections, settings) {
            points.push(Point { number, position, first_seen, source: Source::Transponder(transponder) });
        }
    }

    fn update(&mut self, window: &Window, stale: SlotSet, detections: &Detections, settings: &Settings) {
        let changed = self.curve.update(window, settings.grid, settings.max_gap_ns);
        self.pairs.update(window, changed.or(stale), &self.curve, detections);
    }
}

/// The point of a detection that no transponder explains, when its track was a UAV for long enough.
fn radar_only(
    detection: &Detection,
    window: &Window,
    detections: &Detections,
    settings: &Settings,
) -> Option<Point> {
    let Plot { track: key, position, .. } = detection.plot;
    let track = detections.track(key);
    let so_far = SlotSet::span(window.first, window.emitted);
    let uav_s = f64::from(track.uav.and(so_far).count()) * settings.period_s[usize::from(key.sensor.0)];
    (uav_s > settings.radar_only_min_s).then(|| Point {
        number: key.number.into(),
        position,
        first_seen: settings.grid.centre(track.first_seen.unwrap_or(window.emitted)),
        source: Source::Radar(RadarPart::of(detection)),
    })
}

/// The weighted mean; the height is the transponder's alone where the radar measured none.
fn fuse(detection: &Detection, transponder: Enu, settings: &Settings) -> Enu {
    let (radar, by) = (settings.weight_radar, settings.weight_transponder);
    let mut fused = (detection.plot.position.0 * radar + transponder.0 * by) / (radar + by);
    if !detection.plot.height_measured {
        fused.z = transponder.0.z;
    }
    Enu(fused)
}

impl RadarPart {
    fn of(detection: &Detection) -> Self {
        let plot = &detection.plot;
        Self {
            track: plot.track,
            time: plot.time,
            height_measured: plot.height_measured,
            uav_probability: plot.uav_probability,
        }
    }
}

impl Source {
    fn rank(&self) -> u8 {
        match self {
            Self::Fused(..) => 0,
            Self::Radar(_) => 1,
            Self::Transponder(_) => 2,
        }
    }

    /// Whether the point's height was measured: always, unless it is a radar's alone that measured none.
    pub fn height_measured(&self) -> bool {
        !matches!(self, Self::Radar(RadarPart { height_measured: false, .. }))
    }

    /// The radar's part, if it has one.
    pub fn radar(&self) -> Option<&RadarPart> {
        match self {
            Self::Fused(radar, ..) | Self::Radar(radar) => Some(radar),
            Self::Transponder(_) => None,
        }
    }

    /// The transponder's part, if it has one.
    pub fn transponder(&self) -> Option<&TransponderPart> {
        match self {
            Self::Fused(_, transponder, _) | Self::Transponder(transponder) => Some(transponder),
            Self::Radar(_) => None,
        }
    }
}

/// The slots that are due, in order. Those not taken are emitted, and lost, when it is dropped.
#[derive(Debug)]
#[must_use = "the due slots are the engine's output"]
pub struct Due<'a> {
    engine: &'a mut Engine,
    last: Option<Slot>,
    restart: Option<Time>,
}

impl Due<'_> {
    /// Whether the engine starts afresh after these.
    pub fn restarts(&self) -> bool {
        self.restart.is_some()
    }
}

impl Iterator for Due<'_> {
    type Item = Emission;

    fn next(&mut self) -> Option<Emission> {
        if self.last.zip(self.engine.next_slot()).is_some_and(|(last, next)| next <= last) {
            return self.engine.emit();
        }
        if let Some(received) = self.restart.take() {
            self.engine.restart(received);
        }
        None
    }
}

impl Drop for Due<'_> {
    fn drop(&mut self) {
        self.for_each(drop);
    }
}
