//! The search by squares misses no pair.

use proptest::prelude::*;

use super::*;

fn traffic() -> impl Strategy<Value = Vec<ConflictAircraft>> {
    let one = (
        prop::array::uniform2(-6000.0..6000.0_f64),
        0.0..120.0_f64,
        prop::array::uniform2(-25.0..25.0_f64),
        prop_oneof![1 => Just(0.0), 8 => Just(1.0), 1 => Just(8.0)],
        prop_oneof![1 => Just(0.0), 1 => -4.0..4.0_f64],
        1.0..40.0_f64,
        prop_oneof![3 => Just(TrafficKind::Drone), 1 => Just(TrafficKind::Crewed)],
    );
    let one = one.prop_map(|(place, up, velocity, fast, climb, worse, kind)| {
        let [east, north] = velocity.map(|rate| fast * rate);
        let mut one = aircraft(0, [place[0], place[1], up], [east, north, climb]);
        one.covariance *= worse;
        one.kind = kind;
        one
    });
    prop::collection::vec(one, 2..60).prop_map(|mut all| {
        (1..).zip(&mut all).for_each(|(number, one)| one.key.0 = number);
        all
    })
}

/// Over ground they are at rest, so their closest approach is now, however far one climbs later.
#[test]
fn climb_away_from_a_hovering_drone_is_found() {
    let pair = vec![
        aircraft(1, [0.0, 0.0, 100.0], [0.05, 0.0, 0.0]),
        aircraft(2, [3.0, 0.0, 117.0], [0.0, 0.0, 4.0]),
    ];
    let evaluation = Conflicts::new(rules(vec![drones()])).evaluate(at(0), pair);
    assert!(evaluation.conflicts.iter().any(|conflict| conflict.probability > 0.1));
}

/// The closest approach over ground is now; the heights meet after 20 s.
#[test]
fn descent_onto_a_hovering_drone_is_found() {
    let pair = vec![
        aircraft(1, [0.0, 0.0, 100.0], [0.0, 0.0, 0.0]),
        aircraft(2, [3.0, 0.0, 175.0], [0.0, 0.0, -3.0]),
    ];
    let found = Conflicts::new(rules(vec![drones()])).evaluate(at(0), pair).conflicts;
    assert!(found[0].probability > 0.95 && found[0].approach.t_cpa_s == 0.0, "{found:?}");
    assert!((found[0].entry_s - 20.0).abs() < 1e-9, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Pairs that the search excludes have a probability below the listing threshold.
    #[test]
    fn no_pair_that_may_meet_is_left_out(aircraft in traffic()) {
        let crewed = Volume {
            between: [AcceptedKinds::Only(TrafficKind::Crewed), AcceptedKinds::Any],
            ..Preset::Do365Enroute.volume()
        };
        let rules = rules(vec![drones(), crewed]);
        let evaluation = Conflicts::new(rules.clone()).evaluate(at(0), aircraft.clone());
        let mut expected = Vec::new();
        for (a, one) in aircraft.iter().enumerate() {
            for (b, other) in aircraft.iter().enumerate().skip(a + 1) {
                let relative = Relative::of(one, other);
                for (index, volume) in rules.volumes.iter().enumerate() {
                    let probability = relative.passage(volume, &rules.ahead, 0.0).probability;
                    if probability >= 0.01 && volume.is_between(one.kind, other.kind) {
                        expected.push(([a, b], index, probability));
                    }
                }
            }
        }
        let found: Vec<_> = evaluation
            .conflicts
            .iter()
            .map(|conflict| (conflict.pair, conflict.volume, conflict.probability))
            .collect();
        prop_assert_eq!(found, expected);
        prop_assert!(evaluation.tested <= aircraft.len() * (aircraft.len() - 1) / 2, "no pair is looked at twice");
    }

    /// The order of the picture does not matter.
    #[test]
    fn the_same_traffic_in_another_order_has_the_same_conflicts(aircraft in traffic()) {
        let mut backwards = aircraft.clone();
        backwards.reverse();
        let evaluate = |aircraft| Conflicts::new(rules(vec![drones()])).evaluate(at(0), aircraft);
        prop_assert_eq!(evaluate(aircraft), evaluate(backwards));
    }
}
