//! Configuration of a service for a scenario's sensors.

use std::net::Ipv4Addr;

use site::config::{
    self, Address, Alerts, Category, Config, Conflicts, Fusion, Http, Input, Integrity, Map, Output,
    Persistence, PictureKind, RadarAccuracy, Sensor, SensorKind, Sink, Site, TransponderAccuracy,
};
use world::ground::Ground;
use world::scenario::{Radar, Scenario, TRANSPONDER_ID, Transponder};

/// Accuracies from data sheets, which differ from the simulated ones.
const RADAR_ACCURACY: RadarAccuracy = RadarAccuracy { range_m: 5.0, azimuth_deg: 1.0, height_m: Some(10.0) };
const TRANSPONDER_ACCURACY: TransponderAccuracy = TransponderAccuracy { horizontal_m: 3.0, vertical_m: 5.0 };
/// Assumed height of plots without a height, metres above ground.
const ASSUMED_AGL_M: f64 = 75.0;
/// Port offset of a sensor's second line.
const SECOND_LINE_PORTS: u16 = 10;

/// Configuration with the scenario's radars in order, then the transponder receiver, if there is one.
pub fn site(scenario: &Scenario, ground: &Ground) -> Config {
    let place = &scenario.place;
    // A site without a radar has to state the origin of its local frame.
    let origin = scenario.radars.is_empty();
    let mut sensors: Vec<Sensor> = scenario
        .radars
        .iter()
        .enumerate()
        .map(|(index, radar)| radar_sensor(scenario, ground, index, radar))
        .collect();
    if scenario.transponder.has_receiver {
        sensors.push(transponder_sensor(scenario, &scenario.transponder));
    }
    Config {
        site: Site {
            name: scenario.name.clone(),
            sac: place.sac as u8,
            sic: place.sic as u8,
            geoid_undulation_m: Some(place.geoid_undulation_m),
            latitude_deg: origin.then_some(place.latitude_deg),
            longitude_deg: origin.then_some(place.longitude_deg),
            height_amsl_m: origin.then_some(place.ground_amsl_m),
        },
        sensors,
        fusion: Fusion::default(),
        integrity: Integrity::default(),
        conflicts: Conflicts::default(),
        alerts: Alerts::default(),
        areas: Vec::new(),
        output: Output {
            asterix: vec![Sink {
                address: group(Ipv4Addr::new(239, 192, 129, 2)),
                port: 8130,
                ttl: 1,
                picture: PictureKind::Lagged,
                category: Category::Cat129,
            }],
            status: false,
            ..Output::default()
        },
        http: Http::default(),
        map: Map::default(),
        state: Persistence::default(),
        cluster: None,
    }
}

fn radar_sensor(scenario: &Scenario, ground: &Ground, index: usize, radar: &Radar) -> Sensor {
    let antenna = ground.antenna(radar);
    let position = antenna.position;
    let rounded = |value: f64| (value * 1e9).round() / 1e9;
    Sensor {
        id: radar.id.clone(),
        sac: radar.sac as u8,
        sic: radar.sic as u8,
        period_s: Some(radar.period_s),
        inputs: inputs(scenario, Ipv4Addr::new(239, 192, 48, 1 + index as u8), 8048),
        connections: Vec::new(),
        kind: SensorKind::Radar(config::Radar {
            latitude_deg: rounded(position.latitude_deg()),
            longitude_deg: rounded(position.longitude_deg()),
            height_amsl_m: antenna.altitude_amsl_m,
            max_range_m: Some(radar.max_range_m),
            assumed_height_amsl_m: scenario.place.ground_amsl_m + ASSUMED_AGL_M,
            accuracy: Some(RadarAccuracy {
                height_m: RADAR_ACCURACY.height_m.filter(|_| radar.heights),
                ..RADAR_ACCURACY
            }),
            ..config::Radar::default()
        }),
    }
}

fn transponder_sensor(scenario: &Scenario, model: &Transponder) -> Sensor {
    Sensor {
        id: TRANSPONDER_ID.to_owned(),
        sac: model.sac as u8,
        sic: model.sic as u8,
        period_s: Some((model.period_s.low + model.period_s.high) / 2.0),
        inputs: inputs(scenario, Ipv4Addr::new(239, 192, 129, 1), 8129),
        connections: Vec::new(),
        kind: SensorKind::Transponder(config::Transponder {
            accuracy: Some(TRANSPONDER_ACCURACY),
            ..config::Transponder::default()
        }),
    }
}

/// Inputs of a sensor, one per line. Two lines complement each other only if both name their `source`.
pub fn inputs(scenario: &Scenario, address: Ipv4Addr, port: u16) -> Vec<Input> {
    let source = scenario.network.second_line.then_some(Ipv4Addr::LOCALHOST);
    let line = |port| Input { address: group(address), port, source, trailer_octets: None };
    let second = scenario.network.second_line.then(|| line(port + SECOND_LINE_PORTS));
    [Some(line(port)), second].into_iter().flatten().collect()
}

fn group(group: Ipv4Addr) -> Address {
    Address::Multicast { group, interface: Ipv4Addr::LOCALHOST }
}
