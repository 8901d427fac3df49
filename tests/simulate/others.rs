//! ADS-B of crewed aircraft, Remote ID and cameras: arriving data compared with the truth. They change nothing else.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use asterix::cat021::{self, Edition};
use asterix::{Record, TimeOfDay, blocks, cat015, cat048, cat129};
use fusion::frames::{AtSite, Geodetic, TangentPlane};
use fusion::time::{SECOND, Time};
use remote_id::{IdType, Location, Message, messages};
use serde_json::Value;
use utm_fusion::simulate::{Scenario, Simulation, simulate};

use crate::common::{Scratch, between, files, kept, kept_path, ran, scenario, utm_fusion};

/// True positions: the plane at the origin, and each flight by its id.
struct Truth<'a> {
    simulation: &'a Simulation,
    plane: TangentPlane<AtSite>,
    undulation_m: f64,
}

impl<'a> Truth<'a> {
    fn new(scenario: &Scenario, simulation: &'a Simulation) -> Self {
        let place = &scenario.place;
        let height_m = place.ground_amsl_m + place.geoid_undulation_m;
        let origin = Geodetic::from_degrees(place.latitude_deg, place.longitude_deg, height_m);
        Self { simulation, plane: TangentPlane::at(origin), undulation_m: place.geoid_undulation_m }
    }

    fn enu(&self, latitude_deg: f64, longitude_deg: f64, height_m: f64) -> [f64; 3] {
        self.plane.from_geodetic(Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)).0.into()
    }

    /// East, north, up at the time, metres: linear between samples.
    fn at(&self, id: &str, time: Time) -> [f64; 3] {
        let flight = self.simulation.flights.iter().find(|flight| flight.id == id).unwrap();
        let since = (time - flight.samples[0].time).as_secs_f64() * 10.0;
        let before = (since.max(0.0) as usize).min(flight.samples.len() - 2);
        let place = |index: usize| {
            let sample = &flight.samples[index];
            let height_m = sample.altitude_amsl_m + self.undulation_m;
            self.enu(sample.latitude_deg, sample.longitude_deg, height_m)
        };
        let (a, b, part) = (place(before), place(before + 1), since - before as f64);
        std::array::from_fn(|axis| a[axis] + (b[axis] - a[axis]) * part)
    }
}

/// The time with this time of day nearest to a reception.
fn instant(time: TimeOfDay, received: Time) -> Time {
    let day = 86_400 * SECOND;
    let off = (time.seconds() * SECOND as f64) as i64 - received.nanos().rem_euclid(day);
    Time::from_nanos(received.nanos() + (off + day / 2).rem_euclid(day) - day / 2)
}

