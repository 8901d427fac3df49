//! Levels over time: raised by two of four evaluations, held, lowered, with one identifier.

use super::*;

/// Two aircraft that meet head on at 100 s, 12 m/s each, `aside_m` apart over ground and `above_m` in height.
fn meet(seconds: i64, aside_m: f64, above_m: f64) -> Vec<ConflictAircraft> {
    let away_m = 12.0 * (100 - seconds) as f64;
    vec![
        aircraft(1, [-away_m, 0.0, 100.0], [12.0, 0.0, 0.0]),
        aircraft(2, [away_m, aside_m, 100.0 + above_m], [-12.0, 0.0, 0.0]),
    ]
}

fn level(evaluation: &ConflictEvaluation) -> Option<Level> {
    evaluation.conflicts.first().and_then(|conflict| conflict.level).map(|(level, _)| level)
}

#[test]
fn the_warning_comes_in_time_and_the_levels_in_order() {
    let mut conflicts = Conflicts::new(rules(vec![drones()]));
    let mut seen = Vec::new();
    let mut ids = Vec::new();
    for second in 0..130 {
        let evaluation = conflicts.evaluate(at(second), meet(second, 0.0, 0.0));
        let now = level(&evaluation);
        if seen.last().map(|&(_, level)| level) != Some(now) {
            seen.push((second, now));
        }
        ids.extend(evaluation.conflicts.iter().filter_map(|conflict| conflict.id));
    }
    let order: Vec<Option<Level>> = seen.iter().map(|&(_, level)| level).collect();
    let expected = [None, Some(Level::Advisory), Some(Level::Warning), Some(Level::Violation), None];
    assert_eq!(order, expected, "{seen:?}");
    let (warned, entered) = (seen[2].0, seen[3].0);
    assert!(warned <= 83, "warned {} s ahead", 100 - warned);
    // 50 m at 24 m/s take 2.1 s; the second evaluation inside raises the level.
    assert_eq!(entered, 99);
    assert!(ids.iter().all(|&id| id == 1), "one conflict");
    assert!(conflicts.known.is_empty(), "nothing is left of it");
}

#[test]
fn passes_at_a_distance_or_other_height_raise_nothing() {
    for (aside_m, above_m) in [(400.0, 0.0), (0.0, 120.0)] {
        let mut conflicts = Conflicts::new(rules(vec![drones()]));
        for second in 0..130 {
            let evaluation = conflicts.evaluate(at(second), meet(second, aside_m, above_m));
            assert!(level(&evaluation) < Some(Level::Warning), "{aside_m} {above_m} {second}");
        }
    }
}

#[test]
fn unknown_height_counts_as_equal_and_is_marked() {
    let mut conflicts = Conflicts::new(rules(vec![drones()]));
    let mut worst = None;
    for second in 60..100 {
        let mut aircraft = meet(second, 0.0, 120.0);
        aircraft[0].vertical = None;
        let evaluation = conflicts.evaluate(at(second), aircraft);
        assert!(evaluation.conflicts.iter().all(|conflict| conflict.approach.vertical.is_none()));
        worst = worst.max(level(&evaluation));
    }
    assert_eq!(worst, Some(Level::Violation));
}

#[test]
fn one_evaluation_raises_nothing_and_one_without_ends_nothing() {
    let mut conflicts = Conflicts::new(rules(vec![drones()]));
    let near = || vec![aircraft(1, [0.0; 3], [0.0; 3]), aircraft(2, [10.0, 0.0, 0.0], [0.0; 3])];
    let far = || vec![aircraft(1, [0.0; 3], [0.0; 3]), aircraft(2, [900.0, 0.0, 0.0], [0.0; 3])];
    assert_eq!(level(&conflicts.evaluate(at(0), near())), None);
    for second in 1..4 {
        assert_eq!(level(&conflicts.evaluate(at(second), far())), None);
    }
    // The first evaluation has left the last four.
    assert_eq!(level(&conflicts.evaluate(at(4), near())), None);
    assert_eq!(level(&conflicts.evaluate(at(5), near())), Some(Level::Violation));
    let first = conflicts.evaluate(at(6), near()).conflicts[0];
    // One of them is missing for a while.
    for second in 7..10 {
        assert!(conflicts.evaluate(at(second), vec![near().remove(0)]).conflicts.is_empty());
    }
    let back = conflicts.evaluate(at(10), near()).conflicts[0];
    assert_eq!((back.id, back.level), (first.id, first.level));
    for second in 11..15 {
        assert_eq!(level(&conflicts.evaluate(at(second), far())), Some(Level::Violation), "{second}");
    }
    assert_eq!(level(&conflicts.evaluate(at(15), far())), None);
    // A later encounter is another conflict.
    for second in 30..32 {
        conflicts.evaluate(at(second), near());
    }
    assert_eq!(conflicts.evaluate(at(32), near()).conflicts[0].id, Some(2));
}

