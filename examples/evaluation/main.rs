//! Writes `docs/EVALUATION.md`: both profiles compared with each input alone, on simulated and on real flights.
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
//! cargo run --release --example evaluation -- --renew worlds
//! cargo run --release --example evaluation -- --worlds --seeds 3
//! cargo run --release --example evaluation -- --hundred --seeds 100 --first-seed 5001 --each
//! cargo run --release --example evaluation -- --quick --seeds 20 --limit --scenario crossing --each
//! ```
//!
//! `--quick` writes nothing. It prints a line for each scenario with the `operational` profile, for variants of
//! scenarios, for multiples of the data sheet's errors, and for clean real flights. Only seeds below 1001 are used for
//! tuning; the document uses seeds from 1001 on.
//!
//! The real flights are recordings outside the project: `--recordings DIR` (or `UTM_FUSION_SHARED_DATA`) is the folder
//! that contains `drone-trial/`. Without them, their section is copied from the existing file.

mod conflicts;
mod degrade;
mod figures;
mod flights;
mod integrity;
mod lags;
mod limit;
mod measures;
mod parallel;
mod quick;
mod reference_measures;
mod registration;
mod renew;
mod report;
mod results;
mod runs;
mod score;
mod sheet;
mod speed;
mod summary;
mod table;
mod themes;
mod variants;
mod worlds;

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use utm_fusion::commands::replay;

use crate::flights::{CITY, EvaluationFailure, EvaluationFlight, FlightRow, RECORDINGS, SCENARIOS};
use crate::measures::OtherResults;
use crate::renew::DocumentSection;
use crate::report::EvaluationDocument;
use crate::results::SideColumn;
use crate::variants::VARIANTS;

/// First seed that is not used for tuning. `SEEDS` is the number of seeds of the document.
const FIRST_SEED: u64 = 1001;
const SEEDS: u64 = 20;
/// Number of seeds for `--quick`.
const QUICK_SEEDS: u64 = 4;

