//! What one receiver is owed. Sans-IO.

use std::sync::Arc;
use std::time::Duration;

use super::batch::Batch;
use super::counts::{Counts, Loss};
use super::mirror::Mirror;
use super::queue::{ALIKE, Notice, Queue, WAITING};
use super::selection::Selection;
use crate::live::{Alert, Change, Severity, Trouble};
use crate::net::health::{Ailing, Answer, Health, News};
use fusion::time::Time;

#[derive(Debug)]
pub(super) struct Outbox {
    pub(super) selection: Selection,
    queue: Queue,
    /// The alerts that last, for a broker.
    pub(super) mirror: Option<Mirror>,
    health: Health,
    counts: Counts,
}

impl Outbox {
    pub(super) fn new(selection: Selection, mirror: Option<Mirror>) -> Self {
        let queue = Queue::new(WAITING, ALIKE);
        Self { selection, queue, mirror, health: Health::default(), counts: Counts::default() }
    }

    /// Takes a change.
    pub(super) fn note(&mut self, change: Change, alert: &Arc<Alert>, at: Time) {
        if let Some(mirror) = &mut self.mirror {
            let is_shown = self.selection.wants(alert) && self.selection.is_bad_enough(alert);
            mirror.note(alert, is_shown);
        }
        if self.selection.admits(change, alert) {
            let dropped = self.queue.push(change, alert.clone(), at);
            self.drop_waiting(dropped);
        }
    }

    /// Whether a critical notice waits.
    pub(super) fn is_urgent(&self) -> bool {
        self.queue.is_urgent()
    }

    /// The next delivery.
    pub(super) fn take(&mut self, now: Time) -> Option<Batch> {
        let Self { queue, counts, health, .. } = self;
        queue.take(now, |loss| {
            counts.lose(loss);
            health.lose();
        })
    }

    /// What came of it; how long to wait then, and what is worth a line in the log.
    pub(super) fn settle(&mut self, batch: Batch, answer: Answer, now: Time) -> (Duration, Option<News>) {
        match answer {
            Answer::Taken => {
                self.counts.sent += batch.len() as u64;
                (Duration::ZERO, self.works(now))
            }
            Answer::Later { why, after } => {
                let news = self.fails(why, now);
                let dropped = self.queue.put_back(batch);
                self.drop_waiting(dropped);
                (self.health.wait(after), news)
            }
            Answer::Refused { why } => {
                let news = self.fails(why, now);
                batch.notices().for_each(|_| self.lose(Loss::Refused));
                (self.health.wait(None), news)
            }
        }
    }

    /// The receiver is there.
    pub(super) fn works(&mut self, now: Time) -> Option<News> {
        self.health.works(now)
    }

    /// An attempt failed.
    pub(super) fn fails(&mut self, why: String, now: Time) -> Option<News> {
        self.counts.failed += 1;
        self.health.fails(why, now)
    }

    /// Until the next attempt.
    pub(super) fn wait(&self) -> Duration {
        self.health.wait(None)
    }

    pub(super) fn counts(&self) -> Counts {
        let mut counts = self.counts;
        (counts.waiting, counts.is_failing) = (self.queue.len(), self.health.is_failing());
        counts
    }

    pub(super) fn trouble(&self, name: &str, now: Time) -> Option<Trouble> {
        let Ailing { lost, why } = self.health.ailing(now)?;
        let text = match lost {
            0 => format!("{name}: alerts are not delivered: {why}"),
            1 => format!("{name}: one notice of an alert is lost: {why}"),
            lost => format!("{name}: {lost} notices of alerts are lost: {why}"),
        };
        Some(Trouble { about: name.to_owned().into(), severity: Severity::Warning, text })
    }

    /// Counts notices that were dropped. The end of an alert is not sent where its beginning never was.
    fn drop_waiting(&mut self, dropped: impl IntoIterator<Item = Notice>) {
        for notice in dropped {
            if notice.is_first() {
                self.selection.forget(notice.alert.id);
            }
            self.lose(Loss::Full);
        }
    }

