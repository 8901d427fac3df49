//! Sensors other than radars and CAT129 receivers: ADS-B of crewed aircraft, Remote ID, bearings of cameras. They draw
//! from random streams of their own, so that they change nothing else.

mod adsb;
mod camera;
mod remote_id;

use std::collections::BTreeMap;
use std::net::Ipv4Addr;

use super::network;
use super::site;
use super::wire::SentDatagram;
use super::{SimulatedDatagram, drone_id};
use crate::evaluate::Label;
use ::site::config::{Input, Sensor, SensorKind};
use fusion::time::Time;
use world::ground::Ground;
use world::motion::{self, FlightPath};
use world::radar::RadarTarget;
use world::scenario::{Network, Scenario};
use world::streams::{Entity, RandomStreams};

pub use adsb::CrewedAircraft;

/// Number of the first crewed aircraft in the random streams of radars and cameras.
pub const CREWED: usize = 1 << 24;

/// A sensor that is neither a radar nor a receiver of CAT129.
#[derive(Clone, Debug, PartialEq)]
pub struct FurtherSensor {
    /// Entry in the configuration.
    pub sensor: Sensor,
    /// File that holds what the sensor sends.
    pub file: &'static str,
}

/// One aircraft's identities, for `classes.csv`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AircraftIdentities {
    /// Id in the truth; for fakes, `F` and a number.
    pub id: String,
    /// `unmanned`, `crewed`, `vehicle` or `fake`.
    pub class: &'static str,
    /// Serial number in CAT129.
    pub serial: Option<String>,
    /// Serial number in Remote ID.
    pub remote_id: Option<String>,
    /// ICAO 24-bit address, hexadecimal.
    pub icao24: Option<String>,
    /// Callsign in ADS-B.
    pub callsign: Option<String>,
    /// Emitter category (I021/020), as a number.
    pub emitter_category: Option<u8>,
}

/// The sensors and their data.
#[derive(Clone, Debug, Default)]
pub struct FurtherSensors {
    pub receivers: Vec<FurtherSensor>,
    /// Data in order of arrival; `sensor` is an index into `receivers`.
    pub sent: Vec<SentDatagram>,
    pub datagrams: Vec<SimulatedDatagram>,
    pub labels: Vec<Label>,
    pub identified: Vec<AircraftIdentities>,
    /// Track numbers, by serial number, that the configuration reserves; the labels use the same numbers.
    pub numbers: BTreeMap<String, u32>,
}

/// Common inputs of these simulations.
pub struct SensorScene<'a> {
    pub scenario: &'a Scenario,
    pub ground: &'a Ground,
    pub streams: &'a RandomStreams,
    pub start: Time,
    /// Flights of the drones.
    pub drones: &'a [FlightPath],
    /// Whether each drone has a CAT129 transponder.
    pub equipped: &'a [bool],
    pub aircraft: &'a [CrewedAircraft],
    /// All visible targets: drones, birds and clutter, then the aircraft.
    pub targets: &'a [RadarTarget],
}

