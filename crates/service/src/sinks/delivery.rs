//! Delivery queue of one sink: an outbox with the clock, the log, and the notification of its task.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tracing::{info, warn};

use super::counts::{SinkCounts, SinkLoss};
use super::outbox::SinkOutbox;
use super::second::PictureSecond;
use crate::live::{ServiceFault, now};
use crate::net::health::HealthChange;
use site::config::PictureKind;

/// Queue between the follower of the hub and the task of one sink.
#[derive(Debug)]
pub(super) struct SinkQueue {
    name: String,
    /// Kind of picture that the sink sends.
    pub(super) picture: PictureKind,
    outbox: Mutex<SinkOutbox<Arc<PictureSecond>>>,
    wake: Notify,
}

impl SinkQueue {
    /// `name` is used in the log, in `/metrics` and in alerts.
    pub(super) fn new(name: String, picture: PictureKind) -> Self {
        Self { name, picture, outbox: Mutex::default(), wake: Notify::new() }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// A poisoned lock is usable: no update of this state can be left half done.
    fn outbox(&self) -> MutexGuard<'_, SinkOutbox<Arc<PictureSecond>>> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a second; never waits.
    pub(super) fn note(&self, second: Arc<PictureSecond>) {
        self.outbox().push(second);
        self.wake.notify_one();
    }

    pub(super) fn counts(&self) -> SinkCounts {
        self.outbox().counts()
    }

    pub(super) fn trouble(&self) -> Option<ServiceFault> {
        self.outbox().trouble(&self.name, now())
    }

    /// The next second, if there is one.
    pub(super) fn take(&self) -> Option<Arc<PictureSecond>> {
        self.outbox().take()
    }

    /// Waits for the next second. Cancelling the wait loses nothing.
    pub(super) async fn next(&self) -> Arc<PictureSecond> {
        loop {
            if let Some(second) = self.take() {
                return second;
            }
            self.wake.notified().await;
        }
    }

    /// Records that a connection begins.
    pub(super) fn begin(&self) {
        self.outbox().begin();
    }

    /// Records that the receiver can be reached.
    pub(super) fn works(&self) {
        let news = self.outbox().works(now());
        self.log(news);
    }

    /// Counts sent messages.
    pub(super) fn sent(&self, messages: u64) {
        self.outbox().sent(messages);
    }

    /// Counts seconds that were missed because the service was overloaded.
    pub(super) fn missed(&self, seconds: usize) {
        self.outbox().missed(seconds);
    }

    /// Counts a second lost because the receiver has not accepted the registration.
    pub(super) fn withheld(&self) {
        self.outbox().withheld();
    }

    /// Counts tracks that the format cannot represent.
    pub(super) fn left_out(&self, tracks: u64) {
        self.outbox().left_out(tracks);
    }

    /// Records a failed attempt, and a second lost with it if `loss` is given. Returns the pause before the next.
    pub(super) fn fails(&self, why: String, loss: Option<SinkLoss>) -> Duration {
        let (wait, news) = self.outbox().fails(why, loss, now());
        self.log(news);
        wait
    }

    /// Logs when the sink begins to fail, and when it works again.
    fn log(&self, news: Option<HealthChange>) {
        let sink = &self.name;
        match news {
            None => {}
            Some(HealthChange::Fails(why)) => warn!(sink, why, "the picture is not delivered: tried again"),
            Some(HealthChange::Works { failed_s, .. }) => {
                info!(sink, failed_s, "the picture is delivered again");
            }
        }
    }
}
