//! A flood of invented identities beside ten drones: its cost for the service, and its effect on the drones.

use std::fmt;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Capture, Reception, ReceptionKind};
use utm_fusion::config::{Address, Config, SensorKind};
use utm_fusion::formats::{Cat129Encoder, pack};
use utm_fusion::live::now;
use utm_fusion::net::send::socket;
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::state::{NUMBERS, read_numbers_beside};

use crate::figures::DelayQuantiles;
use crate::invented::{invented, is_invented};
use crate::stage::{LoadResult, RunningSite};

/// Invented identities per second, each of which reports once. `LASTS` is the duration of the flood.
const A_SECOND: u64 = 6_000;
const LASTS: Duration = Duration::from_secs(10);
/// Duration of the flight before the flood. `AFTER` is the time after it, until its traces have expired.
const BEFORE: Duration = Duration::from_secs(30);
const AFTER: Duration = Duration::from_secs(40);
/// Maximum lateness of a slot, seconds.
const LATE_S: f64 = 1.0;
/// Maximum memory of the service at any time, octets.
const MEMORY: u64 = 200_000_000;

/// Duration of the drones' flight.
pub const FLIGHT: Duration = Duration::from_secs(30 + 10 + 40 + 15);

/// Measurements of a run.
pub struct FloodFigures {
    sent: u64,
    /// Lateness of slots at a member of the output's multicast group, from the beginning of the flood on.
    lateness: DelayQuantiles,
    most_memory: u64,
    metrics: String,
    /// Number of datagrams in the recording, of input and of output.
    recorded: (u64, u64),
    /// Number of datagrams sent. `is_the_same` states whether they equal those without the flood.
    output: u64,
    is_the_same: bool,
}

/// Waits, sends the flood, and waits. Returns the number of reports sent, and the beginning and end of the flood.
pub fn flood(stage: &RunningSite) -> LoadResult<(u64, Time, Time)> {
    thread::sleep(BEFORE);
    let input = stage
        .config()
        .sensors
        .iter()
        .find(|sensor| matches!(sensor.kind, SensorKind::Transponder(_)))
        .and_then(|sensor| sensor.inputs.first())
        .ok_or("no transponder receiver has an input")?;
    let Address::Multicast { group, interface } = input.address else {
        return Err("the input is no group".into());
    };
    let sender = socket(Some(interface), 1)?;
    let like = stage.transponder_report()?;
    let begin = now();
    let mut sent = 0;
    let send = |sender: &UdpSocket, number: u64| {
        sender.send_to(&invented(&like, number, now()), (group, input.port))
    };
    while now().seconds_since(begin) < LASTS.as_secs_f64() {
        let due = (now().seconds_since(begin) * A_SECOND as f64) as u64;
        while sent < due {
            send(&sender, sent)?;
            sent += 1;
        }
        thread::sleep(Duration::from_millis(2));
    }
    thread::sleep(AFTER);
    Ok((sent, begin, now()))
}

impl FloodFigures {
    /// Figures after the end of the service.
    pub fn of(
        sent: u64,
        lateness: DelayQuantiles,
        most_memory: u64,
        metrics: String,
        recordings: &Path,
    ) -> LoadResult<Self> {
        let input = only(recordings, "input-")?;
        let received = datagrams(&input)?;
        let output = datagrams(&only(recordings, "output-")?)?;
        let recorded = (received.len() as u64, output.len() as u64);
        let without = received.into_iter().filter(|(_, payload)| !is_invented(payload));
        let expected = replayed(&input, without)?;
        let is_the_same = expected.iter().eq(output.iter().map(|(_, payload)| payload));
        Ok(Self { sent, lateness, most_memory, metrics, recorded, output: output.len() as u64, is_the_same })
    }

    fn counted(&self, name: &str) -> u64 {
        let lines = self.metrics.lines().filter(|line| line.starts_with(name));
        lines.filter_map(|line| line.rsplit(' ').next()?.parse::<u64>().ok()).sum()
    }

    fn fate(&self, fate: &str) -> u64 {
        let is_it = |line: &&str| {
            line.starts_with("utm_fusion_new_identities_total") && line.contains(&format!("\"{fate}\""))
        };
        let lines = self.metrics.lines().filter(is_it);
        lines.filter_map(|line| line.rsplit(' ').next()?.parse::<u64>().ok()).sum()
    }

