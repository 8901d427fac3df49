//! Registration of the radars: over restarts, in recordings, and with an invalid file.

use std::fs;
use std::path::Path;

use fusion::Engine;
use fusion::time::Time;
use jiff::SignedDuration;
use serde_json::{Value, json};
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Profile, Record, SensorKind};
use utm_fusion::live::{Driver, DriverEvent};
use utm_fusion::pipeline::{Event, Pipeline};
use utm_fusion::record::{RecordedContents, Recorder};
use utm_fusion::simulate::Simulation;
use utm_fusion::state::{SavedRegistrations, parse_registration, registration_text};

use crate::common::{Running, Scratch, beside, files, flight, on_own_ports, only, replayed, utm_fusion};
use crate::driver::{Fate, Flown, fly};

/// Enough drones to estimate the radar's misalignment in a few minutes.
const SCENARIO: &str = "name = \"registered\"\nduration_s = 150\n[drones]\nmultirotors = 12\nequipped = 12\n";
/// Bearing error of the radar, in degrees.
const TURNED_DEG: f64 = 4.0;

/// A flight seen by a misaligned radar, in the operational profile.
fn turned(seed: u64, start: Option<Time>) -> (Simulation, Config) {
    let simulation = flight(SCENARIO, seed, start);
    let mut config = simulation.config.clone();
    config.fusion.profile = Profile::Operational;
    radar(&mut config).bearing_correction_deg += TURNED_DEG;
    (simulation, config)
}

fn radar(config: &mut Config) -> &mut utm_fusion::config::Radar {
    let radar = config.sensors.iter_mut().find_map(|sensor| match &mut sensor.kind {
        SensorKind::Radar(radar) => Some(radar),
        _ => None,
    });
    radar.unwrap()
}

fn recorded(simulation: &Simulation, config: &Config, fate: &Fate, dir: &Path) -> Flown {
    let record = Record { dir: dir.to_owned(), rotate_mib: 256, keep: 9, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) = Recorder::start(config, &record, Vec::new(), RecordedContents::Service).unwrap();
    let flown = fly(config, &simulation.datagrams, fate, &queue);
    drop(queue);
    assert_eq!(recorder.join().unwritten, 0);
    flown
}

