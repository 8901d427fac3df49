//! The experiment with fewer encounters.

use crate::summary::EncounterSummary;

/// A third of the page's encounters, with the same first seed.
#[test]
fn experiment_requirements_are_met() {
    let summary = EncounterSummary::measure(crate::experiment::FIRST_SEED, 120);
    for requirement in summary.requirements() {
        assert!(
            requirement.met,
            "{}: {} instead of {}",
            requirement.what, requirement.measured, requirement.required
        );
    }
}

#[test]
fn the_same_seed_is_the_same_encounter() {
    let of = |seed| format!("{:?}", EncounterSummary::measure(seed, 2).errors);
    assert_eq!(of(1), of(1));
    assert_ne!(of(1), of(3));
}
