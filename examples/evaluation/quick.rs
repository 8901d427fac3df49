//! Short table for developers of the `operational` profile: a line per row of flights.

use crate::figures::*;
use crate::flights::{FlightRow, RECORDINGS, SCENARIOS};
use crate::score::FlightScores;
use crate::sheet;
use crate::summary::{MeanValue, SeedScores};
use crate::variants::VARIANTS;

/// Headings and widths of the columns after the row's name.
const COLUMNS: [(&str, usize); 24] = [
    ("covered/T", 9),
    ("gap/radar", 9),
    ("gap50 %", 7),
    ("PU eq.", 6),
    ("uneq.", 5),
    ("err/radar", 9),
    ("precision", 9),
    ("recall", 6),
    ("id/min", 6),
    ("of all", 6),
    ("2 no. %", 7),
    ("ghost s", 7),
    ("false s", 7),
    ("GOSPA m", 7),
    ("/ref.", 5),
    ("NEES cov.", 9),
    ("gap", 6),
    ("uneq.", 8),
    ("straight", 8),
    ("turning", 7),
    ("off", 7),
    ("err m", 6),
    ("radars", 6),
    ("one", 5),
];

/// Table of the rows that were flown.
pub fn table(scores: &[FlightScores]) -> String {
    let line = |name: &str, cells: Vec<String>| {
        let cells = cells.into_iter().zip(COLUMNS).map(|(cell, (_, width))| format!("  {cell:>width$}"));
        format!("{name:<28}{}\n", cells.collect::<String>())
    };
    let mut text = line("scenario", COLUMNS.map(|(head, _)| head.to_owned()).into());
    let scenarios = SCENARIOS.into_iter().map(|name| (name.to_owned(), FlightRow::Scenario(name)));
    let variants =
        VARIANTS.into_iter().map(|variant| (variant.name.to_owned(), FlightRow::Variant(variant.name)));
    let sheets = sheet::BASES.into_iter().flat_map(sheet::rows);
    let recordings = RECORDINGS.into_iter().map(|name| (name.to_owned(), FlightRow::Clean(name)));
    for (name, row) in scenarios.chain(variants).chain(sheets).chain(recordings) {
        let seeds = SeedScores::of(scores, &row);
        if !seeds.0.is_empty() {
            text += &line(&name, cells(&seeds));
        }
    }
    text
}

fn cells(seeds: &SeedScores<'_>) -> Vec<String> {
    let show = |mean: Option<MeanValue>, decimals: usize| {
        mean.map_or("-".to_owned(), |mean| format!("{:.decimals$}", mean.mean))
    };
    let of = |group: ScoreGroup, figure: ScoreFigure, decimals| show(seeds.of_group(group, figure), decimals);
    let ratio =
        |of: ScoreGroup, over: ScoreGroup, figure: ScoreFigure| show(seeds.ratio(of, over, figure), 3);
    let nees = |drones: DroneScores, figure: ScoreFigure| show(seeds.of_drones(drones, figure), 2);
    let us = OPERATIONAL;
    vec![
        ratio(us.equipped, TRANSPONDER.equipped, COVERED),
        ratio(us.equipped, RADAR.equipped, GAP),
        of(us.equipped, GAP_WITHIN_50_M, 1),
        of(us.equipped, PU, 1),
        of(us.unequipped, PU, 1),
        ratio(us.unequipped, RADAR.unequipped, EPOS),
        of(us.all, PRECISION, 3),
        of(us.all, RECALL, 3),
        of(us.equipped, ID_CHANGES, 3),
        of(us.all, ID_CHANGES, 3),
        of(us.all, TWO_NUMBERS, 2),
        of(us.all, GHOSTS, 2),
        of(us.all, FALSE_TRACK, 2),
        of(us.all, GOSPA, 1),
        ratio(us.all, REFERENCE.all, GOSPA),
        nees(us.each_equipped, NEES_COVERED),
        nees(us.each_equipped, NEES_GAP),
        nees(us.each_unequipped, NEES),
        nees(us.each_unequipped, NEES_STRAIGHT),
        nees(us.each_unequipped, NEES_TURNING),
        nees(us.each_unequipped, NEES_WALKED_OFF),
        of(us.unequipped, EPOS, 1),
        ratio(us.unequipped, RADAR.unequipped, SEVERAL_RADARS),
        ratio(us.unequipped, RADAR.unequipped, ONE_RADAR),
    ]
}
