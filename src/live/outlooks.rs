//! Conflicts on their way to readers: each second's outlook, and what became of those that came too late.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::{broadcast, watch};

use crate::conflicts::Outlook;

/// Outlooks that a reader may be behind.
const KEPT: usize = 16;

/// What was spent on conflicts, and what came of it.
#[derive(Debug, Default)]
struct Counts {
    dropped: AtomicU64,
    spent_us: AtomicU64,
}

/// The readers' side; cheap to clone.
#[derive(Clone, Debug)]
pub struct Outlooks {
    all: broadcast::Sender<Arc<Outlook>>,
    latest: watch::Receiver<Option<Arc<Outlook>>>,
    counts: Arc<Counts>,
}

/// The one writer's side.
#[derive(Debug)]
pub struct OutlookWriter {
    all: broadcast::Sender<Arc<Outlook>>,
    latest: watch::Sender<Option<Arc<Outlook>>>,
    counts: Arc<Counts>,
}

/// Both sides.
pub(super) fn outlooks() -> (OutlookWriter, Outlooks) {
    let (all, _) = broadcast::channel(KEPT);
    let (writer, latest) = watch::channel(None);
    let counts = Arc::<Counts>::default();
    (
        OutlookWriter { all: all.clone(), latest: writer, counts: counts.clone() },
        Outlooks { all, latest, counts },
    )
}

impl Outlooks {
    /// The latest; `None` before the first, and where none are made.
    pub fn latest(&self) -> Option<Arc<Outlook>> {
        self.latest.borrow().clone()
    }

    /// Each from now on.
    pub fn all(&self) -> broadcast::Receiver<Arc<Outlook>> {
        self.all.subscribe()
    }

    /// Outlooks that were not shown, because they came too late.
    pub fn dropped(&self) -> u64 {
        self.counts.dropped.load(Ordering::Relaxed)
    }

    /// Time that the latest took.
    pub fn spent(&self) -> Duration {
        Duration::from_micros(self.counts.spent_us.load(Ordering::Relaxed))
    }
}

impl OutlookWriter {
    /// Publishes one; never waits.
    pub fn publish(&self, outlook: Outlook) {
        let outlook = Arc::new(outlook);
        self.latest.send_replace(Some(outlook.clone()));
        // Nobody may be listening.
        let _ = self.all.send(outlook);
    }

    /// Notes how long one took, whatever becomes of it.
    pub fn note_spent(&self, spent: Duration) {
        let spent_us = u64::try_from(spent.as_micros()).unwrap_or(u64::MAX);
        self.counts.spent_us.store(spent_us, Ordering::Relaxed);
    }

    /// One that comes too late is not shown.
    pub fn drop_late(&self) {
        self.counts.dropped.fetch_add(1, Ordering::Relaxed);
    }

    /// How many came too late.
    pub fn dropped(&self) -> u64 {
        self.counts.dropped.load(Ordering::Relaxed)
    }
}
