//! The memory of the stream: the last events with their octets, which every reader walks at its own pace.
//!
//! One writer, any number of readers; nobody waits for anybody. A reader that falls behind is told so and starts again.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

use super::payload::Payload;
use super::shown::Shown;

/// Slots that are remembered: 16 s, as in the hub. What happened between them is remembered with them.
const SLOTS: usize = 64;
/// Slots of which the JSON is kept: 2 s, by when all but slow readers have it.
const WRITTEN: usize = 8;
/// Events that are remembered where no slots come.
const EVENTS: usize = 512;

/// Something that readers of the stream are told.
#[derive(Clone, Debug)]
pub enum Event {
    /// A slot.
    Slot(Arc<Shown>),
    /// A slot of an earlier time: a replay went back, and everybody begins anew.
    Back(Arc<Shown>),
    /// Tracks that ended, for readers of everything; others find their own out.
    Ended(Payload),
    /// For everybody.
    Told(Payload),
    /// A sensor's state, by its index, for readers that want that sensor.
    Sensor(usize, Payload),
    /// Slots were lost on the way here: everybody begins anew.
    Lost,
    /// The last one: the service stops.
    Closed(Payload),
}

/// The events of the last moments.
#[derive(Debug)]
pub struct Log {
    memory: Mutex<Memory>,
    last: watch::Sender<u64>,
}

#[derive(Debug, Default)]
struct Memory {
    events: VecDeque<Event>,
    slots: usize,
    /// Number of the newest event; the first one is 1.
    last: u64,
    latest: Option<Arc<Shown>>,
}

/// What comes behind a place in the log.
#[derive(Clone, Debug)]
pub enum Next {
    /// The next event.
    Event(Event),
    /// Nothing yet.
    Nothing,
    /// What came next is forgotten.
    Forgotten,
}

impl Event {
    /// The slot that it brings.
    fn slot(&self) -> Option<&Arc<Shown>> {
        match self {
            Self::Slot(shown) | Self::Back(shown) => Some(shown),
            _ => None,
        }
    }
}

impl Default for Log {
    fn default() -> Self {
        Self { memory: Mutex::default(), last: watch::Sender::new(0) }
    }
}

impl Log {
    /// The number that the next event gets; only its one writer can rely on it.
    pub fn next_number(&self) -> u64 {
        self.memory().last + 1
    }

    /// Appends an event and wakes the readers that wait.
    pub fn push(&self, event: Event) {
        let mut memory = self.memory();
        if let Some(shown) = event.slot() {
            memory.latest = Some(shown.clone());
            memory.slots += 1;
        }
        memory.events.push_back(event);
        memory.last += 1;
        memory
            .events
            .iter()
            .rev()
            .filter_map(Event::slot)
            .nth(WRITTEN)
            .into_iter()
            .for_each(|old| old.forget());
        while memory.slots > SLOTS || memory.events.len() > EVENTS {
            if memory.events.pop_front().is_some_and(|event| event.slot().is_some()) {
                memory.slots -= 1;
            }
        }
        let last = memory.last;
        drop(memory);
        self.last.send_replace(last);
    }

    /// What comes behind event `number`.
    pub fn after(&self, number: u64) -> Next {
        let memory = self.memory();
        let Some(behind) = memory.last.checked_sub(number) else { return Next::Forgotten };
        if behind == 0 {
            return Next::Nothing;
        }
        let index = usize::try_from(behind).ok().and_then(|behind| memory.events.len().checked_sub(behind));
        index.map_or(Next::Forgotten, |index| Next::Event(memory.events[index].clone()))
    }

    /// The newest slot, and the number of the newest event.
    pub fn latest(&self) -> (u64, Option<Arc<Shown>>) {
        let memory = self.memory();
        (memory.last, memory.latest.clone())
    }

    /// The remembered slots up to event `number`, oldest first.
    pub fn slots_until(&self, number: u64) -> Vec<Arc<Shown>> {
        let memory = self.memory();
        let newer = usize::try_from(memory.last.saturating_sub(number)).unwrap_or(usize::MAX);
        let until = memory.events.len().saturating_sub(newer);
        memory.events.iter().take(until).filter_map(Event::slot).cloned().collect()
    }

    /// Told of each new event.
    pub fn watch(&self) -> watch::Receiver<u64> {
        self.last.subscribe()
    }

    /// A panic elsewhere leaves nothing half done in here.
    fn memory(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
