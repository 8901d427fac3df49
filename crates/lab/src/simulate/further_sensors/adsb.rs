//! ADS-B of crewed aircraft and surface vehicles, as a receiver reports it: CAT021, edition 2.6.

use asterix::cat021::{
    self, AircraftAddress, AircraftIdentification, AltitudeReporting, BarometricLevel, CoarsePosition,
    Emitter, EmitterCategory, GeometricHeight, GroundVector, LinkTechnology, MopsVersion, Position,
    QualityIndicators, Standard, TargetReport, VerticalRate,
};
use asterix::{DataSource, TimeOfDay, encode_block};
use nalgebra::Vector3;

use super::{FurtherSensor, FurtherSensors, SensorScene};
use crate::evaluate::Label;
use crate::simulate::wire::{SentDatagram, after, stamped};
use input::normalise::time_of_day_count;
use site::config::{self, SensorKind};
use world::motion::FlightPath;
use world::scenario::{Adsb, Span};
use world::streams::{Entity, GaussMarkov, RandomStream};
use world::transponder::episodes;

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;
/// Noise of velocities, metres per second per axis.
const VELOCITY_M_S: f64 = 0.4;
/// First ICAO address allocated to the United Kingdom.
const ADDRESSES: u32 = 0x40_0000;
/// Maximum number of aircraft of a kind; each aircraft draws its address from a block of 16.
const OF_A_KIND: usize = 0x800;

/// Kind of aircraft. The discriminants are part of every seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrewedKind {
    /// An aeroplane in transit.
    Transit = 0,
    /// An aeroplane in the circuit.
    Circuit = 1,
    /// A helicopter.
    Helicopter = 2,
    /// A helicopter that flies into an encounter with a drone.
    Conflict = 3,
    /// A surface vehicle.
    Vehicle = 4,
}

/// A crewed aircraft or a surface vehicle.
#[derive(Clone, Debug)]
pub struct CrewedAircraft {
    kind: CrewedKind,
    of_kind: usize,
    /// Number in the random streams.
    pub number: usize,
    /// Flight of the aircraft.
    pub path: FlightPath,
    address: u32,
    callsign: String,
    category: EmitterCategory,
    /// Stream for the errors of its ADS-B.
    stream: RandomStream,
}

impl CrewedAircraft {
    /// The aircraft with index `of_kind` among its kind.
    pub fn new(
        kind: CrewedKind,
        of_kind: usize,
        number: usize,
        path: FlightPath,
        stream: &mut RandomStream,
    ) -> Self {
        let address = ADDRESSES + ((kind as usize * OF_A_KIND + of_kind) * 16 + stream.below(16)) as u32;
        let letter = |stream: &mut RandomStream| char::from(b'A' + stream.below(26) as u8);
        let registration: String = (0..4).map(|_| letter(stream)).collect();
        let is_light = stream.chance(0.7);
        let (callsign, category) = match kind {
            CrewedKind::Transit | CrewedKind::Circuit if is_light => {
                (format!("G{registration}"), EmitterCategory::Light)
            }
            CrewedKind::Transit | CrewedKind::Circuit => (format!("G{registration}"), EmitterCategory::Small),
            CrewedKind::Helicopter | CrewedKind::Conflict => {
                (format!("G{registration}"), EmitterCategory::Rotorcraft)
            }
            CrewedKind::Vehicle if is_light => {
                (format!("OPS{}", of_kind + 1), EmitterCategory::ServiceVehicle)
            }
            CrewedKind::Vehicle => (format!("FIRE{}", of_kind + 1), EmitterCategory::EmergencyVehicle),
        };
        Self { kind, of_kind, number, path, address, callsign, category, stream: stream.clone() }
    }

