//! Worlds beyond the standard sets: scenarios with one difficulty each, and random worlds.

mod figures;
mod flown;
mod rows;

use std::ops::RangeInclusive;

use utm_fusion::simulate::random;

use crate::flights::{self, EvaluationFailure};
use crate::parallel;
use figures::{COLUMNS, WorldFigures, cells, heads};
use flown::World;

/// Scenarios, in the order of the table.
pub const NAMED: [&str; 12] = [
    "braking",
    "fast",
    "swarm",
    "barometric",
    "two-transponders",
    "two-networks",
    "slow-gnss",
    "late-stamps",
    "radar-clock",
    "ghosts",
    "flocks-40",
    "swaps",
];
/// Default number of seeds of each scenario.
pub const SEEDS: u64 = 3;
/// Default number of random worlds.
pub const HUNDRED: u64 = 100;
/// First seed of the random worlds in the document. None of these is used for tuning.
pub const HUNDRED_FIRST: u64 = 5001;

/// Results of all flights.
pub struct WorldResults {
    named: Vec<WorldFigures>,
    random: Vec<WorldFigures>,
}

/// Flies the scenarios with these seeds.
pub fn named(seeds: &RangeInclusive<u64>, threads: usize) -> Result<Vec<WorldFigures>, EvaluationFailure> {
    let mut worlds = Vec::new();
    for name in NAMED {
        let scenario = flights::scenario(name)?;
        worlds.extend(seeds.clone().map(|seed| World { scenario: scenario.clone(), seed }));
    }
    fly(&worlds, threads)
}

/// Flies the random worlds of these seeds.
pub fn hundred(seeds: &RangeInclusive<u64>, threads: usize) -> Result<Vec<WorldFigures>, EvaluationFailure> {
    let world = |seed| World { scenario: random::random_world(seed), seed };
    fly(&seeds.clone().map(world).collect::<Vec<_>>(), threads)
}

/// Flies all worlds of the document.
pub fn measure(seeds: &RangeInclusive<u64>, threads: usize) -> Result<WorldResults, EvaluationFailure> {
    let random = HUNDRED_FIRST..=HUNDRED_FIRST + HUNDRED - 1;
    Ok(WorldResults { named: named(seeds, threads)?, random: hundred(&random, threads)? })
}

fn fly(worlds: &[World], threads: usize) -> Result<Vec<WorldFigures>, EvaluationFailure> {
    let flown = parallel::each(worlds, threads, |place, world| {
        eprintln!("{} of {}: {} seed {}", place + 1, worlds.len(), world.scenario.name, world.seed);
        world.figures()
    });
    flown.into_iter().collect()
}

/// A line per scenario, with the means over its seeds.
pub fn table(named: &[WorldFigures]) -> String {
    let rows = NAMED.into_iter().filter_map(|name| {
        let of_name: Vec<&WorldFigures> = named.iter().filter(|figures| figures.name == name).collect();
        (!of_name.is_empty()).then(|| (name.to_owned(), cells(&of_name)))
    });
    aligned(rows)
}

/// A line per world, with its unusual parameters.
pub fn each(random: &[WorldFigures]) -> String {
    let rows: Vec<_> = random.iter().map(|figures| (figures.name.clone(), cells(&[figures]))).collect();
    let mut text = aligned(rows);
    for figures in random {
        let drawn = random::drawn(figures.seed).into_iter().filter(|drawn| drawn.is_unusual);
        let unusual: Vec<String> =
            drawn.map(|drawn| format!("{} {}", drawn.parameter.name, drawn.value)).collect();
        text += &format!("{}: {}\n", figures.name, unusual.join("; "));
    }
    text
}

/// Section of the document.
pub fn section(measured: &WorldResults) -> String {
    let mut lines = vec![heads("world")];
    lines.extend(NAMED.into_iter().map(|name| {
        let of_name: Vec<&WorldFigures> =
            measured.named.iter().filter(|figures| figures.name == name).collect();
        [vec![format!("`{name}`")], cells(&of_name)].concat()
    }));
    [
        include_str!("words/worlds.md").to_owned(),
        markdown(&lines),
        include_str!("words/hundred.md").to_owned(),
        summary(&measured.random),
        include_str!("words/worlds_short.md").to_owned(),
    ]
    .join("\n")
}

/// Table of the measures of random worlds.
pub fn summary(random: &[WorldFigures]) -> String {
    crate::results::table(&rows::rows(random), crate::results::SideColumn::Count)
}

fn aligned(rows: impl IntoIterator<Item = (String, Vec<String>)>) -> String {
    let line = |name: &str, cells: &[String]| {
        let cells =
            cells.iter().zip(COLUMNS).map(|(cell, column)| format!(" {cell:>width$}", width = column.width));
        format!("{name:<17}{}\n", cells.collect::<String>())
    };
    let mut text = line("world", &heads("")[1..]);
    for (name, cells) in rows {
        text += &line(&name, &cells);
    }
    text
}

fn markdown(lines: &[Vec<String>]) -> String {
    let mut text = String::new();
    for (index, cells) in lines.iter().enumerate() {
        text += &format!("| {} |\n", cells.join(" | "));
        if index == 0 {
            text += &format!("|---|{}\n", "---:|".repeat(cells.len() - 1));
        }
    }
    text
}
