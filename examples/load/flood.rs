//! A flood of invented identities beside ten drones: what it costs the service, and what it does to the drones.

use std::error::Error;
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

use crate::figures::Quantiles;
use crate::invented::{invented, is_invented};
use crate::stage::Stage;

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Invented identities a second, each heard once, and for how long.
const A_SECOND: u64 = 6_000;
const LASTS: Duration = Duration::from_secs(10);
/// The drones fly for this long before it; and after it, until what it left has gone.
const BEFORE: Duration = Duration::from_secs(30);
const AFTER: Duration = Duration::from_secs(40);
/// No slot may be sent later than this, seconds.
const LATE_S: f64 = 1.0;
/// The service may hold no more at any time, octets.
const MEMORY: u64 = 200_000_000;

/// How long the drones have to fly.
pub const FLIGHT: Duration = Duration::from_secs(30 + 10 + 40 + 15);

/// What was measured.
pub struct Figures {
    sent: u64,
    /// Of slots at a member of the output's group, from the flood's beginning on.
    lateness: Quantiles,
    most_memory: u64,
    metrics: String,
    /// Datagrams in the recording, of input and of output.
    recorded: (u64, u64),
    /// Datagrams that were sent, and whether they are those that come without the flood.
    output: u64,
    is_the_same: bool,
}

/// Lets the drones fly, and the flood come; when it began and ended.
pub fn flood(stage: &Stage) -> Result<(u64, Time, Time)> {
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

impl Figures {
    /// After the service has ended.
    pub fn of(
        sent: u64,
        lateness: Quantiles,
        most_memory: u64,
        metrics: String,
        recordings: &Path,
    ) -> Result<Self> {
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

    /// What is not as it has to be.
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

impl fmt::Display for Figures {
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

/// What the service sends of these, without its clock.
fn replayed(input: &Path, received: impl Iterator<Item = (Time, Vec<u8>)>) -> Result<Vec<Vec<u8>>> {
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

/// The one file of a series.
fn only(directory: &Path, series: &str) -> Result<PathBuf> {
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

fn datagrams(path: &Path) -> Result<Vec<(Time, Vec<u8>)>> {
    let mut datagrams = Vec::new();
    for datagram in Capture::open(path)? {
        let datagram = datagram?;
        datagrams.push((datagram.received.ok_or("a datagram without its time")?, datagram.payload));
    }
    Ok(datagrams)
}
