//! Readers who ask for the longest trails as fast as they get them: what that costs slots and the probe `/healthz`.

use std::error::Error;
use std::fmt;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use fusion::time::Time;
use utm_fusion::live::now;

use crate::figures::Quantiles;
use crate::output::{Lateness, Output};
use crate::readers;
use crate::stage::Stage;

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// How long everything settles, and how long each part is measured.
const SETTLES: Duration = Duration::from_secs(40);
const LASTS: Duration = Duration::from_secs(30);
/// An address has all its requests back within this time.
const PAUSE: Duration = Duration::from_secs(10);
/// How long the city has to be flown over.
pub const FLIGHT: Duration = Duration::from_secs(40 + 3 * 30 + 2 * 10 + 15);
/// Requests of a connection that are not answered yet.
const PIPELINED: usize = 16;
const REQUEST: &str = "GET /api/v1/tracks?trail_s=600 HTTP/1.1\r\nhost: localhost\r\n\r\n";
/// Pause between two looks at the probe.
const PROBE: Duration = Duration::from_millis(100);
/// In 99 of 100 slots a slot may be sent this much later than without readers, seconds.
const LATER_S: f64 = 0.020;
/// The probe answers within this time, seconds.
const PROBE_S: f64 = 0.250;

/// The readers.
#[derive(Clone, Copy)]
enum Askers {
    Nobody,
    /// A hundred addresses, a connection each.
    Addresses,
    /// One address with 16 connections.
    Connections,
}

impl Askers {
    fn addresses(self) -> Vec<Ipv4Addr> {
        match self {
            Self::Nobody => Vec::new(),
            Self::Addresses => (1..=100).map(|host| Ipv4Addr::new(127, 0, 9, host)).collect(),
            Self::Connections => vec![Ipv4Addr::new(127, 0, 10, 1); 16],
        }
    }
}

/// The figures of one part.
struct Part {
    name: &'static str,
    between: [Time; 2],
    /// Seconds until the probe answered.
    probes: Quantiles,
    /// Octets of answers.
    octets: u64,
}

/// The figures of all parts.
pub struct Figures {
    parts: Vec<(Part, Quantiles)>,
}

/// Lets the city be flown over, and readers ask.
pub fn ask(stage: &Stage, output: &Output) -> Result<Figures> {
    let address = stage.address();
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let listening = scope.spawn(|| output.hear(&stop));
        thread::sleep(SETTLES);
        let parts = [
            ("nobody", Askers::Nobody),
            ("100 addresses", Askers::Addresses),
            ("one address, 16 connections", Askers::Connections),
        ]
        .map(|(name, askers)| {
            let part = measure(address, name, askers);
            thread::sleep(PAUSE);
            part
        });
        stop.store(true, Ordering::Relaxed);
        let lateness: Lateness = listening.join().expect("no panic");
        let of = |part: Part| {
            let [from, until] = part.between;
            (part, Quantiles::of(lateness.between(from, until)))
        };
        Ok(Figures { parts: parts.into_iter().map(|part| part.map(of)).collect::<Result<_>>()? })
    })
}

fn measure(address: SocketAddr, name: &'static str, askers: Askers) -> Result<Part> {
    let (stop, octets) = (AtomicBool::new(false), AtomicU64::new(0));
    thread::scope(|scope| {
        for from in askers.addresses() {
            let (stop, octets) = (&stop, &octets);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    // A connection that is closed is opened again.
                    _ = ask_on(address, from, stop, octets);
                    thread::sleep(PROBE);
                }
            });
        }
        let (begin, mut probes) = (now(), Vec::new());
        let measured = loop {
            let asked = Instant::now();
            if let Err(error) = readers::get(address, "/healthz") {
                break Err(error);
            }
            probes.push(asked.elapsed().as_secs_f64());
            if now().seconds_since(begin) >= LASTS.as_secs_f64() {
                break Ok(());
            }
            thread::sleep(PROBE);
        };
        stop.store(true, Ordering::Relaxed);
        measured?;
        let probes = Quantiles::of(probes.into_iter());
        Ok(Part { name, between: [begin, now()], probes, octets: octets.load(Ordering::Relaxed) })
    })
}

/// Asks until it is to stop, or the connection ends.
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

impl Figures {
    /// The figures that are missed.
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

impl fmt::Display for Figures {
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
