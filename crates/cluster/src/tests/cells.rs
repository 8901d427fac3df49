//! Four cells that meet in a corner, with drones that fly across it, compared with one engine for all.

use std::collections::BTreeMap;
use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

use fusion::frames::{Geodetic, TangentPlane};
use fusion::point::Source;
use fusion::slots::SlotGrid;
use fusion::time::Time;
use fusion::{Identity, RadarTrackKey};

use super::number_table::NumberTable;
use crate::cell::CellEngine;
use crate::engine::{SiteEngine, pictures};
use crate::message::ReceivedDatagram;
use crate::region::{
    Border, BorderCounts, CellMessage, CellMessageContent, CellPicture, PictureMerger, Region, number_table,
};
use lab::simulate::{Scenario, Simulation, simulate};
use picture::{Picture, PictureTrack};
use site::areas::Masks;
use site::config::{Config, Registration, SensorKind};
use site::territory::{CellName, Territory};

/// The corner where the cells meet, in degrees.
const CORNER: (f64, f64) = (52.5, -0.6);
const CELLS: [&str; 4] = ["n524-w0006", "n524-w0007", "n525-w0006", "n525-w0007"];
/// Distance below which a position counts as near a border, in metres.
const NEAR_M: f64 = 300.0;

/// Parameters of a simulated flight.
#[derive(Clone, Debug)]
pub(super) struct FlightSetup {
    pub(super) seconds: u32,
    pub(super) drones: u32,
    pub(super) birds: u32,
    pub(super) radars: u32,
    pub(super) seed: u64,
    /// 0: registration and errors as configured; 1: they are learned, and the single engine receives the values of the cells; 2:
    /// the single engine learns itself.
    pub(super) learns: u32,
    pub(super) halo_m: f64,
    pub(super) radius_m: f64,
    /// Delay of messages between cells, in slots.
    pub(super) delay: i64,
    /// Every `unreliable`-th message is repeated, and as many are lost; 0: none.
    pub(super) unreliable: usize,
    /// Every `reloaded` slots each cell's engine is restored from its checkpoint; 0: never.
    pub(super) reloaded: i64,
}

impl FlightSetup {
    pub(super) fn flight(&self) -> Simulation {
        let Self { seconds, drones, birds, radars, radius_m, .. } = *self;
        let (latitude, longitude) = CORNER;
        let (multirotors, equipped) = (drones * 7 / 10, drones / 2);
        let mut text = format!(
            "name = \"corner\"\nduration_s = {seconds}\n\
             [place]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n\
             [airspace]\neast_m = 0\nnorth_m = 0\nradius_m = {radius_m}\n\
             [drones]\nmultirotors = {multirotors}\nfixed_wings = {}\nequipped = {equipped}\n\
             [birds]\ncount = {birds}\n",
            drones - multirotors
        );
        if radars == 2 {
            text += "[[radars]]\nid = \"middle\"\nsic = 200\n\
                     [[radars]]\nid = \"east\"\nsic = 201\neast_m = 2800\nnorth_m = 700\nbias_azimuth_deg = -0.6\n\
                     bias_range_m = -3.0\n";
        }
        let scenario = Scenario::parse(&text, "corner.toml").unwrap();
        let mut flight = simulate(&scenario, self.seed, None).unwrap();
        if self.learns == 0 {
            held(&mut flight.config);
        }
        flight
    }
}

/// Turns off learning for radars and delays.
fn held(config: &mut Config) {
    for sensor in &mut config.sensors {
        match &mut sensor.kind {
            SensorKind::Radar(radar) => {
                (radar.registration, radar.learn_accuracy) = (Registration::Off, false);
            }
            SensorKind::Transponder(transponder) => transponder.delay_s = Some(0.12),
            _ => {}
        }
    }
}

