//! Level of a conflict over time: several evaluations must agree to raise it, and it ends after seconds without one.

use fusion::time::{SECOND, Time};

/// Number of evaluations that are remembered, and minimum number of these that must agree.
const OF_THE_LAST: u32 = 4;
const TO_RAISE: u32 = 2;
/// Minimum duration of a level, nanoseconds.
const HELD_NS: i64 = 4 * SECOND;
/// Time without an evaluation that keeps a level after which it ends, nanoseconds.
const LOWERED_NS: i64 = 5 * SECOND;

/// Severity of a conflict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// A conflict is possible.
    Advisory,
    /// A conflict is likely.
    Warning,
    /// A volume is entered.
    Violation,
}

fusion::interface_names!(Level { Advisory = "advisory", Warning = "warning", Violation = "violation" });

/// Result of an evaluation for one level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LevelVote {
    /// Whether the level is reached.
    pub(super) reached: bool,
    /// Whether the level is kept.
    pub(super) kept: bool,
    /// Whether this evaluation raises the level alone, if it is reached.
    pub(super) is_clear: bool,
}

/// State of one level of one pair and volume.
#[derive(Clone, Copy, Debug, Default)]
struct Latch {
    /// Whether recent evaluations reached the level, the last one in the lowest bit.
    reached: u8,
    /// Time since which the level holds.
    since: Option<Time>,
    /// Time of the last evaluation that kept the level.
    kept: Time,
}

impl Latch {
    fn update(&mut self, now: Time, say: LevelVote) {
        self.reached = (self.reached << 1 | u8::from(say.reached)) & ((1 << OF_THE_LAST) - 1);
        if say.reached || say.kept {
            self.kept = now;
        }
        match self.since {
            None if self.reached.count_ones() >= TO_RAISE || (say.reached && say.is_clear) => {
                self.since = Some(now);
            }
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
    /// Applies the results of an evaluation, one for each level.
    pub(super) fn update(&mut self, now: Time, said: [LevelVote; Level::ALL.len()]) {
        for (latch, say) in self.0.iter_mut().zip(said) {
            latch.update(now, say);
        }
    }

    /// The highest level that holds, and since when.
    pub(super) fn worst(&self) -> Option<(Level, Time)> {
        let holds = |(level, latch): (Level, &Latch)| Some((level, latch.since?));
        Level::ALL.into_iter().zip(&self.0).rev().find_map(holds)
    }

    /// Whether there is nothing to remember.
    pub(super) fn is_blank(&self) -> bool {
        self.0.iter().all(|latch| latch.since.is_none() && latch.reached == 0)
    }
}
