//! Endurance tests: a city for a day, and thousands of flights with faults. They run in virtual time, in one process,
//! without sockets; files are in a temporary directory.
//!
//! ```sh
//! cargo run --release --example endurance -- city --hours 24            # memory, history and time taken, minute by minute
//! cargo run --release --example endurance -- faults --schedules 10000   # network, clock, disk, restarts
//! ```
//!
//! The exit code is 1 if a condition was violated. `faults --from SEED --schedules 1` repeats a single schedule.

#![expect(clippy::disallowed_methods, reason = "it measures how long things take, and keeps files")]

mod city;
mod faults;
mod flights;
mod picture_log;
mod plan;
mod service;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

/// Runs endurance tests of the service.
#[derive(Parser)]
enum Args {
    /// A busy site for hours.
    City(city::Args),
    /// Flights of two minutes with faults.
    Faults(faults::Args),
    /// Writes one flight of the city, for the process that replays it.
    #[command(hide = true)]
    Flight(flights::Args),
}

fn main() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let holds = match Args::parse() {
        Args::City(args) => city::fly(&args)?,
        Args::Faults(args) => faults::fly(&args)?,
        Args::Flight(args) => flights::write(&args).map(|()| true)?,
    };
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
