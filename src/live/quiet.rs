//! One warning per second and kind: a flood of bad datagrams must not become a flood of log lines.

use std::collections::BTreeMap;

use fusion::time::{SECOND, Time};

/// When each kind of warning was logged last, and how often it was suppressed since.
#[derive(Clone, Debug, Default)]
pub(super) struct Quiet(BTreeMap<&'static str, (Time, u64)>);

impl Quiet {
    /// Whether a warning of this kind may be logged at `now`; it is counted where not.
    pub(super) fn may_tell(&mut self, kind: &'static str, now: Time) -> bool {
        let Some((told, kept_back)) = self.0.get_mut(kind) else {
            self.0.insert(kind, (now, 0));
            return true;
        };
        // A clock that steps back silences nothing.
        let may = now.nanos().abs_diff(told.nanos()) >= SECOND as u64 && *kept_back == 0;
        if may {
            *told = now;
        } else {
            *kept_back += 1;
        }
        may
    }

    /// The kinds that were suppressed for a second, each with how often; they count from 0 again.
    pub(super) fn suppressed(&mut self, now: Time) -> Vec<(&'static str, u64)> {
        let due = |(&kind, (told, kept_back)): (&&'static str, &mut (Time, u64))| {
            if *kept_back == 0 || now.nanos().abs_diff(told.nanos()) < SECOND as u64 {
                return None;
            }
            *told = now;
            Some((kind, std::mem::take(kept_back)))
        };
        self.0.iter_mut().filter_map(due).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_a_second_and_kind_and_the_rest_is_counted() {
        let at = |seconds: f64| Time::from_nanos((seconds * 1e9) as i64);
        let mut quiet = Quiet::default();
        assert!(quiet.may_tell("a", at(10.0)) && quiet.may_tell("b", at(10.0)));
        assert!(!quiet.may_tell("a", at(10.2)) && !quiet.may_tell("a", at(10.9)));
        assert_eq!(quiet.suppressed(at(10.95)), []);
        assert_eq!(quiet.suppressed(at(11.0)), [("a", 2)]);
        assert!(!quiet.may_tell("a", at(11.5)), "the count was a line, too");
        assert!(quiet.may_tell("b", at(11.5)));
        assert!(quiet.may_tell("b", at(5.0)), "the clock stepped back");
    }
}