/// Writes docs/EVALUATION.md.
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Args {
    #[command(subcommand)]
    program: Option<Program>,
    /// Print a short table of the operational profile and write nothing. City is included only if --scenario names it.
    #[arg(long)]
    quick: bool,
    /// Fly only this scenario, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = SCENARIOS)]
    scenario: Vec<String>,
    /// Fly this scenario with radar errors that are multiples of the data sheet's, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = sheet::BASES)]
    sheet: Vec<String>,
    /// Fly only this variant of a scenario, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = VARIANTS.map(|variant| variant.name))]
    variant: Vec<String>,
    /// Replay this real flight as recorded, with --quick; repeat for more.
    #[arg(long, requires = "quick", value_name = "NAME", value_parser = RECORDINGS)]
    recording: Vec<String>,
    /// Measure only the cost of shorter latencies, with --quick.
    #[arg(long, requires = "quick")]
    lags: bool,
    /// Measure only processor time, with --quick.
    #[arg(long, requires = "quick")]
    speed: bool,
    /// Measure only the predictions of conflicts, with --quick.
    #[arg(long, requires = "quick")]
    conflicts: bool,
    /// Measure only the detection of false transponder reports, with --quick.
    #[arg(long, requires = "quick")]
    integrity: bool,
    /// Fly only this attack, or this scenario without an attack, with --integrity; repeat for more.
    #[arg(long, requires = "integrity", value_name = "NAME", value_parser = integrity::NAMES)]
    attack: Vec<String>,
    /// Fly only the scenarios of a wider world, and write nothing.
    #[arg(long)]
    worlds: bool,
    /// Fly only random worlds, and write nothing.
    #[arg(long, conflicts_with = "worlds")]
    hundred: bool,
    /// Update only this section of the document, on the first seeds that are not used for tuning.
    #[arg(long, value_name = "SECTION", conflicts_with_all = ["quick", "worlds", "hundred"])]
    renew: Option<DocumentSection>,
    /// Measure only the error compared with a smoother that knows the drone of each plot and report, with --quick.
    #[arg(long, requires = "quick", conflicts_with = "integrity")]
    limit: bool,
    /// Print a line for each attack and each false flag (with --integrity), for each kind of motion (with --limit), or
    /// for each world (with --hundred).
    #[arg(long)]
    each: bool,
    /// First seed, with --quick, --worlds and --hundred. Tune and test on different seeds.
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Number of seeds of each scenario; by default 20, with --quick 4, with --worlds 3, with --hundred 100.
    #[arg(long)]
    seeds: Option<u64>,
    /// Number of seeds of `city`.
    #[arg(long, default_value_t = 1)]
    city_seeds: u64,
    /// Folder that contains drone-trial/; by default the folder in UTM_FUSION_SHARED_DATA.
    #[arg(long)]
    recordings: Option<PathBuf>,
    /// File to write.
    #[arg(long, default_value = "docs/EVALUATION.md")]
    out: PathBuf,
    /// Number of flights at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

/// Subcommands of the program itself, for measuring the processor time of its runs.
#[derive(Subcommand)]
enum Program {
    #[command(hide = true)]
    Replay(replay::Args),
}

fn main() -> Result<(), EvaluationFailure> {
    let args = Args::parse();
    match args {
        Args { program: Some(Program::Replay(args)), .. } => replay::run(&args).map(drop),
        Args { speed: true, .. } => {
            println!("{:#?}", speed::measure(args.first_seed)?);
            Ok(())
        }
        Args { integrity: true, .. } => attacks(&args),
        Args { worlds: true, .. } => {
            let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(worlds::SEEDS) - 1;
            print!("{}", worlds::table(&worlds::named(&seeds, args.threads)?));
            Ok(())
        }
        Args { hundred: true, .. } => {
            let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(worlds::HUNDRED) - 1;
            let random = worlds::hundred(&seeds, args.threads)?;
            let each = if args.each { worlds::each(&random) } else { String::new() };
            print!("{each}{}", worlds::summary(&random));
            Ok(())
        }
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
        Args { renew: Some(section), .. } => renew(section, &args),
        Args { limit: true, .. } => bounds(&args),
        Args { quick: true, .. } => quick(&args),
        Args { .. } => document(&args),
    }
}

/// Prints the table of attacks on transponders.
fn attacks(args: &Args) -> Result<(), EvaluationFailure> {
    let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
    let recordings = args.recordings();
    let request = integrity::IntegrityRequest {
        seeds,
        names: &args.attack,
        recordings: recordings.as_deref(),
        threads: args.threads,
    };
    let measured = integrity::measure(&request)?;
    if args.each {
        println!("{}", integrity::each(&measured));
    }
    print!("{}", results::table(&integrity::rows(&measured), SideColumn::Count));
    Ok(())
}

/// Prints the table of the limit.
fn bounds(args: &Args) -> Result<(), EvaluationFailure> {
    let seeds = args.first_seed..=args.first_seed + args.seeds.unwrap_or(QUICK_SEEDS) - 1;
    let names: Vec<&str> = args.scenario.iter().chain(&args.variant).map(String::as_str).collect();
    let measured = limit::measure(&names, &seeds, args.threads)?;
    print!("{}", limit::table(&measured));
    if args.each {
        print!("{}", limit::parts(&measured));
    }
    Ok(())
}

/// Updates one section of the document.
fn renew(section: DocumentSection, args: &Args) -> Result<(), EvaluationFailure> {
    let seeds = |count| FIRST_SEED..=FIRST_SEED + args.seeds.unwrap_or(count) - 1;
    let text = match section {
        DocumentSection::Limit => limit::section(&limit::measure(&[], &seeds(QUICK_SEEDS), args.threads)?),
        DocumentSection::Worlds => worlds::section(&worlds::measure(&seeds(SEEDS), args.threads)?),
    };
    let document = String::from_utf8(std::fs::read(&args.out)?)?;
    let document = section.put_into(&document, &text).ok_or("the document has another form")?;
    std::fs::write(&args.out, document)?;
    Ok(())
}

fn quick(args: &Args) -> Result<(), EvaluationFailure> {
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
        let is_wanted = |flight: &EvaluationFlight| matches!(flight.row, FlightRow::Clean(name) if is_in(recording, name));
        flights.extend(flights::recorded(&folder, seeds).into_iter().filter(is_wanted));
    }
    print!("{}", quick::table(&score::score(&flights, args.threads)?));
    Ok(())
}

impl Args {
    fn recordings(&self) -> Option<PathBuf> {
        self.recordings.clone().or_else(|| std::env::var_os("UTM_FUSION_SHARED_DATA").map(PathBuf::from))
    }
}

fn document(args: &Args) -> Result<(), EvaluationFailure> {
    let seeds = FIRST_SEED..=FIRST_SEED + args.seeds.unwrap_or(SEEDS) - 1;
    // The largest flights come first, so that none of them runs alone at the end.
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
    let request = integrity::IntegrityRequest {
        seeds: seeds.clone(),
        names: &[],
        recordings: recordings.as_deref(),
        threads: args.threads,
    };
    let integrity = integrity::measure(&request)?;
    eprintln!("limit");
    // A smoother for each point takes long, so a few seeds must suffice.
    let few = FIRST_SEED..=(FIRST_SEED + QUICK_SEEDS - 1).min(*seeds.end());
    let limit = limit::measure(&[], &few, args.threads)?;
    eprintln!("worlds");
    let worlds = worlds::measure(&seeds, args.threads)?;
    let other = OtherResults {
        registration: found,
        lags,
        integrity,
        limit,
        speed: speed::measure(FIRST_SEED)?,
        worlds,
    };
    let before = String::from_utf8(std::fs::read(&args.out).unwrap_or_default())?;
    let (scores, other, city_seeds) = (scored.as_slice(), &other, args.city_seeds);
    let report = EvaluationDocument { scores, other, seeds, city_seeds, before: &before };
    std::fs::write(&args.out, report.text())?;
    eprintln!("written to {}", args.out.display());
    Ok(())
}
