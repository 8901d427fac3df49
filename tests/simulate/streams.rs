//! Random streams: the same seed gives the same octets, and each entity draws independently of the others.

use std::collections::BTreeSet;
use std::fs;

use fusion::time::Time;
use utm_fusion::simulate::{Scenario, SimulatedDatagram, SimulatedFlight, Span, simulate};

use crate::common::{Flown, Scratch, files, fly, kept_path, scenario};

const FILES: [&str; 6] =
    ["radar.ast", "transponder.ast", "capture.pcap", "truth.csv", "labels.csv", "site.toml"];

#[test]
fn same_seed_gives_same_files_and_other_seed_others() {
    let scratch = Scratch::new();
    let made = |name: &str, seed: u64| {
        let directory = scratch.path(name);
        files(&kept_path("midnight"), seed, &directory);
        let mut names: Vec<_> = fs::read_dir(&directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(names.iter().collect::<BTreeSet<_>>(), FILES.map(str::to_owned).iter().collect());
        FILES.map(|file| fs::read(directory.join(file)).unwrap())
    };
    let first = made("first", 7);
    assert!(first == made("again", 7), "the same seed gives other files");
    let other = made("other", 8);
    for (index, name) in FILES.iter().enumerate() {
        assert_ne!(first[index], other[index], "{name}");
    }
}

/// Drones that may meet, and birds; all errors have their defaults.
fn base() -> Scenario {
    scenario(
        r#"
        name = "streams"
        duration_s = 60
        [drones]
        multirotors = 3
        fixed_wings = 2
        equipped = 3
        separation_m = 0
        [birds]
        count = 8
        "#,
    )
}

fn paths(flights: &[SimulatedFlight]) -> Vec<String> {
    let mut paths: Vec<String> = flights.iter().map(|flight| format!("{:?}", flight.samples)).collect();
    paths.sort();
    paths
}

/// Times and positions of the plots of a bird, or of the drone with this path. Track numbers are omitted: the radar
/// assigns them to all targets in turn, and drones may have theirs swapped.
fn plots(flown: &Flown, of: Option<&str>) -> Vec<(Time, String)> {
    let flights = &flown.simulation.flights;
    let is_of = |drone: Option<usize>| match (drone, of) {
        (Some(drone), Some(path)) => format!("{:?}", flights[drone].samples) == path,
        (drone, of) => drone.is_none() && of.is_none(),
    };
    let drones: Vec<bool> = (0..flights.len()).map(|drone| is_of(Some(drone))).collect();
    let others = is_of(None);
    let wanted = flown.plots.iter().filter(|plot| plot.drone.map_or(others, |drone| drones[drone]));
    let mut plots: Vec<_> = wanted
        .map(|plot| (plot.time, format!("{:?} {:?}", plot.position, plot.record.special_purpose)))
        .collect();
    plots.sort();
    plots
}

#[test]
fn one_drone_more_changes_nothing_for_the_others() {
    let before = fly(&base(), 1);
    let alone = paths(&before.simulation.flights);
    for (multirotors, fixed_wings, equipped) in [(4, 2, 3), (4, 2, 4), (3, 3, 3), (3, 3, 4)] {
        let mut scenario = base();
        let drones = &mut scenario.drones;
        (drones.multirotors, drones.fixed_wings, drones.equipped) = (multirotors, fixed_wings, equipped);
        let after = fly(&scenario, 1);
        let joined = paths(&after.simulation.flights);
        assert_eq!(joined.len(), 6);
        assert!(
            alone.iter().all(|path| joined.contains(path)),
            "another path with {multirotors} + {fixed_wings}"
        );
        assert_eq!(plots(&before, None), plots(&after, None), "plots of birds");
        for path in &alone {
            assert_eq!(plots(&before, Some(path)), plots(&after, Some(path)), "plots of a drone");
        }
    }
}

#[test]
fn one_bird_more_changes_nothing_for_drones_and_transponders() {
    let before = fly(&base(), 1);
    let mut scenario = base();
    scenario.birds.count += 1;
    let after = fly(&scenario, 1);
    assert_eq!(before.simulation.flights, after.simulation.flights);
    assert_eq!(of_category(&before, 129), of_category(&after, 129));
    for path in paths(&before.simulation.flights) {
        assert_eq!(plots(&before, Some(&path)), plots(&after, Some(&path)));
    }
}

fn of_category(flown: &Flown, category: u8) -> Vec<&SimulatedDatagram> {
    let datagrams = flown.simulation.datagrams.iter();
    datagrams.filter(|datagram| (datagram.payload[0] == 129) == (category == 129)).collect()
}

#[test]
fn a_key_of_one_sensor_changes_no_octet_of_the_other() {
    let before = fly(&base(), 1);
    let mut scenario = base();
    scenario.transponder.period_s = Span::new(1.0, 1.5);
    let other_transponders = fly(&scenario, 1);
    assert_eq!(of_category(&before, 48), of_category(&other_transponders, 48));
    assert_ne!(of_category(&before, 129), of_category(&other_transponders, 129));
    let mut scenario = base();
    scenario.radars[0].track_azimuth_deg = 2.0;
    scenario.radars[0].seen_s = 60.0;
    let other_radar = fly(&scenario, 1);
    assert_ne!(of_category(&before, 48), of_category(&other_radar, 48));
    assert_eq!(of_category(&before, 129), of_category(&other_radar, 129));
    assert_eq!(before.simulation.flights, other_radar.simulation.flights);
}

#[test]
fn name_and_seed_are_both_part_of_the_streams() {
    let flights = |name: &str, seed| {
        let scenario = Scenario { name: name.to_owned(), ..base() };
        simulate(&scenario, seed, None).unwrap().flights
    };
    assert_eq!(flights("a", 1), flights("a", 1));
    assert_ne!(flights("a", 1), flights("a", 2));
    assert_ne!(flights("a", 1), flights("b", 1));
}

#[test]
fn another_start_shifts_everything_and_changes_nothing_else() {
    let scenario = base();
    let later = Time::from_nanos(scenario.start_time().nanos() + 86_400_000_000_000 * 3);
    let [a, b] = [None, Some(later)].map(|start| simulate(&scenario, 1, start).unwrap());
    assert_eq!(a.datagrams.len(), b.datagrams.len());
    for (a, b) in a.datagrams.iter().zip(&b.datagrams) {
        assert_eq!((b.received - a.received).as_hours(), 72);
        assert_eq!(a.payload, b.payload, "whole days later the times of day are the same");
    }
}