    /// Id in the truth: a letter and a number from 1. `A` is a transit, `C` the circuit, `H` a helicopter, `X` a
    /// conflict, `V` a vehicle.
    pub fn id(&self) -> String {
        let letter = match self.kind {
            CrewedKind::Transit => 'A',
            CrewedKind::Circuit => 'C',
            CrewedKind::Helicopter => 'H',
            CrewedKind::Conflict => 'X',
            CrewedKind::Vehicle => 'V',
        };
        format!("{letter}{}", self.of_kind + 1)
    }

    /// Whether it is a surface vehicle.
    pub fn is_vehicle(&self) -> bool {
        self.kind == CrewedKind::Vehicle
    }
}

/// Adds everything that the receiver reports.
pub fn add_reports(scene: &SensorScene<'_>, further: &mut FurtherSensors) {
    let model = &scene.scenario.adsb;
    let sensor = further.receivers.len();
    further.receivers.push(FurtherSensor {
        sensor: super::sensor(
            scene.scenario,
            (&model.id, model.sac, model.sic),
            (model.period_s.low + model.period_s.high) / 2.0,
            ([239, 192, 21, 1], 8021),
            SensorKind::AdsB(config::AdsB::default()),
        ),
        file: "adsb.ast",
    });
    let weather_m = scene.streams.of(Entity::Adsb, usize::MAX).within(model.weather_m);
    for aircraft in scene.aircraft {
        let is_without_category = of_aircraft(scene, aircraft, sensor, weather_m, further);
        let class = if aircraft.is_vehicle() { "vehicle" } else { "crewed" };
        let entry = further.identity(aircraft.id(), class);
        entry.icao24 = Some(format!("{:06x}", aircraft.address));
        entry.callsign = Some(aircraft.callsign.clone());
        entry.emitter_category = (!is_without_category).then(|| aircraft.category.code());
    }
}

/// Properties of one aircraft's ADS-B that are constant over a flight.
struct AdsbProperties {
    nacp: u8,
    is_geometric: bool,
    is_applicable: bool,
    is_fine: bool,
    is_without_category: bool,
    late_s: f64,
    barometric_m: f64,
}

impl AdsbProperties {
    fn new(model: &Adsb, aircraft: &CrewedAircraft, stream: &mut RandomStream) -> Self {
        let nacp = stream.within(Span::new(model.nacp.low, model.nacp.high + 1.0)).min(11.0) as u8;
        Self {
            nacp: if stream.chance(model.nacp_missing) { 0 } else { nacp.min(model.nacp.high as u8) },
            is_geometric: !stream.chance(model.barometric_share),
            is_applicable: stream.chance(model.applicability_share),
            is_fine: stream.chance(0.5),
            // Surface vehicles always report their category.
            is_without_category: stream.chance(model.no_category_share) && !aircraft.is_vehicle(),
            late_s: stream.within(model.stamped_late_s),
            barometric_m: stream.normal(model.barometric_m),
        }
    }
}

