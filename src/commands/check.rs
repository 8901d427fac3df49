//! `check`: is the configuration valid, and what is in force.

use std::io::{self, Write};
use std::path::PathBuf;

use super::{CommandResult, Outcome};
use crate::areas::Masks;
use crate::config::Config;
use crate::normalise::Normaliser;

/// Validates a configuration and prints the one in force, every default filled in.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The configuration.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = Config::load(&args.config)?;
    let undulation_m = Normaliser::new(&config, Masks::load(&config.areas)?).undulation_m();
    let mut out = io::stdout().lock();
    writeln!(out, "# {}: valid. In force, defaults filled in:", args.config.display())?;
    writeln!(out, "# geoid undulation: {undulation_m:.2} m\n")?;
    write!(out, "{config}")?;
    Ok(Outcome::Done)
}
