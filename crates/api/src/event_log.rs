//! Log of the stream: the last encoded events, which each reader follows at its own pace.
//!
//! There is one writer and any number of readers, and no one waits for another. A reader that falls behind is notified and starts
//! again.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

use super::payload::Payload;
use super::slot_json::SlotJson;

/// Number of slots kept: 16 s, as in the hub. Events between them are kept too.
const SLOTS: usize = 64;
/// Number of slots whose JSON is kept: 2 s, after which only slow readers still need it.
const WRITTEN: usize = 8;
/// Number of events kept while no slots arrive.
const EVENTS: usize = 512;

/// An event for readers of the stream.
#[derive(Clone, Debug)]
pub enum StreamEvent {
    /// A new slot.
    Slot(Arc<SlotJson>),
    /// A slot earlier than the previous one: a replay jumped back, and all readers start again.
    Back(Arc<SlotJson>),
    /// Ended tracks, for readers without a filter. Readers with a filter determine their own.
    Ended(Payload),
    /// An event for all readers.
    Broadcast(Payload),
    /// State of the sensor with this index, for readers that want the sensor.
    Sensor(usize, Payload),
    /// Slots were lost before they reached the log: all readers start again.
    Lost,
    /// The last event: the service stops.
    Closed(Payload),
}

/// The most recent events.
#[derive(Debug)]
pub struct EventLog {
    memory: Mutex<KeptEvents>,
    last: watch::Sender<u64>,
}

#[derive(Debug, Default)]
struct KeptEvents {
    events: VecDeque<StreamEvent>,
    slots: usize,
    /// Number of the newest event; the first one is 1.
    last: u64,
    latest: Option<Arc<SlotJson>>,
}

/// Result of looking up the event after a position in the log.
#[derive(Clone, Debug)]
pub enum NextEvent {
    /// The next event.
    Event(StreamEvent),
    /// No further event has arrived yet.
    Nothing,
    /// The next event is no longer kept.
    Forgotten,
}

impl StreamEvent {
    /// Slot of the event, if it has one.
    fn slot(&self) -> Option<&Arc<SlotJson>> {
        match self {
            Self::Slot(slot) | Self::Back(slot) => Some(slot),
            _ => None,
        }
    }
}

impl Default for EventLog {
    fn default() -> Self {
        Self { memory: Mutex::default(), last: watch::Sender::new(0) }
    }
}

impl EventLog {
    /// Number of the next event. Only the single writer can rely on it.
    pub fn next_number(&self) -> u64 {
        self.memory().last + 1
    }

    /// Appends an event and wakes the waiting readers.
    pub fn push(&self, event: StreamEvent) {
        let mut memory = self.memory();
        if let Some(slot) = event.slot() {
            memory.latest = Some(slot.clone());
            memory.slots += 1;
        }
        memory.events.push_back(event);
        memory.last += 1;
        memory
            .events
            .iter()
            .rev()
            .filter_map(StreamEvent::slot)
            .nth(WRITTEN)
            .into_iter()
            .for_each(|old| old.discard_json());
        while memory.slots > SLOTS || memory.events.len() > EVENTS {
            if memory.events.pop_front().is_some_and(|event| event.slot().is_some()) {
                memory.slots -= 1;
            }
        }
        let last = memory.last;
        drop(memory);
        self.last.send_replace(last);
    }

    /// The event after event `number`.
    pub fn after(&self, number: u64) -> NextEvent {
        let memory = self.memory();
        let Some(behind) = memory.last.checked_sub(number) else { return NextEvent::Forgotten };
        if behind == 0 {
            return NextEvent::Nothing;
        }
        let index = usize::try_from(behind).ok().and_then(|behind| memory.events.len().checked_sub(behind));
        index.map_or(NextEvent::Forgotten, |index| NextEvent::Event(memory.events[index].clone()))
    }

    /// The newest slot, and the number of the newest event.
    pub fn latest(&self) -> (u64, Option<Arc<SlotJson>>) {
        let memory = self.memory();
        (memory.last, memory.latest.clone())
    }

    /// Slots kept up to event `number`, oldest first.
    pub fn slots_until(&self, number: u64) -> Vec<Arc<SlotJson>> {
        let memory = self.memory();
        let newer = usize::try_from(memory.last.saturating_sub(number)).unwrap_or(usize::MAX);
        let until = memory.events.len().saturating_sub(newer);
        memory.events.iter().take(until).filter_map(StreamEvent::slot).cloned().collect()
    }

    /// Channel that reports the number of each new event.
    pub fn watch(&self) -> watch::Receiver<u64> {
        self.last.subscribe()
    }

    /// Locks the memory. A panic of another holder leaves no inconsistent state.
    fn memory(&self) -> MutexGuard<'_, KeptEvents> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