/// Result of a comparison.
#[derive(Clone, Debug, Default)]
pub(super) struct ComparisonResult {
    pub(super) slots: usize,
    pub(super) points: usize,
    pub(super) near_points: usize,
    /// Points of the single engine that no cell has, and those near a border.
    pub(super) lost: usize,
    pub(super) near_lost: usize,
    /// Points that the single engine does not have.
    pub(super) extra: usize,
    pub(super) near_extra: usize,
    /// Points, losses and extra points from radar alone.
    pub(super) radar_points: usize,
    pub(super) radar_lost: usize,
    pub(super) radar_extra: usize,
    /// Points of one aircraft from two cells.
    pub(super) doubled: usize,
    /// Points that the merger left out.
    pub(super) removed: u64,
    /// Changes of an aircraft's id or number, and those near a border.
    pub(super) id_changes: usize,
    pub(super) near_id_changes: usize,
    /// Points whose position is identical to the single engine's.
    pub(super) equal: usize,
    pub(super) differences_mm: Vec<f64>,
    pub(super) near_differences_mm: Vec<f64>,
    pub(super) counts: Vec<(String, BorderCounts)>,
    /// Hash of all that the cells have published and sent.
    pub(super) hash: u64,
    /// Messages between the cells, and their size in octets.
    pub(super) messages: usize,
    pub(super) octets: usize,
    /// Number of times that an aircraft changed from one cell's picture to another's.
    pub(super) changes_of_cell: usize,
}

fn quantiles(values: &[f64]) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at =
        |share: f64| sorted.get(((sorted.len() as f64 * share) as usize).min(sorted.len().saturating_sub(1)));
    let [half, most, all] = [0.5, 0.99, 1.0].map(|share| at(share).copied().unwrap_or(f64::NAN));
    let above = sorted.iter().filter(|value| **value > 1.0).count() as f64 / sorted.len().max(1) as f64;
    format!("p50 {half:.6} p99 {most:.3} max {all:.1} mm, above 1 mm {:.3} %", 100.0 * above)
}

impl ComparisonResult {
    pub(super) fn p99_mm(values: &[f64]) -> f64 {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() * 99 / 100).copied().unwrap_or_default()
    }
}

impl fmt::Display for ComparisonResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { slots, points, near_points, lost, near_lost, extra, near_extra, doubled, removed, .. } =
            self;
        writeln!(f, "{slots} slots, {points} points, {near_points} of them within {NEAR_M} m of a border")?;
        writeln!(
            f,
            "lost {lost} ({near_lost} near), extra {extra} ({near_extra} near), doubled {doubled}, removed {removed}"
        )?;
        let Self { radar_points, radar_lost, radar_extra, .. } = self;
        writeln!(f, "by radar alone: {radar_points} points, lost {radar_lost}, extra {radar_extra}")?;
        writeln!(
            f,
            "id changes {} ({} near), changes of cell {}",
            self.id_changes, self.near_id_changes, self.changes_of_cell
        )?;
        writeln!(f, "letters {}, octets {}", self.messages, self.octets)?;
        writeln!(
            f,
            "equal to the bit: {:.3} %",
            100.0 * self.equal as f64 / self.differences_mm.len() as f64
        )?;
        writeln!(f, "all:  {}", quantiles(&self.differences_mm))?;
        writeln!(f, "near: {}", quantiles(&self.near_differences_mm))?;
        self.counts.iter().try_for_each(|(cell, counts)| writeln!(f, "{cell} {counts:?}"))
    }
}

/// Identifies an aircraft in both pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum AircraftKey {
    Identity(Identity),
    Radar(RadarTrackKey),
}

fn key(track: &PictureTrack) -> AircraftKey {
    match &track.point.source {
        Source::Fused(_, part, _) | Source::Transponder(part) => AircraftKey::Identity(part.identity),
        Source::Radar(part) => AircraftKey::Radar(part.track),
        Source::Cameras => panic!("there is no camera"),
    }
}

pub(super) fn territory() -> Territory {
    Territory::grid(0.1).unwrap()
}

fn engine(flight: &Simulation, started: Time) -> SiteEngine {
    SiteEngine::new(flight.config.clone(), Masks::default(), started)
}