#[test]
fn pairs_are_distinct_aircraft_of_the_volumes_kinds() {
    let near = || vec![aircraft(1, [0.0; 3], [0.0; 3]), aircraft(2, [10.0, 0.0, 0.0], [0.0; 3])];
    let count = |volume: Volume, aircraft: fn(Vec<ConflictAircraft>) -> Vec<ConflictAircraft>| {
        Conflicts::new(rules(vec![volume])).evaluate(at(0), aircraft(near())).conflicts.len()
    };
    assert_eq!(count(drones(), |near| near), 1);
    let crewed: fn(Vec<ConflictAircraft>) -> Vec<ConflictAircraft> = |mut near| {
        near[1].kind = TrafficKind::Crewed;
        near
    };
    assert_eq!(count(drones(), crewed), 0);
    let mixed = Volume {
        between: [AcceptedKinds::Only(TrafficKind::Crewed), AcceptedKinds::Only(TrafficKind::Drone)],
        ..drones()
    };
    assert_eq!((count(mixed.clone(), crewed), count(mixed, |near| near)), (1, 0));
    assert_eq!(count(Preset::Nmac.volume(), crewed), 1);
    let twins: fn(Vec<ConflictAircraft>) -> Vec<ConflictAircraft> = |mut near| {
        near[1].disputed = vec![1];
        near
    };
    assert_eq!(count(drones(), twins), 0);
    let broken: fn(Vec<ConflictAircraft>) -> Vec<ConflictAircraft> = |mut near| {
        near[0].covariance[(1, 1)] = f64::NAN;
        near
    };
    assert_eq!(count(drones(), broken), 0);
    let evaluation = Conflicts::new(rules(vec![drones()])).evaluate(at(0), broken(near()));
    assert_eq!((evaluation.left_out, evaluation.aircraft.len()), (1, 1));
}

/// Modified tau: (R² - r²) / (r · closing rate), by hand.
#[test]
fn a_volume_with_tau_is_entered_before_its_radius_is() {
    let enroute = Preset::Do365Enroute.volume();
    let entered = |range_m: f64, closing: f64, aside_m: f64, above_m: f64| {
        let pair =
            [aircraft(1, [0.0; 3], [0.0; 3]), aircraft(2, [aside_m, range_m, above_m], [0.0, -closing, 0.0])];
        enroute.is_entered(&Relative::of(&pair[0], &pair[1]), 1.0)
    };
    // R = 1222.32 m. From 4000 m at 100 m/s: (4000² - 1222.32²) / (4000 · 100) = 36.26 s; from 3850 m: 34.62 s.
    assert!(!entered(4000.0, 100.0, 0.0, 0.0));
    assert!(entered(3850.0, 100.0, 0.0, 0.0));
    assert!(!entered(3850.0, -100.0, 0.0, 0.0), "it flies away");
    assert!(!entered(3500.0, 100.0, 1300.0, 0.0), "it passes by");
    assert!(!entered(3850.0, 100.0, 0.0, 140.0), "it is above 450 ft");
    assert!(entered(1200.0, -100.0, 0.0, 0.0), "within the radius nobody asks where it flies");
}

#[test]
fn an_earlier_time_begins_anew() {
    let near = || vec![aircraft(1, [0.0; 3], [0.0; 3]), aircraft(2, [10.0, 0.0, 0.0], [0.0; 3])];
    let mut conflicts = Conflicts::new(rules(vec![drones()]));
    conflicts.evaluate(at(100), near());
    assert!(level(&conflicts.evaluate(at(101), near())).is_some());
    assert!(level(&conflicts.evaluate(at(50), near())).is_none());
}
