//! How bad a conflict is, and for how long it stays so: a level comes by two evaluations and goes after seconds without.

use crate::time::{SECOND, Time};

/// Evaluations that are remembered, and of these how many have to agree.
const OF_THE_LAST: u32 = 4;
const TO_RAISE: u32 = 2;
/// A level lasts at least this long, nanoseconds.
const HELD_NS: i64 = 4 * SECOND;
/// And is over when nothing has kept it for this long, nanoseconds.
const LOWERED_NS: i64 = 5 * SECOND;

/// How bad a conflict is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// It may come to one.
    Advisory,
    /// It is likely to.
    Warning,
    /// A volume is entered.
    Violation,
}

crate::interface_names!(Level { Advisory = "advisory", Warning = "warning", Violation = "violation" });

/// What an evaluation says of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Say {
    /// It is reached.
    pub(super) reached: bool,
    /// It is not over yet.
    pub(super) kept: bool,
}

/// One level of one pair and volume.
#[derive(Clone, Copy, Debug, Default)]
struct Latch {
    /// Whether it was reached, the last evaluation in the lowest bit.
    reached: u8,
    /// Since when it holds.
    since: Option<Time>,
    /// When it was kept last.
    kept: Time,
}

impl Latch {
    fn note(&mut self, now: Time, say: Say) {
        self.reached = (self.reached << 1 | u8::from(say.reached)) & ((1 << OF_THE_LAST) - 1);
        if say.reached || say.kept {
            self.kept = now;
        }
        match self.since {
            None if self.reached.count_ones() >= TO_RAISE => self.since = Some(now),
            Some(since)
                if now.nanos() - since.nanos() >= HELD_NS
                    && now.nanos() - self.kept.nanos() >= LOWERED_NS =>
            {
                self.since = None;
            }
            _ => {}
        }
    }
}

/// The levels of one pair and volume.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Levels([Latch; Level::ALL.len()]);

impl Levels {
    /// Takes in an evaluation: what it says of each level.
    pub(super) fn note(&mut self, now: Time, said: [Say; Level::ALL.len()]) {
        for (latch, say) in self.0.iter_mut().zip(said) {
            latch.note(now, say);
        }
    }

    /// The worst that holds, and since when.
    pub(super) fn worst(&self) -> Option<(Level, Time)> {
        let holds = |(level, latch): (Level, &Latch)| Some((level, latch.since?));
        Level::ALL.into_iter().zip(&self.0).rev().find_map(holds)
    }

    /// Whether there is nothing to remember.
    pub(super) fn is_blank(&self) -> bool {
        self.0.iter().all(|latch| latch.since.is_none() && latch.reached == 0)
    }
}
