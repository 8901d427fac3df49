//! Makes `docs/EVALUATION.md`: both profiles against each input alone, on simulated and on real flights.
//!
//! ```sh
//! cargo run --release --example evaluation
//! cargo run --release --example evaluation -- --quick --seeds 6 --scenario crossing --scenario gaps
//! cargo run --release --example evaluation -- --quick --seeds 6 --variant two-radars --variant singer
//! cargo run --release --example evaluation -- --quick --seeds 6 --sheet three
//! cargo run --release --example evaluation -- --quick --recording 1_4
//! cargo run --release --example evaluation -- --quick --integrity --seeds 20 --attack drift --attack crossing --each
//! cargo run --release --example evaluation -- --quick --seeds 6 --lags
//! cargo run --release --example evaluation -- --quick --seeds 20 --conflicts
//! ```
//!
//! `--quick` writes nothing: it prints a line a scenario of the `operational` profile, of variants of scenarios, of
//! multiples of the data sheet's errors and of clean real flights. What is tuned is tuned on the seeds below 1001; the
//! document is made on those from there on, which are for reporting only.
//!
//! The real flights are recordings that are not part of the project: `--recordings DIR` (or `UTM_FUSION_SHARED_DATA`)
//! names the folder that holds `drone-trial/`. Without them their section is taken over from the file as it stands.

mod asked;
mod conflicts;
mod degrade;
mod demands;
mod figures;
mod flights;
mod integrity;
mod lags;
mod parallel;
mod quick;
mod registration;
mod report;
mod runs;
mod score;
mod sheet;
mod speed;
mod standing;
mod summary;
mod table;
mod themes;
mod variants;

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use utm_fusion::commands::replay;

use crate::asked::Beside;
use crate::demands::Apart;
use crate::flights::{CITY, Failure, Flight, RECORDINGS, Row, SCENARIOS};
use crate::report::Report;
use crate::variants::VARIANTS;

/// The first of the seeds that nothing is tuned on, and how many of them the document is made on.
const FIRST_SEED: u64 = 1001;
const SEEDS: u64 = 20;
/// How many seeds `--quick` flies.
const QUICK_SEEDS: u64 = 4;