/// Appends the records of one aircraft. Returns whether these have no emitter category.
fn of_aircraft(
    scene: &SensorScene<'_>,
    aircraft: &CrewedAircraft,
    sensor: usize,
    weather_m: f64,
    further: &mut FurtherSensors,
) -> bool {
    let model = &scene.scenario.adsb;
    let duration_s = scene.scenario.duration_s;
    let mut stream = aircraft.stream.clone();
    let stream = &mut stream;
    let properties = AdsbProperties::new(model, aircraft, stream);
    let gaps = episodes(model.gap_every_s, model.gap_s, duration_s, stream);
    let mut bias = [model.gnss_horizontal_m, model.gnss_horizontal_m, model.gnss_vertical_m]
        .map(|sigma_m| GaussMarkov::new(sigma_m, model.gnss_time_s, 0.0, stream));
    let stands = Vector3::new(model.east_m, model.north_m, 10.0);
    let mut time_s = stream.within(Span::new(0.0, model.period_s.high));
    while time_s < duration_s {
        let state = aircraft.path.at(time_s);
        let error = Vector3::from(bias.each_mut().map(|axis| axis.at(time_s, stream)));
        let noise = Vector3::from_fn(|_, _| stream.normal(VELOCITY_M_S));
        let is_lost = stream.chance(model.lost);
        let latency_s = stream.within(model.latency_s);
        let is_silent = gaps.iter().any(|gap| (gap.low..gap.high).contains(&time_s));
        let stamped_s = if properties.is_applicable { time_s } else { time_s + properties.late_s };
        if !is_lost && !is_silent && (state.position - stands).norm() <= model.range_m {
            let state = ReportedMotion {
                position: state.position + error,
                velocity: state.velocity + noise,
                pressure_m: scene.ground.altitude_amsl_m(&state.position)
                    + weather_m
                    + properties.barometric_m,
                stamped_s,
            };
            if let Some(payload) = record(scene, aircraft, &properties, &state) {
                let arrives = after(scene.start, stamped_s + latency_s);
                further.sent.push(SentDatagram { arrives, sensor, payload });
                further.labels.push(Label {
                    time: stamped(after(scene.start, stamped_s)),
                    sensor: model.id.clone(),
                    number: aircraft.address,
                    id: Some(aircraft.id()),
                    seduced: false,
                    identity: Some(format!("{:06X}", aircraft.address)),
                });
            }
        }
        time_s += stream.within(model.period_s);
    }
    properties.is_without_category
}

/// Motion of an aircraft as a record reports it.
struct ReportedMotion {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Pressure altitude, metres.
    pressure_m: f64,
    stamped_s: f64,
}

/// Encodes a record. `None` if CAT021 cannot represent a value, which cannot happen with a valid scenario.
fn record(
    scene: &SensorScene<'_>,
    aircraft: &CrewedAircraft,
    properties: &AdsbProperties,
    reported: &ReportedMotion,
) -> Option<Vec<u8>> {
    let model = &scene.scenario.adsb;
    let source = DataSource { sac: model.sac as u8, sic: model.sic as u8 };
    let is_on_ground = aircraft.is_vehicle();
    let report = TargetReport::default().with_altitude_reporting(AltitudeReporting::Feet25);
    // Add the second octet only if it is needed.
    let report = if is_on_ground { report.with_on_ground(true) } else { report };
    let place = scene.ground.geodetic(&reported.position);
    let (latitude_deg, longitude_deg) = (place.latitude_deg(), place.longitude_deg());
    let time = TimeOfDay::from_count(time_of_day_count(after(scene.start, reported.stamped_s)));
    let technology = MopsVersion::default().with_standard(Standard::Do260B);
    let mut record = cat021::Record::builder(source, report, AircraftAddress::new(aircraft.address))
        .quality(QualityIndicators::default().with_accuracy_category(properties.nacp))
        .mops_version(technology.with_technology(LinkTechnology::ExtendedSquitter))
        .ground_vector(GroundVector::new(
            reported.velocity.xy().norm(),
            reported.velocity.x.atan2(reported.velocity.y).to_degrees(),
        ))
        .target_identification(AircraftIdentification::new(&aircraft.callsign));
    record =
        if properties.is_applicable { record.position_time(time) } else { record.position_reception(time) };
    record = if properties.is_fine {
        record.fine_position(Position::new(latitude_deg, longitude_deg))
    } else {
        record.position(CoarsePosition::new(latitude_deg, longitude_deg))
    };
    if !is_on_ground {
        record = record
            .flight_level(BarometricLevel::default().with_flight_level(reported.pressure_m / FOOT_M / 100.0));
        if properties.is_geometric {
            record = record
                .geometric_height(GeometricHeight::default().with_height_m(place.height_m))
                .geometric_rate(VerticalRate::default().with_up_m_s(reported.velocity.z));
        }
    }
    if !properties.is_without_category {
        record = record.emitter(Emitter::default().with_category(aircraft.category));
    }
    let mut payload = Vec::new();
    encode_block(&[record.build().ok()?], &mut payload).ok()?;
    Some(payload)
}
