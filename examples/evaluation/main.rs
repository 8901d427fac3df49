//! Makes `docs/EVALUATION.md`: both profiles against each input alone, on simulated and on real flights.
//!
//! ```sh
//! cargo run --release --example evaluation
//! cargo run --release --example evaluation -- --quick --seeds 6 --scenario crossing --scenario gaps
//! cargo run --release --example evaluation -- --quick --seeds 6 --sheet three
//! ```
//!
//! `--quick` writes nothing: it prints a line a scenario of the `operational` profile; with `--motion singer` by that model;
//! with `--sheet` a line a multiple of the data sheet's errors.
//!
//! The real flights are recordings that are not part of the project: `--recordings DIR` (or `UTM_FUSION_SHARED_DATA`)
//! names the folder that holds `drone-trial/`. Without them their section is taken over from the file as it stands.

mod asked;
mod degrade;
mod demands;
mod figures;
mod flights;
mod held_out;
mod quick;
mod registration;
mod report;
mod score;
mod sheet;
mod speed;
mod summary;
mod table;

use std::path::PathBuf;

use clap::Parser;
use utm_fusion::config::{Motion, Profile};

use crate::demands::Apart;
use crate::flights::{CITY, Failure, SCENARIOS};
use crate::report::Report;

/// Seeds of each scenario, for the document and for `--quick`.
const SEEDS: u64 = 20;
const QUICK_SEEDS: u64 = 4;
/// Seeds of the long flights.
const SETTLED_SEEDS: u64 = 20;

/// Makes docs/EVALUATION.md.
#[derive(Parser)]
struct Args {
    /// Print a short table of the operational profile and write nothing; city only where --scenario names it.
    #[arg(long)]
    quick: bool,
    /// Only this scenario, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = SCENARIOS)]
    scenario: Vec<String>,
    /// Radars whose true errors are a multiple of their data sheet's, flown in this, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = sheet::BASES)]
    sheet: Vec<String>,
    /// The first seed, with --quick: what was tuned on some is judged on others.
    #[arg(long, requires = "quick", default_value_t = 1)]
    first_seed: u64,
    /// How aircraft are taken to move, with --quick: imm (default) or singer.
    #[arg(long, requires = "quick")]
    motion: Option<Motion>,
    /// Seeds of each scenario; by default 20, with --quick 4.
    #[arg(long)]
    seeds: Option<u64>,
    /// Seeds of `city`.
    #[arg(long, default_value_t = 1)]
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

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    if args.quick { quick(&args) } else { document(args) }
}

fn quick(args: &Args) -> Result<(), Failure> {
    let is_wanted = |name: &&str| match args.scenario.as_slice() {
        [] => *name != CITY && args.sheet.is_empty(),
        wanted => wanted.iter().any(|wanted| wanted == name),
    };
    let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
    let mut flights = Vec::new();
    for name in SCENARIOS.into_iter().filter(is_wanted) {
        flights.extend(flights::simulated(name, seeds.clone())?);
    }
    for base in sheet::BASES.into_iter().filter(|base| args.sheet.iter().any(|wanted| wanted == base)) {
        flights.extend(sheet::flights(base, seeds.clone())?);
    }
    let motion = args.motion.unwrap_or(Motion::Imm);
    flights.iter_mut().for_each(|flight| flight.motion = motion);
    print!("{}", quick::table(&score::score(&flights, args.threads)?));
    Ok(())
}

fn document(args: Args) -> Result<(), Failure> {
    let seeds = args.seeds.unwrap_or(SEEDS);
    // The largest first, so that two of them do not end it alone.
    let mut flights = flights::simulated(CITY, 1..=args.city_seeds)?;
    flights.extend(flights::settled(SETTLED_SEEDS.min(seeds))?);
    for name in SCENARIOS.into_iter().filter(|&name| name != CITY) {
        flights.extend(flights::simulated(name, 1..=seeds)?);
    }
    flights.extend(held_out::flights()?);
    for base in sheet::BASES {
        flights.extend(sheet::flights(base, 1..=sheet::SEEDS)?);
    }
    let recordings =
        args.recordings.or_else(|| std::env::var_os("UTM_FUSION_SHARED_DATA").map(PathBuf::from));
    flights.extend(recordings.iter().flat_map(|folder| flights::recorded(folder)));
    let scored = score::score(&flights, args.threads)?;
    let speed = |name| -> Result<_, Failure> {
        let scenario = flights::scenario(name)?;
        let of = |profile| speed::measure(&scenario, profile);
        Ok([of(Profile::Reference)?, of(Profile::Operational)?])
    };
    eprintln!("how fast it is");
    let (dense, city) = (speed("dense")?, speed(CITY)?);
    eprintln!("registration");
    let found = registration::found(&flights::scenario("crossing")?, SETTLED_SEEDS.min(seeds), args.threads)?;
    let apart = Apart { found, dense, city };
    let before = String::from_utf8(std::fs::read(&args.out).unwrap_or_default())?;
    let (scores, apart, city_seeds) = (scored.as_slice(), &apart, args.city_seeds);
    let report = Report { scores, apart, seeds, city_seeds, before: &before };
    std::fs::write(&args.out, report.text())?;
    eprintln!("written to {}", args.out.display());
    Ok(())
}