/// Makes docs/EVALUATION.md.
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Args {
    #[command(subcommand)]
    program: Option<Program>,
    /// Print a short table of the operational profile and write nothing; city only where --scenario names it.
    #[arg(long)]
    quick: bool,
    /// Only this scenario, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = SCENARIOS)]
    scenario: Vec<String>,
    /// Radars whose true errors are a multiple of their data sheet's, flown in this, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = sheet::BASES)]
    sheet: Vec<String>,
    /// Only this variant of a scenario, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = VARIANTS.map(|variant| variant.name))]
    variant: Vec<String>,
    /// This real flight as it was recorded, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = RECORDINGS)]
    recording: Vec<String>,
    /// Only what shorter latencies cost, with --quick.
    #[arg(long, requires = "quick")]
    lags: bool,
    /// Only what it costs, with --quick.
    #[arg(long, requires = "quick")]
    speed: bool,
    /// Only how well conflicts are foreseen, with --quick.
    #[arg(long, requires = "quick")]
    conflicts: bool,
    /// Only how well transponders that lie are found, with --quick.
    #[arg(long, requires = "quick")]
    integrity: bool,
    /// Of that only this attack, or this scenario without one, with --integrity; repeat for more.
    #[arg(long, requires = "integrity", value_name = "NAME", value_parser = integrity::NAMES)]
    attack: Vec<String>,
    /// A line for each attack and each false flag, with --integrity.
    #[arg(long, requires = "integrity")]
    each: bool,
    /// The first seed, with --quick: what was tuned on some is judged on others.
    #[arg(long, requires = "quick", default_value_t = 1)]
    first_seed: u64,
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

/// The program itself, for the processor time of its runs.
#[derive(Subcommand)]
enum Program {
    #[command(hide = true)]
    Replay(replay::Args),
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    match args {
        Args { program: Some(Program::Replay(args)), .. } => replay::run(&args).map(drop),
        Args { speed: true, .. } => {
            println!("{:#?}", speed::measure(args.first_seed)?);
            Ok(())
        }
        Args { integrity: true, .. } => lies(&args),
        Args { conflicts: true, .. } => {
            let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
            print!("{}", conflicts::table(&conflicts::measure(&seeds, args.threads)?));
            Ok(())
        }
        Args { lags: true, .. } => {
            let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
            print!("{}", lags::table(&lags::measure(seeds, args.threads)?));
            Ok(())
        }
        Args { quick: true, .. } => quick(&args),
        Args { .. } => document(&args),
    }
}

/// The table of the transponders that lie.
fn lies(args: &Args) -> Result<(), Failure> {
    let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
    let recordings = args.recordings();
    let order = integrity::Order {
        seeds,
        names: &args.attack,
        recordings: recordings.as_deref(),
        threads: args.threads,
    };
    let measured = integrity::measure(&order)?;
    if args.each {
        println!("{}", integrity::each(&measured));
    }
    print!("{}", asked::table(&integrity::asked(&measured), Beside::Count));
    Ok(())
}

fn quick(args: &Args) -> Result<(), Failure> {
    let Args { scenario, sheet, variant, recording, .. } = args;
    let names_some = [scenario, sheet, variant, recording].into_iter().any(|names| !names.is_empty());
    let is_in = |names: &[String], name: &str| names.iter().any(|wanted| wanted == name);
    let is_wanted = |name: &&str| is_in(scenario, name) || (!names_some && *name != CITY);
    let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
    let mut flights = Vec::new();
    for name in SCENARIOS.into_iter().filter(is_wanted) {
        flights.extend(flights::simulated(name, seeds.clone())?);
    }
    for variant in VARIANTS.into_iter().filter(|known| is_in(variant, known.name)) {
        flights.extend(variant.flights(seeds.clone())?);
    }
    for base in sheet::BASES.into_iter().filter(|base| is_in(sheet, base)) {
        flights.extend(sheet::flights(base, seeds.clone())?);
    }
    if !recording.is_empty() {
        let folder = args.recordings().ok_or("--recordings says where the real flights are")?;
        let is_asked = |flight: &Flight| matches!(flight.row, Row::Clean(name) if is_in(recording, name));
        flights.extend(flights::recorded(&folder, seeds).into_iter().filter(is_asked));
    }
    print!("{}", quick::table(&score::score(&flights, args.threads)?));
    Ok(())
}

impl Args {
    fn recordings(&self) -> Option<PathBuf> {
        self.recordings.clone().or_else(|| std::env::var_os("UTM_FUSION_SHARED_DATA").map(PathBuf::from))
    }
}

fn document(args: &Args) -> Result<(), Failure> {
    let seeds = FIRST_SEED..=FIRST_SEED + args.seeds.unwrap_or(SEEDS) - 1;
    // The largest first, so that two of them do not end it alone.
    let mut flights = flights::simulated(CITY, FIRST_SEED..=FIRST_SEED + args.city_seeds - 1)?;
    flights.extend(flights::settled(seeds.clone())?);
    for name in SCENARIOS.into_iter().filter(|&name| name != CITY) {
        flights.extend(flights::simulated(name, seeds.clone())?);
    }
    for variant in VARIANTS {
        flights.extend(variant.flights(seeds.clone())?);
    }
    for base in sheet::BASES {
        flights.extend(sheet::flights(base, seeds.clone())?);
    }
    let recordings = args.recordings();
    if recordings.is_none() {
        eprintln!(
            "the real flights are nowhere (--recordings DIR): their rows will say that they are not measured"
        );
    }
    flights.extend(recordings.iter().flat_map(|folder| flights::recorded(folder, seeds.clone())));
    let scored = score::score(&flights, args.threads)?;
    eprintln!("registration");
    let found = registration::found(&flights::scenario("crossing")?, seeds.clone(), args.threads)?;
    eprintln!("latencies");
    let lags = lags::measure(seeds.clone(), args.threads)?;
    let order = integrity::Order {
        seeds: seeds.clone(),
        names: &[],
        recordings: recordings.as_deref(),
        threads: args.threads,
    };
    let integrity = integrity::measure(&order)?;
    let apart = Apart { found, lags, integrity, speed: speed::measure(FIRST_SEED)? };
    let before = String::from_utf8(std::fs::read(&args.out).unwrap_or_default())?;
    let (scores, apart, city_seeds) = (scored.as_slice(), &apart, args.city_seeds);
    let report = Report { scores, apart, seeds, city_seeds, before: &before };
    std::fs::write(&args.out, report.text())?;
    eprintln!("written to {}", args.out.display());
    Ok(())
}
