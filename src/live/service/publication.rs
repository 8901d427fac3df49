//! Slots between their making and their publication: the deadline finds them ready.

use super::Engine;
use crate::config::{Feed, PictureKind};
use crate::formats::Encoders;
use crate::live::published::PublishedPicture;
use crate::net::send::Sinks;
use crate::record::Recorded;
use fusion::time::Time;

/// Slots over which lateness is taken: ten minutes.
const LATENESS: usize = 2400;

/// A slot that is made, and published when it is due.
pub(super) struct ReadySlot {
    frame: PublishedPicture,
    /// The datagrams of the feeds that somebody wants, and of the one that is recorded.
    payloads: Vec<(Feed, Vec<Vec<u8>>)>,
}

impl ReadySlot {
    pub(super) fn new(
        frame: PublishedPicture,
        sinks: &Sinks,
        encoders: &mut Encoders,
        max_accuracy_m: f64,
    ) -> Self {
        let mut payloads = Vec::new();
        for feed in Feed::ALL.into_iter().filter(|&feed| feed == Feed::RECORDED || sinks.want(feed)) {
            let now = frame.now.get();
            let picture = match feed.picture {
                PictureKind::Lagged => Some(&frame.picture),
                PictureKind::Now => now.as_deref(),
            };
            let Some(picture) = picture else { continue };
            let datagrams = encoders.picture(feed, picture.time, picture.within(max_accuracy_m));
            payloads.push((feed, datagrams));
        }
        Self { payloads, frame }
    }

    pub(super) fn due(&self) -> Time {
        self.frame.due
    }
}

impl Engine {
    /// Publishes the slots that are due by now, and those that are not because the clock has stepped back.
    pub(super) fn publish_due(&mut self, now: Time) {
        let lead = self.driver.lead();
        while let Some(ready) = self.ready.pop_front() {
            if ready.frame.due > now && ready.frame.due - now <= lead {
                return self.ready.push_front(ready);
            }
            self.publish(ready);
        }
    }

    /// Sends the slot, then shows it, and notes how late that is.
    fn publish(&mut self, ready: ReadySlot) {
        let frame = self.send(ready);
        let late_us = (frame.published_at.nanos() - frame.due.nanos()).max(0) / 1000;
        if self.lateness_us.len() == LATENESS {
            self.lateness_us.pop_front();
        }
        self.lateness_us.push_back(u32::try_from(late_us).unwrap_or(u32::MAX));
        let frame = self.outlets.hub.publish_live(frame, std::mem::take(&mut self.waited));
        self.look_later(frame);
    }

    /// Publishes all slots that are made; their lateness says nothing about the service.
    pub(super) fn publish_owed(&mut self) {
        while let Some(ready) = self.ready.pop_front() {
            let frame = self.send(ready);
            let frame = self.outlets.hub.publish(frame);
            self.look_later(frame);
        }
    }

    /// Sends the slot, which is published now, and records it.
    fn send(&mut self, ReadySlot { mut frame, payloads }: ReadySlot) -> PublishedPicture {
        for (feed, payloads) in payloads {
            for payload in payloads {
                self.failed_sends += self.outlets.sinks.send_of(feed, &payload);
                if feed == Feed::RECORDED {
                    let due = frame.due;
                    self.record(|| Recorded::Output { due, payload });
                }
            }
        }
        frame.published_at = self.clock.now();
        frame
    }
}
