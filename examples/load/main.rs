//! Loads the live service as a busy site does, and measures what comes out of it.
//!
//! ```sh
//! cargo build --release && cargo run --release --example load -- city       # ten minutes of 500 drones and 500 birds; --minutes 180
//! cargo build --release && cargo run --release --example load -- streams    # a thousand readers of the event stream
//! cargo build --release && cargo run --release --example load -- flood      # 6,000 invented identities a second
//! cargo build --release && cargo run --release --example load -- trails     # a hundred addresses that ask for the longest trails
//! ```
//!
//! The simulator and the service run as processes of their own, with recorder and history; everything stays on this
//! machine's loopback interface and ends by itself. The figures of `city` and `streams` are also written to
//! `target/load-<scenario>.json`, and what each minute was like to `.csv` and `.svg` beside it. The exit code is 1 where a figure is missed.

#![expect(clippy::disallowed_methods, reason = "it measures how long things take")]

mod figures;
mod flights;
mod flood;
#[path = "../../tests/shared/invented.rs"]
#[allow(dead_code, reason = "shared with tests")]
mod invented;
mod minutes;
mod output;
mod readers;
mod stage;
mod trails;

use std::error::Error;
use std::fs;
use std::net::{Ipv4Addr, SocketAddr};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use clap::Parser;

use crate::figures::{Figures, Quantiles};
use crate::output::{Lateness, Output};
use crate::readers::{Read, Wish};
use crate::stage::Stage;

/// Loads the live service and measures what comes out of it.
#[derive(Parser)]
struct Args {
    /// What is flown and who reads it.
    #[arg(value_enum)]
    load: Load,
    /// How long is measured; a minute before that, in which everything settles, is not.
    #[arg(long)]
    minutes: Option<f64>,
    /// How many read the event stream.
    #[arg(long)]
    readers: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Load {
    /// `city`; each reader sees a part of it, once a second; the picture is asked for ten times a second.
    City,
    /// `crossing`; each reader sees every slot; one more opens the stream and never reads.
    Streams,
    /// `crossing`, and beside it 60,000 identities, each heard once, within ten seconds; nobody reads.
    Flood,
    /// `city`; a hundred addresses ask for trails of ten minutes without a pause, then one address with 16 connections.
    Trails,
}

/// How long everything settles before it is measured.
const SETTLE: Duration = Duration::from_secs(60);
/// A slot may be sent this much after its time, at the 99.9th percentile.
const LATE_S: f64 = 0.050;
/// The service may hold this much more at the end than in the middle.
const GROWTH: f64 = 1.05;

fn main() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let args = Args::parse();
    let (scenario, minutes, readers, polls) = match args.load {
        Load::City => ("city", 10.0, 20, 10),
        Load::Streams => ("crossing", 2.0, 1000, 0),
        Load::Flood => return flooded(),
        Load::Trails => return trails(),
    };
    let measured = Duration::try_from_secs_f64(60.0 * args.minutes.unwrap_or(minutes))?;
    let readers = args.readers.unwrap_or(readers);
    let mut stage = Stage::set(scenario, SETTLE + measured + Duration::from_secs(30))?;
    let [output, of_now] = stage.sinks().map(Output::listen);
    let (output, of_now) = (output?, of_now?);
    let address = stage.address();
    let stop = AtomicBool::new(false);
    let polled = AtomicU64::new(0);