fn horizontal_m(one: [f64; 3], other: [f64; 3]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// All records of a category as they arrived.
fn records<R: Record>(simulation: &Simulation, edition: R::Edition) -> Vec<(Time, R)> {
    let mut records = Vec::new();
    for datagram in simulation.datagrams.iter().filter(|datagram| datagram.payload[0] == R::CATEGORY) {
        for block in blocks(&datagram.payload) {
            for located in block.unwrap().records_in::<R>(edition) {
                records.push((datagram.received, located.unwrap().record));
            }
        }
    }
    records
}

/// Octets that sensors of these categories sent, with their times.
fn of_categories(simulation: &Simulation, categories: [u8; 3]) -> Vec<(Time, Vec<u8>)> {
    let wanted = simulation.datagrams.iter().filter(|datagram| categories.contains(&datagram.payload[0]));
    wanted.map(|datagram| (datagram.received, datagram.payload.clone())).collect()
}

const RADARS_AND_TRANSPONDERS: [u8; 3] = [34, cat048::Record::CATEGORY, cat129::Record::CATEGORY];

#[test]
fn crewed_aircraft_beside_a_scenario_change_nothing_of_it() {
    for seed in [1, 2] {
        let alone = simulate(&kept("crossing"), seed, None).unwrap();
        let mut beside = kept("crossing-crewed");
        let joined = simulate(&beside, seed, None).unwrap();
        assert_eq!(alone.flights, joined.flights[..alone.flights.len()]);
        assert!(joined.flights.len() == alone.flights.len() + 7);
        let all = |simulation: &Simulation| of_categories(simulation, RADARS_AND_TRANSPONDERS);
        assert!(all(&alone) == all(&joined), "other octets of the drones");
        let heard = |simulation: &Simulation| {
            let labels = simulation.labels.iter().filter(|label| label.sensor != "adsb");
            labels.cloned().collect::<Vec<_>>()
        };
        assert_eq!(heard(&alone), heard(&joined));
        // Neither does a bad network for these sensors, nor additional Remote ID and a camera.
        beside = kept("crossing");
        beside.network.lost = 0.1;
        beside.network.duplicated = 0.1;
        let alone = simulate(&beside, seed, None).unwrap();
        beside.crewed.transits = 2;
        beside.remote_id.drones = 5;
        beside.remote_id.fakes = 3;
        beside.cameras = vec![utm_fusion::simulate::Camera::default()];
        assert!(all(&alone) == all(&simulate(&beside, seed, None).unwrap()));
        // A radar that detects crewed aircraft does.
        beside.crewed.transits = 8;
        beside.crewed.radius_m = 2000.0;
        beside.radars[0].sees_crewed = true;
        let seen = simulate(&beside, seed, None).unwrap();
        assert!(all(&alone) != all(&seen));
        let of_radar = |label: &&utm_fusion::evaluate::Label| label.sensor == "gamekeeper";
        let is_crewed =
            |label: &utm_fusion::evaluate::Label| label.id.as_ref().is_some_and(|id| id.starts_with('A'));
        assert!(seen.labels.iter().filter(of_radar).any(is_crewed));
    }
}

#[test]
fn adsb_is_that_of_a_real_feed() {
    let mut scenario = scenario(
        "name = \"adsb\"\nhas_radars = false\n[transponder]\nhas_receiver = false\n[crewed]\ntransits = 60\ncircuits = 20\n\
         helicopters = 20\nvehicles = 10\n[adsb]\ngap_every_s = 0\n",
    );
    scenario.duration_s = 120.0;
    let simulation = simulate(&scenario, 1, None).unwrap();
    let truth = Truth::new(&scenario, &simulation);
    let ids: BTreeMap<String, String> =
        simulation.identified.iter().map(|entry| (entry.icao24.clone().unwrap(), entry.id.clone())).collect();
    assert_eq!(ids.len(), 110, "addresses are unique");
    let records = records::<cat021::Record>(&simulation, Edition::V2_6);
    // 1 Hz, with 5 % lost.
    between("records a second and aircraft", 0.93, records.len() as f64 / 120.0 / 110.0, 0.97);
    let (mut without_nacp, mut applicable, mut geometric) =
        (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let (mut errors, mut late, mut lateness) = (Vec::new(), 0, Vec::new());
    for (received, record) in &records {
        let address = record.target_address.unwrap().to_string().to_lowercase();
        let id = &ids[&address];
        assert_eq!(record.data_source.unwrap().sic, 210);
        let time = record.position_time.or(record.position_reception).unwrap();
        assert!(record.position_time.is_some() != record.position_reception.is_some());
        let time = instant(time, *received);
        lateness.push((*received - time).as_secs_f64());
        let place = match (record.position, record.fine_position) {
            (Some(place), None) => [place.latitude_deg(), place.longitude_deg()],
            (None, Some(place)) => [place.latitude_deg(), place.longitude_deg()],
            _ => panic!("one position"),
        };
        let error_m = horizontal_m(truth.enu(place[0], place[1], 200.0), truth.at(id, time));
        let speed_m_s = record.ground_vector.unwrap().speed_m_s();
        let category = record.emitter.map(|emitter| emitter.category().code());
        if id.starts_with('V') {
            assert!(matches!(category, Some(20 | 21)) && record.target_report.unwrap().is_on_ground());
            assert!(record.flight_level.is_none() && record.geometric_height.is_none());
            continue;
        }
        // Velocities have noise of 0.4 m/s per axis.
        between("speed, m/s", 58.0, speed_m_s, 122.0);
        let flight_level = record.flight_level.unwrap().flight_level() * 30.48;
        let height_m = truth.at(id, time)[2] + scenario.place.ground_amsl_m;
        between("pressure altitude less height, m", -330.0, flight_level - height_m, 330.0);
        if let Some(geometric_m) = record.geometric_height {
            geometric.insert(id.clone());
            let off_m = geometric_m.height_m() - height_m - truth.undulation_m;
            between("geometric height, m", -30.0, off_m, 30.0);
        }
        if record.quality.unwrap().accuracy_category() == 0 {
            without_nacp.insert(id.clone());
        }
        if record.position_time.is_some() {
            applicable.insert(id.clone());
            errors.push(error_m);
        } else if error_m > 12.0 {
            late += 1;
        }
    }
    let airborne = 100.0;
    between("share without NACp", 0.1, without_nacp.len() as f64 / airborne, 0.3);
    between("share with 071", 0.07, applicable.len() as f64 / airborne, 0.25);
    between("share with 140", 0.75, geometric.len() as f64 / airborne, 0.95);
    let mean_m = errors.iter().sum::<f64>() / errors.len() as f64;
    // Rayleigh's mean for 3 m per axis is 3.8 m; I021/130 rounds to 2.4 m.
    between("mean error where the time is that of the position, m", 2.5, mean_m, 5.0);
    assert!(late > records.len() / 10, "what is stamped on reception lags");
    between("arrival, s", 0.09, lateness.iter().copied().fold(f64::MAX, f64::min), 0.15);
}

#[test]
fn a_conflict_meets_its_drone() {
    for seed in 1..=5 {
        let scenario = kept("airfield");
        let simulation = simulate(&scenario, seed, None).unwrap();
        let truth = Truth::new(&scenario, &simulation);
        let start = simulation.flights[0].samples[0].time;
        let apart = (0..3000).map(|tenth| {
            let time = Time::from_nanos(start.nanos() + tenth * SECOND / 10);
            let (one, other) = (truth.at("X1", time), truth.at("D1", time));
            horizontal_m(one, other).hypot(one[2] - other[2])
        });
        between("closest, m", 0.0, apart.fold(f64::MAX, f64::min), 45.0);
    }
}

/// Octets from hexadecimal digits.
fn octets(digits: &str) -> Vec<u8> {
    (0..digits.len()).step_by(2).map(|at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap()).collect()
}

/// A gateway's line.
struct Heard {
    time: Time,
    transmitter: String,
    rssi: i64,
    messages: Vec<Message>,
}

fn heard(simulation: &Simulation) -> Vec<Heard> {
    let lines = simulation.datagrams.iter().filter(|datagram| datagram.payload.starts_with(b"{"));
    lines
        .map(|datagram| {
            let line: Value = serde_json::from_slice(&datagram.payload).unwrap();
            assert_eq!(line["receiver"], "remote-id");
            let time: jiff::Timestamp = line["time"].as_str().unwrap().parse().unwrap();
            let octets = octets(line["message"].as_str().unwrap());
            Heard {
                time: Time::from_nanos(i64::try_from(time.as_nanosecond()).unwrap()),
                transmitter: line["transmitter"].as_str().unwrap().to_owned(),
                rssi: line["rssi"].as_i64().unwrap(),
                messages: messages(&octets).map(Result::unwrap).collect(),
            }
        })
        .collect()
}

/// Serial number of each transmitter.
fn serials(heard: &[Heard]) -> BTreeMap<&str, String> {
    let mut serials = BTreeMap::new();
    for frame in heard {
        for message in &frame.messages {
            if let Message::BasicId(id) = message {
                assert_eq!(id.id_type(), IdType::SerialNumber);
                let serial = String::from_utf8(id.id().to_vec()).unwrap();
                let before = serials.insert(frame.transmitter.as_str(), serial.clone());
                assert!(before.is_none_or(|before| before == serial));
            }
        }
    }
    serials
}

fn locations(frame: &Heard) -> impl Iterator<Item = &Location> {
    frame.messages.iter().filter_map(|message| match message {
        Message::Location(location) => Some(location),
        _ => None,
    })
}

#[test]
fn remote_id_reports_drone_positions() {
    let mut scenario = kept("crossing");
    scenario.remote_id.drones = 10;
    scenario.remote_id.range_m = 100_000.0;
    scenario.remote_id.pack_share = 0.0;
    let simulation = simulate(&scenario, 3, None).unwrap();
    let truth = Truth::new(&scenario, &simulation);
    let heard = heard(&simulation);
    let serials = serials(&heard);
    assert_eq!(serials.len(), 10);
    let drones: BTreeMap<&str, &str> = (simulation.identified.iter())
        .filter_map(|entry| Some((entry.remote_id.as_deref()?, entry.id.as_str())))
        .collect();
    // Eight have a CAT129 transponder and send the same serial number; two have one after ANSI/CTA-2063-A.
    let own = simulation.identified.iter().filter(|entry| entry.serial.is_none());
    assert_eq!(own.clone().count(), 2);
    for entry in own {
        let serial = entry.remote_id.as_deref().unwrap();
        assert_eq!(serial.len(), 5 + usize::from(serial.as_bytes()[4] - b'0'));
    }
    let (mut identities, mut fresh, mut without_altitude) = (0, BTreeSet::new(), BTreeSet::new());
    for frame in &heard {
        let id = drones[serials[frame.transmitter.as_str()].as_str()];
        identities += usize::from(matches!(frame.messages[0], Message::BasicId(_)));
        for location in locations(frame) {
            let second = location.seconds_of_hour().unwrap();
            let hour = 3600 * SECOND;
            let of_hour = (second * 10.0).round() as i64 * SECOND / 10;
            let off = (of_hour - frame.time.nanos().rem_euclid(hour) + hour / 2).rem_euclid(hour) - hour / 2;
            let stamp = Time::from_nanos(frame.time.nanos() + off);
            fresh.insert((id, stamp));
            let [latitude, longitude] = location.place_deg();
            if [latitude, longitude] == [0.0; 2] {
                continue;
            }
            // Up to 0.35 s late at up to 29 m/s, and GNSS errors.
            let error_m = horizontal_m(truth.enu(latitude, longitude, 150.0), truth.at(id, stamp));
            between("error, m", 0.0, error_m, 25.0);
            match location.geodetic_altitude_m() {
                Some(height_m) => {
                    let expected_m =
                        truth.at(id, stamp)[2] + scenario.place.ground_amsl_m + truth.undulation_m;
                    between("height, m", -15.0, height_m - expected_m, 15.0);
                }
                None => {
                    without_altitude.insert(id);
                }
            }
        }
    }
    between("share of identities", 0.31, identities as f64 / heard.len() as f64, 0.35);
    between("new positions a second", 0.95, fresh.len() as f64 / 3000.0, 1.01);
    between("frames a second", 4.0, heard.len() as f64 / 3000.0, 9.0);
    assert!((1..=6).contains(&without_altitude.len()));
    let labels = simulation.labels.iter().filter(|label| label.sensor == "remote-id");
    assert!(labels.clone().all(|label| fresh.contains(&(label.id.as_deref().unwrap(), label.time))));
    assert!(labels.count() > fresh.len() * 9 / 10);
}

#[test]
fn far_away_remote_id_is_lost_in_bursts() {
    let counts = |range_m: f64| {
        let mut scenario = kept("remote-id");
        scenario.remote_id.range_m = range_m;
        heard(&simulate(&scenario, 1, None).unwrap())
    };
    let (near, far) = (counts(20_000.0), counts(300.0));
    between("share heard", 0.05, far.len() as f64 / near.len() as f64, 0.7);
    // Compares the share of frames received with the share received after a received frame; for independent losses the
    // two are equal.
    let mut all: BTreeMap<&str, Vec<Time>> = BTreeMap::new();
    near.iter().for_each(|frame| all.entry(&frame.transmitter).or_default().push(frame.time));
    let heard: BTreeSet<(&str, Time)> =
        far.iter().map(|frame| (frame.transmitter.as_str(), frame.time)).collect();
    let (mut after_heard, mut after) = (0, 0);
    for (transmitter, times) in &mut all {
        times.sort();
        let is_heard = |time: Time| heard.contains(&(*transmitter, time));
        for pair in times.windows(2).filter(|pair| is_heard(pair[0])) {
            after += 1;
            after_heard += usize::from(is_heard(pair[1]));
        }
    }
    let share = far.len() as f64 / near.len() as f64;
    assert!(after_heard as f64 / after as f64 > share + 0.1, "{after_heard} of {after}, {share}");
}

#[test]
fn fakes_are_twenty_and_come_from_one_place() {
    let scenario = kept("fakes");
    let simulation = simulate(&scenario, 1, None).unwrap();
    let heard = heard(&simulation);
    let serials = serials(&heard);
    let fakes: BTreeSet<&str> = (simulation.identified.iter())
        .filter(|entry| entry.class == "fake")
        .map(|entry| entry.remote_id.as_deref().unwrap())
        .collect();
    assert_eq!((fakes.len(), simulation.flights.len()), (20, 3));
    let is_fake = |frame: &&Heard| fakes.contains(serials[frame.transmitter.as_str()].as_str());
    let start = simulation.flights[0].samples[0].time;
    let mut places: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
    let mut strengths = Vec::new();
    for frame in heard.iter().filter(is_fake) {
        assert!((frame.time - start).as_secs_f64() >= 40.0);
        strengths.push(frame.rssi as f64);
        for location in locations(frame) {
            places.entry(&frame.transmitter).or_default().push(location.place_deg());
        }
    }
    assert_eq!(places.len(), 20);
    // They move, and no label names a drone.
    assert!(places.values().all(|places| places.windows(2).any(|pair| pair[0] != pair[1])));
    let labels =
        simulation.labels.iter().filter(|label| label.sensor == "remote-id" && label.number > 9_000_000);
    assert!(labels.clone().count() > 2000 && labels.into_iter().all(|label| label.id.is_none()));
    // One transmitter: apart from fading, all have the same strength.
    let mean = strengths.iter().sum::<f64>() / strengths.len() as f64;
    let spread =
        strengths.iter().map(|strength| (strength - mean).powi(2)).sum::<f64>() / strengths.len() as f64;
    between("spread of strength, dB", 5.0, spread.sqrt(), 8.0);
}

#[test]
fn a_camera_measures_bearings() {
    let mut scenario = kept("event");
    let camera = &mut scenario.cameras[0];
    (camera.bias_azimuth_deg, camera.bias_elevation_deg) = (0.3, -0.2);
    let simulation = simulate(&scenario, 1, None).unwrap();
    let truth = Truth::new(&scenario, &simulation);
    let camera = &scenario.cameras[0];
    let labels: BTreeMap<(Time, u32), Option<&str>> = (simulation.labels.iter())
        .filter(|label| label.sensor == "camera")
        .map(|label| ((label.time, label.number), label.id.as_deref()))
        .collect();
    let (mut azimuths, mut elevations, mut ended) = (Vec::new(), Vec::new(), 0);
    let mut seen = BTreeSet::new();
    for (received, record) in records::<cat015::Record>(&simulation, ()) {
        let number = u32::from(record.number.unwrap().number());
        let (Some(azimuth), Some(elevation)) = (record.azimuth, record.elevation) else {
            assert_eq!(record.message_type.unwrap().kind(), cat015::MessageKind::TrackEnd);
            ended += 1;
            continue;
        };
        let time = instant(record.time_of_day.unwrap(), received);
        let Some(id) = labels[&(time, number)] else { continue };
        seen.insert(id);
        let at = truth.at(id, time);
        let [east, north] = [at[0] - camera.east_m, at[1] - camera.north_m];
        let up = at[2] - camera.lens_agl_m;
        let off = azimuth.azimuth.unwrap().degrees() - east.atan2(north).to_degrees();
        azimuths.push((off + 180.0).rem_euclid(360.0) - 180.0);
        elevations.push(elevation.elevation.unwrap().degrees() - up.atan2(east.hypot(north)).to_degrees());
        assert!((azimuth.deviation.unwrap().degrees() - 0.1).abs() < 0.001);
    }
    assert!(ended > 10 && seen.len() > 8, "{ended} {seen:?}");
    let statistics = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let spread = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
        (mean, spread.sqrt())
    };
    // The plane of the camera differs from that of the origin, and times have a resolution of 1/128 s, which matters
    // for near helicopters.
    let (mean, spread) = statistics(&azimuths);
    between("bias of azimuths, degrees", 0.27, mean, 0.33);
    between("noise of azimuths, degrees", 0.08, spread, 0.15);
    let (mean, spread) = statistics(&elevations);
    between("bias of elevations, degrees", -0.23, mean, -0.17);
    between("noise of elevations, degrees", 0.16, spread, 0.21);
}

/// Checks that the service accepts the site, and as many reports of each of these sensors as there are labels.
fn taken(directory: &Path, sensors: &[&str]) {
    let site = directory.join("site.toml");
    let (code, shown, errors) = ran(utm_fusion("check").arg("--config").arg(&site));
    assert_eq!(code, 0, "{shown}{errors}");
    let mut replay = utm_fusion("replay");
    let (code, summary, errors) = ran(replay.arg(directory.join("capture.pcap")).arg("--config").arg(&site));
    assert_eq!(code, 0, "{summary}{errors}");
    let labels = fs::read_to_string(directory.join("labels.csv")).unwrap();
    for sensor in sensors {
        let line = summary.lines().find(|line| line.starts_with(&format!("sensor     {sensor} ")));
        let count = line.and_then(|line| line.split_whitespace().nth(3)?.parse::<usize>().ok()).unwrap();
        let sent = labels.lines().filter(|line| line.contains(&format!(",{sensor},"))).count();
        // A position without an identity, or an unknown position, is not a report.
        let least = if *sensor == "remote-id" { sent * 9 / 10 } else { sent };
        assert!((least..=sent).contains(&count), "{sensor}: {sent} sent, {count} accepted: {summary}");
    }
}

#[test]
fn further_sensor_files_are_accepted_by_the_service() {
    let scratch = Scratch::new();
    let directory = scratch.path("airfield");
    files(&kept_path("airfield"), 1, &directory);
    for file in ["adsb.ast", "remote-id.ndjson"] {
        assert!(fs::metadata(directory.join(file)).unwrap().len() > 10_000, "{file}");
    }
    assert!(!directory.join("camera.ast").exists());
    let lines = fs::read_to_string(directory.join("remote-id.ndjson")).unwrap();
    assert!(lines.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()));
    let classes = fs::read_to_string(directory.join("classes.csv")).unwrap();
    let of = |class: &str| classes.lines().filter(|line| line.contains(&format!(",{class},"))).count();
    assert_eq!((of("unmanned"), of("crewed"), of("vehicle"), of("fake")), (5, 5, 1, 0));
    taken(&directory, &["adsb", "remote-id"]);
    let directory = scratch.path("event");
    files(&kept_path("event"), 1, &directory);
    assert!(fs::metadata(directory.join("camera.ast")).unwrap().len() > 10_000);
    taken(&directory, &["gamekeeper", "drone-it", "adsb", "remote-id", "camera"]);
}

#[test]
fn invalid_keys_are_reported_by_name() {
    let wrong = |toml: &str| Scenario::parse(toml, "wrong.toml").unwrap_err().to_string();
    for (toml, key) in [
        ("name = \"a\"\n[remote_id]\ndrones = 1\n", "drones"),
        ("name = \"a\"\n[crewed]\nconflicts = 1\n", "conflicts"),
        (
            "name = \"a\"\n[drones]\nmultirotors = 1\nequipped = 1\n[transponder]\nhas_receiver = false\n",
            "has_receiver",
        ),
        ("name = \"a\"\nhas_radars = false\n[[radars]]\n", "has_radars"),
        ("name = \"a\"\n[[cameras]]\n[[cameras]]\n", "id"),
        ("name = \"a\"\n[adsb]\nid = \"drone-it\"\n", "id"),
    ] {
        let said = wrong(toml);
        assert!(said.contains(key) && said.contains("wrong.toml"), "{toml}: {said}");
    }
}