/// Crewed aircraft and surface vehicles, each with its flight.
pub fn crewed(
    scenario: &Scenario,
    drones: &[FlightPath],
    steps: usize,
    streams: &RandomStreams,
) -> Vec<CrewedAircraft> {
    let (model, airspace) = (&scenario.crewed, &scenario.airspace);
    let kinds: [(u32, adsb::CrewedKind); 5] = [
        (model.transits, adsb::CrewedKind::Transit),
        (model.circuits, adsb::CrewedKind::Circuit),
        (model.helicopters, adsb::CrewedKind::Helicopter),
        (model.conflicts, adsb::CrewedKind::Conflict),
        (model.vehicles, adsb::CrewedKind::Vehicle),
    ];
    let mut all = Vec::new();
    for (count, kind) in kinds {
        let flown = (0..count as usize).map(|of_kind| {
            // Each kind is counted separately: adding an aircraft leaves the others unchanged.
            let number = (kind as usize) << 16 | of_kind;
            let mut stream = streams.of(Entity::Crewed, number);
            let stream = &mut stream;
            let path = match kind {
                adsb::CrewedKind::Transit => {
                    let legs = (model.radius_m, model.speed_m_s);
                    motion::transit(model, airspace, steps, legs, stream)
                }
                adsb::CrewedKind::Circuit => motion::circuit(model, steps, stream),
                adsb::CrewedKind::Helicopter => {
                    let legs = (model.radius_m / 2.0, model.helicopter_speed_m_s);
                    motion::transit(model, airspace, steps, legs, stream)
                }
                adsb::CrewedKind::Conflict => motion::conflict(model, &drones[of_kind], steps, stream),
                adsb::CrewedKind::Vehicle => motion::surface(model, steps, stream),
            };
            CrewedAircraft::new(kind, of_kind, number, path, &mut streams.of(Entity::Adsb, number))
        });
        all.extend(flown);
    }
    all
}

/// Simulates all sensors of these kinds.
pub fn further_sensors(scene: &SensorScene<'_>) -> FurtherSensors {
    let mut further = FurtherSensors::default();
    let SensorScene { scenario, .. } = *scene;
    if !scene.aircraft.is_empty() {
        adsb::add_reports(scene, &mut further);
    }
    if scenario.remote_id.drones + scenario.remote_id.fakes > 0 {
        remote_id::add_reports(scene, &mut further);
    }
    for (index, model) in scenario.cameras.iter().enumerate() {
        camera::add_bearings(scene, index, model, &mut further);
    }
    if further.receivers.is_empty() {
        return further;
    }
    further.identified.sort_by(|one, other| key(&one.id).cmp(&key(&other.id)));
    further.sent.sort_by_key(|sent| sent.arrives);
    let lines: Vec<&[Input]> =
        further.receivers.iter().map(|receiver| receiver.sensor.inputs.as_slice()).collect();
    let network =
        Network { foreign_source_per_s: 0.0, foreign_category_per_s: 0.0, ..scenario.network.clone() };
    let mut stream = scene.streams.of(Entity::OtherNetwork, 0);
    let span = (scene.start, scenario.duration_s);
    further.datagrams = network::arrivals(&network, &lines, &further.sent, span, &mut stream);
    further
}

impl FurtherSensors {
    /// Returns the entry of an identity, adding it if necessary.
    fn identity(&mut self, id: String, class: &'static str) -> &mut AircraftIdentities {
        let index = self.identified.iter().position(|entry| entry.id == id).unwrap_or_else(|| {
            self.identified.push(AircraftIdentities {
                id,
                class,
                serial: None,
                remote_id: None,
                icao24: None,
                callsign: None,
                emitter_category: None,
            });
            self.identified.len() - 1
        });
        &mut self.identified[index]
    }
}

/// Adds the identities of all drones.
fn drones(scene: &SensorScene<'_>, further: &mut FurtherSensors) {
    for drone in 0..scene.drones.len() {
        let serial = scene.equipped[drone].then(|| super::wire::serial_text(drone));
        further.identity(drone_id(drone), "unmanned").serial = serial;
    }
}

/// Sort key: by letter, then by number.
fn key(id: &str) -> (&str, u32) {
    let (letter, number) = id.split_at(1);
    (letter, number.parse().unwrap_or(0))
}

/// A sensor of this scenario, with one or two lines.
fn sensor(
    scenario: &Scenario,
    (id, sac, sic): (&str, u32, u32),
    period_s: f64,
    (group, port): ([u8; 4], u16),
    kind: SensorKind,
) -> Sensor {
    let inputs = site::inputs(scenario, Ipv4Addr::from(group), port);
    let (id, connections) = (id.to_owned(), Vec::new());
    Sensor { id, sac: sac as u8, sic: sic as u8, period_s: Some(period_s), inputs, connections, kind }
}
