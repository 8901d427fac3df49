//! The engine's state, for a prompt restart. Nothing here waits, except at the end.

use bytes::Bytes;
use jiff::SignedDuration;

use super::EngineThread;
use crate::record::RecordingItem;
use crate::state::{WarmFrame, WarmQueue};
use fusion::time::Time;
use input::capture::Reception;

impl EngineThread {
    /// Saves an input that is handled now.
    pub(super) fn keep_input(&mut self, reception: &Reception) {
        let Reception { received: Some(received), input, from: Some(from), payload, .. } = reception else {
            return;
        };
        if let Some(warm) = self.warm() {
            warm.offer(|| WarmFrame::Input {
                received: *received,
                line: *input,
                from: *from,
                payload: payload.clone(),
            });
        }
    }

    /// Saves a checkpoint if one is due.
    pub(super) fn keep_checkpoint(&mut self) {
        let now = self.publisher.clock.now();
        let period = SignedDuration::try_from_secs_f64(self.config.state.checkpoint_s).unwrap_or_default();
        // Also due after the clock stepped back.
        let is_due = now >= self.next_checkpoint || self.next_checkpoint - now > period;
        if !is_due || self.driver.next_made().is_none() || self.warm().is_none() {
            return;
        }
        let mut engine = Vec::with_capacity(self.checkpoint_capacity);
        self.driver.checkpoint_into(&self.config, &mut engine);
        self.checkpoint_capacity = engine.len() + engine.len() / 8;
        let engine = Bytes::from(engine);
        // A new file of the recording may begin here.
        if let Some(recorder) = &self.publisher.outlets.recorder {
            recorder.try_add(RecordingItem::Checkpoint(engine.clone()));
        }
        let checkpoint = self.checkpoint(now, engine);
        if self.warm().is_some_and(|warm| warm.begin(checkpoint)) {
            self.next_checkpoint = now + period;
        }
    }

    /// Saves the state before the window is emptied.
    pub(super) fn end_checkpoint(&mut self) {
        if self.driver.next_made().is_none() || self.warm().is_none() {
            return;
        }
        let checkpoint = self.checkpoint(self.publisher.clock.now(), self.driver.checkpoint(&self.config));
        if let Some(warm) = self.warm() {
            warm.end(checkpoint);
        }
    }

    /// Slots published early at the stop must not be published again.
    pub(super) fn end_published(&mut self) {
        if let (Some(until), Some(warm)) = (self.driver.published(), self.warm()) {
            warm.end(WarmFrame::Published(until));
        }
    }

    fn checkpoint(&self, at: Time, engine: Bytes) -> WarmFrame {
        let encoders = self.publisher.outlets.encoders.checkpoint().into();
        WarmFrame::Checkpoint { at, engine, encoders, published: self.driver.published() }
    }

    fn warm(&mut self) -> Option<&mut WarmQueue> {
        self.publisher.outlets.keepers.as_mut()?.warm.as_mut()
    }
}
