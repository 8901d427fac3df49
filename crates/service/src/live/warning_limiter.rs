//! Limits warnings to one per second and kind, so that a flood of bad datagrams does not flood the log.

use std::collections::BTreeMap;

use fusion::time::{SECOND, Time};

/// By kind: time of the last logged warning, and the number suppressed since.
#[derive(Clone, Debug, Default)]
pub(super) struct WarningLimiter(BTreeMap<&'static str, (Time, u64)>);

impl WarningLimiter {
    /// Whether a warning of this kind may be logged at `now`; counts it otherwise.
    pub(super) fn may_log(&mut self, kind: &'static str, now: Time) -> bool {
        let Some((logged, suppressed)) = self.0.get_mut(kind) else {
            self.0.insert(kind, (now, 0));
            return true;
        };
        // A clock that steps back suppresses no warning.
        let may = now.nanos().abs_diff(logged.nanos()) >= SECOND as u64 && *suppressed == 0;
        if may {
            *logged = now;
        } else {
            *suppressed += 1;
        }
        may
    }

    /// Kinds with warnings suppressed for a second, each with the number; the counts restart at 0.
    pub(super) fn suppressed(&mut self, now: Time) -> Vec<(&'static str, u64)> {
        let due = |(&kind, (logged, suppressed)): (&&'static str, &mut (Time, u64))| {
            if *suppressed == 0 || now.nanos().abs_diff(logged.nanos()) < SECOND as u64 {
                return None;
            }
            *logged = now;
            Some((kind, std::mem::take(suppressed)))
        };
        self.0.iter_mut().filter_map(due).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_warning_per_second_and_kind_is_logged() {
        let at = |seconds: f64| Time::from_nanos((seconds * 1e9) as i64);
        let mut limiter = WarningLimiter::default();
        assert!(limiter.may_log("a", at(10.0)) && limiter.may_log("b", at(10.0)));
        assert!(!limiter.may_log("a", at(10.2)) && !limiter.may_log("a", at(10.9)));
        assert_eq!(limiter.suppressed(at(10.95)), []);
        assert_eq!(limiter.suppressed(at(11.0)), [("a", 2)]);
        assert!(!limiter.may_log("a", at(11.5)), "the count was a line, too");
        assert!(limiter.may_log("b", at(11.5)));
        assert!(limiter.may_log("b", at(5.0)), "the clock stepped back");
    }
}