#[test]
fn recording_beginning_with_a_registration_replays() {
    let scratch = Scratch::new();
    let (simulation, config) = turned(1, None);
    let fate = Fate { seed: 1, queue_ms: 300, tick_ms: 400, silence_s: Some((60, 10)), ..Fate::default() };
    let first = scratch.path("first");
    let flown = recorded(&simulation, &config, &fate, &first);
    let input = only(&first, "input-", ".pcap");
    assert!(fs::read(only(&first, "output-", ".pcap")).unwrap() == replayed(&input), "from nothing");

    // A flight an hour later, by a service with the saved registration.
    let later = simulation.datagrams[0].received + SignedDuration::from_hours(1);
    let (simulation, config) = turned(1, Some(later));
    let second = scratch.path("second");
    let fate = Fate { registrations: flown.registrations.clone(), ..fate };
    recorded(&simulation, &config, &fate, &second);
    let input = only(&second, "input-", ".pcap");
    let sent = fs::read(only(&second, "output-", ".pcap")).unwrap();
    assert!(sent == replayed(&input), "from what was known");
    let written = fs::read_to_string(beside(&input, "registration.json")).unwrap();
    assert!(parse_registration(&written).unwrap() == flown.registrations);

    // The summary reports it; without the file the registration is unknown at first, and the output differs.
    let summary = |state: &Path| {
        let mut replay = utm_fusion("replay");
        replay.arg(&input).arg("--config").arg(beside(&input, "site.toml")).arg("--state").arg(state);
        let output = replay.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let told = summary(&beside(&input, "numbers.json"));
    let line = told.lines().find(|line| line.starts_with("registered ")).expect(&told);
    assert!(line.contains("(apply): bearing +"), "{line}");
    let bearing: f64 = line.split("bearing +").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((bearing - TURNED_DEG).abs() < 1.0, "{line}");
    for same in [&beside(&input, "registration.json"), &input, &input.with_extension("")] {
        assert_eq!(summary(same), told, "{}", same.display());
    }
    fs::remove_file(beside(&input, "registration.json")).unwrap();
    assert_ne!(summary(&beside(&input, "numbers.json")), told);
    assert!(sent != replayed(&input), "what was known was not used");
}

/// Runs a service of this configuration with this file; returns its log and its directory.
fn run(config: &Config, port: u16, file: &str) -> (String, Scratch) {
    let scratch = Scratch::new();
    let config = on_own_ports(config, port, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    fs::create_dir(scratch.path("state")).unwrap();
    scratch.file("state/registration.json", file);
    let mut service = Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
    service.says("running");
    assert!(service.is_running());
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    (log, scratch)
}

#[test]
fn registration_is_restored_only_for_the_same_radar() {
    let scratch = Scratch::new();
    let (simulation, mut config) = turned(2, None);
    let registrations = recorded(&simulation, &config, &Fate::default(), &scratch.path("r")).registrations;
    let text = registration_text(&registrations);
    let kept = |scratch: &Scratch| {
        let text = fs::read_to_string(scratch.path("state/registration.json")).unwrap();
        parse_registration(&text).unwrap()
    };

    let (log, after) = run(&config, 22_400, &text);
    assert!(log.contains("registration goes on radars=1"), "{log}");
    assert!(kept(&after) == registrations);

    radar(&mut config).bearing_correction_deg = -1.5;
    let (log, _) = run(&config, 22_410, &text);
    assert!(
        log.contains("begins anew radar=gamekeeper reason=\"bearing_correction_deg was 4 and is -1.5"),
        "{log}"
    );
    assert!(!log.contains("goes on"), "{log}");
    radar(&mut config).bearing_correction_deg = TURNED_DEG;
    radar(&mut config).latitude_deg += 1e-4;
    let (log, _) = run(&config, 22_420, &text);
    assert!(log.contains("reason=\"latitude_deg was "), "{log}");
}

#[test]
fn damaged_registration_file_stops_no_start() {
    let scratch = Scratch::new();
    let (simulation, config) = turned(3, None);
    let registrations = recorded(&simulation, &config, &Fate::default(), &scratch.path("r")).registrations;
    let text = registration_text(&registrations);
    for (file, why) in [
        (&text[..text.len() / 2], "EOF while parsing"),
        ("", "EOF while parsing"),
        ("[1, 2]", "invalid type"),
        (&text.replacen("\"version\":1", "\"version\":7", 1), "its version is 7, and only 1 is known"),
    ] {
        let (log, after) = run(&config, 22_430, file);
        assert!(
            log.contains(why) && log.contains("set aside, another one is begun contents=\"registration\""),
            "{why}: {log}"
        );
        assert_eq!(files(&after.path("state"), "registration.json.damaged-2", "Z").len(), 1);
    }
    // The file is valid, but the radar's state in it is not.
    let contents: Value = serde_json::from_str(&text).unwrap();
    let id = contents["radars"].as_object().unwrap().keys().next().unwrap().clone();
    let state = &contents["radars"][&id]["state"];
    assert!(state["latest"].as_array().unwrap().len() > 1);
    let first = |numbers: &str, other: &str| {
        let rest = numbers.split_once(' ').unwrap().1;
        json!(format!("{other} {rest}"))
    };
    let azimuths = state["settled"]["axes"][0].as_str().unwrap();
    let now = state["now"].as_i64().unwrap();
    let much = vec![state["latest"][0].clone(); 1000];
    // One entry is rejected, for this reason.
    let refused = |place: &str, value: Value, why: &str| {
        let mut hostile = contents.clone();
        *hostile.pointer_mut(place).unwrap() = value;
        let registrations = parse_registration(&hostile.to_string()).unwrap();
        let mut hurt = Pipeline::new(&config, Masks::default());
        let unused = registrations.restore(&config, Some(utm_fusion::live::now()), hurt.engine_mut());
        assert!(unused.len() == 1 && unused[0].contains(why), "{place}: {why}: {unused:?}");
        hurt
    };
    let delays = |engine: &Engine| serde_json::to_value(engine.type_states()).unwrap()[0]["delays"].clone();
    let mut whole = Pipeline::new(&config, Masks::default());
    parse_registration(&text).unwrap().restore(&config, None, whole.engine_mut());
    assert_eq!(delays(whole.engine()).as_object().map(serde_json::Map::len), Some(1));
    for (place, value, why) in [
        ("/version", json!(9), "registration state of version 9"),
        ("/settled/axes/0", first(azimuths, "NaN"), "has numbers beyond"),
        ("/settled/axes/0", first(azimuths, "-inf"), "has numbers beyond"),
        ("/settled/axes/0", first(azimuths, "1e300"), "has numbers beyond"),
        ("/settled/axes/0", json!("1 2 3"), "3 numbers where 42"),
        ("/settled/axes/0", first(azimuths, "a"), "invalid float literal"),
        ("/settled/tracks", json!("-1e9"), "nothing follows from its numbers"),
        ("/settled/profiles", json!([]), "invalid length"),
        ("/now", json!(now + 400 * 86_400_000_000_000_i64), "is still to come"),
        ("/latest/0/time", json!(i64::MAX), "later than itself"),
        ("/latest", json!(much), "it has 1000 tracks"),
        ("", json!(null), "invalid type"),
    ] {
        let hurt = refused(&format!("/radars/{id}/state{place}"), value, why);
        assert_eq!(delays(hurt.engine()), json!({}), "what it showed of delays is relative to it");
        assert!(SavedRegistrations::of(&config, hurt.engine()).is_empty());
    }
    // Its learned errors restart separately.
    for (place, value, why) in [
        ("/version", json!(9), "learning state of version 9"),
        ("/plots", json!("1.0"), "1 numbers where 2"),
        ("/axes/1/straight", json!("1.0 1.0 1.0 1.0 1.0 0.0 0.5"), "nothing follows from its numbers"),
        ("/axes/0/changes", json!([]), "invalid length"),
        ("/velocity", json!("a"), "invalid float literal"),
        ("/now", json!(now + 400 * 86_400_000_000_000_i64), "is still to come"),
        ("", json!({"x": 1}), "unknown field"),
    ] {
        let hurt = refused(&format!("/radars/{id}/learning{place}"), value, why);
        let (_, registered) = hurt.engine().registered().next().unwrap();
        assert_eq!(registered.learning_state().time(), None, "{place}");
    }
    // Each type of transponders restarts separately, too.
    assert_eq!(contents["transponders"]["types"].as_array().map(Vec::len), Some(1));
    for (place, value, why) in [
        ("/version", json!(9), "learning state of version 9"),
        ("/noise/0", json!("0.0 1.0"), "2 numbers where 17"),
        ("/heard", json!(now + 400 * 86_400_000_000_000_i64), "is still to come"),
        ("", json!({"x": 1}), "unknown field"),
    ] {
        let hurt = refused(&format!("/transponders/types/0{place}"), value, why);
        assert!(hurt.engine().learnt_types().is_empty() && hurt.engine().registered().count() == 1);
    }
    let (log, after) = run(&config, 22_440, &text.replacen("\"settled\":{", "\"settled\":{\"x\":1,", 1));
    assert!(log.contains(&format!("begins anew radar={id} reason=\"unknown field")), "{log}");
    assert!(files(&after.path("state"), "registration.json.broken", "").is_empty());
}

#[test]
fn registration_survives_a_silence() {
    let (simulation, config) = turned(4, None);
    let start = simulation.datagrams[0].received;
    let mut driver = Driver::new(&config, Masks::default(), start, 2);
    for datagram in &simulation.datagrams {
        let received = Some(datagram.received);
        let (kind, payload) = (ReceptionKind::Datagram, datagram.payload.clone());
        driver.receive(&Reception { received, input: 0, from: None, kind, origin: 0, payload });
    }
    let known = |driver: &Driver| {
        let engine = driver.pipeline().engine();
        engine.registered().map(|(_, known)| known.estimate).collect::<Vec<_>>()
    };
    let before = known(&driver);
    assert!(before[0].samples > 8.0, "{before:?}");
    let end = simulation.datagrams.last().unwrap().received;
    driver.tick(end + SignedDuration::from_hours(1));
    let restarts = std::iter::from_fn(|| driver.poll())
        .filter(|made| matches!(made, DriverEvent::Event(Event::Restarted)))
        .count();
    assert_eq!(restarts, 1);
    assert!(known(&driver)[0].samples >= before[0].samples);
}