/// Simulates the flight with four cells and with a single engine.
pub(super) fn fly(setup: &FlightSetup) -> ComparisonResult {
    let flight = setup.flight();
    let started = flight.datagrams[0].received;
    let mut alone = engine(&flight, started);
    let mut hasher = DefaultHasher::new();
    let mut written = 0;
    if setup.learns < 2 {
        alone = alone.sharing();
    }
    let names: Vec<CellName> = CELLS.iter().map(|name| CellName::new(name).unwrap()).collect();
    let border = |name: &CellName| {
        let region = Region::new(territory(), names.clone(), name.clone(), setup.halo_m, 150.0).unwrap();
        Border::new(region)
    };
    let new = |name: &CellName| (name.clone(), engine(&flight, started).bordering(border(name)));
    let mut cells: Vec<(CellName, SiteEngine)> = names.iter().map(new).collect();
    let grid = SlotGrid::default();
    let mut table = NumberTable::default();
    let first = |name: &CellName| {
        let (from, to) = (name.clone(), number_table());
        table
            .answer(&CellMessage {
                from,
                to,
                slot: grid.of(started),
                index: 0,
                content: CellMessageContent::RequestBlock,
            })
            .unwrap()
    };
    let mut messages: Vec<CellMessage> = names.iter().map(first).collect();
    let mut in_transit: Vec<(i64, CellMessage)> = Vec::new();
    let mut found = ComparisonResult::default();
    let mut comparison = PictureComparison::default();
    let mut merger = PictureMerger::default();

    let mut datagrams = flight.datagrams.iter().peekable();
    let mut at = grid.of(started).plus(1);
    let end = grid.of(flight.datagrams.last().unwrap().received);
    while at <= end {
        let due = grid.open(at);
        for message in messages.drain(..) {
            let first = names.iter().find(|name| **name != message.from);
            if setup.learns < 2
                && matches!(message.content, CellMessageContent::Values { .. })
                && Some(&message.to) == first
            {
                alone.handle_message(&message);
            }
            for (name, engine) in &mut cells {
                if message.to == *name {
                    engine.handle_message(&message);
                }
            }
        }
        while let Some(datagram) = datagrams.next_if(|datagram| datagram.received < due) {
            let heard = ReceivedDatagram {
                received: datagram.received,
                from: (datagram.flow.from, datagram.flow.port).into(),
                to: (datagram.flow.to, datagram.flow.port).into(),
                payload: datagram.payload.clone(),
            };
            alone.receive(&heard, heard.received);
            cells.iter_mut().for_each(|(_, engine)| engine.receive(&heard, heard.received));
        }
        alone.tick(due);
        cells.iter_mut().for_each(|(_, engine)| engine.tick(due));
        if let Some((slot, octets)) = alone.poll() {
            let (one, _) = pictures(&octets).unwrap();
            let mut parts = Vec::new();
            for (cell, engine) in &mut cells {
                let (of, octets) = engine.poll().unwrap();
                assert_eq!(of, slot);
                let (picture, _) = pictures(&octets).unwrap();
                parts.push(CellPicture { cell: cell.clone(), epoch: 1, picture });
                octets.hash(&mut hasher);
                for message in engine.take_messages() {
                    message.body().hash(&mut hasher);
                    let message = match message.to == number_table() {
                        true => table.answer(&message),
                        false => Some(message),
                    };
                    let Some(message) = message else { continue };
                    found.messages += 1;
                    found.octets += message.body().len();
                    let message = CellMessage::parse(&message.body()).unwrap();
                    // The log loses nothing; messages that a dead owner had not sent yet may be lost. Sensor values are repeated
                    // anyway.
                    let is_of_sensor = matches!(
                        message.content,
                        CellMessageContent::Values { .. } | CellMessageContent::Labelled(_)
                    );
                    written += usize::from(!is_of_sensor);
                    let is_unreliable = setup.unreliable > 0 && !is_of_sensor;
                    let every = |phase| is_unreliable && written % setup.unreliable == phase;
                    if !every(1) {
                        in_transit.push((at.0 + setup.delay, message.clone()));
                    }
                    if every(0) {
                        in_transit.push((at.0 + setup.delay + 7, message));
                    }
                }
                if setup.reloaded > 0 && slot.0 % setup.reloaded == 0 {
                    let new = border(cell);
                    let octets = engine.checkpoint();
                    *engine = self::engine(&flight, started)
                        .bordering(new)
                        .restored(Masks::default(), &octets)
                        .unwrap();
                    assert!(engine.checkpoint() == octets, "another state");
                }
            }
            let merged = merger.merge(slot, &parts).unwrap();
            comparison.compare(&mut found, &one, &merged, &parts);
        }
        at = at.plus(1);
        let (now, later): (Vec<_>, Vec<_>) = in_transit.drain(..).partition(|(when, _)| *when <= at.0);
        in_transit = later;
        messages.extend(now.into_iter().map(|(_, message)| message));
    }
    if std::env::var_os("UTM_FUSION_CELLS_TELL").is_some() {
        let mut deviations: Vec<_> = comparison.deviations.iter().collect();
        deviations.sort_by_key(|(_, known)| known.1);
        deviations.iter().for_each(|(who, (count, first, last, away_m))| {
            println!("{first} to {last}: {count} times {who}, first {away_m:.0} m from a border");
        });
    }
    found.removed = merger.doubled;
    found.hash = hasher.finish();
    found.counts =
        cells.iter().map(|(name, engine)| (name.to_string(), engine.border().unwrap().counts)).collect();
    found
}

