//! An outbox with the clock, the log, and the waking of its task.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tracing::{info, warn};

use super::counts::{Counts, Loss};
use super::outbox::Outbox;
use super::second::Second;
use crate::config::PictureKind;
use crate::live::{Trouble, now};
use crate::net::health::News;

/// Between the follower of the hub and the task of one sink.
#[derive(Debug)]
pub(super) struct Desk {
    name: String,
    /// What it wants.
    pub(super) picture: PictureKind,
    outbox: Mutex<Outbox<Arc<Second>>>,
    wake: Notify,
}

impl Desk {
    /// `name`: in the log, in `/metrics` and in alerts.
    pub(super) fn new(name: String, picture: PictureKind) -> Self {
        Self { name, picture, outbox: Mutex::default(), wake: Notify::new() }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// A panic elsewhere leaves nothing half done in here.
    fn outbox(&self) -> MutexGuard<'_, Outbox<Arc<Second>>> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a second; never waits.
    pub(super) fn note(&self, second: Arc<Second>) {
        self.outbox().push(second);
        self.wake.notify_one();
    }

    pub(super) fn counts(&self) -> Counts {
        self.outbox().counts()
    }

    pub(super) fn trouble(&self) -> Option<Trouble> {
        self.outbox().trouble(&self.name, now())
    }

    /// The next second, where there is one.
    pub(super) fn take(&self) -> Option<Arc<Second>> {
        self.outbox().take()
    }

    /// Waits for the next second; what waits stays where this is dropped.
    pub(super) async fn next(&self) -> Arc<Second> {
        loop {
            if let Some(second) = self.take() {
                return second;
            }
            self.wake.notified().await;
        }
    }

    /// A connection begins.
    pub(super) fn begin(&self) {
        self.outbox().begin();
    }

    /// The receiver is there.
    pub(super) fn works(&self) {
        let news = self.outbox().works(now());
        self.log(news);
    }

    /// So many messages are sent.
    pub(super) fn sent(&self, messages: u64) {
        self.outbox().sent(messages);
    }

    /// Seconds that it never got to see.
    pub(super) fn missed(&self, seconds: usize) {
        self.outbox().missed(seconds);
    }

    /// A second that the receiver has not agreed to.
    pub(super) fn withheld(&self) {
        self.outbox().withheld();
    }

    /// Tracks that the format cannot hold.
    pub(super) fn left_out(&self, tracks: u64) {
        self.outbox().left_out(tracks);
    }

    /// An attempt failed, and where `loss` says so a second was lost with it; how long to wait then.
    pub(super) fn fails(&self, why: String, loss: Option<Loss>) -> Duration {
        let (wait, news) = self.outbox().fails(why, loss, now());
        self.log(news);
        wait
    }

    /// A line where it begins to fail, and one where it works again.
    fn log(&self, news: Option<News>) {
        let sink = &self.name;
        match news {
            None => {}
            Some(News::Fails(why)) => warn!(sink, why, "the picture is not delivered: tried again"),
            Some(News::Works { failed_s, .. }) => info!(sink, failed_s, "the picture is delivered again"),
        }
    }
}
