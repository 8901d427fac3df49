//! The way into the recorder. It never makes the engine wait; where something did not fit, the recorder is told.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;

use super::recorded::Recorded;
use fusion::time::Time;

/// Where the engine hands what is to be recorded.
#[derive(Debug)]
pub struct RecorderQueue {
    sender: SyncSender<Recorded>,
    counters: Arc<Counters>,
    /// The latest time of what did not fit; the recorder hears of it once there is room for more than a few datagrams.
    gap: Option<Time>,
    /// Most items that may wait when it goes on after a gap. Each gap begins new files: going on as soon as a single item
    /// fits would end them with the next, and a recorder that is busy beginning files falls behind ever more.
    resume: usize,
}

impl RecorderQueue {
    /// `sender` has room for `capacity`.
    pub(super) fn new(sender: SyncSender<Recorded>, capacity: usize, counters: Arc<Counters>) -> Self {
        Self { sender, counters, gap: None, resume: capacity / 4 }
    }

    /// Hands an item over. Where there is no room it is lost, which is counted, and marked in the recording.
    pub fn offer(&mut self, recorded: Recorded) {
        let time = match recorded {
            Recorded::Input { received: time, .. } | Recorded::Output { due: time, .. } => Some(time),
            Recorded::Gap(until) => Some(until),
            Recorded::Numbered(_)
            | Recorded::Registered(_)
            | Recorded::Decided(_)
            | Recorded::Checkpoint(_)
            | Recorded::Published(_)
            | Recorded::Correlations(_) => None,
        };
        if let Some(until) = self.gap
            && self.counters.waiting.load(Ordering::Relaxed) <= self.resume
            && self.has_room_for(Recorded::Gap(until))
        {
            self.gap = None;
        }
        // Nothing overtakes the mark.
        if self.gap.is_some() || !self.has_room_for(recorded) {
            self.gap = self.gap.max(time);
            self.counters.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Hands over an item that may as well come later; whether there was room.
    pub fn has_room_for(&self, recorded: Recorded) -> bool {
        // Counted before it is there, so that the other end never takes one that is not counted.
        self.counters.waiting.fetch_add(1, Ordering::Relaxed);
        let has_room = self.sender.try_send(recorded).is_ok();
        if !has_room {
            self.counters.taken();
        }
        has_room
    }

    /// Hands an item over and waits for room; whether the recorder still runs.
    pub fn wait(&self, recorded: Recorded) -> bool {
        self.counters.waiting.fetch_add(1, Ordering::Relaxed);
        self.sender.send(recorded).is_ok()
    }

    /// What the recorder did so far.
    pub fn counts(&self) -> RecorderCounts {
        self.counters.now()
    }

    /// A reader of the same counts.
    pub fn meter(&self) -> RecorderMeter {
        RecorderMeter(self.counters.clone())
    }
}

/// Reads what a recorder did.
#[derive(Clone, Debug)]
pub struct RecorderMeter(Arc<Counters>);

impl RecorderMeter {
    /// What it did by now.
    pub fn counts(&self) -> RecorderCounts {
        self.0.now()
    }
}

/// What a recorder did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecorderCounts {
    /// Datagrams written.
    pub written: u64,
    /// Datagrams lost because the disk failed.
    pub unwritten: u64,
    /// Datagrams lost because the recorder did not keep up.
    pub lost: u64,
    /// Whether the disk fails, and nothing is recorded.
    pub failing: bool,
}

#[derive(Debug, Default)]
pub(super) struct Counters {
    pub(super) written: AtomicU64,
    pub(super) unwritten: AtomicU64,
    pub(super) lost: AtomicU64,
    pub(super) failing: AtomicBool,
    /// What waits in the queue.
    waiting: AtomicUsize,
}

impl Counters {
    /// Notes that an item was taken from the queue.
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

    fn output(number: i64) -> Recorded {
        Recorded::Output { due: Time::from_nanos(number), payload: Vec::new() }
    }

    /// As the recorder takes them; how many of these were gaps.
    fn take(queue: &Receiver<Recorded>, counters: &Counters, count: usize) -> usize {
        let taken = queue.try_iter().take(count).inspect(|_| counters.taken());
        taken.filter(|recorded| matches!(recorded, Recorded::Gap(_))).count()
    }

    #[test]
    fn a_recorder_that_takes_half_of_what_comes_is_told_of_few_gaps_and_each_loss_is_counted() {
        let (sender, receiver) = sync_channel(CAPACITY);
        let counters = Arc::<Counters>::default();
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
        // A gap each time that one fits would be thousands.
        assert!((10..200).contains(&gaps), "{gaps}");
        assert_eq!(counters.now().lost as usize, 10_000 - (5_000 + left - gaps));
    }

    #[test]
    fn it_goes_on_by_itself_when_what_waited_has_been_taken() {
        let (sender, receiver) = sync_channel(CAPACITY);
        let counters = Arc::<Counters>::default();
        let mut queue = RecorderQueue::new(sender, CAPACITY, counters.clone());
        (0..100).for_each(|number| queue.offer(output(number)));
        assert_eq!(counters.now().lost, 36);
        assert_eq!(take(&receiver, &counters, CAPACITY), 0);
        queue.offer(output(100));
        assert_eq!(receiver.try_recv(), Ok(Recorded::Gap(Time::from_nanos(99))));
        assert_eq!(receiver.try_recv(), Ok(output(100)));
        assert_eq!(counters.now().lost, 36);
    }
}
