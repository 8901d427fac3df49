//! Histories of aircraft: legs, turns, and gaps.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::history::FlightHistory;
use crate::motion::{Motion, PairMotion};
use crate::outlook::LegOutlook;

/// An aircraft as a filter states it: errors of 2 m and 1 m/s, of which 10 m and 4 m/s are stated.
fn measured(number: u32, place: [f64; 3], velocity: [f64; 3], random: &mut ChaCha8Rng) -> ConflictAircraft {
    let mut normal =
        |deviation: f64| -> f64 { deviation * Distribution::<f64>::sample(&StandardNormal, random) };
    let place = place.map(|axis| axis + normal(2.0));
    let velocity = velocity.map(|axis| axis + normal(1.0));
    ConflictAircraft {
        covariance: Matrix4::from_diagonal(&[100.0, 100.0, 16.0, 16.0].into()),
        vertical: Some([100.0, 0.0, 16.0]),
        ..aircraft(number, place, velocity)
    }
}

/// Legs of 40 s at 15 m/s, each to the right of the last.
fn zigzag(second: i64) -> ([f64; 3], [f64; 3]) {
    let (mut place, mut course) = ([0.0, 0.0, 100.0], 0.0_f64);
    let velocity = |course: f64| [15.0 * course.sin(), 15.0 * course.cos(), 0.0];
    for _ in 0..second / 40 {
        let [east, north, _] = velocity(course);
        (place[0], place[1]) = (place[0] + 40.0 * east, place[1] + 40.0 * north);
        course += std::f64::consts::FRAC_PI_2;
    }
    let (rest, [east, north, up]) = ((second % 40) as f64, velocity(course));
    ([place[0] + rest * east, place[1] + rest * north, place[2]], [east, north, up])
}

/// The history after this many seconds of a flight.
fn flown(seconds: i64, flight: impl Fn(i64) -> ([f64; 3], [f64; 3])) -> FlightHistory {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut history = FlightHistory::new(at(0));
    for second in 0..=seconds {
        let (place, velocity) = flight(second);
        let one = measured(1, place, velocity, &mut random);
        history.add(at(second), &one, &SteadyFlightRatios::MEASURED);
    }
    history
}

fn straight(second: i64) -> ([f64; 3], [f64; 3]) {
    ([8.0 * second as f64, 0.0, 100.0 - second as f64], [8.0, 0.0, -1.0])
}

#[test]
fn a_leg_is_known_better_than_the_filter_states() {
    let leg = flown(30, straight).leg(at(30)).unwrap();
    let error = leg.velocity - nalgebra::Vector2::new(8.0, 0.0);
    assert!(error.norm() < 0.3 && leg.lasted_s == 30.0, "{leg:?}");
    let vertical = leg.vertical.unwrap();
    assert!((vertical.climb + 1.0).abs() < 0.3 && (vertical.height_m - 70.0).abs() < 4.0, "{vertical:?}");
    // The filter states an error of the velocity of 4 m/s.
    assert!(leg.ground[2] < 0.1, "{leg:?}");
}

#[test]
fn a_leg_goes_on_while_no_position_arrives() {
    let history = flown(30, straight);
    let (now, later) = (history.leg(at(30)).unwrap(), history.leg(at(38)).unwrap());
    assert!((later.position - now.position - now.velocity * 8.0).norm() < 1e-9);
    assert_eq!((later.age_s, later.lasted_s), (8.0, 38.0));
    assert!(later.ground[0] > now.ground[0]);
}

#[test]
fn a_turn_ends_the_leg() {
    let share = |seconds: i64| {
        let one = aircraft(1, [0.0; 3], [0.0; 3]);
        let motion = Motion::of(&flown(seconds, zigzag), at(seconds), &one, &rules(vec![drones()]).ahead);
        let pair = PairMotion::of(
            &Relative::of(&aircraft(1, [0.0; 3], [0.0; 3]), &aircraft(2, [0.0; 3], [0.0; 3])),
            (&aircraft(1, [0.0; 3], [0.0; 3]), &motion),
            (&aircraft(2, [0.0; 3], [0.0; 3]), &motion),
            &rules(vec![drones()]).ahead,
        );
        pair.share_at(0.0).sqrt()
    };
    let (before, after, again) = (share(38), share(43), share(60));
    assert!(before > 0.95 && after < 0.5 && again > 0.95, "{before} {after} {again}");
}

#[test]
fn legs_are_expected_to_last_as_long_as_earlier_ones() {
    let history = flown(215, zigzag);
    let leg = history.leg(at(215)).unwrap();
    let outlook = history.outlook(at(215), &leg, 60.0);
    // The present leg has lasted for 15 s of 40.
    let (soon, late) = (outlook.survival(10.0), outlook.survival(45.0));
    assert!(soon > 0.9 && late < 0.3, "{outlook:?}: {soon} {late}");
}

#[test]
fn an_aircraft_off_any_line_probably_turns() {
    let circle = |second: i64| {
        let angle = 0.3 * second as f64;
        ([50.0 * angle.cos(), 50.0 * angle.sin(), 100.0], [-15.0 * angle.sin(), 15.0 * angle.cos(), 0.0])
    };
    let one = aircraft(1, [0.0; 3], [0.0; 3]);
    let motion = Motion::of(&flown(30, circle), at(30), &one, &rules(vec![drones()]).ahead);
    assert!(motion.leg.is_none_or(|leg| leg.lasted_s < 6.0), "{motion:?}");
    assert!(!motion.is_coasting());
}

