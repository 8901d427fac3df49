//! Outbox of one sink: the last few seconds, its health and its counts. Sans-IO.

use std::collections::VecDeque;
use std::time::Duration;

use super::counts::{SinkCounts, SinkLoss};
use crate::live::{OngoingLosses, ServiceFault, Severity};
use crate::net::health::{HealthChange, NotableFailure, ReceiverHealth};
use fusion::time::Time;

/// Maximum number of waiting seconds: as many as a service publishes at once when it ends, 6.25 s by default.
pub(super) const WAITING: usize = 8;

/// Queue of one sink, with its health.
#[derive(Debug)]
pub(super) struct SinkOutbox<T> {
    waiting: VecDeque<T>,
    health: ReceiverHealth,
    counts: SinkCounts,
    slow: OngoingLosses,
}

impl<T> Default for SinkOutbox<T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            health: ReceiverHealth::default(),
            counts: SinkCounts::default(),
            slow: OngoingLosses::default(),
        }
    }
}

impl<T> SinkOutbox<T> {
    /// Adds a second, and drops the oldest of a full queue. While the sink fails only the newest is kept: it is what a
    /// receiver needs when it is back.
    pub(super) fn push(&mut self, second: T) {
        let (bound, loss) =
            if self.health.is_failing() { (1, SinkLoss::Unreachable) } else { (WAITING, SinkLoss::Slow) };
        self.waiting.push_back(second);
        self.shorten(bound, loss);
    }

    /// The next second.
    pub(super) fn take(&mut self) -> Option<T> {
        self.waiting.pop_front()
    }

    /// A connection begins: only the newest second is kept.
    pub(super) fn begin(&mut self) {
        self.shorten(1, SinkLoss::Unreachable);
    }

    /// Drops the oldest seconds above the bound.
    fn shorten(&mut self, bound: usize, loss: SinkLoss) {
        let dropped = self.waiting.len().saturating_sub(bound);
        self.waiting.drain(..dropped);
        self.counts.lose(loss, dropped);
    }

    /// Counts sent messages.
    pub(super) fn sent(&mut self, messages: u64) {
        self.counts.sent += messages;
    }

    /// Records that the receiver can be reached.
    pub(super) fn works(&mut self, now: Time) -> Option<HealthChange> {
        self.health.works(now)
    }

    /// Counts tracks that the format cannot represent.
    pub(super) fn left_out(&mut self, tracks: u64) {
        self.counts.left_out += tracks;
    }

    /// Counts a second lost because the receiver has not accepted the registration.
    pub(super) fn withheld(&mut self) {
        self.counts.lose(SinkLoss::Refused, 1);
    }

    /// Counts seconds that were missed because the service was overloaded.
    pub(super) fn missed(&mut self, seconds: usize) {
        self.counts.lose(SinkLoss::Overload, seconds);
    }

    /// Records a failed attempt, and a second lost with it if `loss` is given.
    pub(super) fn fails(
        &mut self,
        why: String,
        loss: Option<SinkLoss>,
        now: Time,
    ) -> (Duration, Option<HealthChange>) {
        self.counts.failed += 1;
        let news = self.health.fails(why, now);
        loss.into_iter().for_each(|loss| self.counts.lose(loss, 1));
        (self.health.wait(None), news)
    }

    pub(super) fn counts(&self) -> SinkCounts {
        let mut counts = self.counts;
        (counts.waiting, counts.is_failing) = (self.waiting.len(), self.health.is_failing());
        counts
    }

    /// Fault that is worth an alert: a long failure, or lost pictures because the receiver is slow.
    pub(super) fn trouble(&mut self, name: &str, now: Time) -> Option<ServiceFault> {
        let slow = self.slow.update(self.counts.lost(SinkLoss::Slow), now);
        let text = match (self.health.ailing(now), slow) {
            (Some(NotableFailure { why, .. }), _) => format!("{name}: the picture is not delivered: {why}"),
            (None, Some(1)) => format!("{name}: the receiver is too slow: one second is lost"),
            (None, Some(lost)) => format!("{name}: the receiver is too slow: {lost} seconds are lost"),
            (None, None) => return None,
        };
        Some(ServiceFault { about: name.to_owned().into(), severity: Severity::Warning, text })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use fusion::time::SECOND;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * SECOND)
    }

    #[test]
    fn slow_receiver_misses_the_oldest_seconds_with_an_alert() {
        let mut outbox = SinkOutbox::default();
        (0..10).for_each(|second| outbox.push(second));
        assert_eq!((outbox.counts().waiting, outbox.counts().lost(SinkLoss::Slow)), (WAITING, 2));
        assert_eq!(outbox.take(), Some(2));
        let text =
            |outbox: &mut SinkOutbox<i32>, now| outbox.trouble("cot:a", now).map(|trouble| trouble.text);
        assert_eq!(
            text(&mut outbox, at(1)).as_deref(),
            Some("cot:a: the receiver is too slow: 2 seconds are lost")
        );
        assert_eq!(text(&mut outbox, at(9)), None);
    }

    #[test]
    fn returning_receiver_gets_the_newest_second() {
        let mut outbox = SinkOutbox::default();
        (0..3).for_each(|second| outbox.push(second));
        let (wait, news) = outbox.fails("closed".to_owned(), None, at(0));
        assert_eq!((wait.as_secs(), news), (1, Some(HealthChange::Fails("closed".to_owned()))));
        outbox.push(3);
        assert_eq!((outbox.counts().waiting, outbox.counts().lost(SinkLoss::Unreachable)), (1, 3));
        assert_eq!(outbox.trouble("cot:a", at(59)), None);
        let text = outbox.trouble("cot:a", at(60)).unwrap().text;
        assert_eq!(text, "cot:a: the picture is not delivered: closed");
        outbox.begin();
        assert_eq!(outbox.take(), Some(3));
        outbox.sent(5);
        assert!(outbox.counts().is_failing, "it has not lasted yet");
        assert_eq!(outbox.works(at(61)), Some(HealthChange::Works { failed_s: 61, lost: 0 }));
        assert_eq!((outbox.counts().sent, outbox.counts().is_failing), (5, false));
        assert_eq!(outbox.trouble("cot:a", at(61)), None);
    }

    proptest! {
        /// For any sequence of steps: the queue is bounded and in order, and each second added was taken, was lost or
        /// waits.
        #[test]
        fn each_loss_is_counted(steps in prop::collection::vec(0_u8..8, 1..300)) {
            let mut outbox = SinkOutbox::default();
            let (mut noted, mut taken, mut last) = (0_u64, 0_u64, 0_u64);
            for step in steps {
                match step {
                    0..=3 => {
                        noted += 1;
                        outbox.push(noted);
                    }
                    4 => _ = outbox.fails("no".to_owned(), None, at(0)),
                    5 => _ = outbox.works(at(0)),
                    6 => outbox.begin(),
                    _ => {
                        if let Some(second) = outbox.take() {
                            prop_assert!(second > last);
                            last = second;
                            taken += 1;
                        }
                    }
                }
                let counts = outbox.counts();
                let lost: u64 = SinkLoss::ALL.map(|loss| counts.lost(loss)).iter().sum();
                prop_assert!(counts.waiting <= WAITING);
                prop_assert_eq!(noted, taken + lost + counts.waiting as u64);
            }
        }
    }
}
