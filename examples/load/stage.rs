//! Runs the simulator and the service as processes, and measures the service's resources.

use std::error::Error;
use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use utm_fusion::config::{Config, PictureKind, Record, Sink};
use utm_fusion::live::now;

use crate::flights::FlightSeries;
use crate::minutes::{EVERY, ResourceSample};
use crate::readers;

pub type LoadResult<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Maximum time until the service listens.
const READY: Duration = Duration::from_secs(20);
/// Maximum time until the service stops.
const STOP: Duration = Duration::from_secs(5);

/// A running site; its processes end on drop.
pub struct RunningSite {
    directory: PathBuf,
    config: Config,
    service: Child,
    flights: FlightSeries,
}

/// Resources of the service.
#[derive(Clone, Copy, Debug)]
pub struct ResourceUse {
    /// Resident memory, octets.
    pub resident: u64,
    /// Anonymous memory, octets: without the pages of the history's file.
    pub anonymous: u64,
    /// Processor time since its start, seconds.
    pub processor_s: f64,
    /// Time of the measurement.
    pub at: Instant,
}

impl RunningSite {
    /// Starts the service and sends it the scenario, for that long.
    pub fn set(scenario: &str, lasts: Duration) -> LoadResult<Self> {
        let directory = std::env::temp_dir().join(format!("utm-fusion-load-{}", std::process::id()));
        fs::create_dir_all(&directory)?;
        let path = format!("config/scenarios/{scenario}.toml");
        let text =
            fs::read(&path).map_err(|error| format!("{path}: {error}; run it in the project's folder"))?;
        let text = String::from_utf8(text)?;

        // A short flight provides the site's configuration.
        let short = directory.join("short.toml");
        fs::write(&short, lasting(&text, Duration::from_secs(20))?)?;
        let site = directory.join("site.toml");
        succeed(program("simulate")?.arg(&short).arg("--out").arg(&directory).stderr(Stdio::null()))?;
        let mut config = Config::load(&site)?;
        config.http.listen = TcpListener::bind("127.0.0.1:0")?.local_addr()?;
        config.state.dir = directory.join("state");
        config.output.status = true;
        let lagged = config.output.asterix[0];
        config.output.asterix.push(Sink { port: lagged.port + 1, picture: PictureKind::Now, ..lagged });
        config.output.record = Some(Record {
            dir: directory.join("recordings"),
            rotate_mib: 64,
            keep: 4,
            keep_mib: 0,
            keep_hours: 0,
        });
        fs::write(&site, config.to_string())?;

        let service = program("run")?.arg("--config").arg(&site).spawn()?;
        let flights = FlightSeries::of(&text, lasts, &directory)?;
        let stage = Self { directory, config, service, flights };
        let begun = Instant::now();
        while readers::get(stage.address(), "/healthz").is_err() {
            if begun.elapsed() > READY {
                return Err("the service does not answer".into());
            }
            thread::sleep(Duration::from_millis(100));
        }
        Ok(stage)
    }

    /// Configuration of the site.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Directory of the recordings.
    pub fn recordings(&self) -> PathBuf {
        self.directory.join("recordings")
    }

    /// A report of one of the drones' transponders.
    pub fn transponder_report(&self) -> LoadResult<Vec<u8>> {
        let octets = fs::read(self.directory.join("transponder.ast"))?;
        let length = usize::from(u16::from_be_bytes([octets[1], octets[2]]));
        Ok(octets[..length].to_vec())
    }

    /// Maximum resident memory of the service so far, octets.
    pub fn most_memory(&self) -> LoadResult<u64> {
        self.memory("VmHWM:")
    }

    fn memory(&self, key: &str) -> LoadResult<u64> {
        let process = Path::new("/proc").join(self.service.id().to_string());
        let status = String::from_utf8(fs::read(process.join("status"))?)?;
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        let kib = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
        Ok(kib.map(|kib| kib * 1024).ok_or_else(|| format!("{key} is not told"))?)
    }

    /// Address of its API.
    pub fn address(&self) -> SocketAddr {
        self.config.http.listen
    }

    /// Outputs of the published slots and of the current picture.
    pub fn sinks(&self) -> [Sink; 2] {
        [self.config.output.asterix[0], self.config.output.asterix[1]]
    }

    /// Latitude and longitude of the origin, degrees.
    pub fn radar(&self) -> (f64, f64) {
        let (latitude_deg, longitude_deg, _) = self.config.origin();
        (latitude_deg, longitude_deg)
    }

