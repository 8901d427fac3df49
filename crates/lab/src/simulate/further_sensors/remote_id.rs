//! Remote ID of drones and of fakes, as a gateway forwards it: one line of JSON per frame.

use jiff::Timestamp;
use nalgebra::Vector3;
use remote_id::{
    BasicId, HeightAbove, IdType, Location, LocationContent, Message, Status, System, SystemContent, UaType,
    pack,
};

use super::{FurtherSensor, FurtherSensors, SensorScene, drones};
use crate::evaluate::Label;
use crate::simulate::wire::{SentDatagram, after, serial_text};
use crate::simulate::{drone_id, wire};
use fusion::time::{SECOND, Time};
use input::hex;
use site::config::{self, SensorKind};
use world::motion::{self, FlightPath, RATE_HZ};
use world::scenario::{Airspace, RemoteId, Span};
use world::streams::{Entity, GaussMarkov, RandomStream};

/// Path-loss exponent.
const EXPONENT: f64 = 2.5;
/// Strength of the weakest frame that is received, dBm.
const FLOOR_DBM: f64 = -95.0;
/// Noise of each frame's strength, decibels.
const NOISE_DB: f64 = 3.0;
/// Height of the receiver, and of a person on the ground, metres above ground.
const STANDS_AGL_M: f64 = 3.0;
/// One frame in three carries the identity; one in thirty the operator's position.
const IDENTITY_EVERY: u32 = 3;
const SYSTEM_EVERY: u32 = 30;
/// Heights of fake drones, metres above ground.
const FAKES_AGL_M: Span = Span::new(40.0, 110.0);
/// First number of fakes, in serial numbers and labels.
const FAKES: u32 = 9_000_000;
/// A tenth of a second, ns.
const TENTH_NS: i64 = SECOND / 10;
/// Seconds from 1970 to 2019.
const BEGIN_OF_2019_S: i64 = 1_546_300_800;

/// A transmitter.
struct Beacon<'a> {
    path: &'a FlightPath,
    /// True position of the transmitter, if it differs from the reported one.
    from: Option<Vector3<f64>>,
    transmitter: String,
    serial: String,
    /// Number in the labels.
    number: u32,
    id: Option<String>,
    rate_hz: f64,
    /// Interval of transmission, seconds.
    span: Span,
    stream: RandomStream,
}

/// Adds everything that the receiver forwards.
pub fn add_reports(scene: &SensorScene<'_>, further: &mut FurtherSensors) {
    let model = &scene.scenario.remote_id;
    let sensor = further.receivers.len();
    further.receivers.push(FurtherSensor {
        sensor: super::sensor(
            scene.scenario,
            (&model.id, model.sac, model.sic),
            model.period_s,
            ([239, 192, 201, 1], 8201),
            SensorKind::RemoteId(config::Transponder::default()),
        ),
        file: "remote-id.ndjson",
    });
    drones(scene, further);
    let duration_s = scene.scenario.duration_s;
    for drone in chosen(scene) {
        let number = motion::number(&scene.scenario.drones, drone);
        let mut stream = scene.streams.of(Entity::Beacon, number);
        let is_same = scene.equipped[drone] && model.same_serial;
        let serial = if is_same { serial_text(drone) } else { own_serial(drone as u32 + 1) };
        further.identity(drone_id(drone), "unmanned").remote_id = Some(serial.clone());
        if !scene.equipped[drone] {
            further.numbers.insert(serial.clone(), wire::transponder_number(drone));
        }
        let beacon = Beacon {
            path: &scene.drones[drone],
            from: None,
            transmitter: address(&mut stream),
            serial,
            number: wire::transponder_number(drone),
            id: Some(drone_id(drone)),
            rate_hz: stream.within(model.rate_hz),
            span: Span::new(0.0, duration_s),
            stream,
        };
        broadcast(scene, model, beacon, sensor, further);
    }
    let airspace = Airspace {
        east_m: model.fakes_east_m,
        north_m: model.fakes_north_m,
        radius_m: model.fakes_radius_m,
        height_agl_m: FAKES_AGL_M,
    };
    let steps = (duration_s * RATE_HZ as f64) as usize + 1;
    for fake in 0..model.fakes {
        let mut stream = scene.streams.of(Entity::Fake, fake as usize);
        let path = motion::seeming(scene.scenario, &airspace, steps, &mut stream);
        let begins_s = stream.within(model.fakes_after_s);
        let ends_s = if model.fakes_last_s > 0.0 { begins_s + model.fakes_last_s } else { duration_s };
        let serial = own_serial(FAKES + fake + 1);
        further.identity(format!("F{}", fake + 1), "fake").remote_id = Some(serial.clone());
        let beacon = Beacon {
            path: &path,
            from: Some(Vector3::new(model.fakes_east_m, model.fakes_north_m, STANDS_AGL_M)),
            transmitter: address(&mut stream),
            serial,
            number: FAKES + fake + 1,
            id: None,
            rate_hz: model.fakes_rate_hz,
            span: Span::new(begins_s, ends_s.min(duration_s)),
            stream,
        };
        broadcast(scene, model, beacon, sensor, further);
    }
}

