//! Readers that request the longest trails as fast as possible: effect on slots and on the probe `/healthz`.

use std::fmt;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use fusion::time::Time;
use utm_fusion::live::now;

use crate::figures::DelayQuantiles;
use crate::output::{LatenessByTime, OutputListener};
use crate::readers;
use crate::stage::{LoadResult, RunningSite};

/// Settling time. `LASTS` is the duration of each part.
const SETTLES: Duration = Duration::from_secs(40);
const LASTS: Duration = Duration::from_secs(30);
/// Time after which the rate limit of an address has fully recovered.
const PAUSE: Duration = Duration::from_secs(10);
/// Duration of the flight.
pub const FLIGHT: Duration = Duration::from_secs(40 + 3 * 30 + 2 * 10 + 15);
/// Number of outstanding requests per connection.
const PIPELINED: usize = 16;
const REQUEST: &str = "GET /api/v1/tracks?trail_s=600 HTTP/1.1\r\nhost: localhost\r\n\r\n";
/// Pause between two probes.
const PROBE: Duration = Duration::from_millis(100);
/// Maximum additional lateness of slots compared with no readers, 99th percentile, seconds.
const LATER_S: f64 = 0.020;
/// Maximum response time of the probe, seconds.
const PROBE_S: f64 = 0.250;

/// The readers.
#[derive(Clone, Copy)]
enum TrailReaders {
    Nobody,
    /// A hundred addresses with one connection each.
    Addresses,
    /// One address with 16 connections.
    Connections,
}

impl TrailReaders {
    fn addresses(self) -> Vec<Ipv4Addr> {
        match self {
            Self::Nobody => Vec::new(),
            Self::Addresses => (1..=100).map(|host| Ipv4Addr::new(127, 0, 9, host)).collect(),
            Self::Connections => vec![Ipv4Addr::new(127, 0, 10, 1); 16],
        }
    }
}

/// Measurements of one part.
struct TrailPart {
    name: &'static str,
    between: [Time; 2],
    /// Response times of the probe, seconds.
    probes: DelayQuantiles,
    /// Total size of the responses, octets.
    octets: u64,
}

/// Measurements of all parts.
pub struct TrailFigures {
    parts: Vec<(TrailPart, DelayQuantiles)>,
}

/// Runs the requests of each part while the city is flown.
pub fn ask(stage: &RunningSite, output: &OutputListener) -> LoadResult<TrailFigures> {
    let address = stage.address();
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let listening = scope.spawn(|| output.hear(&stop));
        thread::sleep(SETTLES);
        let parts = [
            ("nobody", TrailReaders::Nobody),
            ("100 addresses", TrailReaders::Addresses),
            ("one address, 16 connections", TrailReaders::Connections),
        ]
        .map(|(name, readers)| {
            let part = measure(address, name, readers);
            thread::sleep(PAUSE);
            part
        });
        stop.store(true, Ordering::Relaxed);
        let lateness: LatenessByTime = listening.join().expect("no panic");
        let of = |part: TrailPart| {
            let [from, until] = part.between;
            (part, DelayQuantiles::of(lateness.between(from, until)))
        };
        Ok(TrailFigures { parts: parts.into_iter().map(|part| part.map(of)).collect::<LoadResult<_>>()? })
    })
}

fn measure(address: SocketAddr, name: &'static str, readers: TrailReaders) -> LoadResult<TrailPart> {
    let (stop, octets) = (AtomicBool::new(false), AtomicU64::new(0));
    thread::scope(|scope| {
        for from in readers.addresses() {
            let (stop, octets) = (&stop, &octets);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    // Reopen a connection that is closed.
                    _ = ask_on(address, from, stop, octets);
                    thread::sleep(PROBE);
                }
            });
        }
        let (begin, mut probes) = (now(), Vec::new());
        let measured = loop {
            let started = Instant::now();
            if let Err(error) = readers::get(address, "/healthz") {
                break Err(error);
            }
            probes.push(started.elapsed().as_secs_f64());
            if now().seconds_since(begin) >= LASTS.as_secs_f64() {
                break Ok(());
            }
            thread::sleep(PROBE);
        };
        stop.store(true, Ordering::Relaxed);
        measured?;
        let probes = DelayQuantiles::of(probes.into_iter());
        Ok(TrailPart { name, between: [begin, now()], probes, octets: octets.load(Ordering::Relaxed) })
    })
}

/// Sends requests until `stop`, or until the connection ends.
fn ask_on(address: SocketAddr, from: Ipv4Addr, stop: &AtomicBool, octets: &AtomicU64) -> std::io::Result<()> {
    let mut connection = readers::connect(address, from)?;
    connection.set_read_timeout(Some(Duration::from_secs(1)))?;
    connection.write_all(REQUEST.repeat(PIPELINED).as_bytes())?;
    let (mut buffer, mut answered) = (vec![0; 1 << 18], 0);
    while !stop.load(Ordering::Relaxed) {
        match connection.read(&mut buffer) {
            Ok(0) => break,
            Ok(length) => {
                octets.fetch_add(length as u64, Ordering::Relaxed);
                answered += buffer[..length].windows(9).filter(|octets| octets == b"HTTP/1.1 ").count();
                if answered >= PIPELINED / 2 {
                    connection.write_all(REQUEST.repeat(answered).as_bytes())?;
                    answered = 0;
                }
            }
            Err(error) if matches!(error.kind(), std::io::ErrorKind::WouldBlock) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

impl TrailFigures {
    /// Requirements that are missed.
    pub fn missed(&self) -> Vec<String> {
        let alone_s = self.parts[0].1.p99_s();
        let mut missed = Vec::new();
        for (part, slots) in &self.parts {
            if slots.p99_s() > alone_s + LATER_S {
                missed.push(format!("{}: slots are too late", part.name));
            }
            if slots.count() < 4 * LASTS.as_secs() as usize - 2 {
                missed.push(format!("{}: slots were not sent", part.name));
            }
            if part.probes.most_s() > PROBE_S {
                missed.push(format!("{}: the probe answers too late", part.name));
            }
        }
        missed
    }
}

impl fmt::Display for TrailFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "milliseconds                        median      p99    p99.9      max")?;
        for (part, slots) in &self.parts {
            writeln!(f, "{}: {:.0} MB of answers", part.name, part.octets as f64 * 1e-6)?;
            writeln!(f, "  slot at a member of the group   {slots}")?;
            writeln!(f, "  /healthz                        {}", part.probes)?;
        }
        Ok(())
    }
}
