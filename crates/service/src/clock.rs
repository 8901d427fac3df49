//! The clock of the service.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use jiff::SignedDuration;

use fusion::time::Time;

/// Present time of the wall clock, the only clock of the service.
#[expect(clippy::disallowed_methods, reason = "the live service is told the time by this clock")]
pub fn now() -> Time {
    Time::from_nanos(i64::try_from(jiff::Timestamp::now().as_nanosecond()).unwrap_or(i64::MAX))
}

/// The wall clock as the service's threads read it. Tests step it, as an operator or a time server would.
#[derive(Clone, Debug, Default)]
pub struct WallClock(Arc<AtomicI64>);

impl WallClock {
    /// Present time.
    pub fn now(&self) -> Time {
        now() + SignedDuration::from_nanos(self.0.load(Ordering::Relaxed))
    }

    /// Steps the clock, for all its clones.
    pub fn step(&self, by: SignedDuration) {
        let by_ns = i64::try_from(by.as_nanos()).unwrap_or(i64::MAX);
        self.0.fetch_add(by_ns, Ordering::Relaxed);
    }
}
