//! A busy site for hours of its own time: does anything grow, does anything get slower?

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fusion::time::{SECOND, Time};
use jiff::SignedDuration;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Feed};
use utm_fusion::conflicts::ConflictWatch;
use utm_fusion::evaluate::plot::curves::{Panel, panels};
use utm_fusion::formats::Encoders;
use utm_fusion::history::{Limits, SavedTrack, Snapshot, Store};
use utm_fusion::live::{Driver, Made};
use utm_fusion::picture::MAX_ACCURACY_M;
use utm_fusion::simulate::simulate;

use crate::flights::{self, Flights};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Pictures in a transaction of the history, as the service has it.
const BATCH: usize = 5;
/// At the end of a day no more memory is held than this times what it took in the second quarter of it.
const GROWTH: f64 = 1.05;

#[derive(clap::Args)]
pub struct Args {
    /// How long, in the site's own time.
    #[arg(long, default_value_t = 24.0)]
    hours: f64,
    /// Who flies: five minutes, a minute's pause, the next flight.
    #[arg(long, default_value = "config/scenarios/city.toml")]
    scenario: PathBuf,
    /// Where the table and its figure are written.
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

/// A minute.
#[derive(Clone, Copy, Debug, Default)]
struct Minute {
    /// Since the beginning, hours.
    at_h: f64,
    /// Memory that the process holds for itself, MiB.
    memory_mib: f64,
    /// The history's file, MiB, and how far back it goes, hours.
    history_mib: f64,
    history_h: f64,
    /// The longest that a slot took, milliseconds: made, encoded, looked at for conflicts; and, every five seconds, the history
    /// written, which the service leaves to a thread of its own.
    slot_ms: f64,
    /// Time on a processor, seconds.
    processor_s: f64,
    tracks: usize,
    numbers: usize,
}

/// A row of the table.
const HEAD: &str = "hour,memory_mib,history_mib,history_h,slot_ms,processor_s,tracks,numbers\n";

struct City {
    config: Config,
    driver: Driver,
    encoders: Encoders,
    watch: Option<ConflictWatch>,
    store: Store,
    waiting: Vec<Snapshot>,
    /// The latest slot, and the second that is kept.
    latest: Option<Time>,
    second: i64,
    slots: u64,
    missing: u64,
    octets: u64,
    tracks: usize,
}

/// Flies it; whether nothing was missing and nothing grew.
pub fn fly(args: &Args) -> Result<bool> {
    let scenario = flights::scenario(&args.scenario)?;
    let (start, mut short) = (scenario.start_time(), scenario);
    short.duration_s = 1.0;
    let config = simulate(&short, 1, Some(start))?.config;
    fs::create_dir_all(&args.out)?;
    let file = args.out.join(format!("endurance-{}.redb", std::process::id()));
    let limits = Limits::of(&config.state).ok_or("no history is kept")?;
    let driver = Driver::new(&config, Masks::default(), start, config.sensors.len());
    let mut city = City {
        encoders: Encoders::new(&config),
        watch: ConflictWatch::of(&config),
        store: Store::open(&file, limits)?,
        driver,
        config,
        waiting: Vec::new(),
        latest: None,
        second: i64::MIN,
        slots: 0,
        missing: 0,
        octets: 0,
        tracks: 0,
    };
    let (began, mut minutes) = (Instant::now(), Vec::new());
    let outcome = city.minutes(args, start, &mut minutes);
    let _ = fs::remove_file(&file);
    outcome?;
    let seconds = began.elapsed().as_secs_f64();
    let City { slots, missing, octets, .. } = city;
    println!("{:.1} h in {seconds:.0} s: {slots} slots, {missing} missing, {octets} octets sent", args.hours);
    report(&minutes, &args.out)?;
    let quarter = |of: usize| {
        let part = &minutes[of * minutes.len() / 4..(of + 1) * minutes.len() / 4];
        part.iter().map(|minute| minute.memory_mib).fold(0.0, f64::max)
    };
    let (before, after) = (quarter(1), quarter(3));
    println!("memory at most, second quarter {before:.1} MiB, last quarter {after:.1} MiB");
    Ok(missing == 0 && after <= GROWTH * before)
}

impl City {
    fn minutes(&mut self, args: &Args, start: Time, minutes: &mut Vec<Minute>) -> Result<()> {
        let end = start + SignedDuration::from_secs_f64(3600.0 * args.hours);
        let mut flights = Flights::new(&args.scenario)?;
        let mut next = start + SignedDuration::from_mins(1);
        let mut slowest_s: f64 = 0.0;
        loop {
            let received = flights.next()?;
            // Slots are made when they are due, whether anything comes or not.
            while let Some(made) = self.driver.next_made().filter(|made| *made < received.at) {
                let began = Instant::now();
                self.driver.tick(made);
                self.hand_out()?;
                slowest_s = slowest_s.max(began.elapsed().as_secs_f64());
            }
            while received.at >= next {
                let minute = self.minute((next - start).as_secs_f64() / 3600.0, slowest_s)?;
                if minutes.len() % 60 == 59 {
                    println!("{minute:.3?}");
                }
                minutes.push(minute);
                next = next + SignedDuration::from_mins(1);
                slowest_s = 0.0;
            }
            if received.at >= end {
                return Ok(());
            }
            self.driver.receive(&Reception {
                received: Some(self.driver.reception(received.at, received.at)),
                input: received.line,
                from: Some(([127, 0, 0, 1], 40_000).into()),
                kind: ReceptionKind::Datagram,
                origin: 0,
                payload: received.payload,
            });
            self.hand_out()?;
        }
    }

