//! Writes `docs/SEED001.md`: three configurations of sensors against two turning intruders, after M. Rousseau, L.
//! Ratton, T. Fournet, *Multiple sensor tracking in a sense & avoid context* (ICAS 2010), section 4.
//!
//! ```sh
//! cargo run --release --example seed001
//! cargo run --release --example seed001 -- --quick --first-seed 1 --runs 60
//! ```
//!
//! `--quick` writes nothing and prints the requirements. Only seeds below 1001 are used for tuning.

#[path = "../experiment/experiment.rs"]
mod experiment;
mod figures;
mod page;
mod scenario;
mod sensors;
mod summary;
#[cfg(test)]
mod tests;
mod tracking;

use clap::Parser;

use crate::experiment::{Args, ExperimentFailure, requirement_table, timed, write};
use crate::summary::TurnSummary;

/// Number of flights of each intruder with each configuration, for the page.
const RUNS: u64 = 200;

fn main() -> Result<(), ExperimentFailure> {
    let Args { quick, first_seed, runs } = Args::parse();
    let runs = runs.unwrap_or(RUNS);
    let (summary, took_s) = timed(|| TurnSummary::measure(first_seed, runs));
    if quick {
        println!(
            "{}\n{}\n{}",
            summary.table(),
            summary.models_table(),
            requirement_table(&summary.requirements())
        );
        return Ok(());
    }
    let figures = figures::figures(&summary);
    write("SEED001.md", &page::page(&summary, &figures)?, &figures)?;
    eprintln!("docs/SEED001.md: {runs} flights of each in {took_s:.1} s");
    Ok(())
}
