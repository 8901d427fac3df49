//! Successive flights, simulated by a separate process. A simulated flight is held in memory as a whole, which must not
//! count as memory of the service.

use std::error::Error;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use asterix::{blocks, cat129, encode_block};
use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::simulate::{Scenario, simulate};

pub type EnduranceResult<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Duration of a flight, seconds.
const LASTS_S: i64 = 300;
/// Time between the beginnings of two flights.
const EVERY: SignedDuration = SignedDuration::from_secs(360);
/// Transponders of a flight with numbers above this one are received in that flight only.
const RETURNS: u32 = 200;

/// Writes a flight to the standard output.
#[derive(clap::Args)]
pub struct Args {
    scenario: PathBuf,
    number: u64,
}

/// A received datagram.
pub struct TimedDatagram {
    pub at: Time,
    pub line: usize,
    pub payload: Vec<u8>,
}

/// Loads the scenario, with the duration of flights used here.
pub fn scenario(path: &Path) -> EnduranceResult<Scenario> {
    let mut scenario = Scenario::load(path)?;
    scenario.duration_s = LASTS_S as f64;
    Ok(scenario)
}

/// Writes the flight. Each datagram has its time (8 octets), line (1), length (2, all little endian), and payload.
pub fn write(args: &Args) -> EnduranceResult<()> {
    let scenario = scenario(&args.scenario)?;
    let start = scenario.start_time() + SignedDuration::from_secs(EVERY.as_secs() * args.number as i64);
    // For some seeds the drones find no free paths.
    let mut flights =
        (0..10).map(|other| simulate(&scenario, args.number + 1 + 1_000_000 * other, Some(start)));
    let simulation = flights.find_map(Result::ok).ok_or("too crowded, by ten seeds")?;
    let ports: Vec<u16> = simulation.config.sensors.iter().map(|sensor| sensor.inputs[0].port).collect();
    let mut out = BufWriter::new(io::stdout().lock());
    for datagram in simulation.datagrams {
        let line = ports.iter().position(|port| *port == datagram.flow.port).unwrap_or(ports.len());
        let payload = renamed(&datagram.payload, args.number);
        out.write_all(&datagram.received.nanos().to_le_bytes())?;
        out.write_all(&[u8::try_from(line)?])?;
        out.write_all(&u16::try_from(payload.len())?.to_le_bytes())?;
        out.write_all(&payload)?;
    }
    Ok(out.flush()?)
}

/// Changes the datagram's serial number to one of this flight, unless the transponder returns in later flights.
fn renamed(payload: &[u8], flight: u64) -> Vec<u8> {
    if payload.first() != Some(&129) {
        return payload.to_vec();
    }
    let mut out = Vec::new();
    for block in blocks(payload).flatten() {
        let records = block.records::<cat129::Record>().flatten().map(|located| {
            let mut record = located.record;
            if let Some(serial) = &mut record.serial_number {
                let number = serial.iter().fold(0, |number, digit| 10 * number + u32::from(digit - b'0'));
                if number > RETURNS {
                    serial.copy_from_slice(format!("F{flight:04}-{number:06}").as_bytes());
                }
            }
            record
        });
        if encode_block(&records.collect::<Vec<_>>(), &mut out).is_err() {
            return payload.to_vec();
        }
    }
    out
}

/// An endless series of flights. While one is read, the next one is simulated.
pub struct EndlessFlights {
    scenario: PathBuf,
    next: u64,
    reading: BufReader<std::process::ChildStdout>,
    /// The process that is read, and the one after it.
    made: [Child; 2],
}

impl EndlessFlights {
    pub fn new(scenario: &Path) -> EnduranceResult<Self> {
        let mut first = making(scenario, 0)?;
        let reading = BufReader::new(first.stdout.take().ok_or("no pipe")?);
        let made = [first, making(scenario, 1)?];
        Ok(Self { scenario: scenario.to_owned(), next: 2, reading, made })
    }

    /// Returns the next datagram.
    pub fn next(&mut self) -> EnduranceResult<TimedDatagram> {
        loop {
            let mut head = [0; 11];
            match self.reading.read_exact(&mut head) {
                Ok(()) => {
                    let [at @ .., line, low, high] = head;
                    let mut payload = vec![0; usize::from(u16::from_le_bytes([low, high]))];
                    self.reading.read_exact(&mut payload)?;
                    return Ok(TimedDatagram {
                        at: Time::from_nanos(i64::from_le_bytes(at)),
                        line: line.into(),
                        payload,
                    });
                }
                Err(error) if error.kind() == ErrorKind::UnexpectedEof => self.turn()?,
                Err(error) => return Err(error.into()),
            }
        }
    }

    fn turn(&mut self) -> EnduranceResult<()> {
        let after = making(&self.scenario, self.next)?;
        self.next += 1;
        self.made.swap(0, 1);
        let mut ended = std::mem::replace(&mut self.made[1], after);
        if !ended.wait()?.success() {
            return Err("a flight could not be made".into());
        }
        self.reading = BufReader::new(self.made[0].stdout.take().ok_or("no pipe")?);
        Ok(())
    }
}

impl Drop for EndlessFlights {
    fn drop(&mut self) {
        for child in &mut self.made {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn making(scenario: &Path, number: u64) -> io::Result<Child> {
    let program = std::env::current_exe()?;
    Command::new(program).arg("flight").arg(scenario).arg(number.to_string()).stdout(Stdio::piped()).spawn()
}
