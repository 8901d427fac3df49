//! Measures of the results' first table.

use crate::figures::*;
use crate::flights::{CITY, FlightRow, RECORDINGS, SCENARIOS};
use crate::integrity::IntegrityResults;
use crate::lags::{self, LatencyResults};
use crate::limit::{self, LimitResults};
use crate::registration::RegistrationResults;
use crate::results::{Measure, ResultRow, against, each, measured};
use crate::score::FlightScores;
use crate::sheet;
use crate::speed::SpeedResults;
use crate::variants::{BIAS_EQUIPPED, BIRDS, BOGUS, RADARS, SPARSE, TWO_RADARS, TWO_RADARS_PATCHY};
use crate::worlds::WorldResults;

/// Measurements other than the flights' scores.
pub struct OtherResults {
    /// Accuracy of the registration.
    pub registration: RegistrationResults,
    /// Cost of shorter latencies.
    pub lags: Vec<LatencyResults>,
    /// Detection of false transponder reports.
    pub integrity: IntegrityResults,
    /// Error compared with a smoother that knows the drone of each plot and report.
    pub limit: Vec<LimitResults>,
    pub speed: SpeedResults,
    /// Worlds that were not used for tuning.
    pub worlds: WorldResults,
}

/// The standard sets.
pub const STANDARD: [FlightRow; 5] = [
    FlightRow::Scenario("single"),
    FlightRow::Scenario("crossing"),
    FlightRow::Scenario("dense"),
    FlightRow::Scenario("flock"),
    FlightRow::Variant(BIAS_EQUIPPED),
];

/// Duration to which the seconds of ghosts refer, minutes.
const GHOSTS_MINUTES: f64 = 20.0;

/// All rows of the table.
pub fn rows(scores: &[FlightScores], other: &OtherResults) -> Vec<ResultRow> {
    let mut rows = covered(scores);
    rows.extend(shown(scores));
    rows.extend(gaps(scores));
    rows.extend(named(scores));
    rows.extend(consistency(scores));
    rows.extend(radars(scores));
    rows.extend(limit::rows(&other.limit));
    rows.extend(lags::rows(&other.lags));
    rows.extend(speed(&other.speed));
    rows
}

fn one(name: &'static str) -> [FlightRow; 1] {
    [FlightRow::Scenario(name)]
}

/// Rows for every multiple of the data sheet's errors.
fn sheets() -> Vec<FlightRow> {
    sheet::BASES.into_iter().flat_map(sheet::rows).map(|(_, row)| row).collect()
}

fn covered(scores: &[FlightScores]) -> Vec<ResultRow> {
    let covered: Measure = |seeds, of| seeds.ratio(of.equipped, TRANSPONDER.equipped, COVERED);
    let twice = sheet::BASES.map(|base| FlightRow::Sheet(base, 200));
    vec![
        ResultRow::new(
            "error on covered slots / transponder's: standard sets",
            each(scores, &STANDARD, covered),
        )
        .limitation(
            "the rest is the slow error of the satellite receivers, which no radar of these scenarios sees, and \
             the transponders' delay, which one drone and one radar show only within a quarter of an hour.",
        ),
        ResultRow::new(
            "error on covered slots / transponder's: radar at 2 times its data sheet",
            each(scores, &twice, covered),
        ),
        ResultRow::new(
            "ePosH / transponder's: clean real flights",
            each(scores, &RECORDINGS.map(FlightRow::Clean), |seeds, of| {
                seeds.ratio(of.all, TRANSPONDER.all, EPOSH)
            }),
        ),
        ResultRow::new(
            "true errors 0.1 to 2 times the configured: association recall",
            each(scores, &sheets(), |seeds, of| seeds.of_group(of.all, RECALL)),
        )
        .limitation(
            "the learnt bias is smaller than that of a turn, so the plots of turns count against their own drone.",
        )
        .decimals(3)
        .lowest(),
        ResultRow::new(
            "true errors 0.1 to 2 times the configured: error on covered slots / transponder's",
            each(scores, &sheets(), covered),
        ),
    ]
}