    /// Requirements that are missed.
    pub fn missed(&self) -> Vec<String> {
        let mut missed = Vec::new();
        let mut must = |holds: bool, miss: &str| {
            if !holds {
                missed.push(miss.to_owned());
            }
        };
        must(self.lateness.most_s() <= LATE_S, "slots were too late");
        must(
            self.lateness.count() as f64 >= 4.0 * (LASTS + AFTER).as_secs_f64() - 40.0,
            "slots were not sent",
        );
        must(self.most_memory <= MEMORY, "too much memory");
        must(self.is_the_same, "the drones' output is not what it is without the flood");
        must(self.counted("utm_fusion_line_kernel_dropped_total") == 0, "the kernel dropped datagrams");
        must(self.counted("utm_fusion_line_queue_full_total") == 0, "the queue was full");
        must(self.fate("heard") >= self.sent, "identities were not counted");
        let lost = self.counted("utm_fusion_recorder_lost_total")
            + self.counted("utm_fusion_recorder_unwritten_total");
        let received = self.counted("utm_fusion_line_received_total");
        must(self.recorded.0 + lost >= received, "the recorder lost datagrams that it did not count");
        missed
    }
}

impl fmt::Display for FloodFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "invented identities sent           {} in {} s", self.sent, LASTS.as_secs())?;
        writeln!(f, "milliseconds                        median      p99    p99.9      max")?;
        writeln!(f, "slot at a member of the group     {}", self.lateness)?;
        writeln!(f, "most memory                       {:.1} MB", self.most_memory as f64 * 1e-6)?;
        for fate in ["heard", "admitted", "heard_once", "inconsistent", "rate_limited", "crowded_out"] {
            writeln!(f, "identities {fate:22} {}", self.fate(fate))?;
        }
        writeln!(
            f,
            "transponder numbers in use        {}",
            self.counted("utm_fusion_transponder_numbers_used ")
        )?;
        writeln!(f, "recorded, in and out              {}, {}", self.recorded.0, self.recorded.1)?;
        for (what, name) in [
            ("datagrams received", "utm_fusion_line_received_total"),
            ("lost by the recorder", "utm_fusion_recorder_lost_total"),
            ("dropped by the kernel", "utm_fusion_line_kernel_dropped_total"),
            ("dropped by the queue", "utm_fusion_line_queue_full_total"),
        ] {
            writeln!(f, "{what:33} {}", self.counted(name))?;
        }
        let same = if self.is_the_same { "the same" } else { "NOT THE SAME" };
        write!(f, "{:33} {} datagrams, {same} as without the flood", "output", self.output)
    }
}

/// Output of the service for these datagrams, in a replay.
fn replayed(input: &Path, received: impl Iterator<Item = (Time, Vec<u8>)>) -> LoadResult<Vec<Vec<u8>>> {
    let name = input.to_string_lossy().replace(".pcap", "");
    let config = Config::load(Path::new(&format!("{name}.site.toml")))?;
    let mut pipeline = Pipeline::new(&config, Masks::default());
    for given in read_numbers_beside(input).map_err(|error| format!("{NUMBERS}: {error}"))? {
        pipeline.engine_mut().remember(given);
    }
    let maker = PictureMaker::new(&config, pipeline.normaliser());
    let encoder = Cat129Encoder::of(&config);
    let mut sent = Vec::new();
    for (received, payload) in received {
        let (received, kind) = (Some(received), ReceptionKind::Datagram);
        pipeline.receive(&Reception { received, input: 0, from: None, kind, origin: 0, payload });
        sent.extend(
            pipeline.emissions().flat_map(|emission| pack(&maker.picture(emission).tracks, &encoder)),
        );
    }
    pipeline.finish();
    sent.extend(pipeline.emissions().flat_map(|emission| pack(&maker.picture(emission).tracks, &encoder)));
    Ok(sent)
}

/// The only file of a series.
fn only(directory: &Path, series: &str) -> LoadResult<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.starts_with(series) && name.ends_with(".pcap") {
            found.push(path);
        }
    }
    found.pop().filter(|_| found.is_empty()).ok_or_else(|| format!("not one {series} file").into())
}

fn datagrams(path: &Path) -> LoadResult<Vec<(Time, Vec<u8>)>> {
    let mut datagrams = Vec::new();
    for datagram in Capture::open(path)? {
        let datagram = datagram?;
        datagrams.push((datagram.received.ok_or("a datagram without its time")?, datagram.payload));
    }
    Ok(datagrams)
}
