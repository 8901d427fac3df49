//! Loads the live service like a busy site, and measures its output.
//!
//! ```sh
//! cargo build --release && cargo run --release --example load -- city       # ten minutes of 500 drones and 500 birds; --minutes 180
//! cargo build --release && cargo run --release --example load -- streams    # a thousand readers of the event stream
//! cargo build --release && cargo run --release --example load -- flood      # 6,000 invented identities a second
//! cargo build --release && cargo run --release --example load -- trails     # a hundred addresses that ask for the longest trails
//! ```
//!
//! The simulator and the service run as separate processes, with recorder and history. All traffic stays on this
//! machine's loopback interface, and the run ends by itself. The figures of `city` and `streams` are also written to
//! `target/load-<scenario>.json`, and figures for each minute to `.csv` and `.svg` beside it. The exit code is 1 if a
//! requirement is missed.

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

use crate::figures::{DelayQuantiles, LoadFigures};
use crate::output::{LatenessByTime, OutputListener};
use crate::readers::{ReaderRequest, ReaderResult};
use crate::stage::RunningSite;

/// Loads the live service and measures its output.
#[derive(Parser)]
struct Args {
    /// Scenario and readers.
    #[arg(value_enum)]
    load: Load,
    /// Duration of the measurement, minutes. It begins after one minute of settling.
    #[arg(long)]
    minutes: Option<f64>,
    /// Number of readers of the event stream.
    #[arg(long)]
    readers: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Load {
    /// `city`; each reader receives a part of it once per second; the picture is requested ten times per second.
    City,
    /// `crossing`; each reader receives every slot; one more opens the stream and never reads.
    Streams,
    /// `crossing`, and 60,000 invented identities within ten seconds, each of which reports once; no readers.
    Flood,
    /// `city`; a hundred addresses request trails of ten minutes without a pause, then one address with 16 connections.
    Trails,
}

/// Settling time before the measurement.
const SETTLE: Duration = Duration::from_secs(60);
/// Maximum lateness of a slot, 99.9th percentile, seconds.
const LATE_S: f64 = 0.050;
/// Maximum ratio of the service's memory at the end to that in the middle.
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
    let mut stage = RunningSite::set(scenario, SETTLE + measured + Duration::from_secs(30))?;
    let [output, of_now] = stage.sinks().map(OutputListener::listen);
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
                let request = request(args.load, index, stage.radar());
                thread::Builder::new()
                    .stack_size(256 * 1024)
                    .spawn_scoped(scope, move || readers::read(address, &request, stop))
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

        let read: Vec<ReaderResult> =
            reading.into_iter().map(|reader| reader.join().expect("no panic")).collect();
        let [slots, of_now, timer] =
            [listening, listening_to_now, timer].map(|heard| heard.join().expect("no panic"));
        fs::create_dir_all("target")?;
        minutes::report(scenario, &samples, &slots, &of_now)?;
        let quantiles = |lateness: &LatenessByTime| DelayQuantiles::of(lateness.between(first.at, last.at));
        Ok::<_, Box<dyn Error + Send + Sync>>(LoadFigures {
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

/// Runs the flood.
fn flooded() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let mut stage = RunningSite::set("crossing", flood::FLIGHT)?;
    let [sink, _] = stage.sinks();
    let output = OutputListener::listen(sink)?;
    let stop = AtomicBool::new(false);
    let (sent, lateness, most_memory, metrics) = thread::scope(|scope| {
        let listening = scope.spawn(|| output.hear(&stop));
        let flown = flood::flood(&stage);
        let metrics = stage.metrics();
        let most_memory = stage.most_memory();
        stop.store(true, Ordering::Relaxed);
        let lateness = listening.join().expect("no panic");
        let (sent, begin, end) = flown?;
        let lateness = DelayQuantiles::of(lateness.between(begin, end));
        Ok::<_, Box<dyn Error + Send + Sync>>((sent, lateness, most_memory?, metrics?))
    })?;
    stage.end()?;
    let figures = flood::FloodFigures::of(sent, lateness, most_memory, metrics, &stage.recordings())?;
    println!("{figures}");
    let missed = figures.missed();
    for miss in &missed {
        println!("MISSED: {miss}");
    }
    Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs the requests for the longest trails.
fn trails() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let mut stage = RunningSite::set("city", trails::FLIGHT)?;
    let [sink, _] = stage.sinks();
    let figures = trails::ask(&stage, &OutputListener::listen(sink)?)?;
    stage.end()?;
    println!("{figures}");
    let missed = figures.missed();
    for miss in &missed {
        println!("MISSED: {miss}");
    }
    Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Request of a reader: every slot, or its own part of the city once per second.
fn request(load: Load, index: usize, (latitude_deg, longitude_deg): (f64, f64)) -> ReaderRequest {
    let from = Ipv4Addr::new(127, 0, 1 + (index / 200) as u8, 1 + (index % 200) as u8);
    match load {
        Load::Streams | Load::Flood | Load::Trails => ReaderRequest { from, query: String::new() },
        Load::City => {
            // Boxes of about 1.8 km by 2.3 km: five columns, four rows.
            let (column, row) = ((index % 5) as f64, (index / 5 % 4) as f64);
            let (height_deg, width_deg) =
                (9.0 / 4.0 / 111.2, 9.0 / 5.0 / 111.2 / latitude_deg.to_radians().cos());
            let west = longitude_deg + (column - 2.5) * width_deg;
            let south = latitude_deg + (row - 2.0) * height_deg;
            let (east, north) = (west + width_deg, south + height_deg);
            ReaderRequest {
                from,
                query: format!("?interval_ms=1000&bbox={west:.6},{south:.6},{east:.6},{north:.6}"),
            }
        }
    }
}

/// Requests the whole picture `a_second` times per second.
fn poll(address: SocketAddr, a_second: u32, polled: &AtomicU64, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let started = std::time::Instant::now();
        if readers::get(address, "/api/v1/tracks").is_ok() {
            polled.fetch_add(1, Ordering::Relaxed);
        }
        thread::sleep((Duration::from_secs(1) / a_second).saturating_sub(started.elapsed()));
    }
}