/// Compares the pictures slot by slot.
#[derive(Default)]
struct PictureComparison {
    /// Names and cell of an aircraft, by the single engine's name.
    called: BTreeMap<(u32, Time), (String, u32, CellName)>,
    /// Deviations noted so far.
    deviations: BTreeMap<String, (usize, i64, i64, f64)>,
}

impl PictureComparison {
    fn compare(
        &mut self,
        found: &mut ComparisonResult,
        one: &Picture,
        merged: &Picture,
        parts: &[CellPicture],
    ) {
        found.slots += 1;
        let plane =
            TangentPlane::<fusion::frames::AtSite>::at(Geodetic::from_degrees(CORNER.0, CORNER.1, 0.0));
        let away_m = |track: &PictureTrack| {
            let place = plane.from_geodetic(track.position);
            place.east().abs().min(place.north().abs())
        };
        let has = |part: &CellPicture, id| part.picture.tracks.iter().any(|track| track.id == id);
        let cell_of = |track: &PictureTrack| {
            let part = parts.iter().find(|part| has(part, track.id.clone()));
            part.map(|part| part.cell.clone()).expect("it is of a cell")
        };
        // An aircraft may still name another one's radar track from a moment ago: two with the same key are then in one cell.
        let mut by_key: BTreeMap<AircraftKey, Vec<(&PictureTrack, CellName)>> = BTreeMap::new();
        for track in &merged.tracks {
            let cell = cell_of(track);
            let same = by_key.entry(key(track)).or_default();
            if let Some((twin, other)) = same.iter().find(|(_, other)| *other != cell) {
                found.doubled += 1;
                self.note_deviation(
                    &format!("doubled {other} {cell} {:?}", twin.id),
                    one,
                    track,
                    away_m(track),
                );
            }
            same.push((track, cell));
        }
        for track in &one.tracks {
            let is_near = away_m(track) < NEAR_M;
            found.points += 1;
            found.near_points += usize::from(is_near);
            let by_radar = usize::from(matches!(track.point.source, Source::Radar(_)));
            found.radar_points += by_radar;
            let apart_mm =
                |other: &PictureTrack| (track.position.to_ecef().0 - other.position.to_ecef().0).norm() * 1e3;
            let same = by_key.entry(key(track)).or_default();
            let nearest =
                (0..same.len()).min_by(|a, b| apart_mm(same[*a].0).total_cmp(&apart_mm(same[*b].0)));
            let Some((other, cell)) = nearest.map(|index| same.swap_remove(index)) else {
                found.lost += 1;
                found.radar_lost += by_radar;
                found.near_lost += usize::from(is_near);
                self.note_deviation("lost", one, track, away_m(track));
                continue;
            };
            let difference = apart_mm(other);
            found.equal += usize::from(track.position == other.position);
            found.differences_mm.push(difference);
            if is_near {
                found.near_differences_mm.push(difference);
            }
            let inner = (track.point.number, track.point.first_seen);
            let named = (other.id.clone().unwrap(), other.point.number, cell.clone());
            if let Some(before) = self.called.insert(inner, named.clone()) {
                found.changes_of_cell += usize::from(before.2 != named.2);
                if (&before.0, before.1) != (&named.0, named.1) {
                    found.id_changes += 1;
                    found.near_id_changes += usize::from(is_near);
                    self.note_deviation(&format!("{before:?} {named:?}"), one, track, away_m(track));
                }
            }
        }
        for (other, cell) in by_key.values().flatten() {
            let is_near = away_m(other) < NEAR_M;
            found.extra += 1;
            found.radar_extra += usize::from(matches!(other.point.source, Source::Radar(_)));
            found.near_extra += usize::from(is_near);
            self.note_deviation(&format!("extra in {cell}"), one, other, away_m(other));
        }
    }

