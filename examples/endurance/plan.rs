//! Schedules of faults, drawn from a seed.

use std::fmt;

use jiff::SignedDuration;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Range of the times at which faults begin, seconds from the beginning of the flight.
const BEGIN_S: (f64, f64) = (8.0, 55.0);
/// Range of the durations of faults, seconds.
const LAST_S: (f64, f64) = (0.1, 9.0);
/// Time from which there are no more faults, seconds.
pub const WELL_S: f64 = BEGIN_S.1 + LAST_S.1;

/// Kind of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// Loss of this share of the datagrams.
    Lost(f64),
    /// Additional delay of each datagram, by up to this many seconds, which also changes the order.
    Late(f64),
    /// Duplication of each datagram.
    Twice,
    /// Truncation of, or a wrong octet in, this share of the datagrams.
    Torn(f64),
    /// Additional random datagrams, per second.
    Noise(f64),
    /// Clock error, seconds; it is corrected at the end.
    Clock(f64),
    /// Suspension of the program.
    Pause,
    /// Loss of the engine's checkpoint; further checkpoints cannot be written.
    Disk,
    /// Orderly stop of the program; it starts again at the end.
    Stop,
    /// Kill of the program; it starts again at the end. The end of its checkpoint may be damaged.
    Kill { damaged: bool },
}

/// A fault and its time, in seconds from the beginning of the flight.
#[derive(Clone, Copy, Debug)]
pub struct PlannedFault {
    /// Kind of fault.
    pub kind: FaultKind,
    /// Beginning, seconds.
    pub from_s: f64,
    /// End, seconds.
    pub until_s: f64,
}

impl PlannedFault {
    /// Whether the fault is active at that time.
    pub fn holds(&self, at_s: f64) -> bool {
        self.from_s <= at_s && at_s < self.until_s
    }

    /// Whether the program does not run during the fault.
    pub fn is_down(&self) -> bool {
        matches!(self.kind, FaultKind::Stop | FaultKind::Kill { .. })
    }
}

impl fmt::Display for PlannedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, from_s, until_s } = self;
        write!(f, "{from_s:5.2} to {until_s:5.2} s: {kind:?}")
    }
}

/// Draws three to eleven faults, in order of their beginnings.
pub fn draw(random: &mut ChaCha8Rng) -> Vec<PlannedFault> {
    let count = random.random_range(3..=11);
    let mut faults: Vec<PlannedFault> = (0..count)
        .map(|_| {
            let from_s = random.random_range(BEGIN_S.0..BEGIN_S.1);
            let until_s = from_s + random.random_range(LAST_S.0..LAST_S.1);
            let kind = match random.random_range(0..10) {
                0 => FaultKind::Lost(random.random_range(0.05..=1.0)),
                1 => FaultKind::Late(random.random_range(0.01..4.0)),
                2 => FaultKind::Twice,
                3 => FaultKind::Torn(random.random_range(0.05..=1.0)),
                4 => FaultKind::Noise(random.random_range(1.0..200.0)),
                5 => FaultKind::Clock(random.random_range(-15.0..15.0)),
                6 => FaultKind::Pause,
                7 => FaultKind::Disk,
                8 => FaultKind::Stop,
                _ => FaultKind::Kill { damaged: random.random_bool(0.5) },
            };
            PlannedFault { kind, from_s, until_s }
        })
        .collect();
    faults.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    faults
}

/// Converts seconds to a duration.
pub fn seconds(seconds: f64) -> SignedDuration {
    SignedDuration::from_nanos((seconds * 1e9) as i64)
}
