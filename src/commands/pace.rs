//! Waiting, so that a recording is shown at the speed it happened, or a multiple of it.

use std::time::{Duration, Instant};

use super::moment::Speed;
use fusion::time::Time;

/// Keeps to the pace of the flight.
pub struct Pace {
    speed: Speed,
    /// The first picture, and when it is shown.
    start: Option<(Time, Instant)>,
    /// When the last picture was due, and the next one is at the earliest.
    last: Option<Instant>,
}

impl Pace {
    /// At a speed; [`Speed::Max`] never waits.
    pub fn new(speed: Speed) -> Self {
        Self { speed, start: None, last: None }
    }

    /// How long it is until a picture of `time` is due.
    #[expect(clippy::disallowed_methods, reason = "pacing is what a speed asks for")]
    pub fn due_in(&mut self, time: Time) -> Duration {
        let Speed::Times(times) = self.speed else { return Duration::ZERO };
        let now = Instant::now();
        let earliest = self.last.map_or(now, |last| now.max(last));
        let (first, shown) = *self.start.get_or_insert((time, earliest));
        let due = shown + Duration::from_secs_f64(time.seconds_since(first).max(0.0) / times);
        self.last = Some(due);
        due.saturating_duration_since(now)
    }

    /// Waits until then.
    #[expect(clippy::disallowed_methods, reason = "pacing is what a speed asks for")]
    pub fn wait_for(&mut self, time: Time) {
        std::thread::sleep(self.due_in(time));
    }

    /// The flight begins anew, a slot after its last picture.
    pub fn begin_anew(&mut self, slot: Duration) {
        self.start = None;
        if let Speed::Times(times) = self.speed {
            self.last = self.last.map(|last| last + slot.div_f64(times));
        }
    }
}
