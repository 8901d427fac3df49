//! The experiment, smaller.

use crate::experiment::FIRST_SEED;
use crate::summary::Summary;

/// A fifth of the flights of the page, from the same seeds on.
#[test]
fn what_is_asked_is_met() {
    let summary = Summary::measure(FIRST_SEED, 40);
    for asked in summary.asked() {
        assert!(asked.met, "{}: {} instead of {}", asked.what, asked.measured, asked.required);
    }
}
