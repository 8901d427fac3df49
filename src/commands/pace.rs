//! Waiting, so that a recording is shown at the speed it happened, or a multiple of it.

use std::time::{Duration, Instant};

use super::moment::Speed;
use crate::time::Time;

/// Keeps to the pace of the flight.
pub struct Pace {
    speed: Speed,
    /// The first picture, and when it was shown.
    start: Option<(Time, Instant)>,
}

impl Pace {
    /// At a speed; [`Speed::Max`] never waits.
    pub fn new(speed: Speed) -> Self {
        Self { speed, start: None }
    }

    /// Waits until it is time for a picture of `time`.
    #[expect(clippy::disallowed_methods, reason = "pacing is what a speed asks for")]
    pub fn wait_for(&mut self, time: Time) {
        let Speed::Times(times) = self.speed else { return };
        let now = Instant::now();
        let (first, shown) = *self.start.get_or_insert((time, now));
        let due = shown + Duration::from_secs_f64(time.seconds_since(first).max(0.0) / times);
        std::thread::sleep(due.saturating_duration_since(now));
    }
}
