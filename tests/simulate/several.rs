//! Several radars: each has its own position, name, numbers and errors, and labels distinguish them.

use std::collections::{BTreeMap, BTreeSet};

use fusion::time::Time;
use utm_fusion::config::SensorKind;
use utm_fusion::simulate::{Radar, Scenario};

use crate::common::{Flown, between, fly, kept, mean, perfect};

/// Angle at each drone between two radars, degrees, once per second.
fn angles(flown: &Flown, of: &Radar, to: &Radar, first: &Radar) -> Vec<f64> {
    // Positions are relative to the first radar.
    let place = |radar: &Radar| (radar.east_m - first.east_m, radar.north_m - first.north_m);
    let mut angles = Vec::new();
    for drone in 0..flown.simulation.flights.len() {
        for sample in flown.samples(drone).iter().step_by(10) {
            let bearing = |radar: &Radar| {
                let (east_m, north_m) = place(radar);
                (east_m - sample.position.x).atan2(north_m - sample.position.y).to_degrees()
            };
            let turn = (bearing(of) - bearing(to)).rem_euclid(360.0);
            angles.push(turn.min(360.0 - turn));
        }
    }
    angles
}

#[test]
fn ranges_of_neighbours_cross() {
    for name in ["two-radars", "three-radars"] {
        let scenario = kept(name);
        let flown = fly(&scenario, 1);
        for pair in scenario.radars.windows(2) {
            let angles = angles(&flown, &pair[0], &pair[1], &scenario.radars[0]);
            let least = angles.iter().copied().fold(f64::MAX, f64::min);
            let most = angles.iter().copied().fold(f64::MIN, f64::max);
            between(&format!("{name}, least angle"), 60.0, least, 120.0);
            between(&format!("{name}, largest angle"), 60.0, most, 120.0);
        }
    }
}

#[test]
fn each_radar_is_a_sensor_of_its_own() {
    let scenario = kept("three-radars");
    let flown = fly(&scenario, 1);
    let sensors = &flown.simulation.config.sensors;
    let codes: Vec<(u32, u32)> =
        sensors.iter().map(|sensor| (u32::from(sensor.sac), u32::from(sensor.sic))).collect();
    assert_eq!(codes, [(25, 200), (25, 201), (25, 202), (0, 0)]);
    let mut places = BTreeSet::new();
    for (sensor, radar) in sensors.iter().zip(&scenario.radars) {
        let SensorKind::Radar(site) = &sensor.kind else { panic!("{} is no radar", sensor.id) };
        assert_eq!((&sensor.id, sensor.period_s), (&radar.id, Some(radar.period_s)));
        places.insert((format!("{:.4}", site.latitude_deg), format!("{:.4}", site.longitude_deg)));
    }
    assert_eq!(places.len(), 3);
    for (place, radar) in scenario.radars.iter().enumerate() {
        let of_radar = || flown.plots.iter().filter(|plot| plot.sensor == place);
        assert!(of_radar().count() > 500, "{}", radar.id);
        for plot in of_radar() {
            let source = plot.record.data_source.unwrap();
            assert_eq!((u32::from(source.sac), u32::from(source.sic)), (radar.sac, radar.sic));
            assert_eq!(plot.record.height_3d.is_some(), radar.heights);
        }
        let drones: BTreeSet<_> = of_radar().filter_map(|plot| plot.drone).collect();
        assert_eq!(drones.len(), 7, "{} sees every drone in time", radar.id);
    }
}

/// With only its own misalignment, each radar's plots are the drones' positions rotated about the radar.
#[test]
fn each_radar_is_wrong_in_its_own_way_about_its_own_place() {
    let radars = kept("two-radars").radars;
    let mut scenario = perfect(6, 0, 0);
    let honest = scenario.radars[0].clone();
    scenario.radars = radars
        .iter()
        .map(|radar| Radar {
            id: radar.id.clone(),
            sic: radar.sic,
            east_m: radar.east_m,
            north_m: radar.north_m,
            ..honest.clone()
        })
        .collect();
    (scenario.radars[1].bias_range_m, scenario.radars[1].bias_azimuth_deg) = (-30.0, 2.0);
    let flown = fly(&scenario, 1);
    let (mut ranges, mut azimuths, mut misses) = (Vec::new(), Vec::new(), Vec::new());
    for plot in &flown.plots {
        let truth = flown.truth(plot.drone.unwrap(), flown.seconds(plot.time)).position;
        if plot.sensor == 0 {
            misses.push((plot.position - truth).norm());
            continue;
        }
        let polar = |position: nalgebra::Vector3<f64>| {
            let (east, north) = (position.x - radars[1].east_m, position.y - radars[1].north_m);
            (east.hypot(north), east.atan2(north).to_degrees())
        };
        let (told, true_place) = (polar(plot.position), polar(truth));
        ranges.push(told.0 - true_place.0);
        azimuths.push(told.1 - true_place.1);
    }
    // A height is rounded to 25 ft, a range to 7 m.
    between("the first radar's error, m", 0.0, mean(&misses), 5.0);
    between("the second's range, m", -31.0, mean(&ranges), -29.0);
    between("the second's azimuth, degrees", 1.99, mean(&azimuths), 2.01);
}

#[test]
fn labels_distinguish_equal_numbers_of_two_radars() {
    let scenario: Scenario = kept("two-radars");
    let flown = fly(&scenario, 1);
    let names: BTreeSet<&str> = flown.simulation.labels.iter().map(|label| label.sensor.as_str()).collect();
    assert_eq!(names, BTreeSet::from(["south-west", "south-east", "drone-it"]));
    // Drones with each number on either radar, for each second.
    let mut told: BTreeMap<(i64, u16), [BTreeSet<Option<usize>>; 2]> = BTreeMap::new();
    let second = |time: Time| flown.seconds(time) as i64;
    for plot in &flown.plots {
        let of_both = told.entry((second(plot.time), plot.number)).or_default();
        of_both[plot.sensor].insert(plot.drone);
    }
    let shared: Vec<_> = told.values().filter(|both| both.iter().all(|drones| drones.len() == 1)).collect();
    let others = shared.iter().filter(|both| both[0] != both[1]).count();
    println!("{} numbers at once on both radars, {others} of them on two targets", shared.len());
    assert!(others > 100, "numbers are each radar's own");
}
