//! What only time shows: a city for a day, and thousands of flights in which things fail. In virtual time, in one process, with no
//! socket; files are in a directory of its own.
//!
//! ```sh
//! cargo run --release --example endurance -- city --hours 24            # memory, history and time taken, minute by minute
//! cargo run --release --example endurance -- faults --schedules 10000   # network, clock, disk, restarts
//! ```
//!
//! The exit code is 1 where something did not hold. A schedule of faults that failed is flown again, alone, by
//! `faults --from SEED --schedules 1`.

#![expect(clippy::disallowed_methods, reason = "it measures how long things take, and keeps files")]

mod book;
mod city;
mod faults;
mod flights;
mod plan;
mod service;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

/// Flies for long, and with faults.
#[derive(Parser)]
enum Args {
    /// A busy site for hours.
    City(city::Args),
    /// Flights of two minutes in which things fail.
    Faults(faults::Args),
    /// A flight of the city, for the process that flies it.
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
