//! Writes `docs/SEED003.md`: the calibration of cameras on an aircraft of G. Fasano et al., *An Innovative Procedure for
//! Calibration of Strapdown Electro-Optical Sensors Onboard Unmanned Air Vehicles* (Sensors 10, 2010), with the q-method of the
//! engine ([`fusion::registration::attitude`]).
//!
//! ```sh
//! cargo run --release --example seed003
//! cargo run --release --example seed003 -- --quick --first-seed 1 --runs 60
//! ```
//!
//! `--quick` writes nothing and prints the requirements.

mod cameras;
#[path = "../experiment/experiment.rs"]
#[allow(dead_code, reason = "shared by several experiments")]
mod experiment;
mod session;
mod summary;
#[cfg(test)]
mod tests;

use clap::Parser;

use crate::experiment::{Args, ExperimentFailure, page, requirement_table, timed, write};
use crate::summary::CalibrationSummary;

/// Number of sessions of each camera, and of each number of measurements.
const RUNS: u64 = 1000;

fn main() -> Result<(), ExperimentFailure> {
    let Args { quick, first_seed, runs } = Args::parse();
    let runs = runs.unwrap_or(RUNS);
    let (summary, took_s) = timed(|| CalibrationSummary::measure(first_seed, runs));
    let requirements = summary.requirements();
    if quick {
        println!("{}\n{}\n{}", summary.cameras(), summary.counts(), requirement_table(&requirements));
        return Ok(());
    }
    let met = requirements.iter().filter(|requirement| requirement.met).count();
    let measured = [
        ("runs", runs.to_string()),
        ("first_seed", first_seed.to_string()),
        ("cameras", summary.cameras()),
        ("counts", summary.counts()),
        ("met", format!("{met} of {}", requirements.len())),
        ("asked", requirement_table(&requirements)),
        ("fewer", summary.fewer()),
    ];
    write("SEED003.md", &page(include_str!("words/page.md"), &measured)?, &[])?;
    eprintln!("docs/SEED003.md: {runs} sessions of each kind in {took_s:.1} s");
    Ok(())
}