    /// Notes a deviation: aircraft, count, first and last slot, and distance from a border.
    fn note_deviation(&mut self, what: &str, one: &Picture, track: &PictureTrack, away_m: f64) {
        let who = format!("{what} {:?} {}", key(track), track.point.number);
        let known = self.deviations.entry(who).or_insert((0, one.slot.0, one.slot.0, away_m));
        *known = (known.0 + 1, known.1, one.slot.0, known.3);
    }
}

/// Two minutes with enough drones that some cross each border.
fn setup() -> FlightSetup {
    FlightSetup {
        seconds: 120,
        drones: 100,
        birds: 50,
        radars: 1,
        seed: 1,
        learns: 1,
        halo_m: 1000.0,
        radius_m: 2500.0,
        delay: 1,
        unreliable: 0,
        reloaded: 0,
    }
}

fn taken(found: &ComparisonResult) -> u64 {
    found.counts.iter().map(|(_, counts)| counts.taken).sum()
}

/// `UTM_FUSION_CELLS` sets: seconds, drones, birds, radars, seed, what is learned, halo and radius in metres, delay of messages
/// in slots, and how unreliable messages are.
#[test]
fn four_cells_publish_the_picture_of_one_engine() {
    let mut setup = setup();
    let asked = std::env::var("UTM_FUSION_CELLS");
    if let Ok(text) = &asked {
        let numbers: Vec<u32> = text.split(',').map(|number| number.trim().parse().unwrap()).collect();
        let [seconds, drones, birds, radars, seed, learns, halo_m, radius_m, delay, unreliable] = numbers[..]
        else {
            panic!("{text}")
        };
        let (halo_m, radius_m, unreliable) = (halo_m.into(), radius_m.into(), unreliable as usize);
        let (seed, delay) = (seed.into(), delay.into());
        setup = FlightSetup {
            seconds,
            drones,
            birds,
            radars,
            seed,
            learns,
            halo_m,
            radius_m,
            delay,
            unreliable,
            reloaded: 0,
        };
    }
    let found = fly(&setup);
    println!("{setup:?}\n{found}");
    assert!(taken(&found) > 0 && found.changes_of_cell > 0, "nobody was handed over");
    if asked.is_err() {
        let ComparisonResult { lost, doubled, removed, id_changes, .. } = found;
        assert_eq!((lost, doubled, removed, id_changes), (0, 0, 0, 0));
        assert!(ComparisonResult::p99_mm(&found.differences_mm) < 1.0 && found.extra * 1000 < found.points);
    }
}

/// If messages are late, repeated or lost, an aircraft changes its cell later, or two cells have it for a while. Both then use
/// the same id, and the region's picture shows the aircraft once.
#[test]
fn late_lost_or_repeated_messages_lose_no_aircraft() {
    // Delays within the 4 s from an offer to the handover make no difference.
    let late = fly(&FlightSetup { delay: 6, ..setup() });
    assert!(taken(&late) > 0, "{late}");
    assert_eq!((late.lost, late.doubled, late.removed, late.id_changes), (0, 0, 0, 0), "{late}");
    for (delay, unreliable) in [(6, 3), (12, 5)] {
        let found = fly(&FlightSetup { delay, unreliable, ..setup() });
        assert!(taken(&found) > 0, "{found}");
        assert_eq!(found.lost, 0, "{found}");
        // An aircraft that starts while its owner's offer is on its way has its own name until the offer arrives.
        assert!(found.doubled * 1000 < found.points && found.id_changes <= 8, "{found}");
        assert!(found.counts.iter().any(|(_, counts)| counts.repeated > 0), "{found}");
    }
}

#[test]
fn restored_cells_continue_byte_for_byte() {
    let setup = FlightSetup { seconds: 60, drones: 40, birds: 10, radius_m: 1000.0, ..setup() };
    let never = fly(&setup);
    assert!(taken(&never) > 0, "{never}");
    for reloaded in [3, 10] {
        assert_eq!(
            fly(&FlightSetup { reloaded, ..setup.clone() }).hash,
            never.hash,
            "every {reloaded} slots"
        );
    }
}
