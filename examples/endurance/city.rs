//! A busy site for hours of its own time: checks that nothing grows or slows down.

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
use utm_fusion::history::{HistoryLimits, HistoryPicture, HistoryStore, HistoryTrack};
use utm_fusion::live::{Driver, DriverEvent};
use utm_fusion::picture::MAX_ACCURACY_M;
use utm_fusion::simulate::simulate;

use crate::flights::{self, EndlessFlights, EnduranceResult};

/// Pictures per transaction of the history, as in the service.
const BATCH: usize = 5;
/// Maximum ratio of memory at the end to memory in the second quarter.
const GROWTH: f64 = 1.05;

#[derive(clap::Args)]
pub struct Args {
    /// Duration in the site's time, hours.
    #[arg(long, default_value_t = 24.0)]
    hours: f64,
    /// Scenario. A flight lasts five minutes; after a pause of one minute the next flight begins.
    #[arg(long, default_value = "config/scenarios/city.toml")]
    scenario: PathBuf,
    /// Directory for the table and its figure.
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

/// Measurements of one minute.
#[derive(Clone, Copy, Debug, Default)]
struct CityMinute {
    /// Time since the beginning, hours.
    at_h: f64,
    /// Anonymous memory of the process, MiB.
    memory_mib: f64,
    /// Size of the history's file, MiB. `history_h` is the time that it covers, hours.
    history_mib: f64,
    history_h: f64,
    /// Longest time for one slot, milliseconds: computation, encoding, conflict detection. Every five seconds it
    /// includes writing the history, which the service does in another thread.
    slot_ms: f64,
    /// Processor time, seconds.
    processor_s: f64,
    tracks: usize,
    numbers: usize,
}

/// Header of the table.
const HEAD: &str = "hour,memory_mib,history_mib,history_h,slot_ms,processor_s,tracks,numbers\n";

struct City {
    config: Config,
    driver: Driver,
    encoders: Encoders,
    watch: Option<ConflictWatch>,
    store: HistoryStore,
    waiting: Vec<HistoryPicture>,
    /// Latest slot. `second` is the latest second in the history.
    latest: Option<Time>,
    second: i64,
    slots: u64,
    missing: u64,
    octets: u64,
    tracks: usize,
}

/// Flies the scenario. Returns whether nothing was missing and nothing grew.
pub fn fly(args: &Args) -> EnduranceResult<bool> {
    let scenario = flights::scenario(&args.scenario)?;
    let (start, mut short) = (scenario.start_time(), scenario);
    short.duration_s = 1.0;
    let config = simulate(&short, 1, Some(start))?.config;
    fs::create_dir_all(&args.out)?;
    let file = args.out.join(format!("endurance-{}.redb", std::process::id()));
    let limits = HistoryLimits::of(&config.state).ok_or("no history is kept")?;
    let driver = Driver::new(&config, Masks::default(), start, config.sensors.len());
    let mut city = City {
        encoders: Encoders::new(&config),
        watch: ConflictWatch::of(&config),
        store: HistoryStore::open(&file, limits)?,
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
    fn minutes(&mut self, args: &Args, start: Time, minutes: &mut Vec<CityMinute>) -> EnduranceResult<()> {
        let end = start + SignedDuration::from_secs_f64(3600.0 * args.hours);
        let mut flights = EndlessFlights::new(&args.scenario)?;
        let mut next = start + SignedDuration::from_mins(1);
        let mut slowest_s: f64 = 0.0;
        loop {
            let received = flights.next()?;
            // Slots are computed when they are due, even if nothing arrives.
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

    fn hand_out(&mut self) -> EnduranceResult<()> {
        while let Some(made) = self.driver.poll() {
            let DriverEvent::Slot(frame) = made else { continue };
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
                let tracks = tracks.map(|track| HistoryTrack::of(track, self.driver.maker())).collect();
                self.waiting.push(HistoryPicture { time: picture.time, tracks });
            }
            if self.waiting.len() == BATCH {
                self.store.keep(&self.waiting)?;
                self.waiting.clear();
            }
        }
        Ok(())
    }

    fn minute(&self, at_h: f64, slowest_s: f64) -> EnduranceResult<CityMinute> {
        let span = self.store.span()?.map_or(0.0, |(from, to)| (to - from).as_secs_f64());
        Ok(CityMinute {
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

/// Anonymous memory of the process, without pages of files (`RssAnon` in proc_pid_status(5)), MiB.
fn anonymous_mib() -> EnduranceResult<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).ok_or("RssAnon is not told")?;
    Ok(line.trim().trim_end_matches("kB").trim().parse::<f64>()? / 1024.0)
}

/// Processor time, seconds, from ticks of 10 ms (proc_pid_stat(5)).
fn processor_s() -> EnduranceResult<f64> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let (_, fields) = stat.rsplit_once(')').ok_or("no name in stat")?;
    let ticks = fields.split_whitespace().skip(11).take(2).map(str::parse::<u64>);
    Ok(ticks.sum::<Result<u64, _>>()? as f64 * 0.01)
}

/// Writes the table and its figure.
fn report(minutes: &[CityMinute], out: &Path) -> EnduranceResult<()> {
    let mut table = HEAD.to_owned();
    for minute in minutes {
        let CityMinute { at_h, memory_mib, history_mib, history_h, slot_ms, processor_s, tracks, numbers } =
            minute;
        table += &format!(
            "{at_h:.3},{memory_mib:.1},{history_mib:.1},{history_h:.2},{slot_ms:.2},{processor_s:.1},{tracks},{numbers}\n"
        );
    }
    fs::write(out.join("endurance-city.csv"), table)?;
    let panel = |label, of: fn(&CityMinute) -> f64| {
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
