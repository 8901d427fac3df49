//! Whether a receiver works, and how long to wait where it does not. Sans-IO.

use std::time::Duration;

use fusion::time::{SECOND, Time};

/// From the first failure to the next attempt; twice that after each further one.
const FIRST_WAIT: Duration = Duration::from_secs(1);
/// The longest pause between two attempts. By judgement: who comes back is served within a minute.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// The longest that a receiver may ask for.
const LONGEST_ASKED: Duration = Duration::from_secs(3_600);
/// A receiver that has failed for so long is worth an alert, nanoseconds. By judgement: longer than the restart of a server.
const WORTH_AN_ALERT_NS: i64 = 60 * SECOND;

/// What came of an attempt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// It is delivered.
    Taken,
    /// It is to be tried again, where the receiver says so not before `after`.
    Later { why: String, after: Option<Duration> },
    /// It will never be taken.
    Refused { why: String },
}

/// What is worth a line in the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum News {
    /// It is the first failure.
    Fails(String),
    /// It works again.
    Works { failed_s: i64, lost: u64 },
}

/// Of one receiver.
#[derive(Debug, Default)]
pub(crate) struct Health(Option<Failing>);

#[derive(Debug)]
struct Failing {
    since: Time,
    /// Attempts in a row.
    attempts: u32,
    lost: u64,
    why: String,
}

impl Health {
    pub(crate) fn is_failing(&self) -> bool {
        self.0.is_some()
    }

    pub(crate) fn works(&mut self, now: Time) -> Option<News> {
        let Failing { since, lost, .. } = self.0.take()?;
        Some(News::Works { failed_s: (now.nanos() - since.nanos()) / SECOND, lost })
    }

    pub(crate) fn fails(&mut self, why: String, now: Time) -> Option<News> {
        if let Some(failing) = &mut self.0 {
            failing.attempts = failing.attempts.saturating_add(1);
            failing.why = why;
            return None;
        }
        self.0 = Some(Failing { since: now, attempts: 1, lost: 0, why: why.clone() });
        Some(News::Fails(why))
    }

    /// A notice is lost.
    pub(crate) fn lose(&mut self) {
        if let Some(failing) = &mut self.0 {
            failing.lost += 1;
        }
    }

    /// Until the next attempt; `asked`: what the receiver asked for.
    pub(crate) fn wait(&self, asked: Option<Duration>) -> Duration {
        let Some(Failing { attempts, .. }) = &self.0 else { return Duration::ZERO };
        let doubled = FIRST_WAIT * 2_u32.pow((attempts - 1).min(6));
        asked.map_or(doubled.min(LONGEST_WAIT), |asked| asked.clamp(FIRST_WAIT, LONGEST_ASKED))
    }

    /// What is wrong, where that is worth an alert: for long, or something is lost.
    pub(crate) fn ailing(&self, now: Time) -> Option<Ailing<'_>> {
        let Failing { since, lost, why, .. } = self.0.as_ref()?;
        let is_long = now.nanos() - since.nanos() >= WORTH_AN_ALERT_NS;
        (*lost > 0 || is_long).then_some(Ailing { lost: *lost, why })
    }
}

/// What is wrong with a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ailing<'a> {
    /// What is lost since it began to fail.
    pub(crate) lost: u64,
    /// Why the last attempt failed.
    pub(crate) why: &'a str,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * SECOND)
    }

    #[test]
    fn the_pauses_double_up_to_a_minute_and_a_receiver_may_ask_for_others() {
        let mut health = Health::default();
        assert_eq!(health.wait(None), Duration::ZERO);
        let mut pause_s = || {
            health.fails("no".to_owned(), at(0));
            health.wait(None).as_secs()
        };
        assert_eq!([(); 9].map(|()| pause_s()), [1, 2, 4, 8, 16, 32, 60, 60, 60]);
        let asked_s = |seconds| health.wait(Some(Duration::from_secs(seconds))).as_secs();
        assert_eq!([0, 7, 90, 86_400].map(asked_s), [1, 7, 90, 3_600]);
    }

    #[test]
    fn the_first_failure_and_the_recovery_are_news() {
        let mut health = Health::default();
        assert_eq!(health.works(at(0)), None);
        assert_eq!(health.fails("closed".to_owned(), at(10)), Some(News::Fails("closed".to_owned())));
        assert_eq!(health.fails("late".to_owned(), at(11)), None);
        health.lose();
        assert_eq!(health.works(at(75)), Some(News::Works { failed_s: 65, lost: 1 }));
        assert_eq!(health.works(at(76)), None);
    }

    #[test]
    fn an_alert_is_raised_after_a_minute_or_at_a_loss() {
        let mut health = Health::default();
        health.fails("closed".to_owned(), at(0));
        assert_eq!(health.ailing(at(59)), None);
        assert_eq!(health.ailing(at(60)), Some(Ailing { lost: 0, why: "closed" }));
        health.lose();
        assert_eq!(health.ailing(at(1)), Some(Ailing { lost: 1, why: "closed" }));
        health.works(at(61));
        assert_eq!(health.ailing(at(61)), None);
    }
}
