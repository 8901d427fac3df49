//! The test range: simulated radars and transponders with realistic errors (`docs/SIMULATION.md`), and the truth.
//!
//! Sans-IO except for [`Scenario::load`] and [`write()`]. The same [`Scenario`] and seed give the same [`Simulation`].
//!
//! ```text
//! world::scenario ──► motion ──► radar ──► wire ──► network ──► datagrams as they arrive
//! seed                truth      transponder       octets
//! ```

mod files;
mod further_sensors;
mod network;
mod site;
mod wire;

pub use files::write;
pub use further_sensors::AircraftIdentities;
pub use network::SimulatedDatagram;
pub use world::motion::Crowded;
pub use world::random;
pub use world::scenario::{
    Adsb, Airspace, Attack, Birds, Camera, Clutter, Crewed, Drones, FixedWing, Multirotor, Network, Pattern,
    Place, Radar, RemoteId, Scenario, Span, TRANSPONDER_ID, Transponder, VelocityModel,
};

use further_sensors::{CREWED, CrewedAircraft, SensorScene};
use world::ground::Ground;
use world::motion::{self, FlightPath, RATE_HZ};
use world::radar::{OTHERS, RadarDetection, RadarTarget};
use world::streams::{Entity, RandomStream, RandomStreams};
use world::transponder::{Transmissions, TransponderReport, TransponderRole};
use world::{attack, ghost, radar, transponder};

use crate::evaluate::{Label, Truth};
use ::site::config::Config;
use fusion::time::Time;
use input::capture::{Reception, ReceptionKind};
use wire::{SentDatagram, after, stamped};

/// A simulated flight: the truth, the data that the sensors sent, and the datagrams that arrived.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Configuration of a site with these sensors.
    pub config: Config,
    /// Drones, then crewed aircraft and surface vehicles.
    pub flights: Vec<SimulatedFlight>,
    /// Classes and identities of the aircraft; empty if the only sensors are radars and receivers of CAT129.
    pub identified: Vec<AircraftIdentities>,
    /// The drone or aircraft behind each plot and report, in order of time.
    pub labels: Vec<Label>,
    /// Attacks on transponders, in order of drones.
    pub attacks: Vec<SimulatedAttack>,
    /// Data from radars and transponder receivers, in order of arrival over a perfect network.
    sent: Vec<SentDatagram>,
    /// Data from further kinds of sensors, in order of arrival over a perfect network.
    further_sent: Vec<SentDatagram>,
    /// File names for `further_sent`, by sensor.
    further_files: Vec<&'static str>,
    /// Datagrams that arrive, in order of arrival.
    pub datagrams: Vec<SimulatedDatagram>,
}

impl Simulation {
    /// Returns the arriving datagrams as receptions, as a capture file passes them to the pipeline.
    pub fn receptions(&self) -> impl Iterator<Item = Reception> {
        self.datagrams.iter().map(|datagram| Reception {
            received: Some(datagram.received),
            input: 0,
            from: Some((datagram.flow.from, datagram.flow.port).into()),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: datagram.payload.clone(),
        })
    }

    /// Replaces every port that sensors send to and that the site listens on or sends to.
    pub fn map_ports(&mut self, port: impl Fn(u16) -> u16) {
        let Self { config, datagrams, .. } = self;
        let inputs = config.sensors.iter_mut().flat_map(|sensor| &mut sensor.inputs);
        let outputs = config.output.asterix.iter_mut().map(|sink| &mut sink.port);
        let flows = datagrams.iter_mut().map(|datagram| &mut datagram.flow.port);
        for used in inputs.map(|input| &mut input.port).chain(outputs).chain(flows) {
            *used = port(*used);
        }
    }

    /// Returns the true paths, for scoring.
    pub fn truth(&self) -> Truth {
        let place = |sample: &TruthSample| crate::evaluate::GeodeticPlace {
            latitude_deg: sample.latitude_deg,
            longitude_deg: sample.longitude_deg,
            altitude_amsl_m: Some(sample.altitude_amsl_m),
        };
        let track = |flight: &SimulatedFlight| {
            let samples = flight.samples.iter().map(|sample| (sample.time, place(sample)));
            (flight.id.clone(), samples.collect())
        };
        Truth::new(self.flights.iter().map(track))
    }
}

