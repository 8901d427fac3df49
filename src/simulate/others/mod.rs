//! What is heard and seen beside radars and CAT129: ADS-B of crewed aircraft, Remote ID, bearings of cameras. None of it
//! draws from a stream of anything else, so that it changes nothing else.

mod adsb;
mod camera;
mod remote_id;

use std::collections::BTreeMap;
use std::net::Ipv4Addr;

use super::network;
use super::site;
use super::wire::Sent;
use super::{Datagram, drone_id};
use crate::config::{Input, Sensor, SensorKind};
use crate::evaluate::Label;
use fusion::time::Time;
use world::ground::Ground;
use world::motion::{self, Path};
use world::radar::Target;
use world::scenario::{Network, Scenario};
use world::streams::{Entity, Streams};

pub use adsb::Aircraft;

/// The first number of a crewed aircraft in the random streams of radars and cameras.
pub const CREWED: usize = 1 << 24;

/// A sensor that is neither radar nor receiver of CAT129.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// As the configuration has it.
    pub sensor: Sensor,
    /// The file that holds what it sends.
    pub file: &'static str,
}

/// What there is of one identity, for `classes.csv`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identified {
    /// Its id in the truth; of what does not exist `F` and a number.
    pub id: String,
    /// `unmanned`, `crewed`, `vehicle` or `fake`.
    pub class: &'static str,
    /// Serial number in CAT129.
    pub serial: Option<String>,
    /// Serial number in Remote ID.
    pub remote_id: Option<String>,
    /// ICAO 24-bit address, hexadecimal.
    pub icao24: Option<String>,
    /// What it calls itself in ADS-B.
    pub callsign: Option<String>,
    /// Emitter category (I021/020), as a number.
    pub emitter_category: Option<u8>,
}

/// The sensors and what they send.
#[derive(Clone, Debug, Default)]
pub struct Others {
    pub receivers: Vec<Receiver>,
    /// In order of arrival; `sensor` is an index of the receivers.
    pub sent: Vec<Sent>,
    pub datagrams: Vec<Datagram>,
    pub labels: Vec<Label>,
    pub identified: Vec<Identified>,
    /// Track numbers that the configuration reserves, by serial number: those of the labels.
    pub numbers: BTreeMap<String, u32>,
}

/// What all of them need.
pub struct Scene<'a> {
    pub scenario: &'a Scenario,
    pub ground: &'a Ground,
    pub streams: &'a Streams,
    pub start: Time,
    /// The drones' flights.
    pub drones: &'a [Path],
    /// Which drones have a CAT129 transponder.
    pub equipped: &'a [bool],
    pub aircraft: &'a [Aircraft],
    /// All that may be seen: drones, birds and clutter, and in the end the aircraft.
    pub targets: &'a [Target],
}

/// Crewed aircraft and surface vehicles, each with its flight.
pub fn crewed(scenario: &Scenario, drones: &[Path], steps: usize, streams: &Streams) -> Vec<Aircraft> {
    let (model, airspace) = (&scenario.crewed, &scenario.airspace);
    let kinds: [(u32, adsb::Kind); 5] = [
        (model.transits, adsb::Kind::Transit),
        (model.circuits, adsb::Kind::Circuit),
        (model.helicopters, adsb::Kind::Helicopter),
        (model.conflicts, adsb::Kind::Conflict),
        (model.vehicles, adsb::Kind::Vehicle),
    ];
    let mut all = Vec::new();
    for (count, kind) in kinds {
        let flown = (0..count as usize).map(|of_kind| {
            // Each kind counts apart: another aircraft changes nothing for the rest.
            let number = (kind as usize) << 16 | of_kind;
            let mut stream = streams.of(Entity::Crewed, number);
            let stream = &mut stream;
            let path = match kind {
                adsb::Kind::Transit => {
                    let legs = (model.radius_m, model.speed_m_s);
                    motion::transit(model, airspace, steps, legs, stream)
                }
                adsb::Kind::Circuit => motion::circuit(model, steps, stream),
                adsb::Kind::Helicopter => {
                    let legs = (model.radius_m / 2.0, model.helicopter_speed_m_s);
                    motion::transit(model, airspace, steps, legs, stream)
                }
                adsb::Kind::Conflict => motion::conflict(model, &drones[of_kind], steps, stream),
                adsb::Kind::Vehicle => motion::surface(model, steps, stream),
            };
            Aircraft::new(kind, of_kind, number, path, &mut streams.of(Entity::Adsb, number))
        });
        all.extend(flown);
    }
    all
}

/// All that is heard and seen.
pub fn others(scene: &Scene<'_>) -> Others {
    let mut others = Others::default();
    let Scene { scenario, .. } = *scene;
    if !scene.aircraft.is_empty() {
        adsb::heard(scene, &mut others);
    }
    if scenario.remote_id.drones + scenario.remote_id.fakes > 0 {
        remote_id::heard(scene, &mut others);
    }
    for (index, model) in scenario.cameras.iter().enumerate() {
        camera::seen(scene, index, model, &mut others);
    }
    if others.receivers.is_empty() {
        return others;
    }
    others.identified.sort_by(|one, other| key(&one.id).cmp(&key(&other.id)));
    others.sent.sort_by_key(|sent| sent.arrives);
    let lines: Vec<&[Input]> =
        others.receivers.iter().map(|receiver| receiver.sensor.inputs.as_slice()).collect();
    let network =
        Network { foreign_source_per_s: 0.0, foreign_category_per_s: 0.0, ..scenario.network.clone() };
    let mut stream = scene.streams.of(Entity::OtherNetwork, 0);
    let span = (scene.start, scenario.duration_s);
    others.datagrams = network::arrivals(&network, &lines, &others.sent, span, &mut stream);
    others
}

impl Others {
    /// The entry of an identity, made where there is none.
    fn identity(&mut self, id: String, class: &'static str) -> &mut Identified {
        let index = self.identified.iter().position(|entry| entry.id == id).unwrap_or_else(|| {
            self.identified.push(Identified {
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

/// The drones, whatever they carry.
fn drones(scene: &Scene<'_>, others: &mut Others) {
    for drone in 0..scene.drones.len() {
        let serial = scene.equipped[drone].then(|| super::wire::serial_text(drone));
        others.identity(drone_id(drone), "unmanned").serial = serial;
    }
}

/// By letter, then by number.
fn key(id: &str) -> (&str, u32) {
    let (letter, number) = id.split_at(1);
    (letter, number.parse().unwrap_or(0))
}

/// A sensor of this scenario, with one line or two.
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
