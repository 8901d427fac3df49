//! Losses that go on: a count that rises is something wrong now, one that stands is the past. Sans-IO.

use fusion::time::{SECOND, Time};

/// Losses with less than this between them are one stretch; it ends when nothing is lost for as long.
const APART_NS: u64 = 5 * SECOND as u64;

/// Watches a count of what was lost.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Losses {
    /// The count as it was last.
    total: u64,
    /// The count before the present stretch of losses, and when it rose last.
    stretch: Option<(u64, Time)>,
}

impl Losses {
    /// Losses of the stretch that goes on at `at`, where the count is `total`; `None` where none goes on.
    pub(crate) fn going_on(&mut self, total: u64, at: Time) -> Option<u64> {
        let before = std::mem::replace(&mut self.total, total);
        if total > before {
            let began_with = self.stretch.map_or(before, |(began_with, _)| began_with);
            self.stretch = Some((began_with, at));
        }
        // A clock that steps ends a stretch, or makes it longer; the count itself misses nothing.
        self.stretch = self.stretch.filter(|(_, last)| at.nanos().abs_diff(last.nanos()) < APART_NS);
        self.stretch.map(|(began_with, _)| total - began_with)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_of_some_seconds_are_one_stretch_and_later_ones_another() {
        let at = |second: i64| Time::from_nanos(second * SECOND);
        let mut losses = Losses::default();
        let told = [(0, 0), (1, 0), (2, 7), (3, 7), (4, 10), (8, 10), (9, 10), (10, 12), (20, 12)];
        let told = told.map(|(second, total)| losses.going_on(total, at(second)));
        assert_eq!(told, [None, None, Some(7), Some(7), Some(10), Some(10), None, Some(2), None]);
    }
}