/// Drones with Remote ID: chosen at random, or those without a transponder first.
fn chosen(scene: &SensorScene<'_>) -> Vec<usize> {
    let model = &scene.scenario.remote_id;
    let lot = |drone| {
        let number = motion::number(&scene.scenario.drones, drone);
        scene.streams.of(Entity::BeaconRole, number).within(Span::new(0.0, 1.0))
    };
    let mut lots: Vec<(bool, f64, usize)> = (0..scene.drones.len())
        .map(|drone| (model.unequipped_first && scene.equipped[drone], lot(drone), drone))
        .collect();
    lots.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut drones: Vec<usize> = lots.into_iter().take(model.drones as usize).map(|lot| lot.2).collect();
    drones.sort_unstable();
    drones
}

/// Serial number after ANSI/CTA-2063-A: four characters of the manufacturer, the length of the rest, the rest.
fn own_serial(number: u32) -> String {
    format!("SMTR7{number:07}")
}

/// Random radio address, locally administered as in real transmitters.
fn address(stream: &mut RandomStream) -> String {
    let octets = stream.octets(6);
    // Set the bit for a locally administered address and clear the multicast bit.
    let text: Vec<String> = octets.iter().map(|octet| format!("{octet:02x}")).collect();
    let first = format!("{:02x}", octets[0] & 0xfc | 0x02);
    [&[first], &text[1..]].concat().join(":")
}

/// Properties of one transmitter that are constant over a flight.
struct Habits {
    says_altitude: bool,
    says_accuracy: bool,
    sends_packs: bool,
    /// End of the time without a position, seconds.
    lost_until_s: f64,
    late_s: f64,
}

impl Habits {
    fn new(model: &RemoteId, from_s: f64, stream: &mut RandomStream) -> Self {
        let is_lost = stream.chance(model.lost_share);
        let lost_s = stream.within(model.lost_s);
        Self {
            says_altitude: !stream.chance(model.altitude_unknown),
            says_accuracy: !stream.chance(model.accuracy_unknown),
            sends_packs: stream.chance(model.pack_share),
            lost_until_s: if is_lost { from_s + lost_s } else { from_s },
            late_s: stream.within(model.stamped_late_s),
        }
    }
}

/// Appends the frames of one transmitter that are received.
fn broadcast(
    scene: &SensorScene<'_>,
    model: &RemoteId,
    beacon: Beacon<'_>,
    sensor: usize,
    further: &mut FurtherSensors,
) {
    let Beacon { path, span, mut stream, .. } = beacon;
    let stream = &mut stream;
    let habits = Habits::new(model, span.low, stream);
    let mut bias = [model.gnss_horizontal_m, model.gnss_horizontal_m, model.gnss_vertical_m]
        .map(|sigma_m| GaussMarkov::new(sigma_m, model.gnss_time_s, span.low, stream));
    let mut fading = GaussMarkov::new(model.fading_db, model.fading_s, span.low, stream);
    let receiver = Vector3::new(model.east_m, model.north_m, STANDS_AGL_M);
    let identity =
        Message::BasicId(BasicId::new(IdType::SerialNumber, UaType::Rotorcraft, beacon.serial.as_bytes()));
    let take_off = path.at(span.low).position;
    let mut frame = stream.below(SYSTEM_EVERY as usize) as u32;
    let mut time_s = span.low + stream.within(Span::new(0.0, model.period_s));
    let (mut next_s, mut arrives_s) = (time_s, 0.0_f64);
    let (mut location, mut stamp, mut is_labelled) = (None, scene.start, true);
    while time_s < span.high {
        if time_s >= next_s {
            next_s += model.period_s;
            let state = path.at(time_s);
            let error = Vector3::from(bias.each_mut().map(|axis| axis.at(time_s, stream)))
                + Vector3::from_fn(|_, _| stream.normal(model.gnss_white_m));
            stamp = tenth(after(scene.start, time_s + habits.late_s));
            let said = motion::KinematicState { position: state.position + error, velocity: state.velocity };
            let content = content(scene, &habits, &said, take_off.z, (time_s, stamp));
            is_labelled = content.place_deg.is_none();
            location = Some(Message::Location(Location::new(&content)));
        }
        let from = beacon.from.unwrap_or_else(|| path.at(time_s).position);
        let distance_m = (from - receiver).norm().max(1.0);
        let margin_db = 10.0 * EXPONENT * (model.range_m / distance_m).log10()
            + fading.at(time_s, stream)
            + stream.normal(NOISE_DB);
        // Frames stay in order within a gateway.
        arrives_s = (time_s + stream.within(model.latency_s)).max(arrives_s);
        frame += 1;
        if let Some(location) = location
            && margin_db > 0.0
        {
            let messages = messages(scene, take_off, (frame, habits.sends_packs), (identity, location));
            if messages.contains(&location) && !is_labelled {
                is_labelled = true;
                further.labels.push(Label {
                    time: stamp,
                    sensor: model.id.clone(),
                    number: beacon.number,
                    id: beacon.id.clone(),
                    seduced: false,
                    identity: Some(beacon.serial.clone()),
                });
            }
            let octets: Option<Vec<u8>> = match &messages[..] {
                [one] => Some(one.octets().to_vec()),
                several => pack(several),
            };
            let received = after(scene.start, time_s);
            let payload = octets.map(|octets| line(model, &beacon.transmitter, received, margin_db, &octets));
            let arrives = after(scene.start, arrives_s);
            further.sent.extend(payload.map(|payload| SentDatagram { arrives, sensor, payload }));
        }
        time_s += stream.within(Span::new(0.8, 1.2)) / beacon.rate_hz;
    }
}

