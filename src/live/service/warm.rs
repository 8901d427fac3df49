//! The engine's state, for a restart that comes soon. Nothing here waits, but at the end.

use bytes::Bytes;
use jiff::SignedDuration;

use super::Engine;
use crate::capture::Reception;
use crate::record::Recorded;
use crate::state::{Frame, WarmQueue};
use fusion::time::Time;

impl Engine {
    /// Hands on what is handled now.
    pub(super) fn keep_input(&mut self, reception: &Reception) {
        let Reception { received: Some(received), input, from: Some(from), payload, .. } = reception else {
            return;
        };
        if let Some(warm) = self.warm() {
            warm.offer(|| Frame::Input {
                received: *received,
                line: *input,
                from: *from,
                payload: payload.clone(),
            });
        }
    }

    /// Hands on a checkpoint, where it is time for one.
    pub(super) fn keep_checkpoint(&mut self) {
        let now = self.publisher.clock.now();
        let period = SignedDuration::try_from_secs_f64(self.config.state.checkpoint_s).unwrap_or_default();
        // Also where the clock has stepped back.
        let is_due = now >= self.next_checkpoint || self.next_checkpoint - now > period;
        if !is_due || self.driver.next_made().is_none() || self.warm().is_none() {
            return;
        }
        let mut engine = Vec::with_capacity(self.checkpoint_room);
        self.driver.checkpoint_into(&self.config, &mut engine);
        self.checkpoint_room = engine.len() + engine.len() / 8;
        let engine = Bytes::from(engine);
        // A recording may begin a file here.
        if let Some(recorder) = &self.publisher.outlets.recorder {
            recorder.has_room_for(Recorded::Checkpoint(engine.clone()));
        }
        let checkpoint = self.checkpoint(now, engine);
        if self.warm().is_some_and(|warm| warm.begin(checkpoint)) {
            self.next_checkpoint = now + period;
        }
    }

    /// The state as it is before the window is emptied.
    pub(super) fn end_checkpoint(&mut self) {
        if self.driver.next_made().is_none() || self.warm().is_none() {
            return;
        }
        let checkpoint = self.checkpoint(self.publisher.clock.now(), self.driver.checkpoint(&self.config));
        if let Some(warm) = self.warm() {
            warm.end(checkpoint);
        }
    }

    /// What was published ahead is not to be published again.
    pub(super) fn end_published(&mut self) {
        if let (Some(until), Some(warm)) = (self.driver.published(), self.warm()) {
            warm.end(Frame::Published(until));
        }
    }

    fn checkpoint(&self, at: Time, engine: Bytes) -> Frame {
        let encoders = self.publisher.outlets.encoders.checkpoint().into();
        Frame::Checkpoint { at, engine, encoders, published: self.driver.published() }
    }

    fn warm(&mut self) -> Option<&mut WarmQueue> {
        self.publisher.outlets.keepers.as_mut()?.warm.as_mut()
    }
}
