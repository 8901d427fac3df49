//! What fails, when, and for how long: drawn from a seed.

use std::fmt;

use jiff::SignedDuration;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Faults begin within this of a flight, seconds,
const BEGIN_S: (f64, f64) = (8.0, 55.0);
/// and last so long.
const LAST_S: (f64, f64) = (0.1, 9.0);
/// Everything is well from here on, seconds.
pub const WELL_S: f64 = BEGIN_S.1 + LAST_S.1;

/// What fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// This share of the datagrams is lost.
    Lost(f64),
    /// Each datagram comes later, by up to so many seconds, and so in another order.
    Late(f64),
    /// Each datagram comes twice.
    Twice,
    /// This share of the datagrams is cut, or has an octet that is another one.
    Torn(f64),
    /// So many datagrams of noise a second come besides.
    Noise(f64),
    /// The clock is wrong by so many seconds, and is set right at the end.
    Clock(f64),
    /// The program stands still.
    Pause,
    /// What the engine goes on from is gone from the disk, and cannot be written.
    Disk,
    /// The program is stopped in order, and started again at the end.
    Stop,
    /// It is killed, and started again at the end; the end of its file may be damaged.
    Kill { damaged: bool },
}

/// A fault and its time, seconds from the beginning of the flight.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// What.
    pub kind: Kind,
    /// From then on,
    pub from_s: f64,
    /// until then.
    pub until_s: f64,
}

impl Fault {
    /// Whether it holds at that time.
    pub fn holds(&self, at_s: f64) -> bool {
        self.from_s <= at_s && at_s < self.until_s
    }

    /// Whether the program does not run while it holds.
    pub fn is_down(&self) -> bool {
        matches!(self.kind, Kind::Stop | Kind::Kill { .. })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, from_s, until_s } = self;
        write!(f, "{from_s:5.2} to {until_s:5.2} s: {kind:?}")
    }
}

/// Three to eleven faults, in order of their beginnings.
pub fn draw(random: &mut ChaCha8Rng) -> Vec<Fault> {
    let count = random.random_range(3..=11);
    let mut faults: Vec<Fault> = (0..count)
        .map(|_| {
            let from_s = random.random_range(BEGIN_S.0..BEGIN_S.1);
            let until_s = from_s + random.random_range(LAST_S.0..LAST_S.1);
            let kind = match random.random_range(0..10) {
                0 => Kind::Lost(random.random_range(0.05..=1.0)),
                1 => Kind::Late(random.random_range(0.01..4.0)),
                2 => Kind::Twice,
                3 => Kind::Torn(random.random_range(0.05..=1.0)),
                4 => Kind::Noise(random.random_range(1.0..200.0)),
                5 => Kind::Clock(random.random_range(-15.0..15.0)),
                6 => Kind::Pause,
                7 => Kind::Disk,
                8 => Kind::Stop,
                _ => Kind::Kill { damaged: random.random_bool(0.5) },
            };
            Fault { kind, from_s, until_s }
        })
        .collect();
    faults.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    faults
}

/// Seconds as a duration.
pub fn seconds(seconds: f64) -> SignedDuration {
    SignedDuration::from_nanos((seconds * 1e9) as i64)
}
