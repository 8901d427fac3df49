//! All kinds of sensors at once: one track per aircraft, and a recording that replays to the data sent.

use std::collections::BTreeMap;
use std::fs;
use std::net::Ipv4Addr;
use std::time::Duration;

use fusion::time::Time;
use serde_json::Value;
use utm_fusion::config::{Address, SensorKind};
use utm_fusion::live::now;

use crate::common::{beside, only, replayed, utm_fusion};
use crate::senders::json;
use crate::stage::Stage;

/// Radar, CAT129, CAT021, Remote ID and a camera.
const EVENT: &str = include_str!("../../config/scenarios/event.toml");

/// Sends the flight until `until_s`, each datagram to its sensor.
fn send(stage: &Stage, until_s: f64) {
    let sender = stage.sender();
    let mut sensors: BTreeMap<(Ipv4Addr, u16), usize> = BTreeMap::new();
    for (index, sensor) in stage.simulation.config.sensors.iter().enumerate() {
        for input in &sensor.inputs {
            let Address::Multicast { group, .. } = input.address else { continue };
            sensors.insert((group, input.port), index);
        }
    }
    let start: Time = stage.start();
    for datagram in &stage.simulation.datagrams {
        if datagram.received.seconds_since(start) > until_s {
            break;
        }
        if let Ok(early) = Duration::try_from(datagram.received - now()) {
            std::thread::sleep(early);
        }
        let sensor = sensors[&(datagram.flow.to, datagram.flow.port)];
        sender.send_to(&datagram.payload, stage.to(sensor)).unwrap();
    }
}

#[test]
fn five_sensor_kinds_make_one_picture_that_replays() {
    let scenario = EVENT.replace("duration_s = 300", "duration_s = 24");
    assert_ne!(scenario, EVENT);
    // The flight is too short for a camera to learn its orientation.
    let stage = Stage::new(&scenario, 23_500, |config, _| {
        let camera = config.sensors.iter_mut().find_map(|sensor| match &mut sensor.kind {
            SensorKind::Camera(camera) => Some(camera),
            _ => None,
        });
        camera.unwrap().orientation_deg = 0.0;
    });
    let service = stage.run("run.log");
    send(&stage, 22.0);
    let address = ([127, 0, 0, 1], service.http_port()).into();
    let sensors = json(address, "/api/v1/sensors");
    let mut kinds: Vec<&str> = Vec::new();
    for sensor in sensors["features"].as_array().unwrap() {
        let properties = &sensor["properties"];
        assert_eq!(properties["state"], "operational", "{properties}");
        assert!(properties["accepted"].as_u64().unwrap() > 10, "{properties}");
        kinds.push(properties["kind"].as_str().unwrap());
    }
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(kinds, ["adsb", "camera", "radar", "remote-id", "transponder"]);
    // One track per identity, whether CAT129 or Remote ID or both report it.
    let mut tracks: BTreeMap<String, usize> = BTreeMap::new();
    let picture = json(address, "/api/v1/tracks");
    for track in picture["features"].as_array().unwrap() {
        let properties = &track["properties"];
        let icao24 = &properties["aircraft"]["icao24"];
        let name = if icao24.is_null() { &properties["uas_id"]["serial_number"] } else { icao24 };
        if let Value::String(name) = name {
            *tracks.entry(name.clone()).or_default() += 1;
        }
        assert_eq!(properties["aircraft_type"] == "crewed", !icao24.is_null(), "{properties}");
    }
    assert!(tracks.len() > 8 && tracks.values().all(|&count| count == 1), "{tracks:?}");

    // Clients of readsb find aircraft with ADS-B under their ICAO address.
    let aircraft = json(address, "/data/aircraft.json");
    let aircraft = aircraft["aircraft"].as_array().unwrap();
    let by_adsb = |track: &&Value| !track["properties"]["aircraft"]["icao24"].is_null();
    let crewed: Vec<&Value> = picture["features"].as_array().unwrap().iter().filter(by_adsb).collect();
    assert!(!crewed.is_empty());
    for track in crewed {
        let icao24 = &track["properties"]["aircraft"]["icao24"];
        let entry = aircraft
            .iter()
            .find(|entry| entry["hex"].as_str() == icao24.as_str().map(str::to_lowercase).as_deref());
        let entry = entry.unwrap_or_else(|| panic!("{icao24} is not in aircraft.json"));
        assert_eq!((&entry["type"], entry.get("t")), (&"adsb_icao".into(), None), "{entry}");
        let states_category = !track["properties"]["aircraft"]["emitter_category"].is_null();
        assert_eq!(entry.get("category").is_some(), states_category, "{entry}");
    }
    let others = aircraft.iter().filter(|entry| entry["type"] != "adsb_icao");
    assert!(
        others.clone().count() > 0
            && others.clone().all(|entry| entry["hex"].as_str().unwrap().starts_with('~'))
    );

    let looked_at = json(address, "/api/v1/tracks?sensor=camera");
    for track in looked_at["features"].as_array().unwrap() {
        assert!(by_camera(&track["properties"]).is_some(), "{track}");
    }

    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    let recordings = stage.scratch.path("recordings");
    let input = only(&recordings, "input-", ".pcap");
    let output = only(&recordings, "output-", ".pcap");
    assert!(replayed(&input) == fs::read(&output).unwrap(), "what is replayed is not what was sent");
    // Only tracks seen by the camera name it, with a recent bearing.
    let lines = stage.scratch.path("tracks.ndjson");
    let mut replay = utm_fusion("replay");
    replay.arg(&input).arg("--config").arg(beside(&input, "site.toml")).arg("-o").arg(&lines);
    assert!(replay.output().unwrap().status.success());
    let (mut with, mut without) = (0, 0);
    for line in fs::read_to_string(&lines).unwrap().lines() {
        let track: Value = serde_json::from_str(line).unwrap();
        let Some(part) = by_camera(&track) else {
            without += 1;
            continue;
        };
        let time = |value: &Value| value["time"].as_str().unwrap().parse::<jiff::Timestamp>().unwrap();
        let age_s = time(&track).duration_since(time(part)).as_secs_f64();
        assert!(part["track_number"].is_u64() && (-0.25..10.5).contains(&age_s), "{track}");
        with += 1;
    }
    assert!(with > 10 && without > with, "{with} {without}");
}

/// The camera's part in a track.
fn by_camera(track: &Value) -> Option<&Value> {
    track["contributors"]
        .as_array()?
        .iter()
        .find(|part| part["kind"] == "camera" && part["sensor"] == "camera")
}
