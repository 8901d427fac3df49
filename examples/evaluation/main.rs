//! Makes `docs/EVALUATION.md`: the `reference` profile against each input alone, on simulated and on real flights.
//!
//! ```sh
//! cargo run --release --example evaluation
//! ```
//!
//! The real flights are recordings that are not part of the project: `--recordings DIR` (or `UTM_FUSION_SHARED_DATA`)
//! names the folder that holds `drone-trial/`. Without them their section is taken over from the file as it stands.

mod degrade;
mod flights;
mod report;
mod summary;

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;

use crate::report::Report;

/// Makes docs/EVALUATION.md.
#[derive(Parser)]
struct Args {
    /// Seeds of each scenario.
    #[arg(long, default_value_t = 50)]
    seeds: u64,
    /// Seeds of `city`.
    #[arg(long, default_value_t = 2)]
    city_seeds: u64,
    /// The folder that holds drone-trial/; by default the one that UTM_FUSION_SHARED_DATA names.
    #[arg(long)]
    recordings: Option<PathBuf>,
    /// The file to write.
    #[arg(long, default_value = "docs/EVALUATION.md")]
    out: PathBuf,
    /// How many flights are flown at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let args = Args::parse();
    let recordings =
        args.recordings.or_else(|| std::env::var_os("UTM_FUSION_SHARED_DATA").map(PathBuf::from));
    let flights = flights::all(args.seeds, args.city_seeds, recordings.as_deref())?;
    let scored = flights::score(&flights, args.threads)?;
    let before = std::fs::read(&args.out).unwrap_or_default();
    let before = String::from_utf8(before)?;
    let report = Report::new(&scored, args.seeds, args.city_seeds, &before);
    std::fs::write(&args.out, report.text())?;
    eprintln!("written to {}", args.out.display());
    Ok(())
}
