//! Successive flights, each simulated and sent by a separate process.

use std::fs;
use std::path::Path;
use std::process::Child;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::stage::{LoadResult, lasting, program};

/// Maximum duration of a flight. A flight is held in memory as a whole, and a long one leaves fewer free paths for
/// drones.
const LONGEST: Duration = Duration::from_secs(300);
/// Maximum number of successive seeds for which the drones find no free paths.
const SEEDS: u64 = 10;
/// Interval at which the end of a flight is checked.
const LOOK: Duration = Duration::from_millis(100);

/// A series of flights, which ends on drop.
pub struct FlightSeries {
    stop: Arc<AtomicBool>,
    sending: Option<JoinHandle<LoadResult<u64>>>,
}

impl FlightSeries {
    /// Flies the scenario for this total time. The next flight begins once it is simulated, some seconds after the
    /// previous one.
    pub fn of(scenario: &str, lasts: Duration, directory: &Path) -> LoadResult<Self> {
        let path = directory.join("flight.toml");
        fs::write(&path, lasting(scenario, lasts.min(LONGEST))?)?;
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let end = Instant::now() + lasts;
        let sending = thread::spawn(move || fly(&path, end, &stopping));
        Ok(Self { stop, sending: Some(sending) })
    }

    /// Whether there are no more flights; [`FlightSeries::end`] then returns the reason.
    pub fn are_over(&self) -> bool {
        self.sending.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends the current flight. Returns the number of flights that ended by themselves.
    pub fn end(&mut self) -> LoadResult<u64> {
        self.stop.store(true, Ordering::Relaxed);
        self.sending.take().map_or(Ok(0), |sending| sending.join().expect("no panic"))
    }
}

impl Drop for FlightSeries {
    fn drop(&mut self) {
        // Errors were already reported to the caller of `end`, or a worse one occurred.
        let _ = self.end();
    }
}

fn fly(scenario: &Path, end: Instant, stop: &AtomicBool) -> LoadResult<u64> {
    let (mut flown, mut failed) = (0, 0);
    for seed in 1.. {
        if stop.load(Ordering::Relaxed) || Instant::now() >= end {
            break;
        }
        let mut simulator = program("simulate")?;
        let child = simulator.arg(scenario).arg("--udp").args(["--seed", &seed.to_string()]).spawn()?;
        match until_ended(child, stop)? {
            Some(true) => (flown, failed) = (flown + 1, 0),
            Some(false) if failed + 1 < SEEDS => failed += 1,
            Some(false) => return Err(format!("no flight could be simulated, by {SEEDS} seeds").into()),
            None => break,
        }
    }
    Ok(flown)
}

/// Waits for the end. Returns whether it was successful; `None` if it was stopped.
fn until_ended(mut child: Child, stop: &AtomicBool) -> LoadResult<Option<bool>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status.success()));
        }
        if stop.load(Ordering::Relaxed) {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(LOOK);
    }
}
