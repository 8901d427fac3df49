//! An outbox with the clock, the log, and the waking of its task.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tracing::{info, warn};

use super::batch::Batch;
use super::counts::Counts;
use super::mirror::{Mirror, Topic};
use super::outbox::Outbox;
use crate::live::{Alert, Change, Trouble, now};
use crate::net::health::{Answer, News};
use fusion::time::Time;

/// Between the observer and the task of one receiver.
#[derive(Debug)]
pub(super) struct Desk {
    name: String,
    outbox: Mutex<Outbox>,
    wake: Notify,
}

/// What a broker is owed next.
#[derive(Debug)]
pub(super) enum Owed {
    /// What is retained there; `None`: nothing.
    State(Topic, Option<Arc<Alert>>),
    /// An event.
    Event(Batch),
}

impl Desk {
    pub(super) fn new(name: String, outbox: Outbox) -> Self {
        Self { name, outbox: Mutex::new(outbox), wake: Notify::new() }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// A panic elsewhere leaves nothing half done in here.
    fn outbox(&self) -> MutexGuard<'_, Outbox> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn note(&self, change: Change, alert: &Arc<Alert>, at: Time) {
        self.outbox().note(change, alert, at);
        self.wake.notify_one();
    }

    pub(super) fn counts(&self) -> Counts {
        self.outbox().counts()
    }

    pub(super) fn trouble(&self, now: Time) -> Option<Trouble> {
        self.outbox().trouble(&self.name, now)
    }

    /// The next delivery, where there is one.
    pub(super) fn take(&self) -> Option<Batch> {
        self.outbox().take(now())
    }

    /// Waits for the next delivery.
    pub(super) async fn next(&self) -> Batch {
        loop {
            if let Some(batch) = self.take() {
                return batch;
            }
            self.wake.notified().await;
        }
    }

    /// The next message for a broker, where there is one: critical alerts first, and retained messages before events.
    pub(super) fn take_owed(&self) -> Option<Owed> {
        let mut outbox = self.outbox();
        let is_event = outbox.is_urgent() && !outbox.mirror.as_ref().is_some_and(Mirror::is_urgent);
        let state = outbox.mirror.as_mut().filter(|_| !is_event).and_then(Mirror::take);
        let state = state.map(|(topic, alert)| Owed::State(topic, alert));
        state.or_else(|| outbox.take(now()).map(Owed::Event))
    }

    /// Waits for what a broker is owed.
    pub(super) async fn owed(&self) -> Owed {
        loop {
            if let Some(owed) = self.take_owed() {
                return owed;
            }
            self.wake.notified().await;
        }
    }

    /// What is retained at the broker, which is the only one to have that.
    pub(super) fn mirrored(&self, then: impl FnOnce(&mut Mirror)) {
        if let Some(mirror) = &mut self.outbox().mirror {
            then(mirror);
        }
    }

    /// Settles a delivery; returns how long to wait then.
    pub(super) fn settle(&self, batch: Batch, answer: Answer) -> Duration {
        let (wait, news) = self.outbox().settle(batch, answer, now());
        self.tell(news);
        wait
    }

    /// The receiver is there.
    pub(super) fn works(&self) {
        let news = self.outbox().works(now());
        self.tell(news);
    }

    /// An attempt failed; how long to wait then.
    pub(super) fn fails(&self, why: String) -> Duration {
        let mut outbox = self.outbox();
        let news = outbox.fails(why, now());
        let wait = outbox.wait();
        drop(outbox);
        self.tell(news);
        wait
    }

    /// A line where it begins to fail, and one where it works again.
    fn tell(&self, news: Option<News>) {
        let receiver = &self.name;
        match news {
            None => {}
            Some(News::Fails(why)) => warn!(receiver, why, "alerts are not delivered: tried again"),
            Some(News::Works { failed_s, lost: 0 }) => {
                info!(receiver, failed_s, "alerts are delivered again");
            }
            Some(News::Works { failed_s, lost }) => {
                warn!(receiver, failed_s, lost, "alerts are delivered again; some notices are lost");
            }
        }
    }
}