    let figures = thread::scope(|scope| {
        let stop = &stop;
        let listening = scope.spawn(|| output.hear(stop));
        let listening_to_now = scope.spawn(|| of_now.hear(stop));
        let timer = scope.spawn(|| output::idle_timer(stop));
        let reading: Vec<_> = (0..readers)
            .map(|index| {
                let wish = wish(args.load, index, stage.radar());
                thread::Builder::new()
                    .stack_size(256 * 1024)
                    .spawn_scoped(scope, move || readers::read(address, &wish, stop))
            })
            .collect::<Result<_, _>>()?;
        if args.load == Load::Streams {
            scope.spawn(|| readers::open_and_never_read(address, stop));
        }
        if polls > 0 {
            let polled = &polled;
            scope.spawn(move || poll(address, polls, polled, stop));
        }

        thread::sleep(SETTLE);
        let before = stage.metrics();
        let sampled = before.and_then(|before| Ok((stage.samples(measured)?, [before, stage.metrics()?])));
        stop.store(true, Ordering::Relaxed);
        let (samples, metrics) = sampled?;
        let (first, middle, last) = (samples[0], samples[samples.len() / 2], samples[samples.len() - 1]);

        let read: Vec<Read> = reading.into_iter().map(|reader| reader.join().expect("no panic")).collect();
        let [slots, of_now, timer] =
            [listening, listening_to_now, timer].map(|heard| heard.join().expect("no panic"));
        fs::create_dir_all("target")?;
        minutes::report(scenario, &samples, &slots, &of_now)?;
        let quantiles = |lateness: &Lateness| Quantiles::of(lateness.between(first.at, last.at));
        Ok::<_, Box<dyn Error + Send + Sync>>(Figures {
            measured,
            lateness: quantiles(&slots),
            now: quantiles(&of_now),
            timer: quantiles(&timer),
            read,
            whole: args.load == Load::Streams,
            polled: polled.load(Ordering::Relaxed),
            use_s: [first, middle, last].map(|sample| sample.used),
            most_memory: stage.most_memory()?,
            metrics,
        })
    })?;
    let flown = stage.end_flights()?;
    let stopped_s = stage.end()?;
    println!("{figures}");
    println!("flights flown to their end        {flown}");
    fs::write(format!("target/load-{scenario}.json"), format!("{:#}\n", figures.to_json()))?;
    println!("stopped after SIGTERM within      {stopped_s:.2} s");
    let missed = figures.missed(LATE_S, GROWTH);
    for miss in &missed {
        println!("MISSED: {miss}");
    }
    Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The flood.
fn flooded() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let mut stage = Stage::set("crossing", flood::FLIGHT)?;
    let [sink, _] = stage.sinks();
    let output = Output::listen(sink)?;
    let stop = AtomicBool::new(false);
    let (sent, lateness, most_memory, metrics) = thread::scope(|scope| {
        let listening = scope.spawn(|| output.hear(&stop));
        let flown = flood::flood(&stage);
        let told = stage.metrics();
        let most_memory = stage.most_memory();
        stop.store(true, Ordering::Relaxed);
        let lateness = listening.join().expect("no panic");
        let (sent, begin, end) = flown?;
        let lateness = Quantiles::of(lateness.between(begin, end));
        Ok::<_, Box<dyn Error + Send + Sync>>((sent, lateness, most_memory?, told?))
    })?;
    stage.end()?;
    let figures = flood::Figures::of(sent, lateness, most_memory, metrics, &stage.recordings())?;
    println!("{figures}");
    let missed = figures.missed();
    for miss in &missed {
        println!("MISSED: {miss}");
    }
    Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The longest trails.
fn trails() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let mut stage = Stage::set("city", trails::FLIGHT)?;
    let [sink, _] = stage.sinks();
    let figures = trails::ask(&stage, &Output::listen(sink)?)?;
    stage.end()?;
    println!("{figures}");
    let missed = figures.missed();
    for miss in &missed {
        println!("MISSED: {miss}");
    }
    Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What a reader asks for: every slot, or its own part of the city once a second.
fn wish(load: Load, index: usize, (latitude_deg, longitude_deg): (f64, f64)) -> Wish {
    let from = Ipv4Addr::new(127, 0, 1 + (index / 200) as u8, 1 + (index % 200) as u8);
    match load {
        Load::Streams | Load::Flood | Load::Trails => Wish { from, query: String::new() },
        Load::City => {
            // Boxes of about 1.8 km by 2.3 km: five columns, four rows.
            let (column, row) = ((index % 5) as f64, (index / 5 % 4) as f64);
            let (height_deg, width_deg) =
                (9.0 / 4.0 / 111.2, 9.0 / 5.0 / 111.2 / latitude_deg.to_radians().cos());
            let west = longitude_deg + (column - 2.5) * width_deg;
            let south = latitude_deg + (row - 2.0) * height_deg;
            let (east, north) = (west + width_deg, south + height_deg);
            Wish { from, query: format!("?interval_ms=1000&bbox={west:.6},{south:.6},{east:.6},{north:.6}") }
        }
    }
}

/// Asks for the whole picture so many times a second.
fn poll(address: SocketAddr, a_second: u32, polled: &AtomicU64, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let asked = std::time::Instant::now();
        if readers::get(address, "/api/v1/tracks").is_ok() {
            polled.fetch_add(1, Ordering::Relaxed);
        }
        thread::sleep((Duration::from_secs(1) / a_second).saturating_sub(asked.elapsed()));
    }
}