    /// The metrics page.
    pub fn metrics(&self) -> LoadResult<String> {
        Ok(readers::get(self.address(), "/metrics")?)
    }

    /// Resources that the service has used so far.
    pub fn service_use(&self) -> LoadResult<ResourceUse> {
        let process = Path::new("/proc").join(self.service.id().to_string());
        // Fields 14 and 15, after the name in brackets; in ticks of 10 ms.
        let stat = String::from_utf8(fs::read(process.join("stat"))?)?;
        let behind = stat.rsplit(')').next().unwrap_or_default();
        let ticks: u64 =
            behind.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
        Ok(ResourceUse {
            resident: self.memory("VmRSS:")?,
            anonymous: self.memory("RssAnon:")?,
            processor_s: ticks as f64 / 100.0,
            at: Instant::now(),
        })
    }

    /// Samples the resources for that long: at the beginning, each minute, and at the end. A run of less than two
    /// minutes is sampled in the middle.
    pub fn samples(&mut self, lasts: Duration) -> LoadResult<Vec<ResourceSample>> {
        let every = EVERY.min(lasts / 2);
        let (began, mut samples) = (Instant::now(), vec![self.sample()?]);
        while began.elapsed() < lasts {
            let next = began + every * u32::try_from(samples.len())?;
            thread::sleep(next.min(began + lasts).saturating_duration_since(Instant::now()));
            samples.push(self.sample()?);
            if self.flights.are_over() {
                let flown = self.flights.end()?;
                return Err(format!("nothing is sent any more, after {flown} flights").into());
            }
        }
        Ok(samples)
    }

    fn sample(&self) -> LoadResult<ResourceSample> {
        let open = fs::read_dir(Path::new("/proc").join(self.service.id().to_string()).join("fd"))?.count();
        let on_disk = octets(&self.recordings())? + octets(&self.config.state.dir)?;
        Ok(ResourceSample { at: now(), used: self.service_use()?, open, on_disk })
    }

    /// Ends the flights. Returns the number of flights that ended by themselves.
    pub fn end_flights(&mut self) -> LoadResult<u64> {
        self.flights.end()
    }

    /// Ends the service as an operator does. Returns the time that it took, seconds. Its files are kept until drop.
    pub fn end(&mut self) -> LoadResult<f64> {
        let started = Instant::now();
        succeed(Command::new("kill").arg("-TERM").arg(self.service.id().to_string()))?;
        while started.elapsed() < STOP {
            if let Some(status) = self.service.try_wait()? {
                let ended =
                    if status.success() { Ok(()) } else { Err(format!("the service ended with {status}")) };
                return Ok(ended.map(|()| started.elapsed().as_secs_f64())?);
            }
            thread::sleep(Duration::from_millis(10));
        }
        Err("the service does not stop".into())
    }
}

impl Drop for RunningSite {
    fn drop(&mut self) {
        let _ = self.flights.end();
        // The process may have ended by itself.
        let _ = self.service.kill();
        let _ = self.service.wait();
        let _ = fs::remove_dir_all(&self.directory);
    }
}

/// The scenario with another duration.
pub fn lasting(scenario: &str, lasts: Duration) -> LoadResult<String> {
    let mut table: toml::Table = scenario.parse()?;
    table.insert("duration_s".to_owned(), toml::Value::Integer(i64::try_from(lasts.as_secs())?));
    Ok(table.to_string())
}

/// The program that was built together with this one.
pub fn program(subcommand: &str) -> LoadResult<Command> {
    let here = std::env::current_exe()?;
    let profile = here.parent().and_then(Path::parent).ok_or("this program is in no folder")?;
    let program = profile.join("utm-fusion");
    if !program.exists() {
        return Err(format!("{} is not there; `cargo build --release` makes it", program.display()).into());
    }
    let mut command = Command::new(program);
    command.arg(subcommand).env("RUST_LOG", "warn").stdin(Stdio::null());
    Ok(command)
}

fn succeed(command: &mut Command) -> LoadResult<()> {
    let status = command.status()?;
    if status.success() { Ok(()) } else { Err(format!("{command:?}: {status}").into()) }
}

/// Total size of the files in a folder; 0 if it does not exist. Files may disappear meanwhile.
fn octets(folder: &Path) -> LoadResult<u64> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(0) };
    let lengths = entries.map(|entry| Ok(entry?.metadata().map_or(0, |file| file.len())));
    lengths.sum()
}
