//! The experiment, smaller.

use crate::experiment::FIRST_SEED;
use crate::summary::{BEHIND, Summary};

/// All but the lag of intruder 1, on a fifth of the flights of the page, from the same seeds on.
#[test]
fn what_is_asked_is_met() {
    let summary = Summary::measure(FIRST_SEED, 40);
    let lag = format!("intruder 1, {BEHIND}");
    for asked in summary.asked().into_iter().filter(|asked| asked.what != lag) {
        assert!(asked.met, "{}: {} instead of {}", asked.what, asked.measured, asked.required);
    }
}
