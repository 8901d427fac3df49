//! True motion of drones, from the samples at 10 Hz.

use nalgebra::Vector3;
use utm_fusion::simulate::{Drones, Pattern, Scenario, Span, simulate};

use crate::common::{Flown, Truth, between, fly, kept, perfect};

const STEP_S: f64 = 0.1;
const GRAVITY_M_S2: f64 = 9.81;

/// Scenario with a radar that detects nothing, because only the flights are of interest.
fn unseen(mut scenario: Scenario) -> Scenario {
    (scenario.radars[0].min_range_m, scenario.radars[0].max_range_m) = (49_000.0, 50_000.0);
    scenario
}

/// Durations of periods in which `so` holds, in seconds; those cut off by the end of the flight are omitted.
fn stretches(samples: &[Truth], so: impl Fn(&Truth) -> bool) -> Vec<f64> {
    let mut found = Vec::new();
    let mut length = 0_usize;
    for sample in samples {
        if so(sample) {
            length += 1;
        } else {
            found.extend((length > 0).then_some(length as f64 * STEP_S));
            length = 0;
        }
    }
    found
}

fn fold(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)))
}

#[test]
fn velocities_are_derivatives_of_ten_samples_per_second() {
    let flown = fly(&unseen(perfect(5, 5, 0)), 1);
    for (drone, flight) in flown.simulation.flights.iter().enumerate() {
        assert_eq!((flight.id.as_str(), flight.samples.len()), (format!("D{}", drone + 1).as_str(), 3001));
        for (step, pair) in flight.samples.windows(2).enumerate() {
            assert_eq!((pair[1].time - pair[0].time).as_millis(), 100, "{step}");
        }
        for pair in flown.samples(drone).windows(2) {
            let moved = (pair[1].position - pair[0].position) / STEP_S;
            let velocity = (pair[0].velocity + pair[1].velocity) / 2.0;
            // At 2 km from the radar, the ground is 0.3 m lower, and the vertical directions differ.
            assert!((moved - velocity).norm() < 0.03, "{moved:?} {velocity:?}");
        }
    }
}

#[test]
fn multirotor_speeds_and_accelerations_are_within_limits() {
    let flown = fly(&unseen(perfect(60, 0, 0)), 1);
    let cruise: Vec<f64> = (0..60)
        .map(|drone| fold(flown.samples(drone).iter().map(|state| state.velocity.xy().norm())).1)
        .collect();
    let acceleration: Vec<f64> = (0..60)
        .map(|drone| {
            let pairs = flown.samples(drone).windows(2);
            fold(pairs.map(|pair| (pair[1].velocity - pair[0].velocity).norm() / STEP_S)).1
        })
        .collect();
    for (what, values, low, high) in [("cruise", cruise, 8.0, 16.0), ("acceleration", acceleration, 2.0, 4.0)]
    {
        let (least, most) = fold(values.iter().copied());
        let width = high - low;
        // 60 draws come near both ends.
        between(&format!("least {what}"), low - 0.01, least, low + 0.1 * width);
        between(&format!("greatest {what}"), high - 0.1 * width, most, high + 0.01);
    }
}

/// To and fro along a line: a waypoint is where the direction reverses.
#[test]
fn multirotors_hover_4_to_15_s_at_half_of_the_waypoints() {
    let mut scenario = unseen(perfect(40, 0, 0));
    scenario.duration_s = 900.0;
    scenario.airspace.radius_m = 300.0;
    scenario.drones.pattern = Pattern::Crossing;
    let flown = fly(&scenario, 1);
    let (mut waypoints, mut hovers) = (0, Vec::new());
    for drone in 0..40 {
        let samples = flown.samples(drone);
        let along =
            samples.iter().map(|state| state.velocity.xy()).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let along = along.unwrap().normalize();
        let mut side = 0.0_f64;
        for state in samples {
            let speed = state.velocity.xy().dot(&along);
            if speed.abs() > 2.0 && speed.signum() != side {
                waypoints += usize::from(side != 0.0);
                side = speed.signum();
            }
        }
        hovers
            .extend(stretches(samples, |state| state.velocity.norm() < 1.0).into_iter().filter(|s| *s > 2.0));
    }
    println!("{} hovers at {waypoints} waypoints", hovers.len());
    between("share of waypoints with hover", 0.42, hovers.len() as f64 / f64::from(waypoints as u32), 0.58);
    // The speed is also below 1 m/s just before and after the hover.
    let (shortest, longest) = fold(hovers.iter().copied());
    between("shortest hover, s", 4.0, shortest, 6.0);
    between("longest hover, s", 14.0, longest, 17.0);
}

