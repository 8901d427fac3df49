//! The simulator and the service as processes, and what the service takes of the machine.

use std::error::Error;
use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use utm_fusion::config::{Config, PictureKind, Record, Sink};
use utm_fusion::live::now;

use crate::flights::Flights;
use crate::minutes::{EVERY, Sample};
use crate::readers;

pub type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// The service listens within this time.
const READY: Duration = Duration::from_secs(20);
/// And stops within this.
const STOP: Duration = Duration::from_secs(5);

/// A site that is flown over; its processes end with it.
pub struct Stage {
    directory: PathBuf,
    config: Config,
    service: Child,
    flights: Flights,
}

/// What the service has taken of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// Resident memory, octets.
    pub resident: u64,
    /// Of its memory, what it holds for itself: without the pages of the history's file.
    pub anonymous: u64,
    /// Time on a processor since its start, seconds.
    pub processor_s: f64,
    /// When that was.
    pub at: Instant,
}

impl Stage {
    /// Starts the service and sends it the scenario, for that long.
    pub fn set(scenario: &str, lasts: Duration) -> Result<Self> {
        let directory = std::env::temp_dir().join(format!("utm-fusion-load-{}", std::process::id()));
        fs::create_dir_all(&directory)?;
        let path = format!("config/scenarios/{scenario}.toml");
        let text =
            fs::read(&path).map_err(|error| format!("{path}: {error}; run it in the project's folder"))?;
        let text = String::from_utf8(text)?;

        // A short flight tells the site.
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
        let flights = Flights::of(&text, lasts, &directory)?;
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

    /// The site.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Where the recordings are.
    pub fn recordings(&self) -> PathBuf {
        self.directory.join("recordings")
    }

    /// A report of one of the drones' transponders.
    pub fn transponder_report(&self) -> Result<Vec<u8>> {
        let octets = fs::read(self.directory.join("transponder.ast"))?;
        let length = usize::from(u16::from_be_bytes([octets[1], octets[2]]));
        Ok(octets[..length].to_vec())
    }

    /// The most that the service has held of the machine's memory, octets.
    pub fn most_memory(&self) -> Result<u64> {
        self.memory("VmHWM:")
    }

    fn memory(&self, key: &str) -> Result<u64> {
        let process = Path::new("/proc").join(self.service.id().to_string());
        let status = String::from_utf8(fs::read(process.join("status"))?)?;
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        let kib = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
        Ok(kib.map(|kib| kib * 1024).ok_or_else(|| format!("{key} is not told"))?)
    }

    /// Where its API is.
    pub fn address(&self) -> SocketAddr {
        self.config.http.listen
    }

    /// Where the slots go that are published, and where the picture of each deadline.
    pub fn sinks(&self) -> [Sink; 2] {
        [self.config.output.asterix[0], self.config.output.asterix[1]]
    }

    /// Latitude and longitude of the origin, degrees.
    pub fn radar(&self) -> (f64, f64) {
        let (latitude_deg, longitude_deg, _) = self.config.origin();
        (latitude_deg, longitude_deg)
    }

    /// The metrics page.
    pub fn metrics(&self) -> Result<String> {
        Ok(readers::get(self.address(), "/metrics")?)
    }

    /// What the service has taken up to now.
    pub fn service_use(&self) -> Result<Use> {
        let process = Path::new("/proc").join(self.service.id().to_string());
        // Fields 14 and 15, counted behind the name in brackets; in ticks of 10 ms.
        let stat = String::from_utf8(fs::read(process.join("stat"))?)?;
        let behind = stat.rsplit(')').next().unwrap_or_default();
        let ticks: u64 =
            behind.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
        Ok(Use {
            resident: self.memory("VmRSS:")?,
            anonymous: self.memory("RssAnon:")?,
            processor_s: ticks as f64 / 100.0,
            at: Instant::now(),
        })
    }

    /// What it takes from now on, for that long: at the beginning, each minute, at the end; in less than two minutes in the middle.
    pub fn samples(&mut self, lasts: Duration) -> Result<Vec<Sample>> {
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

    fn sample(&self) -> Result<Sample> {
        let open = fs::read_dir(Path::new("/proc").join(self.service.id().to_string()).join("fd"))?.count();
        let on_disk = octets(&self.recordings())? + octets(&self.config.state.dir)?;
        Ok(Sample { at: now(), used: self.service_use()?, open, on_disk })
    }

    /// Ends the flights; how many were flown to their end.
    pub fn end_flights(&mut self) -> Result<u64> {
        self.flights.end()
    }

    /// Ends the service as an operator does; how long that took, seconds. Its files stay until this is dropped.
    pub fn end(&mut self) -> Result<f64> {
        let asked = Instant::now();
        succeed(Command::new("kill").arg("-TERM").arg(self.service.id().to_string()))?;
        while asked.elapsed() < STOP {
            if let Some(status) = self.service.try_wait()? {
                let ended =
                    if status.success() { Ok(()) } else { Err(format!("the service ended with {status}")) };
                return Ok(ended.map(|()| asked.elapsed().as_secs_f64())?);
            }
            thread::sleep(Duration::from_millis(10));
        }
        Err("the service does not stop".into())
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        let _ = self.flights.end();
        // It may have ended by itself.
        let _ = self.service.kill();
        let _ = self.service.wait();
        let _ = fs::remove_dir_all(&self.directory);
    }
}

/// The scenario with another duration.
pub fn lasting(scenario: &str, lasts: Duration) -> Result<String> {
    let mut table: toml::Table = scenario.parse()?;
    table.insert("duration_s".to_owned(), toml::Value::Integer(i64::try_from(lasts.as_secs())?));
    Ok(table.to_string())
}

/// The program that was built beside this one.
pub fn program(subcommand: &str) -> Result<Command> {
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

fn succeed(command: &mut Command) -> Result<()> {
    let status = command.status()?;
    if status.success() { Ok(()) } else { Err(format!("{command:?}: {status}").into()) }
}

/// Of the files in a folder, as long as they are there; of none where it is not.
fn octets(folder: &Path) -> Result<u64> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(0) };
    let lengths = entries.map(|entry| Ok(entry?.metadata().map_or(0, |file| file.len())));
    lengths.sum()
}
