//! Measures of the table that compares `operational` with the paper's method, `reference`.

use crate::figures::*;
use crate::flights::{FlightRow, RECORDINGS, SCENARIOS};
use crate::measures::OtherResults;
use crate::registration;
use crate::results::{Measure, ResultRow, each, measured};
use crate::score::FlightScores;
use crate::summary::MeanValue;
use crate::variants::{BIAS_EQUIPPED, DELAY_KNOWN};

/// All rows of the table.
pub fn rows(scores: &[FlightScores], other: &OtherResults) -> Vec<ResultRow> {
    let mut rows = places(scores);
    rows.extend(presence(scores));
    rows.extend(association(scores));
    rows.extend(registration::rows(&other.registration));
    rows.extend(heights(scores));
    rows.extend(real(scores));
    rows.extend(speed(other));
    rows
}

fn every() -> [FlightRow; 8] {
    SCENARIOS.map(FlightRow::Scenario)
}

/// Position errors.
fn places(scores: &[FlightScores]) -> Vec<ResultRow> {
    let against_reference: Measure = |seeds, of| seeds.ratio(of.equipped, REFERENCE.equipped, COVERED);
    let mut rows = vec![ResultRow::new(
        "error on covered slots / transponder's, `crossing`, known delay",
        each(scores, &[FlightRow::Variant(DELAY_KNOWN)], |seeds, of| {
            seeds.ratio(of.equipped, TRANSPONDER.equipped, COVERED)
        }),
    )];
    for name in ["single", "crossing", "bias"] {
        let measure = format!("error on covered slots / `reference`'s, `{name}`");
        let row = ResultRow::new(measure, each(scores, &[FlightRow::Scenario(name)], against_reference));
        rows.push(match name {
            "single" => row.limitation("with one drone the transponders' delay is learnt late."),
            _ => row,
        });
    }
    rows
}

/// Probability of update, and drones without a transponder.
fn presence(scores: &[FlightScores]) -> Vec<ResultRow> {
    let against_radar: Measure = |seeds, of| seeds.ratio(of.unequipped, RADAR.unequipped, EPOS);
    let above_transponder: Measure = |seeds, of| {
        seeds.mean(|scores| Some(PU((of.equipped)(scores))? - PU((TRANSPONDER.equipped)(scores))?))
    };
    vec![
        ResultRow::new(
            "PU of equipped drones less the transponder's, points, worst scenario",
            each(scores, &every(), above_transponder),
        )
        .decimals(1)
        .lowest(),
        ResultRow::new(
            "PU of drones without transponder, percent (the radar's is 38 to 40), worst scenario",
            each(scores, &every(), |seeds, of| seeds.of_group(of.unequipped, PU)),
        )
        .decimals(1)
        .lowest()
        .limitation("drones that look like birds to the radar are withheld with the birds."),
        ResultRow::new(
            "error of drones without transponder / radar's, worst scenario",
            each(scores, &every(), against_radar),
        )
        .limitation("no other sensor shows the slow errors of the radar tracks of a single drone."),
        ResultRow::new(
            "error of drones without transponder / radar's, `bias` after 40 drone-minutes",
            each(scores, &[FlightRow::Settled("bias")], against_radar),
        ),
    ]
}

/// Association, and combined metrics.
fn association(scores: &[FlightScores]) -> Vec<ResultRow> {
    let two = [FlightRow::Scenario("crossing"), FlightRow::Scenario("dense")];
    let of_two = |measure: &str, of| {
        ResultRow::new(format!("{measure}, the worse of `crossing` and `dense`"), each(scores, &two, of))
            .decimals(3)
            .lowest()
    };
    let mut rows = vec![
        of_two("association precision", |seeds, of| seeds.of_group(of.all, PRECISION)).limitation(
            "the learnt errors of the radar include those of turns, so a track that walks off is kept a little \
             longer.",
        ),
        of_two("association recall", |seeds, of| seeds.of_group(of.all, RECALL)),
        of_two("F1 of precision and recall", |seeds, of| seeds.of_group(of.all, F1)),
    ];
    let scenarios = ["single", "crossing", "dense"].map(FlightRow::Scenario);
    for row in scenarios.into_iter().chain([FlightRow::Variant(BIAS_EQUIPPED)]) {
        let is_single = row == FlightRow::Scenario("single");
        let measure = format!("GOSPA / `reference`'s, `{}`", row.name());
        let gospa: Measure = |seeds, of| seeds.ratio(of.all, REFERENCE.all, GOSPA);
        let row = ResultRow::new(measure, each(scores, &[row], gospa)).decimals(3);
        rows.push(match is_single {
            true => row.limitation(
                "a point in a silence that is more than 50 m off counts as a missed drone and a false one.",
            ),
            false => row,
        });
    }
    rows
}

/// Consistency of the height variance.
fn heights(scores: &[FlightScores]) -> Vec<ResultRow> {
    let row = |measure, of| {
        ResultRow::new(measure, each(scores, &every(), of))
            .farthest_from_one()
            .limitation("the data sheet's deviation of the height is 5 m; the simulated one is 2.5 m.")
    };
    vec![
        row("NEES of the height, covered slots, worst scenario", |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_V_COVERED)
        }),
        row("NEES of the height, gaps, worst scenario", |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_V_GAP)
        }),
    ]
}

/// The real flights, degraded as recorded.
fn real(scores: &[FlightScores]) -> Vec<ResultRow> {
    let row = |measure: &str, of| {
        let measure = format!("real flights, degraded as recorded: {measure}, worst flight");
        ResultRow::new(measure, each(scores, &RECORDINGS.map(FlightRow::Prepared), of))
    };
    let above_both: Measure = |seeds, of| {
        seeds.mean(|scores| {
            let alone = PU((RADAR.all)(scores))?.max(PU((TRANSPONDER.all)(scores))?);
            Some(PU((of.all)(scores))? - alone)
        })
    };
    vec![
        row("PU less the better input's, points", above_both).decimals(1).lowest(),
        row("ePosH on covered slots / transponder's", |seeds, of| {
            seeds.ratio(of.all, TRANSPONDER.all, COVERED)
        })
        .decimals(3),
        row("ePosH in gaps / radar's", |seeds, of| seeds.ratio(of.all, RADAR.all, GAP))
            .limitation("the drone turns off during one silence of six seconds, up to 136 m from its points.")
            .decimals(3),
    ]
}

fn speed(other: &OtherResults) -> Vec<ResultRow> {
    let row = |measure, [reference, operational]: [f64; 2]| {
        ResultRow::new(measure, measured(MeanValue::of(&[operational]), MeanValue::of(&[reference])))
    };
    vec![
        row("`dense`, times real time in processor time", other.speed.times_real).decimals(0).lowest(),
        row("`city`, 99 of 100 slots within, ms", other.speed.city_p99_ms).decimals(1),
    ]
}
