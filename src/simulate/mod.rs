//! The test range: radars and transponders that fail the way real ones do (`docs/SIMULATION.md`), and the truth.
//!
//! Sans-IO but for [`Scenario::load`] and [`write()`]: the same [`Scenario`] and seed give the same [`Simulation`].
//!
//! ```text
//! world::scenario ──► motion ──► radar (sight) ──► wire ──► network ──► datagrams as they arrive
//! seed                truth      transponder       octets
//! ```

mod files;
mod network;
mod others;
mod site;
mod wire;

pub use files::write;
pub use network::Datagram;
pub use others::Identified;
pub use world::motion::Crowded;
pub use world::scenario::{
    Adsb, Airspace, Attack, Birds, Camera, Clutter, Crewed, Drones, FixedWing, Multirotor, Network, Pattern,
    Place, Radar, RemoteId, Scenario, Span, TRANSPONDER_ID, Transponder, VelocityModel,
};

use others::{Aircraft, CREWED, Scene};
use world::ground::Ground;
use world::motion::{self, Path, RATE_HZ};
use world::radar::{Detection, OTHERS, Target};
use world::streams::{Entity, Stream, Streams};
use world::transponder::{Role, Transmissions, TransponderReport};
use world::{attack, radar, transponder};

use crate::capture::{Reception, ReceptionKind};
use crate::config::Config;
use crate::evaluate::{Label, Truth};
use fusion::time::Time;
use wire::{Sent, after, stamped};

/// A simulated flight: the truth, what the sensors sent, and what arrived.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Configuration of a site with these sensors.
    pub config: Config,
    /// The drones, then the crewed aircraft and surface vehicles.
    pub flights: Vec<Flight>,
    /// Who is what and how it calls itself, where there are sensors of more kinds than radars and receivers of CAT129.
    pub identified: Vec<Identified>,
    /// The drone or aircraft behind each plot and report, in order of time.
    pub labels: Vec<Label>,
    /// The attacks on transponders, by drone.
    pub attacks: Vec<Attacked>,
    /// What the sensors sent, in order of arrival over a perfect network.
    sent: Vec<Sent>,
    /// What the sensors of further kinds sent, likewise.
    heard: Vec<Sent>,
    /// The files of these, by sensor.
    heard_files: Vec<&'static str>,
    /// What arrives, in order of arrival.
    pub datagrams: Vec<Datagram>,
}

impl Simulation {
    /// What arrives, as a capture hands it to the pipeline.
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

    /// The true paths, for scoring.
    pub fn truth(&self) -> Truth {
        let place = |sample: &TruthSample| crate::evaluate::Place {
            latitude_deg: sample.latitude_deg,
            longitude_deg: sample.longitude_deg,
            altitude_amsl_m: Some(sample.altitude_amsl_m),
        };
        let track = |flight: &Flight| {
            let samples = flight.samples.iter().map(|sample| (sample.time, place(sample)));
            (flight.id.clone(), samples.collect())
        };
        Truth::new(self.flights.iter().map(track))
    }
}

/// An attack on a transponder.
#[derive(Clone, Debug, PartialEq)]
pub struct Attacked {
    /// The drone's id.
    pub id: String,
    /// The number of its transponder, which is its serial number.
    pub number: u32,
    /// What is done; `None`: it is jammed.
    pub attack: Option<Attack>,
    /// When the attack begins and ends, by the time of measurement.
    pub from: Time,
    /// When it ends.
    pub until: Time,
}

/// The true flight of a drone or a crewed aircraft, or the way of a surface vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// `D` and the drone's number, from 1; of crewed aircraft another letter.
    pub id: String,
    /// Whether it is a drone with a CAT129 transponder.
    pub equipped: bool,
    /// Its positions, 10 per second.
    pub samples: Vec<TruthSample>,
}

/// A drone's true position and velocity.
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

