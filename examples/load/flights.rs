//! Flights one after the other, each simulated and sent by a process of its own.

use std::fs;
use std::path::Path;
use std::process::Child;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::stage::{Result, lasting, program};

/// A flight lasts no longer: it is held in memory as a whole, and the longer it is the less room drones find.
const LONGEST: Duration = Duration::from_secs(300);
/// By some seeds a crowd of drones finds no room; so many in turn are too many.
const SEEDS: u64 = 10;
/// How often it is looked whether a flight has ended.
const LOOK: Duration = Duration::from_millis(100);

/// Flights, until they are dropped.
pub struct Flights {
    stop: Arc<AtomicBool>,
    sending: Option<JoinHandle<Result<u64>>>,
}

impl Flights {
    /// Flies that scenario for so long altogether; the next flight begins once it is simulated, some seconds behind the one before.
    pub fn of(scenario: &str, lasts: Duration, directory: &Path) -> Result<Self> {
        let path = directory.join("flight.toml");
        fs::write(&path, lasting(scenario, lasts.min(LONGEST))?)?;
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let end = Instant::now() + lasts;
        let sending = thread::spawn(move || fly(&path, end, &stopping));
        Ok(Self { stop, sending: Some(sending) })
    }

    /// Whether there will be no more; then [`Flights::end`] says why.
    pub fn are_over(&self) -> bool {
        self.sending.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends the one that is under way; how many ended by themselves.
    pub fn end(&mut self) -> Result<u64> {
        self.stop.store(true, Ordering::Relaxed);
        self.sending.take().map_or(Ok(0), |sending| sending.join().expect("no panic"))
    }
}

impl Drop for Flights {
    fn drop(&mut self) {
        // What went wrong has been told by who asked, or something worse has.
        let _ = self.end();
    }
}

fn fly(scenario: &Path, end: Instant, stop: &AtomicBool) -> Result<u64> {
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

/// Whether it ended well; `None`: it was to stop.
fn until_ended(mut child: Child, stop: &AtomicBool) -> Result<Option<bool>> {
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
