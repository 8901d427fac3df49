//! The page.

use utm_fusion::evaluate::plot::Figure;

use crate::experiment::{ExperimentFailure, page as filled, requirement_table, said, shown};
use crate::scenario::INTRUDERS;
use crate::summary::TurnSummary;
use crate::tracking::STAYS;

pub fn page(summary: &TurnSummary, figures: &[Figure]) -> Result<String, ExperimentFailure> {
    let requirements = summary.requirements();
    let lag = summary.lag();
    let met = requirements.iter().filter(|requirement| requirement.met).count();
    filled(
        include_str!("words/page.md"),
        &[
            ("runs", summary.runs.to_string()),
            ("first_seed", summary.first_seed.to_string()),
            ("noise_1", said(INTRUDERS[0].noise)),
            ("noise_2", said(INTRUDERS[1].noise)),
            ("stays", said(STAYS)),
            ("table", summary.table()),
            ("models", summary.models_table()),
            ("met", format!("{met} of {}", requirements.len())),
            ("asked", requirement_table(&requirements)),
            ("along", format!("{} ± {}", said(lag.mean_m), said(lag.error_m))),
            ("lag", said(lag.expected_m)),
            ("known", said(lag.known_s)),
            ("rms", said(lag.rms_m)),
            ("figures", shown(figures)),
        ],
    )
}
