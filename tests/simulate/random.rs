//! Random worlds.

use std::collections::BTreeSet;
use std::fs;

use proptest::prelude::*;
use utm_fusion::simulate::random::{self, PARAMETERS, UNUSUAL, random_world};
use utm_fusion::simulate::{Pattern, Scenario, simulate};

use crate::common::{Scratch, ran, utm_fusion};

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn world_is_within_its_ranges_and_flies(seed in any::<u64>()) {
        let drawn = random::drawn(seed);
        prop_assert_eq!(drawn.len(), PARAMETERS.len());
        for random::DrawnParameter { parameter, value, is_unusual } in &drawn {
            let (low, high) = if *is_unusual { parameter.range } else { parameter.usual };
            prop_assert!((low..=high).contains(value), "{} {}", parameter.name, value);
            let inside = (parameter.usual.0..=parameter.usual.1).contains(value);
            prop_assert!(!is_unusual || !inside, "{} {}", parameter.name, value);
        }
        let unusual = drawn.iter().filter(|drawn| drawn.is_unusual).count();
        prop_assert!((UNUSUAL.0..=UNUSUAL.1).contains(&unusual), "{}", unusual);

        let world = random_world(seed);
        prop_assert_eq!(&Scenario::parse(&world.show(), "world.toml").unwrap(), &world);
        prop_assert!(world.drones.equipped >= 1);
        let short = Scenario { duration_s: 20.0, ..world };
        let simulation = simulate(&short, seed, None).unwrap();
        prop_assert_eq!(simulation.flights.len(), short.drone_count() as usize);
        prop_assert!(!simulation.datagrams.is_empty());
    }
}

#[test]
fn worlds_fly_to_their_end() {
    for seed in 1..=20 {
        let world = random_world(seed);
        assert!(simulate(&world, seed, None).is_ok(), "{seed}");
    }
}

#[test]
fn parameters_reach_the_scenario() {
    let value = |seed: u64, name: &str| {
        let drawn = random::drawn(seed);
        drawn.iter().find(|drawn| drawn.parameter.name == name).unwrap().value
    };
    for seed in 1..=30 {
        let world = random_world(seed);
        let (radar, transponder) = (&world.radars[0], &world.transponder);
        assert_eq!(radar.clock_s, value(seed, "radar: clock, s"));
        assert_eq!(transponder.second_share, value(seed, "share of drones with two transponders"));
        assert_eq!(
            transponder.stamped_late_s.high,
            value(seed, "transponders: longest time to the stamp, s")
        );
        let over = value(seed, "radar: random errors over the defaults'");
        assert!((radar.track_azimuth_deg - 1.25 * over).abs() < 0.006);
        let patterns = [Pattern::Free, Pattern::Crossing, Pattern::Formation];
        let pattern = value(seed, "pattern: 0 free, 1 crossing, 2 formation").round();
        assert_eq!(world.drones.pattern, patterns[pattern as usize]);
    }
}

#[test]
fn each_parameter_is_unusual_in_some_worlds_and_usual_in_most() {
    for parameter in PARAMETERS.iter().filter(|parameter| parameter.usual != parameter.range) {
        let is_unusual = |seed| {
            let drawn = random::drawn(seed);
            drawn.iter().any(|drawn| drawn.is_unusual && drawn.parameter.name == parameter.name)
        };
        let unusual = (1..=400).filter(|&seed| is_unusual(seed)).count();
        assert!((5..100).contains(&unusual), "{}: {unusual}", parameter.name);
    }
    let pattern = |seed| random::drawn(seed)[3].value.round() as u32;
    assert_eq!((1..=400).map(pattern).collect::<BTreeSet<u32>>(), [0, 1, 2].into());
}

#[test]
fn names_of_parameters_are_unique() {
    let names: BTreeSet<&str> = PARAMETERS.iter().map(|parameter| parameter.name).collect();
    assert_eq!(names.len(), PARAMETERS.len());
}

#[test]
fn document_has_the_table_of_parameters() {
    assert!(
        include_str!("../../docs/SIMULATION.md").contains(&random::table()),
        "docs/SIMULATION.md lacks this table:\n{}",
        random::table()
    );
}

#[test]
fn command_flies_a_random_world_and_keeps_its_scenario() {
    let scratch = Scratch::new();
    let directory = scratch.path("world");
    let (code, _, errors) =
        ran(utm_fusion("simulate").args(["--random-world", "7", "--out"]).arg(&directory));
    assert_eq!(code, 0, "{errors}");
    let kept = Scenario::load(&directory.join("scenario.toml")).unwrap();
    assert_eq!(kept, random_world(7));
    let again = scratch.path("again");
    let mut command = utm_fusion("simulate");
    command.arg(directory.join("scenario.toml")).args(["--seed", "7", "--out"]).arg(&again);
    assert_eq!(ran(&mut command).0, 0);
    let octets = |directory: &std::path::Path| fs::read(directory.join("capture.pcap")).unwrap();
    assert!(octets(&directory) == octets(&again), "the kept scenario flies the same world");
    for wrong in
        [vec![], vec!["crossing.toml", "--random-world", "7"], vec!["--random-world", "7", "--seed", "2"]]
    {
        let (code, _, _) = ran(utm_fusion("simulate").args(wrong).args(["--out", "nowhere"]));
        assert_eq!(code, 2);
    }
}