/// Simulates the scenario, from `start` on if given, else from the scenario's own time.
///
/// # Errors
/// The airspace is too crowded for the separation.
pub fn simulate(scenario: &Scenario, seed: u64, start: Option<Time>) -> Result<Simulation, Crowded> {
    let start = start.unwrap_or_else(|| scenario.start_time());
    let streams = Streams::new(&scenario.name, seed);
    let ground = Ground::new(&scenario.place);
    let mut config = site::site(scenario, &ground);
    let steps = (scenario.duration_s * RATE_HZ as f64) as usize + 1;
    let paths = motion::fleet(scenario, steps, &streams)?;
    let roles = roles(&scenario.drones, paths.len(), &streams);

    let mut labels = Vec::new();
    let mut sent = Vec::new();
    let mut targets = targets(scenario, &paths, steps, &streams);
    let without_crewed = targets.len();
    let aircraft = others::crewed(scenario, &paths, steps, &streams);
    targets.extend(aircraft.iter().map(crewed_target));
    let ids: Vec<Option<String>> = (targets.iter())
        .map(|target| target.drone.map(drone_id))
        .take(without_crewed)
        .chain(aircraft.iter().map(|aircraft| Some(aircraft.id())))
        .collect();
    for (index, radar) in scenario.radars.iter().enumerate() {
        let seen = if radar.sees_crewed { &targets[..] } else { &targets[..without_crewed] };
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
        let stream = streams.of(Entity::Transponder, motion::number(&scenario.drones, drone));
        transponders
            .push((drone, transponder::reports(model, drone, path, role, scenario.duration_s, stream)));
    }
    let attacks = attacked(&mut transponders, scenario.duration_s, start);
    for report in transponders.iter().flat_map(|(_, sends)| &sends.reports) {
        labels.push(report_label(report, start));
        sent.extend(wire::transponder_datagram(model, receiver, &ground, report, start));
    }
    let scene = Scene {
        scenario,
        ground: &ground,
        streams: &streams,
        start,
        drones: &paths,
        equipped: &roles.iter().map(Option::is_some).collect::<Vec<bool>>(),
        aircraft: &aircraft,
        targets: &targets,
    };
    let others = others::others(&scene);
    let heard_files = others.receivers.iter().map(|receiver| receiver.file).collect();
    config.fusion.transponder_numbers.extend(others.numbers);
    config.sensors.extend(others.receivers.into_iter().map(|receiver| receiver.sensor));
    labels.extend(others.labels);
    // Stable sorts: at equal times sensors stay in the order of the configuration.
    labels.sort_by_key(|label| label.time);
    sent.sort_by_key(|datagram| datagram.arrives);
    let mut stream = streams.of(Entity::Network, 0);
    let receivers = usize::from(scenario.transponder.has_receiver) + scenario.radars.len();
    // Others have had their network.
    let lines: Vec<&[crate::config::Input]> =
        config.sensors[..receivers].iter().map(|sensor| sensor.inputs.as_slice()).collect();
    let mut datagrams =
        network::arrivals(&scenario.network, &lines, &sent, (start, scenario.duration_s), &mut stream);
    datagrams.extend(others.datagrams);
    datagrams.sort_by_key(|datagram| datagram.received);
    let flights = paths
        .iter()
        .enumerate()
        .map(|(drone, path)| flight(drone_id(drone), roles[drone].is_some(), path, &ground, start))
        .chain(aircraft.iter().map(|aircraft| flight(aircraft.id(), false, &aircraft.path, &ground, start)))
        .collect();
    let (identified, heard) = (others.identified, others.sent);
    Ok(Simulation { config, flights, identified, labels, attacks, sent, heard, heard_files, datagrams })
}

/// All that radars may detect: the drones, then everything else.
fn targets(scenario: &Scenario, drones: &[Path], steps: usize, streams: &Streams) -> Vec<Target> {
    let Scenario { airspace, birds, clutter, .. } = scenario;
    let fleet = &scenario.drones;
    let mut targets: Vec<Target> = drones
        .iter()
        .enumerate()
        .map(|(drone, path)| Target {
            number: motion::number(fleet, drone),
            path: path.clone(),
            drone: Some(drone),
            uav_probability: 0.0,
        })
        .collect();
    let mut other = |paths: Vec<Path>, probability: &dyn Fn(&mut Stream) -> f64| {
        for path in paths {
            let number = OTHERS + targets.len() - drones.len();
            let uav_probability = probability(&mut streams.of(Entity::Character, number));
            targets.push(Target { number, path, drone: None, uav_probability });
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

/// A crewed aircraft as radars and cameras see it. Nothing takes it for a drone.
fn crewed_target(aircraft: &Aircraft) -> Target {
    let (number, path) = (CREWED + aircraft.number, aircraft.path.clone());
    Target { number, path, drone: None, uav_probability: 0.0 }
}

/// Which drones carry a transponder, and how it is attacked: drawn by lot, so that multirotors and fixed wings, equipped or
/// not, come in all combinations.
fn roles(drones: &Drones, count: usize, streams: &Streams) -> Vec<Option<Role>> {
    let lot = |drone| streams.of(Entity::Role, motion::number(drones, drone)).within(Span::new(0.0, 1.0));
    let mut lots: Vec<(f64, usize)> = (0..count).map(|drone| (lot(drone), drone)).collect();
    lots.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut roles = vec![None; count];
    for (rank, &(_, drone)) in lots.iter().take(drones.equipped as usize).enumerate() {
        let rank = rank as u32;
        roles[drone] = Some(match rank {
            _ if rank < drones.spoofed => Role::Spoofed,
            _ if rank < drones.spoofed + drones.jammed => Role::Jammed,
            _ => Role::Honest,
        });
    }
    roles
}

fn plot_label(radar: &Radar, detection: &Detection, ids: &[Option<String>], start: Time) -> Label {
    Label {
        time: stamped(after(start, detection.time_s)),
        sensor: radar.id.clone(),
        number: detection.number.into(),
        id: ids[detection.target].clone(),
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

/// Exchanges the identities of those that are swapped, two by two; all attacks.
fn attacked(transponders: &mut [(usize, Transmissions)], duration_s: f64, start: Time) -> Vec<Attacked> {
    let is_swapped = |sends: &Transmissions| sends.lie.is_some_and(|lie| lie.attack == Attack::Swapped);
    let mut swapped = transponders.iter_mut().map(|(_, sends)| sends).filter(|sends| is_swapped(sends));
    while let (Some(one), Some(other)) = (swapped.next(), swapped.next()) {
        let Some(lie) = one.lie else { continue };
        attack::swap(lie.span, &mut one.reports, &mut other.reports);
        // Both at once.
        other.lie = Some(lie);
    }
    let attacked = |(drone, sends): &(usize, Transmissions)| {
        let lie = sends.lie.map(|lie| (Some(lie.attack), lie.span));
        let (attack, span) = lie.or_else(|| Some((None, sends.jammed_s?)))?;
        Some(Attacked {
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

fn flight(id: String, equipped: bool, path: &Path, ground: &Ground, start: Time) -> Flight {
    let sample = |(step, state): (usize, &motion::Kinematics)| {
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
    Flight { id, equipped, samples: path.samples().iter().enumerate().map(sample).collect() }
}
