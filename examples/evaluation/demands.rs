//! The figures that were asked for, each with the words for where it falls short.

use crate::asked::{Asked, Bound, Demand, Measure};
use crate::figures::*;
use crate::flights::{CITY, RECORDINGS, Row, SCENARIOS};
use crate::held_out::BIRDS;
use crate::registration;
use crate::score::Scores;
use crate::speed::Speed;
use crate::summary::Mean;
use Bound::{AtLeast, AtMost, Honest, Nothing};

/// Why deviations are too small where transponders speak.
const DRIFT: &str = "a transponder's error drifts for a minute (GNSS), and that of a report is taken for its own: the filter believes in a mean that is none. In `spoof` it believes the spoofed one.";

/// What was measured besides the flights' scores.
pub struct Apart {
    /// How well the registration is found.
    pub found: registration::Found,
    /// `dense`, `reference` and `operational`.
    pub dense: [Speed; 2],
    /// `city`, the same.
    pub city: [Speed; 2],
}

/// Every row of the table.
pub fn asked(scores: &[Scores], apart: &Apart) -> Vec<Asked> {
    let mut rows = places(scores);
    rows.extend(presence(scores));
    rows.extend(rightness(scores));
    rows.extend(registration::asked(&apart.found));
    rows.extend(honesty(scores));
    rows.extend(real(scores));
    rows.extend(speed(apart));
    rows
}

fn every() -> Vec<Row> {
    SCENARIOS.map(Row::Scenario).into()
}

fn one(name: &'static str) -> Vec<Row> {
    vec![Row::Scenario(name)]
}

/// Where the drones are said to be.
fn places(scores: &[Scores]) -> Vec<Asked> {
    let against_transponder: Measure = |seeds, of| seeds.ratio(of.equipped, TRANSPONDER.equipped, COVERED);
    let mut rows = vec![
        Demand {
            figure: "error on covered slots / transponder's, worst scenario",
            rows: every(),
            measure: against_transponder,
            decimals: 3,
            required: AtMost(1.0),
            ambition: AtMost(0.85),
            why: "",
        }
        .over(scores),
        Demand {
            figure: "error on covered slots / transponder's, told the delay, worst scenario",
            rows: every(),
            measure: |seeds, _| seeds.mean(covered_with_delay),
            decimals: 3,
            required: AtMost(0.92),
            ambition: Nothing,
            why: "",
        }
        .over(scores),
    ];
    // The profile of the paper is not told a delay.
    rows[1].reference = None;
    for (name, figure, required, ambition) in [
        ("single", "error on covered slots / `reference`'s, `single`", 0.78, 0.68),
        ("crossing", "error on covered slots / `reference`'s, `crossing`", 0.77, 0.64),
        ("bias", "error on covered slots / `reference`'s, `bias`", 0.60, 0.47),
    ] {
        let demand = Demand {
            figure,
            rows: one(name),
            measure: |seeds, of| seeds.ratio(of.equipped, REFERENCE.equipped, COVERED),
            decimals: 3,
            required: AtMost(required),
            ambition: AtMost(ambition),
            why: "",
        };
        rows.push(demand.over(scores));
    }
    let gaps = Demand {
        figure: "error in transponder gaps / radar's, worst scenario",
        rows: every(),
        measure: |seeds, of| seeds.ratio(of.equipped, RADAR.equipped, GAP),
        decimals: 3,
        required: AtMost(0.45),
        ambition: AtMost(0.25),
        why: "",
    };
    rows.push(gaps.over(scores));
    rows
}

