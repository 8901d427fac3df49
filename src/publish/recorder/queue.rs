//! The way into the recorder. It never makes the engine wait; where something did not fit, the recorder is told.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;

use super::Recorded;
use crate::time::Time;

/// Where the engine hands what is to be recorded.
#[derive(Debug)]
pub struct RecorderQueue {
    sender: SyncSender<Recorded>,
    counters: Arc<Counters>,
    /// What did not fit, until then; the recorder is told as soon as something fits again.
    gap: Option<Time>,
}

impl RecorderQueue {
    pub(super) fn new(sender: SyncSender<Recorded>, counters: Arc<Counters>) -> Self {
        Self { sender, counters, gap: None }
    }

    /// Hands it over where there is room. Where there is none it is lost, which is counted, and marked in the recording.
    pub fn offer(&mut self, recorded: Recorded) {
        let time = match recorded {
            Recorded::Input { received: time, .. } | Recorded::Output { due: time, .. } => Some(time),
            Recorded::Gap { until } => Some(until),
            Recorded::Numbered { .. }
            | Recorded::Registered { .. }
            | Recorded::Decided { .. }
            | Recorded::Held { .. } => None,
        };
        if let Some(until) = self.gap
            && self.has_room_for(Recorded::Gap { until })
        {
            self.gap = None;
        }
        // Nothing overtakes the mark.
        if self.gap.is_some() || !self.has_room_for(recorded) {
            self.gap = self.gap.max(time);
            self.counters.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Hands over what can as well come later; whether there was room.
    pub fn has_room_for(&self, recorded: Recorded) -> bool {
        self.sender.try_send(recorded).is_ok()
    }

    /// Hands it over and waits for room, for whoever has time; whether the recorder still runs.
    pub fn wait(&self, recorded: Recorded) -> bool {
        self.sender.send(recorded).is_ok()
    }

    /// What the recorder did so far.
    pub fn counts(&self) -> RecorderCounts {
        self.counters.now()
    }
}

/// What a recorder did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecorderCounts {
    /// Datagrams written.
    pub written: u64,
    /// Datagrams lost because the disk failed.
    pub unwritten: u64,
    /// Datagrams lost because the disk was too slow.
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
}

impl Counters {
    pub(super) fn now(&self) -> RecorderCounts {
        RecorderCounts {
            written: self.written.load(Ordering::Relaxed),
            unwritten: self.unwritten.load(Ordering::Relaxed),
            lost: self.lost.load(Ordering::Relaxed),
            failing: self.failing.load(Ordering::Relaxed),
        }
    }
}
