//! Makes `docs/SEED001.md`: three configurations of sensors against two intruders that turn, after M. Rousseau, L. Ratton,
//! T. Fournet, *Multiple sensor tracking in a sense & avoid context* (ICAS 2010), section 4.
//!
//! ```sh
//! cargo run --release --example seed001
//! cargo run --release --example seed001 -- --quick --first-seed 1 --runs 60
//! ```
//!
//! `--quick` writes nothing and prints what is asked. What is tuned is tuned on the seeds below 1001.

#[path = "../experiment/mod.rs"]
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

use crate::experiment::{Args, Failure, asked_table, timed, write};
use crate::summary::Summary;

/// Flights of each intruder with each configuration, of the page.
const RUNS: u64 = 200;

fn main() -> Result<(), Failure> {
    let Args { quick, first_seed, runs } = Args::parse();
    let runs = runs.unwrap_or(RUNS);
    let (summary, took_s) = timed(|| Summary::measure(first_seed, runs));
    if quick {
        println!("{}\n{}\n{}", summary.table(), summary.models_table(), asked_table(&summary.asked()));
        return Ok(());
    }
    let figures = figures::figures(&summary);
    write("SEED001.md", &page::page(&summary, &figures)?, &figures)?;
    eprintln!("docs/SEED001.md: {runs} flights of each in {took_s:.1} s");
    Ok(())
}
