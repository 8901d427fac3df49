//! Reports of a radar: classification, numbers, latency, period, range, items, resolution.

use std::collections::{BTreeMap, BTreeSet};

use asterix::{Record, blocks, cat034, cat048};
use utm_fusion::simulate::Span;

use crate::common::{Plot, between, deviation, fly, mean, perfect, probability};

#[test]
fn drones_look_like_drones_but_for_8_percent() {
    let mut scenario = perfect(1000, 0, 0);
    scenario.duration_s = 20.0;
    (scenario.radars[0].period_s, scenario.radars[0].min_range_m) = (2.0, 0.0);
    let flown = fly(&scenario, 1);
    let likely: Vec<f64> = flown.plots_by_drone().values().map(|plots| probability(plots[0])).collect();
    assert_eq!(likely.len(), 1000);
    let share = |low: f64, high: f64| {
        likely.iter().filter(|p| (low - 0.002..=high + 0.002).contains(*p)).count() as f64 / 1000.0
    };
    between("share of drones that look like birds", 0.055, share(0.02, 0.2), 0.105);
    assert!((share(0.02, 0.2) + share(0.5, 0.95) - 1.0).abs() < 1e-9);
}

#[test]
fn uav_probability_varies_by_track_and_by_plot() {
    let mut scenario = perfect(60, 0, 0);
    let radar = &mut scenario.radars[0];
    (radar.drone_probability, radar.low_share) = (Span::new(0.5, 0.5), 0.0);
    (radar.track_probability, radar.plot_probability) = (0.1, 0.05);
    (radar.seen_s, radar.unseen_s) = (10.0, 10.0);
    let flown = fly(&scenario, 1);
    let tracks = flown.plots_by_number();
    let long: Vec<Vec<f64>> = tracks
        .values()
        .map(|plots| plots.iter().map(|plot| probability(plot)).collect::<Vec<f64>>())
        .filter(|probabilities| probabilities.len() > 20)
        .collect();
    let means: Vec<f64> = long.iter().map(|track| mean(track)).collect();
    let within: Vec<f64> = long.iter().map(|track| deviation(track).powi(2)).collect();
    println!("{} tracks", long.len());
    between("mean", 0.48, mean(&means), 0.52);
    between("from track to track", 0.085, deviation(&means), 0.115);
    between("from plot to plot", 0.046, mean(&within).sqrt(), 0.052);
}

#[test]
fn numbers_wrap_and_none_is_used_twice_at_a_time() {
    let mut scenario = perfect(60, 0, 0);
    let radar = &mut scenario.radars[0];
    (radar.first_number, radar.last_number) = (900, 1000);
    (radar.seen_s, radar.unseen_s) = (3.0, 3.0);
    let flown = fly(&scenario, 1);
    let mut order = Vec::new();
    let mut seen = BTreeMap::new();
    let mut turns: BTreeMap<(i64, u16), usize> = BTreeMap::new();
    for plot in &flown.plots {
        // A number begins with the first plot of another drone.
        if seen.insert(plot.number, plot.drone) != Some(plot.drone) {
            order.push(plot.number);
        }
        let turn = (flown.seconds(plot.time) * 4.0 + 0.01).floor() as i64;
        *turns.entry((turn, plot.number)).or_default() += 1;
    }
    assert!(turns.values().all(|count| *count <= 2), "a turn and the edge of the next");
    // Targets that are seen immediately come in any order within the first turn.
    let first: BTreeSet<u16> = order[..15].iter().copied().collect();
    assert!(first.is_subset(&(900..960).collect()) && first.contains(&900), "{first:?}");
    let last = order.iter().position(|number| *number == 1000).unwrap();
    assert!(order[last..].iter().take(5).any(|number| *number <= 3), "{:?}", &order[last..last + 5]);
    assert!(!order.contains(&0) && order.iter().all(|number| *number <= 1000));
    assert!(order.iter().filter(|number| **number == 500).count() >= 1, "it came round");
}