proptest! {
    #[test]
    fn survival_falls_from_one(
        lasted_s in 0.0..600.0_f64, before in prop::collection::vec(1.0..600.0_f64, 0..8), t in 0.0..120.0_f64,
    ) {
        let outlook = LegOutlook::after(lasted_s, 60.0, &before);
        let (now, then, later) = (outlook.survival(0.0), outlook.survival(t), outlook.survival(t + 5.0));
        prop_assert!((now - 1.0).abs() < 1e-12 && then <= 1.0 && later <= then && later >= 0.0, "{then} {later}");
    }
}

/// Two drones that fly towards each other at 10 m/s each, from 800 m; the second one is missing for a while.
fn approaching(missing: std::ops::Range<i64>, is_kept: bool) -> Vec<Option<Level>> {
    let mut conflicts = Conflicts::new(rules(vec![drones()]));
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut last = None;
    let mut evaluate = |second: i64| {
        let away = 10.0 * second as f64;
        let mut aircraft = vec![
            measured(1, [away, 0.0, 100.0], [10.0, 0.0, 0.0], &mut random),
            measured(2, [800.0 - away, 10.0, 100.0], [-10.0, 0.0, 0.0], &mut random),
        ];
        if missing.contains(&second) {
            aircraft.pop();
            let state: Option<&(i64, ConflictAircraft)> = last.as_ref();
            aircraft.extend(state.filter(|_| is_kept).map(|(seen, one)| {
                let age_s = (second - seen) as f64;
                let one = one.clone().moved(age_s, &rules(vec![drones()]).ahead);
                ConflictAircraft { is_shown: false, ..one }
            }));
        } else {
            last = Some((second, aircraft[1].clone()));
        }
        let evaluation = conflicts.evaluate(at(second), aircraft);
        evaluation.conflicts.first().and_then(|conflict| conflict.level).map(|(level, _)| level)
    };
    (0..30).map(&mut evaluate).collect()
}

/// The volume is entered after 37 s. Nothing is seen of one of them from 14 s on.
#[test]
fn a_missing_aircraft_on_a_leg_is_followed() {
    let (followed, lost) = (approaching(14..30, true), approaching(14..30, false));
    assert_eq!(followed[28], Some(Level::Warning), "{followed:?}");
    assert!(lost[19..].iter().all(Option::is_none), "{lost:?}");
}

#[test]
fn a_track_that_begins_beside_a_transponder_is_its_twin() {
    let levels = |has_transponder: bool| -> Vec<bool> {
        let mut conflicts = Conflicts::new(rules(vec![drones()]));
        let mut level = |second: i64| {
            let away = 10.0 * second as f64;
            let mut pair = vec![aircraft(1, [away, 0.0, 100.0], [10.0, 0.0, 0.0])];
            if second >= 10 {
                let other = aircraft(2, [away + 20.0, 5.0, 102.0], [9.0, 1.0, 0.0]);
                pair.push(ConflictAircraft { has_transponder, ..other });
            }
            let evaluation = conflicts.evaluate(at(second), pair);
            evaluation.conflicts.iter().any(|conflict| conflict.level.is_some())
        };
        (0..40).map(&mut level).collect()
    };
    let (radar, transponder) = (levels(false), levels(true));
    assert!(radar[..30].iter().all(|has_level| !has_level) && radar[39], "{radar:?}");
    assert!(transponder[15], "{transponder:?}");
}

/// The search finds all pairs that may meet on their legs.
#[test]
fn no_pair_with_legs_is_left_out() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut flights: Vec<([f64; 3], [f64; 3])> = (0..60)
        .map(|_| {
            let mut span = |most: f64| random.random_range(-most..most);
            ([span(3000.0), span(3000.0), 100.0 + span(40.0)], [span(25.0), span(25.0), span(1.5)])
        })
        .collect();
    let rules = rules(vec![drones()]);
    let mut conflicts = Conflicts::new(rules.clone());
    let mut listed = 0;
    for second in 0..40 {
        let aircraft: Vec<ConflictAircraft> = (1..)
            .zip(&flights)
            .map(|(number, (place, velocity))| measured(number, *place, *velocity, &mut random))
            .collect();
        let evaluation = conflicts.evaluate(at(second), aircraft.clone());
        let mut expected = Vec::new();
        for a in 0..aircraft.len() {
            for b in a + 1..aircraft.len() {
                let (one, other) = (&aircraft[a], &aircraft[b]);
                let pair = [(one, &conflicts.motions[a]), (other, &conflicts.motions[b])];
                let motion = PairMotion::of(&Relative::of(one, other), pair[0], pair[1], &rules.ahead);
                let passage = motion.passage(&rules.volumes[0], &rules.ahead, 0.01);
                if passage.probability > 0.0 {
                    expected.push(([a, b], passage.probability));
                }
            }
        }
        let found: Vec<_> = evaluation
            .conflicts
            .iter()
            .filter(|conflict| conflict.probability > 0.0)
            .map(|conflict| (conflict.pair, conflict.probability))
            .collect();
        assert_eq!(found, expected, "after {second} s");
        listed += found.len();
        for (place, velocity) in &mut flights {
            (0..3).for_each(|axis| place[axis] += velocity[axis]);
        }
    }
    assert!(listed > 100, "{listed}");
}
