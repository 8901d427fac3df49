//! What one sink is owed: a few seconds at most, the newest where nobody takes them. Sans-IO.

use std::collections::VecDeque;
use std::time::Duration;

use super::counts::{Counts, Loss};
use crate::live::{Losses, Severity, Trouble};
use crate::net::health::{Ailing, Health, News};
use fusion::time::Time;

/// Most seconds that wait: those that a service publishes at once when it ends, 6.25 s by default. Older ones are of no use.
pub(super) const WAITING: usize = 8;

/// The queue of one sink, and how it is.
#[derive(Debug)]
pub(super) struct Outbox<T> {
    waiting: VecDeque<T>,
    health: Health,
    counts: Counts,
    slow: Losses,
}

impl<T> Default for Outbox<T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            health: Health::default(),
            counts: Counts::default(),
            slow: Losses::default(),
        }
    }
}

impl<T> Outbox<T> {
    /// Takes a second; the oldest makes room for it. While the sink fails only the newest waits: it is what a receiver wants
    /// that is back.
    pub(super) fn push(&mut self, second: T) {
        let (bound, loss) =
            if self.health.is_failing() { (1, Loss::Unreachable) } else { (WAITING, Loss::Slow) };
        self.waiting.push_back(second);
        self.shorten(bound, loss);
    }

    /// The next one.
    pub(super) fn take(&mut self) -> Option<T> {
        self.waiting.pop_front()
    }

    /// A connection begins: of what has waited for it the newest counts.
    pub(super) fn begin(&mut self) {
        self.shorten(1, Loss::Unreachable);
    }

    /// Drops the oldest until no more than that wait.
    fn shorten(&mut self, bound: usize, loss: Loss) {
        let dropped = self.waiting.len().saturating_sub(bound);
        self.waiting.drain(..dropped);
        self.counts.lose(loss, dropped);
    }

    /// So many messages are sent.
    pub(super) fn sent(&mut self, messages: u64) {
        self.counts.sent += messages;
    }

    /// The receiver is there.
    pub(super) fn works(&mut self, now: Time) -> Option<News> {
        self.health.works(now)
    }

    /// Tracks that the format cannot hold.
    pub(super) fn left_out(&mut self, tracks: u64) {
        self.counts.left_out += tracks;
    }

    /// A second that the receiver has not agreed to.
    pub(super) fn withheld(&mut self) {
        self.counts.lose(Loss::Refused, 1);
    }

    /// Seconds that it never got to see.
    pub(super) fn missed(&mut self, seconds: usize) {
        self.counts.lose(Loss::Overload, seconds);
    }

    /// An attempt failed; `loss`: a second was lost with it.
    pub(super) fn fails(&mut self, why: String, loss: Option<Loss>, now: Time) -> (Duration, Option<News>) {
        self.counts.failed += 1;
        let news = self.health.fails(why, now);
        loss.into_iter().for_each(|loss| self.counts.lose(loss, 1));
        (self.health.wait(None), news)
    }

    pub(super) fn counts(&self) -> Counts {
        let mut counts = self.counts;
        (counts.waiting, counts.is_failing) = (self.waiting.len(), self.health.is_failing());
        counts
    }

    /// What is wrong with it, where that is worth an alert: no connection for long, or pictures are lost because it is slow.
    pub(super) fn trouble(&mut self, name: &str, now: Time) -> Option<Trouble> {
        let slow = self.slow.going_on(self.counts.lost(Loss::Slow), now);
        let text = match (self.health.ailing(now), slow) {
            (Some(Ailing { why, .. }), _) => format!("{name}: the picture is not delivered: {why}"),
            (None, Some(1)) => format!("{name}: the receiver is too slow: one second is lost"),
            (None, Some(lost)) => format!("{name}: the receiver is too slow: {lost} seconds are lost"),
            (None, None) => return None,
        };
        Some(Trouble { about: name.to_owned().into(), severity: Severity::Warning, text })
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
    fn a_slow_receiver_misses_the_oldest_and_that_is_an_alert_while_it_goes_on() {
        let mut outbox = Outbox::default();
        (0..10).for_each(|second| outbox.push(second));
        assert_eq!((outbox.counts().waiting, outbox.counts().lost(Loss::Slow)), (WAITING, 2));
        assert_eq!(outbox.take(), Some(2));
        let text = |outbox: &mut Outbox<i32>, now| outbox.trouble("cot:a", now).map(|trouble| trouble.text);
        assert_eq!(
            text(&mut outbox, at(1)).as_deref(),
            Some("cot:a: the receiver is too slow: 2 seconds are lost")
        );
        assert_eq!(text(&mut outbox, at(9)), None);
    }

    #[test]
    fn who_comes_back_gets_the_newest() {
        let mut outbox = Outbox::default();
        (0..3).for_each(|second| outbox.push(second));
        let (wait, news) = outbox.fails("closed".to_owned(), None, at(0));
        assert_eq!((wait.as_secs(), news), (1, Some(News::Fails("closed".to_owned()))));
        outbox.push(3);
        assert_eq!((outbox.counts().waiting, outbox.counts().lost(Loss::Unreachable)), (1, 3));
        assert_eq!(outbox.trouble("cot:a", at(59)), None);
        let text = outbox.trouble("cot:a", at(60)).unwrap().text;
        assert_eq!(text, "cot:a: the picture is not delivered: closed");
        outbox.begin();
        assert_eq!(outbox.take(), Some(3));
        outbox.sent(5);
        assert!(outbox.counts().is_failing, "it has not lasted yet");
        assert_eq!(outbox.works(at(61)), Some(News::Works { failed_s: 61, lost: 0 }));
        assert_eq!((outbox.counts().sent, outbox.counts().is_failing), (5, false));
        assert_eq!(outbox.trouble("cot:a", at(61)), None);
    }

    proptest! {
        /// Whatever happens: no more than the bound waits, in order, and what was noted was taken, was lost or waits.
        #[test]
        fn nothing_is_lost_uncounted(steps in prop::collection::vec(0_u8..8, 1..300)) {
            let mut outbox = Outbox::default();
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
                let lost: u64 = Loss::ALL.map(|loss| counts.lost(loss)).iter().sum();
                prop_assert!(counts.waiting <= WAITING);
                prop_assert_eq!(noted, taken + lost + counts.waiting as u64);
            }
        }
    }
}
