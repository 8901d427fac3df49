//! Pacing of a replay: real time, or a multiple of it.

use std::time::{Duration, Instant};

use super::moment::ReplaySpeed;
use fusion::time::Time;

/// Pacing of pictures by their times.
pub struct Pace {
    speed: ReplaySpeed,
    /// Time of the first picture, and the instant at which it is shown.
    start: Option<(Time, Instant)>,
    /// Due time of the last picture. The next one is not due earlier.
    last: Option<Instant>,
}

impl Pace {
    /// Paces at `speed`; [`ReplaySpeed::Max`] never waits.
    pub fn new(speed: ReplaySpeed) -> Self {
        Self { speed, start: None, last: None }
    }

    /// Time until a picture of `time` is due.
    #[expect(clippy::disallowed_methods, reason = "pacing is what a speed asks for")]
    pub fn due_in(&mut self, time: Time) -> Duration {
        let ReplaySpeed::Times(times) = self.speed else { return Duration::ZERO };
        let now = Instant::now();
        let earliest = self.last.map_or(now, |last| now.max(last));
        let (first, shown) = *self.start.get_or_insert((time, earliest));
        let due = shown + Duration::from_secs_f64(time.seconds_since(first).max(0.0) / times);
        self.last = Some(due);
        due.saturating_duration_since(now)
    }

    /// Waits until a picture of `time` is due.
    #[expect(clippy::disallowed_methods, reason = "pacing is what a speed asks for")]
    pub fn wait_for(&mut self, time: Time) {
        std::thread::sleep(self.due_in(time));
    }

    /// Restarts the flight, one slot after its last picture.
    pub fn restart(&mut self, slot: Duration) {
        self.start = None;
        if let ReplaySpeed::Times(times) = self.speed {
            self.last = self.last.map(|last| last + slot.div_f64(times));
        }
    }
}
