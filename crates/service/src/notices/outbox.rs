//! Outbox of one receiver: queue, health and counts. Sans-IO.

use std::sync::Arc;
use std::time::Duration;

use super::batch::NoticeBatch;
use super::counts::{NoticeCounts, NoticeLoss};
use super::mirror::Mirror;
use super::queue::{ALIKE, Notice, PendingNotices, WAITING};
use super::selection::NoticeSelection;
use crate::live::{Alert, AlertChange, ServiceFault, Severity};
use crate::net::health::{DeliveryResult, HealthChange, NotableFailure, ReceiverHealth};
use fusion::time::Time;

#[derive(Debug)]
pub(super) struct NoticeOutbox {
    pub(super) selection: NoticeSelection,
    queue: PendingNotices,
    /// Active alerts to be retained, if the receiver is a broker.
    pub(super) mirror: Option<Mirror>,
    health: ReceiverHealth,
    counts: NoticeCounts,
}

impl NoticeOutbox {
    pub(super) fn new(selection: NoticeSelection, mirror: Option<Mirror>) -> Self {
        let queue = PendingNotices::new(WAITING, ALIKE);
        Self { selection, queue, mirror, health: ReceiverHealth::default(), counts: NoticeCounts::default() }
    }

    /// Adds a change of an alert.
    pub(super) fn note(&mut self, change: AlertChange, alert: &Arc<Alert>, at: Time) {
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
    pub(super) fn take(&mut self, now: Time) -> Option<NoticeBatch> {
        let Self { queue, counts, health, .. } = self;
        queue.take(now, |loss| {
            counts.lose(loss);
            health.lose();
        })
    }

    /// Records the result of a delivery. Returns the pause before the next, and news for the log.
    pub(super) fn settle(
        &mut self,
        batch: NoticeBatch,
        answer: DeliveryResult,
        now: Time,
    ) -> (Duration, Option<HealthChange>) {
        match answer {
            DeliveryResult::Taken => {
                self.counts.sent += batch.len() as u64;
                (Duration::ZERO, self.works(now))
            }
            DeliveryResult::Later { why, after } => {
                let news = self.fails(why, now);
                let dropped = self.queue.put_back(batch);
                self.drop_waiting(dropped);
                (self.health.wait(after), news)
            }
            DeliveryResult::Refused { why } => {
                let news = self.fails(why, now);
                batch.notices().for_each(|_| self.lose(NoticeLoss::Refused));
                (self.health.wait(None), news)
            }
        }
    }

    /// Records that the receiver can be reached.
    pub(super) fn works(&mut self, now: Time) -> Option<HealthChange> {
        self.health.works(now)
    }

    /// Records a failed attempt.
    pub(super) fn fails(&mut self, why: String, now: Time) -> Option<HealthChange> {
        self.counts.failed += 1;
        self.health.fails(why, now)
    }

    /// Pause before the next attempt.
    pub(super) fn wait(&self) -> Duration {
        self.health.wait(None)
    }

    pub(super) fn counts(&self) -> NoticeCounts {
        let mut counts = self.counts;
        (counts.waiting, counts.is_failing) = (self.queue.len(), self.health.is_failing());
        counts
    }

    pub(super) fn trouble(&self, name: &str, now: Time) -> Option<ServiceFault> {
        let NotableFailure { lost, why } = self.health.ailing(now)?;
        let text = match lost {
            0 => format!("{name}: alerts are not delivered: {why}"),
            1 => format!("{name}: one notice of an alert is lost: {why}"),
            lost => format!("{name}: {lost} notices of alerts are lost: {why}"),
        };
        Some(ServiceFault { about: name.to_owned().into(), severity: Severity::Warning, text })
    }

    /// Counts dropped notices. If the beginning of an alert was dropped, its end is not sent either.
    fn drop_waiting(&mut self, dropped: impl IntoIterator<Item = Notice>) {
        for notice in dropped {
            if notice.is_first() {
                self.selection.forget(notice.alert.id);
            }
            self.lose(NoticeLoss::Full);
        }
    }

    fn lose(&mut self, loss: NoticeLoss) {
        self.counts.lose(loss);
        self.health.lose();
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::tests::alert;
    use super::*;

    fn outbox() -> NoticeOutbox {
        NoticeOutbox::new(NoticeSelection::new("webhook:a".to_owned(), None, Severity::Warning), None)
    }

    fn later() -> DeliveryResult {
        DeliveryResult::Later { why: "answered 500".to_owned(), after: None }
    }

    #[test]
    fn failed_notices_are_retried_lost_or_counted() {
        let mut outbox = outbox();
        let now = Time::default();
        outbox.note(AlertChange::Began, &alert(1), now);
        let notice = outbox.take(now).unwrap();
        let (wait, news) = outbox.settle(notice.clone(), later(), now);
        assert_eq!((wait.as_secs(), news), (1, Some(HealthChange::Fails("answered 500".to_owned()))));
        // The same content is the same notice.
        assert_eq!(outbox.take(now), Some(notice.clone()));
        assert_eq!(outbox.settle(notice.clone(), later(), now), (Duration::from_secs(2), None));
        let notice = outbox.take(now).unwrap();
        let (wait, news) = outbox.settle(notice, DeliveryResult::Taken, now);
        assert_eq!((wait.as_secs(), news), (0, Some(HealthChange::Works { failed_s: 0, lost: 0 })));
        outbox.note(AlertChange::Changed, &alert(1), now);
        let notice = outbox.take(now).unwrap();
        outbox.settle(notice, DeliveryResult::Refused { why: "answered 404".to_owned() }, now);
        assert_eq!(outbox.take(now), None);
        let counts = outbox.counts();
        assert_eq!((counts.sent, counts.failed, counts.waiting, counts.is_failing), (1, 3, 0, true));
        assert_eq!(NoticeLoss::ALL.map(|loss| counts.lost(loss)), [0, 1, 0]);
    }

    #[test]
    fn failure_alert_states_reason_and_losses() {
        let mut outbox = outbox();
        let at = |seconds| Time::from_nanos(seconds * fusion::time::SECOND);
        let text = |outbox: &NoticeOutbox| outbox.trouble("mqtt", at(60)).map(|trouble| trouble.text);
        outbox.fails("closed".to_owned(), at(0));
        assert_eq!(text(&outbox).as_deref(), Some("mqtt: alerts are not delivered: closed"));
        outbox.lose(NoticeLoss::Refused);
        assert_eq!(text(&outbox).as_deref(), Some("mqtt: one notice of an alert is lost: closed"));
        outbox.lose(NoticeLoss::Refused);
        assert_eq!(text(&outbox).as_deref(), Some("mqtt: 2 notices of alerts are lost: closed"));
        outbox.works(at(61));
        assert_eq!(text(&outbox), None);
    }

    #[test]
    fn unreachable_receiver_has_a_bounded_queue() {
        let mut outbox = outbox();
        for id in 0..2_000 {
            outbox.note(AlertChange::Began, &alert(id), Time::default());
        }
        let counts = outbox.counts();
        assert_eq!((counts.waiting, counts.lost(NoticeLoss::Full)), (WAITING, 2_000 - WAITING as u64));
        let summary = outbox.take(Time::default()).unwrap();
        assert_eq!((summary.len(), outbox.counts().waiting), (WAITING, 0));
        assert_eq!(summary.notices().next().unwrap().alert.id, 2_000 - WAITING as u64);
        // The end is sent only for alerts whose beginning was sent.
        outbox.settle(summary, DeliveryResult::Taken, Time::default());
        assert_eq!(outbox.counts().sent, WAITING as u64);
        outbox.note(AlertChange::Ended, &alert(0), Time::default());
        outbox.note(AlertChange::Ended, &alert(1_999), Time::default());
        let end = outbox.take(Time::default()).unwrap();
        assert_eq!(end.single().map(|notice| notice.alert.id), Some(1_999));
        assert_eq!(outbox.take(Time::default()), None);
    }
}
