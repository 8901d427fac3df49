//! The page.

use utm_fusion::evaluate::plot::Figure;

use crate::alignment::{RELATIVE, products};
use crate::approach::{error_of_both, error_of_rate};
use crate::encounter::{FURTHER_DEG, MISS_M, OFF_DEG, SPEED};
use crate::experiment::{ExperimentFailure, page as filled, requirement_table, said, shown};
use crate::sensors::STAMP_VARIANCE_M2;
use crate::summary::EncounterSummary;
use crate::tracking::{ACCELERATION, FIRST_CLIMB, FIRST_SPEED, LASTS_S};

pub fn page(summary: &EncounterSummary, figures: &[Figure]) -> Result<String, ExperimentFailure> {
    let [table_1, equation_3] =
        products().map(|angles| angles.map(|angle| format!("{angle:.3}").replace('-', "−")).join(", "));
    let printed = RELATIVE.map(|angle| format!("{angle:.2}").replace('-', "−")).join(", ");
    let miss = |rates: [f64; 2]| said(error_of_both(2000.0, -75.0, rates.map(f64::to_radians)));
    let exact = |rates: [f64; 2]| {
        let [azimuth, elevation] = rates.map(|rate| error_of_rate(2000.0, -75.0, rate.to_radians()));
        said(azimuth.hypot(elevation))
    };
    let requirements = summary.requirements();
    let met = requirements.iter().filter(|requirement| requirement.met).count();
    filled(
        include_str!("words/page.md"),
        &[
            ("runs", summary.errors.len().to_string()),
            ("first_seed", summary.first_seed.to_string()),
            ("lasts_s", said(LASTS_S)),
            ("acceleration", said(ACCELERATION)),
            ("stamp_m", said(STAMP_VARIANCE_M2.sqrt())),
            ("speed", said(SPEED)),
            ("off_deg", said(OFF_DEG)),
            (
                "before_deg",
                format!("{} and {}", said(OFF_DEG + FURTHER_DEG.0), said(OFF_DEG + FURTHER_DEG.1)),
            ),
            ("above_m", said(MISS_M.1)),
            ("first_speed", said(FIRST_SPEED)),
            ("first_climb", said(FIRST_CLIMB)),
            ("table_2", summary.table()),
            ("met", format!("{met} of {}", requirements.len())),
            ("asked", requirement_table(&requirements)),
            ("times", summary.times()),
            ("miss_radar", miss([0.29, 0.26])),
            ("miss_both", miss([0.099, 0.092])),
            ("exact_radar", exact([0.29, 0.26])),
            ("exact_both", exact([0.099, 0.092])),
            ("printed", printed),
            ("table_1", table_1),
            ("equation_3", equation_3),
            ("figures", shown(figures)),
        ],
    )
}
