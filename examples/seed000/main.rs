//! Writes `docs/SEED000.md`: radar alone compared with radar and camera in the encounter of G. Fasano et al.,
//! *Radar/electro-optical data fusion for non-cooperative UAS sense and avoid* (2015), Table 2.
//!
//! ```sh
//! cargo run --release --example seed000
//! cargo run --release --example seed000 -- --quick --first-seed 1 --runs 60
//! ```
//!
//! `--quick` writes nothing and prints the requirements. Only seeds below 1001 are used for tuning.

mod alignment;
mod approach;
mod encounter;
#[path = "../experiment/experiment.rs"]
mod experiment;
mod figures;
mod page;
mod sensors;
mod summary;
#[cfg(test)]
mod tests;
mod tracking;

use clap::Parser;

use crate::experiment::{Args, ExperimentFailure, requirement_table, timed, write};
use crate::summary::EncounterSummary;

/// Number of encounters of the page.
const RUNS: u64 = 400;

fn main() -> Result<(), ExperimentFailure> {
    let Args { quick, first_seed, runs } = Args::parse();
    let runs = runs.unwrap_or(RUNS);
    let (summary, took_s) = timed(|| EncounterSummary::measure(first_seed, runs));
    if quick {
        println!("{}\n{}", summary.table(), requirement_table(&summary.requirements()));
        return Ok(());
    }
    let figures = figures::figures(&summary.encounter, first_seed);
    write("SEED000.md", &page::page(&summary, &figures)?, &figures)?;
    eprintln!("docs/SEED000.md: {runs} encounters in {took_s:.1} s");
    Ok(())
}