#[test]
fn a_plot_arrives_a_quarter_to_six_tenths_of_a_second_later() {
    let mut scenario = perfect(50, 0, 0);
    scenario.duration_s = 100.0;
    // Drones all around the radar: those seen late in a turn wait least for the datagram.
    (scenario.airspace.east_m, scenario.airspace.north_m, scenario.airspace.radius_m) = (0.0, 0.0, 2000.0);
    let flown = fly(&scenario, 1);
    // A time of day is rounded by up to 1/256 s.
    let delays: Vec<f64> = flown.plots.iter().map(|plot| plot.received.seconds_since(plot.time)).collect();
    between("shortest, s", 0.246, delays.iter().copied().fold(f64::MAX, f64::min), 0.265);
    between("longest, s", 0.585, delays.iter().copied().fold(f64::MIN, f64::max), 0.604);
    between("mean, s", 0.40, mean(&delays), 0.45);
}

#[test]
fn plots_of_a_target_are_a_period_apart() {
    for period_s in [0.25, 1.0, 4.0] {
        let mut scenario = perfect(10, 0, 0);
        scenario.radars[0].period_s = period_s;
        let flown = fly(&scenario, 1);
        let apart = |plots: Vec<&Plot>| -> Vec<f64> {
            plots.windows(2).map(|pair| pair[1].time.seconds_since(pair[0].time)).collect()
        };
        let intervals: Vec<f64> = flown.plots_by_drone().into_values().flat_map(apart).collect();
        between("mean period / period", 0.995, mean(&intervals) / period_s, 1.005);
        // The antenna meets a moving target slightly later or earlier.
        between("its deviation / period", 0.0, deviation(&intervals) / period_s, 0.02);
    }
}

#[test]
fn a_radar_sees_between_its_ranges_only() {
    let mut scenario = perfect(30, 0, 0);
    (scenario.radars[0].min_range_m, scenario.radars[0].max_range_m) = (1200.0, 1700.0);
    let flown = fly(&scenario, 1);
    for plot in &flown.plots {
        let (range_m, _) = flown.truth(plot.drone.unwrap(), flown.seconds(plot.time)).polar();
        // The range limit applies to the position at the beginning of a turn.
        assert!((1195.0..=1705.0).contains(&range_m), "{range_m}");
    }
    for (drone, plots) in flown.plots_by_drone() {
        let inside = (0..1200)
            .filter(|turn| (1205.0..1695.0).contains(&flown.truth(drone, f64::from(*turn) * 0.25).polar().0))
            .count();
        assert!(plots.len() >= inside, "D{}: {} plots in {inside} turns", drone + 1, plots.len());
    }
}

#[test]
fn heights_velocities_and_service_messages_can_be_switched() {
    for (heights, velocities, service_messages) in [(true, false, true), (false, true, false)] {
        let mut scenario = perfect(3, 0, 0);
        let radar = &mut scenario.radars[0];
        (radar.heights, radar.velocities, radar.service_messages) = (heights, velocities, service_messages);
        let flown = fly(&scenario, 1);
        for plot in &flown.plots {
            let record: &cat048::Record = &plot.record;
            assert_eq!((record.height_3d.is_some(), record.track_velocity.is_some()), (heights, velocities));
        }
        let datagrams = flown.simulation.datagrams.iter();
        let services: usize = datagrams
            .flat_map(|datagram| blocks(&datagram.payload))
            .filter(|block| block.as_ref().is_ok_and(|block| block.category == cat034::Record::CATEGORY))
            .count();
        assert_eq!(services, if service_messages { 300 } else { 0 });
    }
}

/// The error of a perfect radar is at most half of the resolution of CAT048: 1/256 NM, 360/65536 degrees, 25 ft.
#[test]
fn a_perfect_radar_is_wrong_by_the_resolution_of_cat048_only() {
    let flown = fly(&perfect(10, 0, 0), 1);
    let errors: Vec<[f64; 3]> = flown.plots.iter().map(|plot| crate::common::errors(&flown, plot)).collect();
    let largest = |part: usize| errors.iter().map(|error| error[part].abs()).fold(0.0, f64::max);
    // A time of day is rounded by up to 1/256 s, in which a drone moves 0.07 m.
    between("range, m", 3.5, largest(0), 1852.0 / 256.0 / 2.0 + 0.07);
    between("azimuth, degrees", 0.0027, largest(1), 360.0 / 65536.0 / 2.0 + 0.01);
    between("height, m", 3.7, largest(2), 25.0 * 0.3048 / 2.0 + 0.02);
}
