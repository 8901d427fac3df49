//! Load shedding of a node that cannot keep up: level by level, the least important data first. Sans-IO.

use fusion::time::Time;
use jiff::SignedDuration;

use input::pipeline::Shed;

/// Lateness above which a cell is late, and below which it is in time again.
const LATE_ABOVE: SignedDuration = SignedDuration::from_millis(500);
const IN_TIME_BELOW: SignedDuration = SignedDuration::from_millis(100);
/// Minimum time at a level before the next one is taken, while the cell is late.
const RAISE_INTERVAL: SignedDuration = SignedDuration::from_secs(2);
/// Time without lateness after which a level is taken back.
const LOWER_INTERVAL: SignedDuration = SignedDuration::from_secs(60);

/// Level of load shedding, as numbered in docs/SCALING.md. Levels not listed here are unused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SheddingLevel(pub u8);

impl SheddingLevel {
    /// The picture contains no competitors.
    pub const COMPETITORS: Self = Self(1);
    /// Checkpoints are written every two minutes.
    pub const CHECKPOINTS: Self = Self(3);
    /// The node is not a standby for any other cell.
    pub const STANDBYS: Self = Self(4);
    /// Plots of radar tracks that are certainly not drones are discarded.
    pub const UNLIKELY: Self = Self(5);
    /// Every second plot is discarded for aircraft with an active transponder.
    pub const HALVED: Self = Self(6);
    /// The cell is left to its standby.
    pub const LEFT: Self = Self(7);

    const ALL: [Self; 7] = [
        Self(0),
        Self::COMPETITORS,
        Self::CHECKPOINTS,
        Self::STANDBYS,
        Self::UNLIKELY,
        Self::HALVED,
        Self::LEFT,
    ];

    /// Plots that the engine discards.
    pub fn shed(self) -> Shed {
        match self {
            _ if self >= Self::HALVED => Shed::Halved,
            _ if self >= Self::UNLIKELY => Shed::Unlikely,
            _ => Shed::Nothing,
        }
    }

    /// Description of the level for operators.
    pub const fn description(self) -> &'static str {
        match self.0 {
            0 => "nothing is left out",
            1 | 2 => "competitors are left out",
            3 => "checkpoints are rare",
            4 => "its node stands by for no other cell",
            5 => "plots of what is certainly no drone are left out",
            6 => "every second plot is left out of aircraft whose transponder speaks",
            _ => "it is left to another node, where there is one",
        }
    }

    fn next(self) -> Self {
        Self::ALL.into_iter().find(|level| *level > self).unwrap_or(Self::LEFT)
    }

    fn previous(self) -> Self {
        Self::ALL.into_iter().rev().find(|level| *level < self).unwrap_or_default()
    }
}

/// Overload control of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct OverloadControl {
    level: SheddingLevel,
    /// Time since when the cell is late, or of the last level change. A new owner is late at first, and soon in time.
    late_since: Option<Time>,
    /// Time since when the cell is in time.
    in_time_since: Option<Time>,
}

impl OverloadControl {
    /// Updates the level at time `at`. `lateness` is the cell's lateness after all possible slots were made.
    pub fn update(&mut self, lateness: SignedDuration, at: Time) -> SheddingLevel {
        if lateness > LATE_ABOVE {
            self.in_time_since = None;
            // Restart the period if the clock was set back.
            let since = self.late_since.filter(|since| *since <= at).unwrap_or(at);
            let is_next = at - since >= RAISE_INTERVAL;
            if is_next {
                self.level = self.level.next();
            }
            self.late_since = Some(if is_next { at } else { since });
            return self.level;
        }
        self.late_since = None;
        if lateness < IN_TIME_BELOW {
            let since = *self.in_time_since.get_or_insert(at);
            if self.level > SheddingLevel::default() && at - since >= LOWER_INTERVAL {
                self.level = self.level.previous();
                self.in_time_since = Some(at);
            }
        } else {
            self.in_time_since = None;
        }
        self.level
    }

    /// Adopts the level stated by another node.
    pub const fn adopt(&mut self, level: SheddingLevel) {
        self.level = level;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_rise_one_by_one_and_fall_after_a_minute_each() {
        let at = |second: i64| Time::from_nanos((1_800_000_000 + second) * 1_000_000_000);
        let (late, well) = (SignedDuration::from_millis(700), SignedDuration::ZERO);
        let mut control = OverloadControl::default();
        assert_eq!(control.update(well, at(0)), SheddingLevel(0));
        let taken: Vec<u8> = (1..20).map(|second| control.update(late, at(second)).0).collect();
        assert_eq!(taken, [0, 0, 1, 1, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 7, 7, 7, 7, 7]);
        // Between the limits the level stays.
        assert_eq!(control.update(SignedDuration::from_millis(300), at(400)), SheddingLevel(7));
        let back: Vec<u8> = (0..8).map(|minute| control.update(well, at(401 + 60 * minute)).0).collect();
        assert_eq!(back, [7, 6, 5, 4, 3, 1, 0, 0]);
        // Short periods of being late or in time do not count.
        control.update(late, at(990));
        control.update(well, at(991));
        assert_eq!(control.update(late, at(998)), SheddingLevel(0));
        assert_eq!(control.update(late, at(1000)), SheddingLevel(1));
        assert_eq!(control.update(well, at(1059)), SheddingLevel(1));
        control.update(SignedDuration::from_millis(300), at(1100));
        assert_eq!(control.update(well, at(1119)), SheddingLevel(1));
        assert_eq!(control.update(well, at(1179)), SheddingLevel(0));
    }

    #[test]
    fn every_level_has_its_own_description() {
        let description: std::collections::BTreeSet<&str> =
            SheddingLevel::ALL.into_iter().map(SheddingLevel::description).collect();
        assert_eq!(description.len(), SheddingLevel::ALL.len());
    }
}
