//! Queue to the recorder. It never makes the engine wait; lost items are marked as gaps in the recording.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;

use super::recorded::RecordingItem;
use fusion::time::Time;

/// The engine's end of the queue.
#[derive(Debug)]
pub struct RecorderQueue {
    sender: SyncSender<RecordingItem>,
    counters: Arc<RecorderCounters>,
    /// Latest time of the lost items. The gap is recorded once the queue has space for more than a few datagrams.
    gap: Option<Time>,
    /// Maximum number of waiting items at which recording resumes after a gap. Each gap begins new files. Resuming as soon
    /// as a single item fits would end them with the next item, and a recorder busy beginning files would fall behind
    /// further.
    resume: usize,
}

impl RecorderQueue {
    /// `sender` has the capacity `capacity`.
    pub(super) fn new(
        sender: SyncSender<RecordingItem>,
        capacity: usize,
        counters: Arc<RecorderCounters>,
    ) -> Self {
        Self { sender, counters, gap: None, resume: capacity / 4 }
    }

    /// Adds an item. If the queue is full the item is lost, counted, and marked as a gap in the recording.
    pub fn offer(&mut self, recorded: RecordingItem) {
        let time = match recorded {
            RecordingItem::Input { received: time, .. } | RecordingItem::Output { due: time, .. } => {
                Some(time)
            }
            RecordingItem::Gap(until) => Some(until),
            RecordingItem::Numbered(_)
            | RecordingItem::Registered(_)
            | RecordingItem::Decided(_)
            | RecordingItem::Checkpoint(_)
            | RecordingItem::Published(_)
            | RecordingItem::Correlations(_) => None,
        };
        if let Some(until) = self.gap
            && self.counters.waiting.load(Ordering::Relaxed) <= self.resume
            && self.try_add(RecordingItem::Gap(until))
        {
            self.gap = None;
        }
        // No item may precede the gap.
        if self.gap.is_some() || !self.try_add(recorded) {
            self.gap = self.gap.max(time);
            self.counters.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Adds an item that may also be added later; returns whether there was space.
    pub fn try_add(&self, recorded: RecordingItem) -> bool {
        // Counted before it is sent, so that the receiver never takes an uncounted item.
        self.counters.waiting.fetch_add(1, Ordering::Relaxed);
        let is_added = self.sender.try_send(recorded).is_ok();
        if !is_added {
            self.counters.taken();
        }
        is_added
    }

    /// Adds an item, and waits for space; returns whether the recorder still runs.
    pub fn add(&self, recorded: RecordingItem) -> bool {
        self.counters.waiting.fetch_add(1, Ordering::Relaxed);
        self.sender.send(recorded).is_ok()
    }

    /// Counts of the recorder so far.
    pub fn counts(&self) -> RecorderCounts {
        self.counters.now()
    }

    /// A reader of the same counts.
    pub fn meter(&self) -> RecorderMeter {
        RecorderMeter(self.counters.clone())
    }
}

/// Reads the counts of a recorder.
#[derive(Clone, Debug)]
pub struct RecorderMeter(Arc<RecorderCounters>);

impl RecorderMeter {
    /// Counts so far.
    pub fn counts(&self) -> RecorderCounts {
        self.0.now()
    }
}

/// Counts of a recorder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecorderCounts {
    /// Datagrams written.
    pub written: u64,
    /// Datagrams lost because the disk failed.
    pub unwritten: u64,
    /// Datagrams lost because the recorder was too slow.
    pub lost: u64,
    /// Whether the disk fails, so that recording is suspended.
    pub failing: bool,
}

#[derive(Debug, Default)]
pub(super) struct RecorderCounters {
    pub(super) written: AtomicU64,
    pub(super) unwritten: AtomicU64,
    pub(super) lost: AtomicU64,
    pub(super) failing: AtomicBool,
    /// Number of items in the queue.
    waiting: AtomicUsize,
}

impl RecorderCounters {
    /// Counts an item taken from the queue.
    pub(super) fn taken(&self) {
        self.waiting.fetch_sub(1, Ordering::Relaxed);
    }

    pub(super) fn now(&self) -> RecorderCounts {
        RecorderCounts {
            written: self.written.load(Ordering::Relaxed),
            unwritten: self.unwritten.load(Ordering::Relaxed),
            lost: self.lost.load(Ordering::Relaxed),
            failing: self.failing.load(Ordering::Relaxed),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, sync_channel};

    use super::*;

    const CAPACITY: usize = 64;

    fn output(number: i64) -> RecordingItem {
        RecordingItem::Output { due: Time::from_nanos(number), payload: Vec::new() }
    }

    /// Takes items like the recorder; returns the number of gaps among them.
    fn take(queue: &Receiver<RecordingItem>, counters: &RecorderCounters, count: usize) -> usize {
        let taken = queue.try_iter().take(count).inspect(|_| counters.taken());
        taken.filter(|recorded| matches!(recorded, RecordingItem::Gap(_))).count()
    }

    #[test]
    fn slow_recorder_has_few_gaps_and_counts_each_loss() {
        let (sender, receiver) = sync_channel(CAPACITY);
        let counters = Arc::<RecorderCounters>::default();
        let mut queue = RecorderQueue::new(sender, CAPACITY, counters.clone());
        let mut gaps = 0;
        for number in 0..10_000 {
            queue.offer(output(number));
            if number % 2 == 0 {
                gaps += take(&receiver, &counters, 1);
            }
        }
        let left = counters.waiting.load(Ordering::Relaxed);
        gaps += take(&receiver, &counters, left);
        // A gap whenever a single item fits would give thousands.
        assert!((10..200).contains(&gaps), "{gaps}");
        assert_eq!(counters.now().lost as usize, 10_000 - (5_000 + left - gaps));
    }

    #[test]
    fn recording_resumes_when_the_queue_has_drained() {
        let (sender, receiver) = sync_channel(CAPACITY);
        let counters = Arc::<RecorderCounters>::default();
        let mut queue = RecorderQueue::new(sender, CAPACITY, counters.clone());
        (0..100).for_each(|number| queue.offer(output(number)));
        assert_eq!(counters.now().lost, 36);
        assert_eq!(take(&receiver, &counters, CAPACITY), 0);
        queue.offer(output(100));
        assert_eq!(receiver.try_recv(), Ok(RecordingItem::Gap(Time::from_nanos(99))));
        assert_eq!(receiver.try_recv(), Ok(output(100)));
        assert_eq!(counters.now().lost, 36);
    }
}
