//! The scenarios in `config/scenarios`.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use utm_fusion::simulate::{Radar, Scenario, simulate};

use crate::common::{kept, kept_path, scenario};

#[test]
fn every_scenario_flies() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios");
    let names: BTreeSet<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    for needed in [
        "single",
        "crossing",
        "dense",
        "bias",
        "paper",
        "spoof",
        "gaps",
        "braking",
        "fast",
        "flock",
        "city",
        "midnight",
        "two-radars",
        "three-radars",
        "airfield",
        "event",
        "crossing-crewed",
        "remote-id",
        "fakes",
        "swarm",
        "barometric",
        "two-transponders",
        "two-networks",
        "slow-gnss",
        "late-stamps",
        "radar-clock",
        "ghosts",
        "flocks-40",
        "swaps",
    ] {
        assert!(names.contains(needed), "{needed}");
    }
    for name in names {
        let mut scenario = kept(&name);
        // A scenario with additional aircraft keeps the name of its base, and therefore its random streams.
        assert_eq!(scenario.name, name.trim_end_matches("-crewed"));
        scenario.duration_s = 20.0;
        let simulation = simulate(&scenario, 1, None).unwrap();
        let drones = simulation.flights.iter().filter(|flight| flight.id.starts_with('D')).count();
        assert_eq!(drones, scenario.drone_count() as usize);
        let equipped = simulation.flights.iter().filter(|flight| flight.equipped).count();
        assert_eq!(equipped, scenario.drones.equipped as usize, "{name}");
        assert!(!simulation.datagrams.is_empty() && !simulation.labels.is_empty() || name == "every-key");
    }
}

#[test]
fn scenarios_match_their_names() {
    let drones = |name: &str| {
        let drones = kept(name).drones;
        (drones.multirotors + drones.fixed_wings, drones.equipped)
    };
    assert_eq!((drones("single"), drones("dense"), drones("crossing").0), ((1, 1), (50, 40), 10));
    assert_eq!((drones("city").0, kept("dense").birds.count), (500, 60));
    assert_eq!(kept("dense").drones.separation_m, 30.0);
    let birds = kept("city").birds;
    assert_eq!(birds.count + birds.flocks * birds.flock_size, 500);
    assert_eq!(kept("bias").radars[0].bias_azimuth_deg, 2.0);
}

/// `UPDATE=1 cargo test --test simulate every_key` writes the file.
#[test]
fn every_key_is_shown_with_its_default() {
    let defaults = scenario("name = \"every-key\"");
    assert_eq!(defaults.radars, [Radar::default()]);
    let shown = defaults.show();
    let path = kept_path("every-key");
    if std::env::var_os("UPDATE").is_some() {
        fs::write(&path, &shown).unwrap();
    }
    assert_eq!(fs::read_to_string(&path).unwrap(), shown, "UPDATE=1 writes it anew");
    assert_eq!(kept("every-key"), defaults);
    assert!(shown.contains("\n[[radars]]\n"));
    assert!(shown.lines().all(|line| line.chars().count() <= 150), "no line is too long to read");
}

#[test]
fn printed_scenario_is_parsed_again() {
    for name in ["midnight", "city", "spoof", "crossing", "three-radars", "airfield", "event"] {
        let scenario = kept(name);
        assert_eq!(Scenario::parse(&scenario.show(), "shown").unwrap(), scenario);
    }
    let odd = scenario("name = \"odd\"\nstart = \"2026-03-14T23:59:59.123456789Z\"\nradars = []");
    assert_eq!(Scenario::parse(&odd.show(), "shown").unwrap(), odd);
}