/// Probability of update, and share of slots with a point near the drone.
fn shown(scores: &[FlightScores]) -> Vec<ResultRow> {
    let pu: Measure = |seeds, of| seeds.of_group(of.equipped, PU);
    let near: Measure = |seeds, of| seeds.of_group(of.equipped, GAP_WITHIN_50_M);
    let rare = [FlightRow::Scenario("gaps"), FlightRow::Variant(SPARSE)];
    let row = |measure, rows: &[FlightRow], of| {
        ResultRow::new(measure, each(scores, rows, of)).decimals(1).lowest()
    };
    vec![
        row("PU of equipped drones, percent: standard sets", &STANDARD, pu),
        row("PU of equipped drones, percent: `gaps` and sparse reports", &rare, pu),
        row("gap slots with a point within 50 m, percent: standard sets", &STANDARD, near),
        row("gap slots with a point within 50 m, percent: `gaps`", &one("gaps"), near)
            .limitation("no sensor sees the drone in half of these slots."),
    ]
}

/// Errors without transponder reports.
fn gaps(scores: &[FlightScores]) -> Vec<ResultRow> {
    let bogus = BOGUS.map(|(name, base)| (FlightRow::Variant(name), FlightRow::Scenario(base)));
    vec![
        ResultRow::new(
            "error in gaps / radar's: standard sets",
            each(scores, &STANDARD, |seeds, of| seeds.ratio(of.equipped, RADAR.equipped, GAP)),
        )
        .limitation(
            "points that no sensor sees are published up to a 95 % radius of 100 m; the ratio of points that a \
             radar sees is below 0.3.",
        ),
        ResultRow::new(
            "bogus I048/200: error in gaps / without them",
            against(scores, &bogus, |scores| GAP((OPERATIONAL.equipped)(scores))),
        ),
        ResultRow::new(
            "bogus I048/200: error of drones without transponder / without them",
            against(scores, &bogus, |scores| EPOS((OPERATIONAL.unequipped)(scores))),
        ),
    ]
}

/// Track numbers and false tracks.
fn named(scores: &[FlightScores]) -> Vec<ResultRow> {
    let changes: Measure = |seeds, of| seeds.of_group(of.all, ID_CHANGES);
    let birds: Measure = |seeds, of| seeds.of_group(of.all, FALSE_TRACK);
    let half = BIRDS.map(FlightRow::Variant);
    let with_birds: Vec<FlightRow> =
        [FlightRow::Scenario("dense"), FlightRow::Scenario(CITY)].into_iter().chain(half.clone()).collect();
    let birds_of =
        |measure, rows: &[FlightRow]| ResultRow::new(measure, each(scores, rows, birds)).decimals(1);
    vec![
        ResultRow::new(
            "identity changes a drone-minute, all drones: standard sets",
            each(scores, &STANDARD, changes),
        )
        .limitation(
            "drones without a transponder are reacquired by position alone, after 20 s unseen by the radar on \
             average.",
        ),
        ResultRow::new(
            "identity changes a drone-minute, all drones: every scenario",
            each(scores, &SCENARIOS.map(FlightRow::Scenario), changes),
        )
        .limitation("a spoofed or jumping transponder leaves its radar track, which becomes a second aircraft."),
        birds_of("seconds of bird track a minute: `dense`", &one("dense")),
        birds_of("seconds of bird track a minute: birds of mean probability 0.5", &half).limitation(
            "a site learns its birds from how many tracks show a UAV probability, which takes some of these five \
             minutes.",
        ),
        birds_of("seconds of bird track a minute: `city` (500 birds)", &one(CITY)),
        ResultRow::new(
            "PU of drones without transponder, percent: where birds are counted",
            each(scores, &with_birds, |seeds, of| seeds.of_group(of.unequipped, PU)),
        )
        .limitation("drones that look like the birds of their site are withheld with them.")
        .decimals(1)
        .lowest(),
        ResultRow::new(
            "ghosts in 20 minutes of clean real flight, seconds",
            each(scores, &RECORDINGS.map(FlightRow::Clean), |seeds, of| {
                seeds.mean(|scores| Some(GHOSTS_MINUTES * GHOSTS((of.all)(scores))?))
            }),
        )
        .decimals(1),
    ]
}

/// Consistency of covariances.
fn consistency(scores: &[FlightScores]) -> Vec<ResultRow> {
    let row = |measure, of| ResultRow::new(measure, each(scores, &STANDARD, of)).farthest_from_one();
    vec![
        row("NEES over ground, covered slots: standard sets", |seeds, of| {
            seeds.of_drones(of.each_equipped, NEES_COVERED)
        })
        .limitation(
            "half of the transponders state an accuracy that is rounded up to whole metres: 3 m instead of 2.2 m.",
        ),
        row("NEES over ground, gaps: standard sets", |seeds, of| seeds.of_drones(of.each_equipped, NEES_GAP))
            .limitation(
                "a silent drone is sometimes taken for another drone's radar track, with too small a covariance; a \
                 few such intervals determine the mean.",
            ),
        row("NEES over ground, drones without transponder: standard sets", |seeds, of| {
            seeds.of_drones(of.each_unequipped, NEES)
        }),
    ]
}