/// An attack on a transponder.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedAttack {
    /// Id of the drone.
    pub id: String,
    /// Number of its transponder, which is also the serial number.
    pub number: u32,
    /// Kind of spoofing; `None`: the transponder is jammed.
    pub attack: Option<Attack>,
    /// Beginning of the attack, by time of measurement.
    pub from: Time,
    /// End of the attack, by time of measurement.
    pub until: Time,
}

/// The true flight of a drone or crewed aircraft, or the path of a surface vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedFlight {
    /// `D` and the drone's number, from 1; crewed aircraft have other letters.
    pub id: String,
    /// Whether this is a drone with a CAT129 transponder.
    pub equipped: bool,
    /// Positions, 10 per second.
    pub samples: Vec<TruthSample>,
}

/// True position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthSample {
    /// Time of the sample.
    pub time: Time,
    /// WGS-84 latitude, degrees.
    pub latitude_deg: f64,
    /// WGS-84 longitude, degrees.
    pub longitude_deg: f64,
    /// Height above mean sea level, metres.
    pub altitude_amsl_m: f64,
    /// Velocity north, east and down, m/s.
    pub velocity_ned_m_s: [f64; 3],
}

/// Simulates the scenario, beginning at `start` or else at the scenario's own start time.
///
/// # Errors
/// [`Crowded`] if the airspace is too small for the drones and their separation.
pub fn simulate(scenario: &Scenario, seed: u64, start: Option<Time>) -> Result<Simulation, Crowded> {
    let start = start.unwrap_or_else(|| scenario.start_time());
    let streams = RandomStreams::new(&scenario.name, seed);
    let ground = Ground::new(&scenario.place);
    let mut config = site::site(scenario, &ground);
    let steps = (scenario.duration_s * RATE_HZ as f64) as usize + 1;
    let paths = motion::fleet(scenario, steps, &streams)?;
    let roles = roles(&scenario.drones, paths.len(), &streams);

    let mut labels = Vec::new();
    let mut sent = Vec::new();
    let mut targets = targets(scenario, &paths, steps, &streams);
    let without_crewed = targets.len();
    let aircraft = further_sensors::crewed(scenario, &paths, steps, &streams);
    targets.extend(aircraft.iter().map(crewed_target));
    let ids: Vec<Option<String>> = (targets.iter())
        .map(|target| target.drone.map(drone_id))
        .take(without_crewed)
        .chain(aircraft.iter().map(|aircraft| Some(aircraft.id())))
        .collect();
    for (index, radar) in scenario.radars.iter().enumerate() {
        let seen = if radar.sees_crewed { &targets[..] } else { &targets[..without_crewed] };
        let ghosts = ghost::ghosts(radar, index, seen, scenario.duration_s, &streams);
        let with_ghosts = if ghosts.is_empty() { Vec::new() } else { [seen, &ghosts].concat() };
        let seen = if ghosts.is_empty() { seen } else { &with_ghosts };
        let detections = radar::detections(radar, index, seen, &ground, scenario.duration_s, &streams);
        labels.extend(detections.iter().map(|detection| plot_label(radar, detection, &ids, start)));
        let antenna = ground.antenna(radar);
        let mut stream = streams.of(Entity::Line, index);
        sent.extend(wire::radar_datagrams(
            radar,
            index,
            &antenna,
            &detections,
            (start, scenario.duration_s),
            &mut stream,
        ));
    }
    let receiver = scenario.radars.len();
    let model = &scenario.transponder;
    let mut transponders: Vec<(usize, Transmissions)> = Vec::new();
    for (drone, path) in paths.iter().enumerate() {
        let Some(role) = roles[drone] else { continue };
        let number = motion::number(&scenario.drones, drone);
        let drawn = [Entity::Transponder, Entity::TransponderFault].map(|entity| streams.of(entity, number));
        let reports = transponder::reports(model, drone, path, role, scenario.duration_s, drawn.into());
        transponders.push((drone, reports));
    }
    let attacks = attacked(&mut transponders, scenario.duration_s, start);
    let seconds = seconds(scenario, &paths, &transponders, &streams);
    for report in transponders.iter().chain(&seconds).flat_map(|(_, sends)| &sends.reports) {
        labels.push(report_label(report, start));
        sent.extend(wire::transponder_datagram(model, receiver, &ground, report, start));
    }
    let scene = SensorScene {
        scenario,
        ground: &ground,
        streams: &streams,
        start,
        drones: &paths,
        equipped: &roles.iter().map(Option::is_some).collect::<Vec<bool>>(),
        aircraft: &aircraft,
        targets: &targets,
    };
    let further = further_sensors::further_sensors(&scene);
    let further_files = further.receivers.iter().map(|receiver| receiver.file).collect();
    config.fusion.transponder_numbers.extend(further.numbers);
    config.sensors.extend(further.receivers.into_iter().map(|receiver| receiver.sensor));
    labels.extend(further.labels);
    // Stable sort: at equal times, sensors stay in the order of the configuration.
    labels.sort_by_key(|label| label.time);
    sent.sort_by_key(|datagram| datagram.arrives);
    let mut stream = streams.of(Entity::Network, 0);
    let receivers = usize::from(scenario.transponder.has_receiver) + scenario.radars.len();
    // Datagrams of further sensors have already passed through the network.
    let lines: Vec<&[::site::config::Input]> =
        config.sensors[..receivers].iter().map(|sensor| sensor.inputs.as_slice()).collect();
    let mut datagrams =
        network::arrivals(&scenario.network, &lines, &sent, (start, scenario.duration_s), &mut stream);
    datagrams.extend(further.datagrams);
    datagrams.sort_by_key(|datagram| datagram.received);
    let flights = paths
        .iter()
        .enumerate()
        .map(|(drone, path)| flight(drone_id(drone), roles[drone].is_some(), path, &ground, start))
        .chain(aircraft.iter().map(|aircraft| flight(aircraft.id(), false, &aircraft.path, &ground, start)))
        .collect();
    let (identified, further_sent) = (further.identified, further.sent);
    Ok(Simulation {
        config,
        flights,
        identified,
        labels,
        attacks,
        sent,
        further_sent,
        further_files,
        datagrams,
    })
}

