//! Health of a receiver, and the pauses between attempts while it fails. Sans-IO.

use std::time::Duration;

use fusion::time::{SECOND, Time};

/// Pause after the first failure; doubled after each further one.
const FIRST_WAIT: Duration = Duration::from_secs(1);
/// Maximum pause between two attempts. Chosen by judgement: a receiver that is back is served within a minute.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// Maximum pause that a receiver may ask for.
const LONGEST_ASKED: Duration = Duration::from_secs(3_600);
/// Duration of a failure that raises an alert, in nanoseconds. Chosen by judgement: longer than the restart of a server.
const WORTH_AN_ALERT_NS: i64 = 60 * SECOND;

/// Result of an attempt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DeliveryResult {
    /// Delivered.
    Taken,
    /// Failed, to be tried again; not before `after`, if the receiver states that.
    Later { why: String, after: Option<Duration> },
    /// Rejected for good.
    Refused { why: String },
}

/// Change of the health, for the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum HealthChange {
    /// The first failure.
    Fails(String),
    /// The receiver works again.
    Works { failed_s: i64, lost: u64 },
}

/// Health of one receiver.
#[derive(Debug, Default)]
pub(crate) struct ReceiverHealth(Option<OngoingFailure>);

#[derive(Debug)]
struct OngoingFailure {
    since: Time,
    /// Number of failed attempts in a row.
    attempts: u32,
    lost: u64,
    why: String,
}

impl ReceiverHealth {
    pub fn is_failing(&self) -> bool {
        self.0.is_some()
    }

    pub(crate) fn works(&mut self, now: Time) -> Option<HealthChange> {
        let OngoingFailure { since, lost, .. } = self.0.take()?;
        Some(HealthChange::Works { failed_s: (now.nanos() - since.nanos()) / SECOND, lost })
    }

    pub fn fails(&mut self, why: String, now: Time) -> Option<HealthChange> {
        if let Some(failing) = &mut self.0 {
            failing.attempts = failing.attempts.saturating_add(1);
            failing.why = why;
            return None;
        }
        self.0 = Some(OngoingFailure { since: now, attempts: 1, lost: 0, why: why.clone() });
        Some(HealthChange::Fails(why))
    }

    /// Counts a lost notice.
    pub(crate) fn lose(&mut self) {
        if let Some(failing) = &mut self.0 {
            failing.lost += 1;
        }
    }

    /// Pause before the next attempt; `asked` is the pause that the receiver asked for.
    pub fn wait(&self, asked: Option<Duration>) -> Duration {
        let Some(OngoingFailure { attempts, .. }) = &self.0 else { return Duration::ZERO };
        let doubled = FIRST_WAIT * 2_u32.pow((attempts - 1).min(6));
        asked.map_or(doubled.min(LONGEST_WAIT), |asked| asked.clamp(FIRST_WAIT, LONGEST_ASKED))
    }

    /// Fault that is worth an alert: a long failure, or losses.
    pub(crate) fn ailing(&self, now: Time) -> Option<NotableFailure<'_>> {
        let OngoingFailure { since, lost, why, .. } = self.0.as_ref()?;
        let is_long = now.nanos() - since.nanos() >= WORTH_AN_ALERT_NS;
        (*lost > 0 || is_long).then_some(NotableFailure { lost: *lost, why })
    }
}

/// Fault of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotableFailure<'a> {
    /// Losses since it began to fail.
    pub lost: u64,
    /// Reason for the last failure.
    pub why: &'a str,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * SECOND)
    }

    #[test]
    fn pauses_double_up_to_a_minute_or_as_requested() {
        let mut health = ReceiverHealth::default();
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
    fn first_failure_and_recovery_are_reported() {
        let mut health = ReceiverHealth::default();
        assert_eq!(health.works(at(0)), None);
        assert_eq!(health.fails("closed".to_owned(), at(10)), Some(HealthChange::Fails("closed".to_owned())));
        assert_eq!(health.fails("late".to_owned(), at(11)), None);
        health.lose();
        assert_eq!(health.works(at(75)), Some(HealthChange::Works { failed_s: 65, lost: 1 }));
        assert_eq!(health.works(at(76)), None);
    }

    #[test]
    fn failure_is_an_alert_after_a_minute_or_a_loss() {
        let mut health = ReceiverHealth::default();
        health.fails("closed".to_owned(), at(0));
        assert_eq!(health.ailing(at(59)), None);
        assert_eq!(health.ailing(at(60)), Some(NotableFailure { lost: 0, why: "closed" }));
        health.lose();
        assert_eq!(health.ailing(at(1)), Some(NotableFailure { lost: 1, why: "closed" }));
        health.works(at(61));
        assert_eq!(health.ailing(at(61)), None);
    }
}