/// Messages of a frame: one message, or in a pack all messages that are due.
fn messages(
    scene: &SensorScene<'_>,
    take_off: Vector3<f64>,
    (frame, is_pack): (u32, bool),
    (identity, location): (Message, Message),
) -> Vec<Message> {
    let is_identity = frame % IDENTITY_EVERY == 0;
    let system = (frame % SYSTEM_EVERY == 1).then(|| {
        let place = scene.ground.geodetic(&take_off);
        Message::System(System::new(&SystemContent {
            location_type: 0,
            classification: 1,
            operator_deg: Some([place.latitude_deg(), place.longitude_deg()]),
            area_count: 1,
            area_radius_m: 0.0,
            area_ceiling_m: None,
            area_floor_m: None,
            category_and_class: [1, 0],
            operator_altitude_m: None,
            time_s: u32::try_from(scene.start.nanos() / SECOND - BEGIN_OF_2019_S).unwrap_or(0),
        }))
    });
    match system {
        system if is_pack => {
            is_identity.then_some(identity).into_iter().chain([location]).chain(system).collect()
        }
        Some(system) => vec![system],
        None if is_identity => vec![identity],
        None => vec![location],
    }
}

/// Content of a location message.
fn content(
    scene: &SensorScene<'_>,
    habits: &Habits,
    state: &motion::KinematicState,
    take_off_m: f64,
    (time_s, stamp): (f64, Time),
) -> LocationContent {
    let place = scene.ground.geodetic(&state.position);
    let velocity = state.velocity;
    let known = |value: f64| habits.says_accuracy.then_some(value);
    LocationContent {
        status: Status::Airborne,
        course_deg: Some(velocity.x.atan2(velocity.y).to_degrees()),
        speed_m_s: Some(velocity.xy().norm()),
        climb_m_s: Some(velocity.z),
        place_deg: (time_s >= habits.lost_until_s).then(|| [place.latitude_deg(), place.longitude_deg()]),
        pressure_altitude_m: None,
        geodetic_altitude_m: habits.says_altitude.then_some(place.height_m),
        height_m: Some((state.position.z - take_off_m, HeightAbove::TakeOff)),
        accuracy_h_m: known(10.0),
        accuracy_v_m: known(10.0),
        accuracy_pressure_m: None,
        accuracy_speed_m_s: known(1.0),
        seconds_of_hour: Some(stamp.nanos().rem_euclid(3600 * SECOND) as f64 / SECOND as f64),
        accuracy_time_s: known(0.3),
    }
}

/// Rounds to a tenth of a second, the resolution of the message.
fn tenth(time: Time) -> Time {
    Time::from_nanos((time.nanos() + TENTH_NS / 2).div_euclid(TENTH_NS) * TENTH_NS)
}

/// A gateway's line for one message.
fn line(model: &RemoteId, transmitter: &str, received: Time, margin_db: f64, octets: &[u8]) -> Vec<u8> {
    let millis = received.nanos().div_euclid(SECOND / 1000);
    let time =
        Timestamp::from_millisecond(millis).map_or_else(|_| String::new(), |stamp| format!("{stamp:.3}"));
    let rssi = (FLOOR_DBM + margin_db).round() as i64;
    let message = hex::text(octets);
    format!(
        "{{\"time\":\"{time}\",\"transmitter\":\"{transmitter}\",\"rssi\":{rssi},\"receiver\":\"{}\",\"message\":\"{message}\"}}",
        model.id
    )
    .into_bytes()
}