/// Everything that radars may detect: drones, then everything else.
fn targets(
    scenario: &Scenario,
    drones: &[FlightPath],
    steps: usize,
    streams: &RandomStreams,
) -> Vec<RadarTarget> {
    let Scenario { airspace, birds, clutter, .. } = scenario;
    let fleet = &scenario.drones;
    let mut targets: Vec<RadarTarget> = drones
        .iter()
        .enumerate()
        .map(|(drone, path)| RadarTarget {
            number: motion::number(fleet, drone),
            path: path.clone(),
            drone: Some(drone),
            uav_probability: 0.0,
            exists_s: None,
        })
        .collect();
    let mut other = |paths: Vec<FlightPath>, probability: &dyn Fn(&mut RandomStream) -> f64| {
        for path in paths {
            let number = OTHERS + targets.len() - drones.len();
            let uav_probability = probability(&mut streams.of(Entity::Character, number));
            targets.push(RadarTarget { number, path, drone: None, uav_probability, exists_s: None });
        }
    };
    let birds_paths = motion::birds(birds, airspace, steps, streams);
    other(birds_paths, &|stream| {
        if stream.chance(birds.zero_share) {
            0.0
        } else if stream.chance(birds.high_share) {
            stream.within(birds.high_probability)
        } else {
            stream.within(birds.probability)
        }
    });
    let clutter_paths = motion::clutter(clutter, airspace, steps, streams);
    other(clutter_paths, &|stream| stream.within(clutter.probability));
    targets
}

/// A crewed aircraft as a target for radars and cameras. Its UAV probability is 0.
fn crewed_target(aircraft: &CrewedAircraft) -> RadarTarget {
    let (number, path) = (CREWED + aircraft.number, aircraft.path.clone());
    RadarTarget { number, path, drone: None, uav_probability: 0.0, exists_s: None }
}

/// Draws which drones carry a transponder and how it is attacked, in all combinations of multirotors and fixed wings,
/// equipped or not.
fn roles(drones: &Drones, count: usize, streams: &RandomStreams) -> Vec<Option<TransponderRole>> {
    let lot = |drone| streams.of(Entity::Role, motion::number(drones, drone)).within(Span::new(0.0, 1.0));
    let mut lots: Vec<(f64, usize)> = (0..count).map(|drone| (lot(drone), drone)).collect();
    lots.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut roles = vec![None; count];
    for (rank, &(_, drone)) in lots.iter().take(drones.equipped as usize).enumerate() {
        let rank = rank as u32;
        roles[drone] = Some(match rank {
            _ if rank < drones.spoofed => TransponderRole::Spoofed,
            _ if rank < drones.spoofed + drones.jammed => TransponderRole::Jammed,
            _ => TransponderRole::Honest,
        });
    }
    roles
}

