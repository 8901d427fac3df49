//! The experiment with fewer sessions.

use crate::experiment::FIRST_SEED;
use crate::summary::CalibrationSummary;

/// All requirements, on a fifth of the page's sessions.
#[test]
fn experiment_requirements_are_met() {
    let summary = CalibrationSummary::measure(FIRST_SEED, 200);
    let requirements = summary.requirements();
    assert_eq!(requirements.len(), 8);
    for requirement in requirements {
        assert!(
            requirement.met,
            "{}: {} instead of {}",
            requirement.what, requirement.measured, requirement.required
        );
    }
}
