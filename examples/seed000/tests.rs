//! The experiment, smaller.

use crate::summary::Summary;

/// A third of the encounters of the page, from the same seeds on.
#[test]
fn what_is_asked_is_met() {
    let summary = Summary::measure(crate::experiment::FIRST_SEED, 120);
    for asked in summary.asked() {
        assert!(asked.met, "{}: {} instead of {}", asked.what, asked.measured, asked.required);
    }
}

#[test]
fn the_same_seed_is_the_same_encounter() {
    let of = |seed| format!("{:?}", Summary::measure(seed, 2).errors);
    assert_eq!(of(1), of(1));
    assert_ne!(of(1), of(3));
}
