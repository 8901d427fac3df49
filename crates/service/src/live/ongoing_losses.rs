//! Ongoing losses: a rising count is a present fault, a constant count is past. Sans-IO.

use fusion::time::{SECOND, Time};

/// Losses less than this apart form one stretch, which ends after this time without losses.
const APART_NS: u64 = 5 * SECOND as u64;

/// Watches a count of losses.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OngoingLosses {
    /// Last value of the count.
    total: u64,
    /// Value of the count before the present stretch of losses, and the time of its last rise.
    stretch: Option<(u64, Time)>,
}

impl OngoingLosses {
    /// Losses in the ongoing stretch at `at`, where the count is `total`; `None` without an ongoing stretch.
    pub fn update(&mut self, total: u64, at: Time) -> Option<u64> {
        let before = std::mem::replace(&mut self.total, total);
        if total > before {
            let began_with = self.stretch.map_or(before, |(began_with, _)| began_with);
            self.stretch = Some((began_with, at));
        }
        // A step of the clock ends or extends a stretch; the count itself stays correct.
        self.stretch = self.stretch.filter(|(_, last)| at.nanos().abs_diff(last.nanos()) < APART_NS);
        self.stretch.map(|(began_with, _)| total - began_with)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_seconds_apart_are_separate_stretches() {
        let at = |second: i64| Time::from_nanos(second * SECOND);
        let mut losses = OngoingLosses::default();
        let told = [(0, 0), (1, 0), (2, 7), (3, 7), (4, 10), (8, 10), (9, 10), (10, 12), (20, 12)];
        let told = told.map(|(second, total)| losses.update(total, at(second)));
        assert_eq!(told, [None, None, Some(7), Some(7), Some(10), Some(10), None, Some(2), None]);
    }
}