    fn hand_out(&mut self) -> Result<()> {
        while let Some(made) = self.driver.poll() {
            let Made::Slot(frame) = made else { continue };
            let picture = &frame.picture;
            let slot = self.config.fusion.slot;
            if self.latest.is_some_and(|latest| picture.time != latest + slot) {
                self.missing += 1;
            }
            self.latest = Some(picture.time);
            self.slots += 1;
            self.tracks = picture.tracks.len();
            let within = picture.within(self.config.output.max_accuracy_m);
            let sent = self.encoders.picture(Feed::RECORDED, picture.time, within);
            self.octets += sent.iter().map(|payload| payload.len() as u64).sum::<u64>();
            if let Some(watch) = &mut self.watch {
                let _ = frame.conflicts(watch, self.driver.maker());
            }
            let second = picture.time.nanos().div_euclid(SECOND);
            if std::mem::replace(&mut self.second, second) != second {
                let tracks = picture.within(MAX_ACCURACY_M);
                let tracks = tracks.map(|track| SavedTrack::of(track, self.driver.maker())).collect();
                self.waiting.push(Snapshot { time: picture.time, tracks });
            }
            if self.waiting.len() == BATCH {
                self.store.keep(&self.waiting)?;
                self.waiting.clear();
            }
        }
        Ok(())
    }

    fn minute(&self, at_h: f64, slowest_s: f64) -> Result<Minute> {
        let span = self.store.span()?.map_or(0.0, |(from, to)| (to - from).as_secs_f64());
        Ok(Minute {
            at_h,
            memory_mib: anonymous_mib()?,
            history_mib: self.store.octets()? as f64 / f64::from(1 << 20),
            history_h: span / 3600.0,
            slot_ms: 1000.0 * slowest_s,
            processor_s: processor_s()?,
            tracks: self.tracks,
            numbers: self.driver.pipeline().engine().numbers().given().count(),
        })
    }
}

/// Memory that is the process's own, without pages of files (`RssAnon` in proc_pid_status(5)), MiB.
fn anonymous_mib() -> Result<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).ok_or("RssAnon is not told")?;
    Ok(line.trim().trim_end_matches("kB").trim().parse::<f64>()? / 1024.0)
}

/// Time on a processor, in ticks of 10 ms (proc_pid_stat(5)), seconds.
fn processor_s() -> Result<f64> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let (_, fields) = stat.rsplit_once(')').ok_or("no name in stat")?;
    let ticks = fields.split_whitespace().skip(11).take(2).map(str::parse::<u64>);
    Ok(ticks.sum::<std::result::Result<u64, _>>()? as f64 * 0.01)
}

/// Writes the table, and a figure of it.
fn report(minutes: &[Minute], out: &Path) -> Result<()> {
    let mut table = HEAD.to_owned();
    for minute in minutes {
        let Minute { at_h, memory_mib, history_mib, history_h, slot_ms, processor_s, tracks, numbers } =
            minute;
        table += &format!(
            "{at_h:.3},{memory_mib:.1},{history_mib:.1},{history_h:.2},{slot_ms:.2},{processor_s:.1},{tracks},{numbers}\n"
        );
    }
    fs::write(out.join("endurance-city.csv"), table)?;
    let panel = |label, of: fn(&Minute) -> f64| {
        Panel::from_zero(label, minutes.iter().map(|minute| (minute.at_h, of(minute))).collect())
    };
    let figure = panels(
        "endurance-city",
        "A city, minute by minute",
        "Memory of the process, its history on the disk, the slowest slot of each minute, and transponders that have a number.",
        "Hours of the site",
        &[
            panel("Memory (MiB)", |minute| minute.memory_mib),
            panel("History (MiB)", |minute| minute.history_mib),
            panel("Slowest slot (ms)", |minute| minute.slot_ms),
            panel("Numbers in use", |minute| minute.numbers as f64),
        ],
    );
    fs::write(out.join("endurance-city.svg"), figure.svg)?;
    println!("{}, {}", out.join("endurance-city.csv").display(), out.join("endurance-city.svg").display());
    Ok(())
}
