//! Delivery queue of one receiver: an outbox with the clock, the log, and the notification of its task.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tracing::{info, warn};

use super::batch::NoticeBatch;
use super::counts::NoticeCounts;
use super::mirror::{Mirror, Topic};
use super::outbox::NoticeOutbox;
use crate::live::{Alert, AlertChange, ServiceFault, now};
use crate::net::health::{DeliveryResult, HealthChange};
use fusion::time::Time;

/// Queue between the observer and the task of one receiver.
#[derive(Debug)]
pub(super) struct NoticeQueue {
    name: String,
    outbox: Mutex<NoticeOutbox>,
    wake: Notify,
}

/// Next message for a broker.
#[derive(Debug)]
pub(super) enum PendingDelivery {
    /// The retained message of a topic; `None` clears it.
    State(Topic, Option<Arc<Alert>>),
    /// An event.
    Event(NoticeBatch),
}

impl NoticeQueue {
    pub(super) fn new(name: String, outbox: NoticeOutbox) -> Self {
        Self { name, outbox: Mutex::new(outbox), wake: Notify::new() }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// A poisoned lock is usable: no update of this state can be left half done.
    fn outbox(&self) -> MutexGuard<'_, NoticeOutbox> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn note(&self, change: AlertChange, alert: &Arc<Alert>, at: Time) {
        self.outbox().note(change, alert, at);
        self.wake.notify_one();
    }

    pub(super) fn counts(&self) -> NoticeCounts {
        self.outbox().counts()
    }

    pub(super) fn trouble(&self, now: Time) -> Option<ServiceFault> {
        self.outbox().trouble(&self.name, now)
    }

    /// The next delivery, if there is one.
    pub(super) fn take(&self) -> Option<NoticeBatch> {
        self.outbox().take(now())
    }

    /// Waits for the next delivery.
    pub(super) async fn next(&self) -> NoticeBatch {
        loop {
            if let Some(batch) = self.take() {
                return batch;
            }
            self.wake.notified().await;
        }
    }

    /// The next message for a broker, if there is one: critical alerts first, and retained messages before events.
    pub(super) fn take_owed(&self) -> Option<PendingDelivery> {
        let mut outbox = self.outbox();
        let is_event = outbox.is_urgent() && !outbox.mirror.as_ref().is_some_and(Mirror::is_urgent);
        let state = outbox.mirror.as_mut().filter(|_| !is_event).and_then(Mirror::take);
        let state = state.map(|(topic, alert)| PendingDelivery::State(topic, alert));
        state.or_else(|| outbox.take(now()).map(PendingDelivery::Event))
    }

    /// Waits for the next message for a broker.
    pub(super) async fn owed(&self) -> PendingDelivery {
        loop {
            if let Some(owed) = self.take_owed() {
                return owed;
            }
            self.wake.notified().await;
        }
    }

    /// Calls `then` with the state of the retained messages, if the receiver is a broker.
    pub(super) fn mirrored(&self, then: impl FnOnce(&mut Mirror)) {
        if let Some(mirror) = &mut self.outbox().mirror {
            then(mirror);
        }
    }

    /// Records the result of a delivery; returns the pause before the next.
    pub(super) fn settle(&self, batch: NoticeBatch, answer: DeliveryResult) -> Duration {
        let (wait, news) = self.outbox().settle(batch, answer, now());
        self.tell(news);
        wait
    }

    /// Records that the receiver can be reached.
    pub(super) fn works(&self) {
        let news = self.outbox().works(now());
        self.tell(news);
    }

    /// Records a failed attempt; returns the pause before the next.
    pub(super) fn fails(&self, why: String) -> Duration {
        let mut outbox = self.outbox();
        let news = outbox.fails(why, now());
        let wait = outbox.wait();
        drop(outbox);
        self.tell(news);
        wait
    }

    /// Logs when the receiver begins to fail, and when it works again.
    fn tell(&self, news: Option<HealthChange>) {
        let receiver = &self.name;
        match news {
            None => {}
            Some(HealthChange::Fails(why)) => warn!(receiver, why, "alerts are not delivered: tried again"),
            Some(HealthChange::Works { failed_s, lost: 0 }) => {
                info!(receiver, failed_s, "alerts are delivered again");
            }
            Some(HealthChange::Works { failed_s, lost }) => {
                warn!(receiver, failed_s, lost, "alerts are delivered again; some notices are lost");
            }
        }
    }
}