/// Who is put out, and drones without a transponder.
fn presence(scores: &[Scores]) -> Vec<Asked> {
    let against_radar: Measure = |seeds, of| seeds.ratio(of.unequipped, RADAR.unequipped, EPOS);
    let above_transponder: Measure = |seeds, of| {
        seeds.mean(|scores| Some(PU((of.equipped)(scores))? - PU((TRANSPONDER.equipped)(scores))?))
    };
    let demands = [
        Demand {
            figure: "PU of equipped drones, percent, worst scenario",
            rows: every(),
            measure: |seeds, of| seeds.of_group(of.equipped, PU),
            decimals: 1,
            required: AtLeast(90.0),
            ambition: AtLeast(95.0),
            why: "in silences of 15 to 45 s a place is soon not known to the 25 m within which it is put out, unless the radar sees the drone.",
        },
        Demand {
            figure: "PU of equipped drones less the transponder's, points, worst scenario",
            rows: every(),
            measure: above_transponder,
            decimals: 1,
            required: AtLeast(0.0),
            ambition: Nothing,
            why: "",
        },
        Demand {
            figure: "PU of drones without transponder, percent (the radar's is 38 to 40), worst scenario",
            rows: every(),
            measure: |seeds, of| seeds.of_group(of.unequipped, PU),
            decimals: 1,
            required: AtLeast(36.0),
            ambition: AtLeast(45.0),
            why: "",
        },
        Demand {
            figure: "error of drones without transponder / radar's, worst scenario",
            rows: every(),
            measure: against_radar,
            decimals: 3,
            required: AtMost(1.0),
            ambition: Nothing,
            why: "",
        },
        Demand {
            figure: "error of drones without transponder / radar's, `bias` after 40 drone-minutes",
            rows: vec![Row::Settled("bias")],
            measure: against_radar,
            decimals: 3,
            required: AtMost(0.65),
            ambition: AtMost(0.5),
            why: "the radar's registration is not found yet.",
        },
    ];
    demands.map(|demand| demand.over(scores)).into()
}

/// Who is brought together with whom, what they are called, and what is no drone.
fn rightness(scores: &[Scores]) -> Vec<Asked> {
    let two = || vec![Row::Scenario("crossing"), Row::Scenario("dense")];
    let few = || every().into_iter().filter(|row| row.name() != CITY).collect();
    let gospa = |figure, name, required, ambition| Demand {
        figure,
        rows: one(name),
        measure: |seeds, of| seeds.ratio(of.all, REFERENCE.all, GOSPA),
        decimals: 3,
        required: AtMost(required),
        ambition: AtMost(ambition),
        why: "",
    };
    let all = |figure, rows, measure: Measure| Demand {
        figure,
        rows,
        measure,
        decimals: 3,
        required: Nothing,
        ambition: Nothing,
        why: "",
    };
    let demands = [
        Demand {
            required: AtLeast(0.99),
            ..all("association precision, the worse of `crossing` and `dense`", two(), |seeds, of| {
                seeds.of_group(of.all, PRECISION)
            })
        },
        Demand {
            required: AtLeast(0.95),
            ..all("association recall, the worse of `crossing` and `dense`", two(), |seeds, of| {
                seeds.of_group(of.all, RECALL)
            })
        },
        Demand {
            ambition: AtLeast(0.99),
            ..all("F1 of precision and recall, the worse of `crossing` and `dense`", two(), |seeds, of| {
                seeds.of_group(of.all, F1)
            })
        },
        Demand {
            decimals: 2,
            required: AtMost(0.1),
            ambition: AtMost(0.02),
            ..all("identity changes a drone and minute, equipped, worst scenario", every(), |seeds, of| {
                seeds.of_group(of.equipped, ID_CHANGES)
            })
        },
        Demand {
            decimals: 1,
            required: AtMost(1.0),
            ambition: AtMost(0.0),
            ..all("seconds of bird track a minute, worst scenario but `city`", few(), |seeds, of| {
                seeds.of_group(of.all, FALSE_TRACK)
            })
        },
        Demand {
            decimals: 1,
            required: AtMost(1.0),
            ambition: AtMost(0.0),
            ..all("seconds of bird track a minute, `city` (500 birds)", one(CITY), |seeds, of| {
                seeds.of_group(of.all, FALSE_TRACK)
            })
        },
        Demand {
            decimals: 1,
            required: AtMost(5.0),
            ambition: AtMost(1.0),
            why: "a second of plots counts 8 (p - 0.45), and at 0.5 that makes a drone of a bird in 8 s.",
            ..all(
                "seconds of bird track a minute, birds of mean probability 0.5",
                BIRDS.map(Row::HeldOut).into(),
                |seeds, of| seeds.of_group(of.all, FALSE_TRACK),
            )
        },
        gospa("GOSPA / `reference`'s, `single`", "single", 0.27, 0.22),
        gospa("GOSPA / `reference`'s, `crossing`", "crossing", 0.68, 0.58),
        gospa("GOSPA / `reference`'s, `dense`", "dense", 0.68, 0.58),
        gospa("GOSPA / `reference`'s, `bias`", "bias", 0.38, 0.30),
    ];
    demands.map(|demand| demand.over(scores)).into()
}