    fn lose(&mut self, loss: Loss) {
        self.counts.lose(loss);
        self.health.lose();
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::tests::alert;
    use super::*;

    fn outbox() -> Outbox {
        Outbox::new(Selection::new("webhook:a".to_owned(), None, Severity::Warning), None)
    }

    fn later() -> Answer {
        Answer::Later { why: "answered 500".to_owned(), after: None }
    }

    #[test]
    fn what_is_tried_again_what_is_lost_and_what_is_counted() {
        let mut outbox = outbox();
        let now = Time::default();
        outbox.note(Change::Began, &alert(1), now);
        let notice = outbox.take(now).unwrap();
        let (wait, news) = outbox.settle(notice.clone(), later(), now);
        assert_eq!((wait.as_secs(), news), (1, Some(News::Fails("answered 500".to_owned()))));
        // The same content is the same notice.
        assert_eq!(outbox.take(now), Some(notice.clone()));
        assert_eq!(outbox.settle(notice.clone(), later(), now), (Duration::from_secs(2), None));
        let notice = outbox.take(now).unwrap();
        let (wait, news) = outbox.settle(notice, Answer::Taken, now);
        assert_eq!((wait.as_secs(), news), (0, Some(News::Works { failed_s: 0, lost: 0 })));
        outbox.note(Change::Changed, &alert(1), now);
        let notice = outbox.take(now).unwrap();
        outbox.settle(notice, Answer::Refused { why: "answered 404".to_owned() }, now);
        assert_eq!(outbox.take(now), None);
        let counts = outbox.counts();
        assert_eq!((counts.sent, counts.failed, counts.waiting, counts.is_failing), (1, 3, 0, true));
        assert_eq!(Loss::ALL.map(|loss| counts.lost(loss)), [0, 1, 0]);
    }

    #[test]
    fn an_alert_says_what_is_wrong_and_how_much_is_lost() {
        let mut outbox = outbox();
        let at = |seconds| Time::from_nanos(seconds * fusion::time::SECOND);
        let text = |outbox: &Outbox| outbox.trouble("mqtt", at(60)).map(|trouble| trouble.text);
        outbox.fails("closed".to_owned(), at(0));
        assert_eq!(text(&outbox).as_deref(), Some("mqtt: alerts are not delivered: closed"));
        outbox.lose(Loss::Refused);
        assert_eq!(text(&outbox).as_deref(), Some("mqtt: one notice of an alert is lost: closed"));
        outbox.lose(Loss::Refused);
        assert_eq!(text(&outbox).as_deref(), Some("mqtt: 2 notices of alerts are lost: closed"));
        outbox.works(at(61));
        assert_eq!(text(&outbox), None);
    }

    #[test]
    fn a_receiver_that_is_gone_costs_a_bounded_queue() {
        let mut outbox = outbox();
        for id in 0..2_000 {
            outbox.note(Change::Began, &alert(id), Time::default());
        }
        let counts = outbox.counts();
        assert_eq!((counts.waiting, counts.lost(Loss::Full)), (WAITING, 2_000 - WAITING as u64));
        let summary = outbox.take(Time::default()).unwrap();
        assert_eq!((summary.len(), outbox.counts().waiting), (WAITING, 0));
        assert_eq!(summary.notices().next().unwrap().alert.id, 2_000 - WAITING as u64);
        // The end is sent only of alerts whose beginning was sent.
        outbox.settle(summary, Answer::Taken, Time::default());
        assert_eq!(outbox.counts().sent, WAITING as u64);
        outbox.note(Change::Ended, &alert(0), Time::default());
        outbox.note(Change::Ended, &alert(1_999), Time::default());
        let end = outbox.take(Time::default()).unwrap();
        assert_eq!(end.single().map(|notice| notice.alert.id), Some(1_999));
        assert_eq!(outbox.take(Time::default()), None);
    }
}