/// Several radars observing one aircraft.
fn radars(scores: &[FlightScores]) -> Vec<ResultRow> {
    let two = RADARS.into_iter().filter(|(name, _)| [TWO_RADARS, TWO_RADARS_PATCHY].contains(name));
    let two: Vec<_> =
        two.map(|(name, first)| (FlightRow::Variant(name), FlightRow::Variant(first))).collect();
    let [steady, patchy] = two.as_slice() else { unreachable!("there are two of them") };
    let error = |scores: &FlightScores| EPOS((OPERATIONAL.unequipped)(scores));
    let rows: Vec<FlightRow> = two.iter().map(|(row, _)| row.clone()).collect();
    let seen = |measure: &'static str, error: Measure| ResultRow::new(measure, each(scores, &rows, error));
    vec![
        seen(
            "two radars, drone without transponder: error / one radar's, in slots where both see it",
            |seeds, of| seeds.ratio(of.unequipped, RADAR.unequipped, SEVERAL_RADARS),
        )
        .limitation(
            "tracks of both radars are not associated while their offset is above three sigma, or while one radar \
             classifies the drone as a bird.",
        ),
        seen("the same, in slots where one of them sees it", |seeds, of| {
            seeds.ratio(of.unequipped, RADAR.unequipped, ONE_RADAR)
        }),
        ResultRow::new(
            "two radars, drone without transponder: error / one radar's, each seeing it most of the time",
            against(scores, std::slice::from_ref(steady), error),
        )
        .limitation(
            "in a third of the slots one radar alone sees the drone, or none, and in one of eight a track has \
             walked off.",
        ),
        ResultRow::new(
            "two radars, drone without transponder: error / one radar's, each seeing it half of the time",
            against(scores, std::slice::from_ref(patchy), error),
        )
        .limitation("both radars see the drone in only one of six slots."),
        ResultRow::new(
            "two radars: slots of a drone with two numbers, percent",
            each(scores, &rows, |seeds, of| seeds.of_group(of.all, TWO_NUMBERS)),
        )
        .limitation(
            "tracks whose offset is above three sigma, mostly in turns, remain two aircraft until the offset is \
             smaller; within 100 m of each other, a drone may keep the other one's track.",
        ),
    ]
}

fn speed(speed: &SpeedResults) -> Vec<ResultRow> {
    let [of_reference, of_operational] = speed.exponents;
    let [written, not_written] = speed.processor;
    let row = |measure, result| ResultRow::new(measure, measured(result, None));
    vec![
        row("`operational` / `reference`, processor time on `dense`, one run, pictures written", written)
            .limitation(
                "no part dominates: estimates, association and filters take a fifth each of the engine's time, \
                 comparisons a seventh.",
            )
            .decimals(1),
        row("the same, pictures not written", not_written).decimals(1),
        row("integrity `flag` / `off`, processor time on `dense`, one run, pictures not written", speed.integrity)
            .limitation(
                "each second of each radar track near a transponder is compared with its curve, by some fifty \
                 filters per transponder.",
            ),
        row(
            "exponent of processor time over 500 to 4,000 targets at constant density: `reference`",
            of_reference,
        ),
        row(
            "exponent of processor time over 500 to 4,000 targets at constant density: `operational`",
            of_operational,
        ),
        row("2,000 radar tracks and 2,000 transponders: slot p99.9, ms", speed.crowd_p999_ms)
            .limitation(
                "likelihoods over the six seconds ahead are computed again in each slot; registration and \
                 numbering run on one core.",
            )
            .decimals(1),
        row("`city` live: lateness p99.9 beyond a sleeping timer, ms", speed.live[0]),
        row("`city` live: \"now\" after its deadline, p99.9 beyond a sleeping timer, ms", speed.live[2]),
        row("`city` live: resident memory, MB", speed.live[1])
            .limitation(
                "the engine takes some 60 MB, a checkpoint 30 MB while it is written, the pictures of the last 16 s \
                 20 MB and the program 15 MB; the allocator keeps the rest.",
            )
            .decimals(0),
    ]
}
