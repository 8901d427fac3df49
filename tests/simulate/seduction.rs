//! Seduced tracks, and swapped track numbers.

use std::collections::BTreeSet;

use utm_fusion::simulate::Span;

use crate::common::{Flown, Plot, between, fly, kept, mean, perfect};

#[test]
fn tracks_walk_off_once_in_70_s_for_4_to_10_s() {
    let mut scenario = perfect(120, 0, 0);
    (scenario.radars[0].seduction_every_s, scenario.radars[0].velocities) = (70.0, true);
    let flown = fly(&scenario, 1);
    let (mut honest_s, mut speeds, mut lengths_s) = (0.0, Vec::new(), Vec::new());
    for plots in flown.plots_by_drone().values() {
        honest_s += plots.iter().filter(|plot| !plot.seduced).count() as f64 * 0.25;
        for walk in plots.chunk_by(|a, b| a.seduced == b.seduced).filter(|walk| walk[0].seduced) {
            let off = |plot: &Plot| {
                let truth = flown.truth(plot.drone.unwrap(), flown.seconds(plot.time));
                (plot.position - truth.position).xy()
            };
            let time_s = |plot: &Plot| flown.seconds(plot.time);
            let (first, last) = (walk[0], walk[walk.len() - 1]);
            // A seduction cut off by the end of the flight counts for the rate only.
            if time_s(last) > 299.0 {
                lengths_s.push(f64::NAN);
                continue;
            }
            assert!(walk.iter().all(|plot| plot.number == first.number));
            let length_s = time_s(last) - time_s(first) + 0.25;
            lengths_s.push(length_s);
            let speed = (off(last) - off(first)).norm() / (length_s - 0.25);
            speeds.push(speed);
            // Straight motion: half of the way at half of the time; plots have a resolution of 7 m.
            let middle = walk[walk.len() / 2];
            let expected = off(first).lerp(&off(last), (time_s(middle) - time_s(first)) / (length_s - 0.25));
            assert!((off(middle) - expected).norm() < 13.0, "{:?} {expected:?}", off(middle));
            // The reported velocity matches the motion of the track.
            let velocity = first.record.track_velocity.unwrap();
            let heading = velocity.heading_deg().to_radians();
            let told = nalgebra::Vector2::new(heading.sin(), heading.cos()) * velocity.speed_m_s();
            let truth = flown.truth(first.drone.unwrap(), time_s(first)).velocity.xy();
            assert!(((told - truth).norm() - speed).abs() < 3.5, "{told:?} {truth:?} {speed}");
        }
        // A seduced track has ended.
        for pair in plots.windows(2).filter(|pair| pair[0].seduced && !pair[1].seduced) {
            assert_ne!(pair[0].number, pair[1].number);
        }
    }
    println!("{} walks in {honest_s:.0} s", lengths_s.len());
    between("seconds of track to a walk", 61.0, honest_s / lengths_s.len() as f64, 79.0);
    lengths_s.retain(|length| length.is_finite());
    let ends = |values: &[f64]| values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    between("shortest, s", 3.99, ends(&lengths_s).0, 4.3);
    between("longest, s", 9.7, ends(&lengths_s).1, 10.26);
    between("mean, s", 6.7, mean(&lengths_s), 7.4);
    between("slowest, m/s", 3.5, ends(&speeds).0, 6.0);
    between("fastest, m/s", 13.0, ends(&speeds).1, 15.5);
    between("mean, m/s", 9.1, mean(&speeds), 9.9);
}

/// Number of times that two drones come closer than this, checked in each turn of the radar.
fn encounters(flown: &Flown, distance_m: f64) -> usize {
    let count = flown.simulation.flights.len();
    let mut encounters = 0;
    for (a, b) in (0..count).flat_map(|a| (0..a).map(move |b| (a, b))) {
        let near = (0..1200).map(|turn| {
            let [a, b] = [a, b].map(|drone| flown.truth(drone, f64::from(turn) * 0.25).position);
            (a - b).norm() < distance_m
        });
        let near: Vec<bool> = near.collect();
        encounters += near.windows(2).filter(|pair| !pair[0] && pair[1]).count() + usize::from(near[0]);
    }
    encounters
}

#[test]
fn close_drones_may_have_their_numbers_swapped() {
    let mut scenario = kept("crossing");
    scenario.birds.count = 0;
    scenario.radars = perfect(0, 0, 0).radars;
    // Every look is a detection: at share 1 each encounter swaps.
    let encounters = encounters(&fly(&scenario, 1), 45.0);
    let swaps = |share: f64| {
        let mut scenario = scenario.clone();
        scenario.radars[0].swap_share = share;
        let flown = fly(&scenario, 1);
        let mut swaps = 0;
        let mut owners = BTreeSet::new();
        for (number, plots) in flown.plots_by_number() {
            owners.extend(plots.iter().map(|plot| (number, plot.drone)));
            for pair in plots.windows(2).filter(|pair| pair[0].drone != pair[1].drone) {
                let places = [pair[0], pair[1]]
                    .map(|plot| flown.truth(plot.drone.unwrap(), flown.seconds(pair[1].time)).position);
                let apart_m = (places[0] - places[1]).norm();
                // 45 m at the beginning of the turn; the drones approach at up to 58 m/s.
                assert!((25.0..60.0).contains(&apart_m), "swapped {apart_m} m from each other");
                swaps += 1;
            }
        }
        (swaps, owners.len())
    };
    assert_eq!(swaps(0.0), (0, 10), "each drone keeps its number");
    let (some, _) = swaps(0.3);
    let (all, owners) = swaps(1.0);
    println!("{encounters} encounters, {some} swaps at 0.3, {all} at 1");
    assert!(owners > 20, "one number belongs to several drones: {owners}");
    // A swap moves two numbers to other drones; three drones that meet at once exchange three numbers by two swaps.
    assert!(encounters >= 10 && (2 * encounters - 3..=2 * encounters).contains(&all));
    assert!(some > 0 && some < all * 6 / 10);
}

#[test]
fn distant_drones_keep_their_numbers() {
    let mut scenario = perfect(20, 0, 0);
    (scenario.drones.separation_m, scenario.radars[0].swap_share) = (60.0, 1.0);
    scenario.airspace.radius_m = 2000.0;
    scenario.radars[0].min_range_m = 0.0;
    scenario.multirotor.speed_m_s = Span::new(8.0, 10.0);
    let flown = fly(&scenario, 1);
    for plots in flown.plots_by_number().values() {
        assert!(plots.iter().all(|plot| plot.drone == plots[0].drone));
    }
}
