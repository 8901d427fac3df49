//! Conflicts for readers: the evaluation of each second, and a count of those that came too late.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::{broadcast, watch};

use picture::conflicts::Outlook;

/// Maximum number of evaluations that a reader may fall behind.
const KEPT: usize = 16;

/// Duration and losses of the evaluations.
#[derive(Debug, Default)]
struct ConflictCounts {
    dropped: AtomicU64,
    spent_us: AtomicU64,
}

/// The readers' end; cheap to clone.
#[derive(Clone, Debug)]
pub struct ConflictReports {
    all: broadcast::Sender<Arc<Outlook>>,
    latest: watch::Receiver<Option<Arc<Outlook>>>,
    counts: Arc<ConflictCounts>,
}

/// The end of the only writer.
#[derive(Debug)]
pub struct ConflictPublisher {
    all: broadcast::Sender<Arc<Outlook>>,
    latest: watch::Sender<Option<Arc<Outlook>>>,
    counts: Arc<ConflictCounts>,
}

/// Both ends.
pub(super) fn conflict_reports() -> (ConflictPublisher, ConflictReports) {
    let (all, _) = broadcast::channel(KEPT);
    let (writer, latest) = watch::channel(None);
    let counts = Arc::<ConflictCounts>::default();
    (
        ConflictPublisher { all: all.clone(), latest: writer, counts: counts.clone() },
        ConflictReports { all, latest, counts },
    )
}

impl ConflictReports {
    /// The latest evaluation; `None` before the first, and if conflicts are not evaluated.
    pub fn latest(&self) -> Option<Arc<Outlook>> {
        self.latest.borrow().clone()
    }

    /// Subscribes to all evaluations from now on.
    pub fn all(&self) -> broadcast::Receiver<Arc<Outlook>> {
        self.all.subscribe()
    }

    /// Number of evaluations not published because they came too late.
    pub fn dropped(&self) -> u64 {
        self.counts.dropped.load(Ordering::Relaxed)
    }

    /// Duration of the latest evaluation.
    pub fn spent(&self) -> Duration {
        Duration::from_micros(self.counts.spent_us.load(Ordering::Relaxed))
    }
}

impl ConflictPublisher {
    /// Publishes an evaluation; never waits.
    pub fn publish(&self, outlook: Outlook) {
        let outlook = Arc::new(outlook);
        self.latest.send_replace(Some(outlook.clone()));
        // Fails only without subscribers.
        let _ = self.all.send(outlook);
    }

    /// Records the duration of an evaluation, published or not.
    pub fn note_spent(&self, spent: Duration) {
        let spent_us = u64::try_from(spent.as_micros()).unwrap_or(u64::MAX);
        self.counts.spent_us.store(spent_us, Ordering::Relaxed);
    }

    /// Counts an evaluation that came too late to be published.
    pub fn drop_late(&self) {
        self.counts.dropped.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of evaluations that came too late.
    pub fn dropped(&self) -> u64 {
        self.counts.dropped.load(Ordering::Relaxed)
    }
}