/// Whether the covariance is what errors are.
fn honesty(scores: &[Scores]) -> Vec<Asked> {
    let demand = |figure, degrees, why, measure: Measure| Demand {
        figure,
        rows: every(),
        measure,
        decimals: 2,
        required: Honest(degrees),
        ambition: Nothing,
        why,
    };
    let demands = [
        demand("NEES over ground, covered slots, worst scenario", 2.0, DRIFT, |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_COVERED)
        }),
        demand("NEES over ground, gaps, worst scenario", 2.0, "", |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_GAP)
        }),
        demand("NEES over ground, drones without transponder, worst scenario", 2.0, "", |seeds, of| {
            seeds.of_drones(of.each_unequipped, NEES)
        }),
        demand("NEES of the height, covered slots, worst scenario", 1.0, DRIFT, |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_V_COVERED)
        }),
        demand("NEES of the height, gaps, worst scenario", 1.0, "", |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_V_GAP)
        }),
    ];
    demands.map(|demand| demand.over(scores)).into()
}

/// The real flights, degraded as recorded.
fn real(scores: &[Scores]) -> Vec<Asked> {
    let flights = || RECORDINGS.map(Row::Prepared).into();
    let above_both: Measure = |seeds, of| {
        seeds.mean(|scores| {
            let alone = PU((RADAR.all)(scores))?.max(PU((TRANSPONDER.all)(scores))?);
            Some(PU((of.all)(scores))? - alone)
        })
    };
    let demands = [
        Demand {
            figure: "real flights, degraded as recorded: PU less the better input's, points, worst flight",
            rows: flights(),
            measure: above_both,
            decimals: 1,
            required: AtLeast(0.0),
            ambition: Nothing,
            why: "",
        },
        Demand {
            figure: "real flights, degraded as recorded: ePosH on covered slots / transponder's, worst flight",
            rows: flights(),
            measure: |seeds, of| seeds.ratio(of.all, TRANSPONDER.all, COVERED),
            decimals: 3,
            required: AtMost(1.0),
            ambition: Nothing,
            why: "",
        },
        Demand {
            figure: "real flights, degraded as recorded: ePosH in gaps / radar's, worst flight",
            rows: flights(),
            measure: |seeds, of| seeds.ratio(of.all, RADAR.all, GAP),
            decimals: 3,
            required: AtMost(1.0),
            ambition: Nothing,
            why: "",
        },
    ];
    demands.map(|demand| demand.over(scores)).into()
}

fn speed(apart: &Apart) -> Vec<Asked> {
    let row = |figure: &str, decimals, required, of: [f64; 2]| Asked {
        figure: figure.to_owned(),
        decimals,
        required,
        ambition: Nothing,
        reference: Mean::of(&of[..1]),
        reached: Mean::of(&of[1..]),
        at: None,
        why: "",
    };
    let Apart { dense, city, .. } = apart;
    let times_real = [0, 1].map(|profile: usize| dense[profile].times_real);
    let p99_ms = [0, 1].map(|profile: usize| city[profile].p99_ms);
    vec![
        row("speed: `dense`, times real time on one core", 0, AtLeast(60.0), times_real),
        row("speed: `city`, 99 of 100 slots within, ms", 1, AtMost(60.0), p99_ms),
    ]
}