/// Bank of a turn: tan(bank) = speed · rate of turn / g.
fn bank_deg(pair: &[Truth]) -> f64 {
    let (a, b) = (pair[0].velocity.xy(), pair[1].velocity.xy());
    (a.norm() * a.angle(&b) / STEP_S / GRAVITY_M_S2).atan().to_degrees()
}

#[test]
fn fixed_wings_keep_speed_and_bank_at_most_35_degrees() {
    let mut scenario = unseen(perfect(0, 60, 0));
    scenario.fixed_wing.loiter_s = Span::new(40.0, 40.0);
    let flown = fly(&scenario, 1);
    let (mut speeds, mut loiters) = (Vec::new(), Vec::new());
    let mut steepest = 0.0_f64;
    for drone in 0..60 {
        let samples = flown.samples(drone);
        let (slowest, fastest) = fold(samples.iter().map(|state| state.velocity.xy().norm()));
        assert!(fastest - slowest < 0.01, "{slowest} {fastest}");
        speeds.push(slowest);
        let banks: Vec<f64> = samples.windows(2).map(bank_deg).collect();
        steepest = steepest.max(fold(banks.iter().copied()).1);
        // A long period at two thirds of the maximum rate of turn is a circle.
        let circling = (35.0_f64.to_radians().tan() * 2.0 / 3.0).atan().to_degrees();
        let mut length = 0;
        for bank in banks {
            if (bank - circling).abs() < 0.5 {
                length += 1;
            } else {
                loiters.extend((length > 200).then_some(f64::from(length) * STEP_S));
                length = 0;
            }
        }
    }
    let (slowest, fastest) = fold(speeds.iter().copied());
    between("slowest, m/s", 16.99, slowest, 18.2);
    between("fastest, m/s", 27.8, fastest, 29.01);
    between("steepest bank, degrees", 33.0, steepest, 35.05);
    // It takes a few seconds to roll in.
    let (shortest, longest) = fold(loiters.iter().copied());
    assert!(loiters.len() > 60, "{} loiters", loiters.len());
    between("shortest loiter, s", 34.0, shortest, 40.0);
    between("longest loiter, s", 36.0, longest, 40.1);
}

#[test]
fn heights_are_30_to_120_m_above_ground() {
    let scenario = unseen(perfect(40, 40, 0));
    let flown = fly(&scenario, 1);
    let ground_m = scenario.place.ground_amsl_m;
    let (lowest, highest) =
        fold((0..80).flat_map(|drone| flown.samples(drone)).map(|state| state.altitude_m - ground_m));
    between("lowest, m", 29.0, lowest, 32.0);
    between("highest, m", 118.0, highest, 121.0);
    let (fall, climb) = fold((0..80).flat_map(|drone| flown.samples(drone)).map(|state| state.velocity.z));
    between("steepest descent, m/s", -3.01, fall, -2.5);
    between("steepest climb, m/s", 2.5, climb, 3.01);
}

fn nearest(flown: &Flown) -> f64 {
    let count = flown.simulation.flights.len();
    let apart = |a: usize, b: usize| {
        let pairs = flown.samples(a).iter().zip(flown.samples(b));
        fold(pairs.map(|(a, b)| (a.position - b.position).norm())).0
    };
    fold((0..count).flat_map(|a| (0..a).map(move |b| (a, b))).map(|(a, b)| apart(a, b))).0
}

#[test]
fn drones_are_never_closer_than_the_separation() {
    let mut scenario = unseen(kept("dense"));
    scenario.birds.count = 0;
    between("nearest, m", 30.0, nearest(&fly(&scenario, 1)), 33.0);
    scenario.drones.separation_m = 0.0;
    between("nearest of those that do not care, m", 0.0, nearest(&fly(&scenario, 1)), 20.0);
}

#[test]
fn crossing_drones_pass_through_one_point_again_and_again() {
    let scenario = unseen(kept("crossing"));
    let flown = fly(&scenario, 1);
    let middle = Vector3::new(scenario.airspace.east_m, scenario.airspace.north_m, 0.0);
    for drone in 0..10 {
        let samples = flown.samples(drone);
        let passes = stretches(samples, |state| (state.position - middle).xy().norm() < 120.0).len();
        assert!(passes >= 3, "D{} passes the middle {passes} times", drone + 1);
    }
}

#[test]
fn too_small_airspace_is_reported() {
    let mut scenario = kept("single");
    scenario.drones = Drones { multirotors: 200, ..scenario.drones };
    scenario.airspace.radius_m = 50.0;
    let crowded = simulate(&scenario, 1, None).unwrap_err().to_string();
    assert!(crowded.contains("a larger airspace or a smaller drones.separation_m"), "{crowded}");
}