fn plot_label(radar: &Radar, detection: &RadarDetection, ids: &[Option<String>], start: Time) -> Label {
    Label {
        time: stamped(after(start, detection.stamped_s)),
        sensor: radar.id.clone(),
        number: detection.number.into(),
        id: ids.get(detection.target).cloned().flatten(),
        seduced: detection.seduced,
        identity: None,
    }
}

fn report_label(report: &TransponderReport, start: Time) -> Label {
    Label {
        time: stamped(after(start, report.stamped_s)),
        sensor: TRANSPONDER_ID.to_owned(),
        number: wire::transponder_number(report.identity),
        id: report.is_own.then(|| drone_id(report.drone)),
        seduced: false,
        identity: Some(wire::serial_text(report.identity)),
    }
}

/// Reports of second transponders, carried by random drones that have a first one. Attacks do not affect them.
fn seconds(
    scenario: &Scenario,
    paths: &[FlightPath],
    first: &[(usize, Transmissions)],
    streams: &RandomStreams,
) -> Vec<(usize, Transmissions)> {
    let model = &scenario.transponder;
    if model.second_share == 0.0 {
        return Vec::new();
    }
    let second_model = transponder::second(model);
    let of_drone = |&(drone, _): &(usize, Transmissions)| {
        let number = motion::number(&scenario.drones, drone);
        let mut stream = streams.of(Entity::SecondTransponder, number);
        stream.chance(model.second_share).then(|| {
            let drawn = (stream, streams.of(Entity::TransponderFault, wire::SECOND_IDENTITY + number));
            let (path, role) = (&paths[drone], TransponderRole::Honest);
            let mut sends =
                transponder::reports(&second_model, drone, path, role, scenario.duration_s, drawn);
            sends.reports.iter_mut().for_each(|report| report.identity += wire::SECOND_IDENTITY);
            (drone, sends)
        })
    };
    first.iter().filter_map(of_drone).collect()
}

/// Exchanges the identities of swapped transponders, pair by pair. Returns all attacks.
fn attacked(
    transponders: &mut [(usize, Transmissions)],
    duration_s: f64,
    start: Time,
) -> Vec<SimulatedAttack> {
    let is_swapped =
        |sends: &Transmissions| sends.attack.is_some_and(|attack| attack.attack == Attack::Swapped);
    let mut swapped = transponders.iter_mut().map(|(_, sends)| sends).filter(|sends| is_swapped(sends));
    while let (Some(one), Some(other)) = (swapped.next(), swapped.next()) {
        let Some(attack) = one.attack else { continue };
        attack::swap(attack.span, &mut one.reports, &mut other.reports);
        // Both swaps have the same interval.
        other.attack = Some(attack);
    }
    let attacked = |(drone, sends): &(usize, Transmissions)| {
        let attack = sends.attack.map(|attack| (Some(attack.attack), attack.span));
        let (attack, span) = attack.or_else(|| Some((None, sends.jammed_s?)))?;
        Some(SimulatedAttack {
            id: drone_id(*drone),
            number: wire::transponder_number(*drone),
            attack,
            from: after(start, span.low),
            until: after(start, span.high.min(duration_s)),
        })
    };
    transponders.iter().filter_map(attacked).collect()
}

fn drone_id(drone: usize) -> String {
    format!("D{}", drone + 1)
}

fn flight(id: String, equipped: bool, path: &FlightPath, ground: &Ground, start: Time) -> SimulatedFlight {
    let sample = |(step, state): (usize, &motion::KinematicState)| {
        let place = ground.geodetic(&state.position);
        let velocity = state.velocity;
        TruthSample {
            time: after(start, step as f64 / RATE_HZ as f64),
            latitude_deg: place.latitude_deg(),
            longitude_deg: place.longitude_deg(),
            altitude_amsl_m: ground.altitude_amsl_m(&state.position),
            velocity_ned_m_s: [velocity.y, velocity.x, -velocity.z],
        }
    };
    SimulatedFlight { id, equipped, samples: path.samples().iter().enumerate().map(sample).collect() }
}
