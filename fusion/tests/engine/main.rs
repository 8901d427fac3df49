//! Compares the engine with a plain recomputation from the window at every slot, over random scenarios.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod checkpoint;
mod plain;
mod same_aircraft;
mod scenario;

use proptest::prelude::*;
use scenario::{Arrival, run, settings};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn incremental_equals_recomputed(scenario in scenario::any()) {
        let settings = settings(&scenario);
        let expected = plain::run(&settings, &scenario.arrivals);
        let emitted = run(&settings, &scenario.arrivals);
        for (emitted, expected) in emitted.iter().zip(&expected) {
            prop_assert_eq!(emitted, expected);
        }
        prop_assert_eq!(emitted.len(), expected.len());
    }

    #[test]
    fn order_between_two_deadlines_does_not_matter(scenario in scenario::any(), seed in any::<u64>()) {
        let settings = settings(&scenario);
        let arrivals = scenario::indifferent_to_order(scenario.arrivals);
        let permuted = scenario::permuted(&arrivals, settings.lead(), seed);
        prop_assert_eq!(run(&settings, &permuted), run(&settings, &arrivals));
    }
}

/// The property tests above would prove nothing if the random scenarios never fused anything.
#[test]
fn random_scenarios_reach_every_kind_of_output() {
    use proptest::strategy::ValueTree;
    use utm_fusion_engine::Source;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut fused, mut radar, mut transponder, mut restarts) = (0, 0, 0, 0);
    for _ in 0..100 {
        let scenario = scenario::any().new_tree(&mut runner).unwrap().current();
        restarts += scenario.arrivals.windows(2).filter(|pair| is_jump(&pair[0], &pair[1])).count();
        for point in run(&settings(&scenario), &scenario.arrivals).into_iter().flat_map(|e| e.points) {
            match point.source {
                Source::Fused(..) => fused += 1,
                Source::Radar(_) => radar += 1,
                Source::Transponder(_) => transponder += 1,
                Source::Cameras => panic!("there is no camera"),
            }
        }
    }
    assert!(
        fused > 1000 && radar > 1000 && transponder > 1000 && restarts > 3,
        "{fused} {radar} {transponder} {restarts}"
    );
}

fn is_jump(before: &Arrival, after: &Arrival) -> bool {
    after.received.nanos() - before.received.nanos() > 25_000_000_000
}
