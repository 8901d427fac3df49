//! What a node does less of while it cannot keep up: step by step, the least missed first. Sans-IO.

use fusion::time::Time;
use jiff::SignedDuration;

use crate::pipeline::Shed;

/// A cell is late from here on, and well again below that.
const LATE: SignedDuration = SignedDuration::from_millis(500);
const WELL: SignedDuration = SignedDuration::from_millis(100);
/// A step is given this time to help before the next one is taken,
const HELPS: SignedDuration = SignedDuration::from_secs(2);
/// and is taken back after this time without being late.
const HELD: SignedDuration = SignedDuration::from_secs(60);

/// Steps, as docs/SCALING.md counts them; those of the picture are its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Step(pub u8);

impl Step {
    /// Competitors are left out of the picture.
    pub const COMPETITORS: Self = Self(1);
    /// Checkpoints are written every two minutes.
    pub const CHECKPOINTS: Self = Self(3);
    /// The node stands by for no other cell.
    pub const STANDBYS: Self = Self(4);
    /// Plots of what is certainly no drone are left out.
    pub const UNLIKELY: Self = Self(5);
    /// Of aircraft whose transponder speaks, every second plot is left out.
    pub const HALVED: Self = Self(6);
    /// The cell is left to whoever stands by.
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

    /// Which plots the engine is not given.
    pub fn shed(self) -> Shed {
        match self {
            _ if self >= Self::HALVED => Shed::Halved,
            _ if self >= Self::UNLIKELY => Shed::Unlikely,
            _ => Shed::Nothing,
        }
    }

    /// What is missing because of it, in words.
    pub const fn words(self) -> &'static str {
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
        Self::ALL.into_iter().find(|step| *step > self).unwrap_or(Self::LEFT)
    }

    fn before(self) -> Self {
        Self::ALL.into_iter().rev().find(|step| *step < self).unwrap_or_default()
    }
}

/// How far a cell is relieved.
#[derive(Clone, Copy, Debug, Default)]
pub struct Relief {
    step: Step,
    /// Since when it is late, or when the last step was taken: one who has just taken over is late, and is soon in time.
    late_since: Option<Time>,
    /// Since when it is well.
    well_since: Option<Time>,
}

impl Relief {
    /// The step that holds at `at`. `behind`: by how much the cell is late although everything that could be made was made.
    pub fn look(&mut self, behind: SignedDuration, at: Time) -> Step {
        if behind > LATE {
            self.well_since = None;
            // Anew where the clock was set back.
            let since = self.late_since.filter(|since| *since <= at).unwrap_or(at);
            let is_next = at - since >= HELPS;
            if is_next {
                self.step = self.step.next();
            }
            self.late_since = Some(if is_next { at } else { since });
            return self.step;
        }
        self.late_since = None;
        if behind < WELL {
            let since = *self.well_since.get_or_insert(at);
            if self.step > Step::default() && at - since >= HELD {
                self.step = self.step.before();
                self.well_since = Some(at);
            }
        } else {
            self.well_since = None;
        }
        self.step
    }

    /// Goes on from the step that another node has taken.
    pub const fn follow(&mut self, step: Step) {
        self.step = step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_taken_one_by_one_and_taken_back_after_a_minute_each() {
        let at = |second: i64| Time::from_nanos((1_800_000_000 + second) * 1_000_000_000);
        let (late, well) = (SignedDuration::from_millis(700), SignedDuration::ZERO);
        let mut relief = Relief::default();
        assert_eq!(relief.look(well, at(0)), Step(0));
        let taken: Vec<u8> = (1..20).map(|second| relief.look(late, at(second)).0).collect();
        assert_eq!(taken, [0, 0, 1, 1, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 7, 7, 7, 7, 7]);
        // In between it stays.
        assert_eq!(relief.look(SignedDuration::from_millis(300), at(400)), Step(7));
        let back: Vec<u8> = (0..8).map(|minute| relief.look(well, at(401 + 60 * minute)).0).collect();
        assert_eq!(back, [7, 6, 5, 4, 3, 1, 0, 0]);
        // A short spell does not count, neither of being late nor of being well.
        relief.look(late, at(990));
        relief.look(well, at(991));
        assert_eq!(relief.look(late, at(998)), Step(0));
        assert_eq!(relief.look(late, at(1000)), Step(1));
        assert_eq!(relief.look(well, at(1059)), Step(1));
        relief.look(SignedDuration::from_millis(300), at(1100));
        assert_eq!(relief.look(well, at(1119)), Step(1));
        assert_eq!(relief.look(well, at(1179)), Step(0));
    }

    #[test]
    fn every_step_says_what_is_missing() {
        let words: std::collections::BTreeSet<&str> = Step::ALL.into_iter().map(Step::words).collect();
        assert_eq!(words.len(), Step::ALL.len());
    }
}
