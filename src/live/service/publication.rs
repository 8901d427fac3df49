//! Slots between their making and their publication: the deadline finds them ready.

use std::collections::VecDeque;
use std::sync::Arc;

use jiff::SignedDuration;

use super::{Outlets, percentiles};
use crate::config::{Config, Feed, PictureKind};
use crate::conflicts::ConflictWatch;
use crate::formats::Encoders;
use crate::live::clock::Clock;
use crate::live::condition::Level;
use crate::live::health::SensorStatus;
use crate::live::published::{PublishedPicture, Status};
use crate::net::send::Sinks;
use crate::record::Recorded;
use fusion::time::Time;

/// Slots over which lateness is taken: ten minutes.
const LATENESS: usize = 2400;

/// Sends slots when they are due, and shows them.
pub(super) struct Publisher {
    pub(super) outlets: Outlets,
    pub(super) clock: Clock,
    /// In order.
    ready: VecDeque<ReadySlot>,
    /// Who looks for conflicts, and the published slots in which they were not looked for yet.
    pub(super) watch: Option<ConflictWatch>,
    pub(super) unseen: VecDeque<Arc<PublishedPicture>>,
    lateness_us: VecDeque<u32>,
    /// Sends that failed.
    pub(super) failed_sends: u64,
    /// Delayed datagrams since the last slot.
    pub(super) waited: usize,
    max_accuracy_m: f64,
    tells_status: bool,
}

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

impl Publisher {
    pub(super) fn new(config: &Config, outlets: Outlets, clock: Clock) -> Self {
        Self {
            watch: ConflictWatch::of(config),
            unseen: VecDeque::new(),
            ready: VecDeque::new(),
            lateness_us: VecDeque::new(),
            failed_sends: 0,
            waited: 0,
            max_accuracy_m: config.output.max_accuracy_m,
            tells_status: config.output.status,
            outlets,
            clock,
        }
    }

    /// Takes a slot that is to be published when it is due.
    pub(super) fn take(&mut self, frame: PublishedPicture) {
        let Outlets { sinks, encoders, .. } = &mut self.outlets;
        self.ready.push_back(ReadySlot::new(frame, sinks, encoders, self.max_accuracy_m));
    }

    /// When the next slot is to be published.
    pub(super) fn next_due(&self) -> Option<Time> {
        self.ready.front().map(ReadySlot::due)
    }

    /// Publishes the slots that are due by now, and those that are not because the clock has stepped back: none is due later
    /// than `lead` after it was made.
    pub(super) fn publish_due(&mut self, now: Time, lead: SignedDuration) {
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
    pub(super) fn record(&mut self, what: impl FnOnce() -> Recorded) {
        if let Some(recorder) = &mut self.outlets.recorder {
            recorder.offer(what());
        }
    }

    /// Publishes the status, to readers and to the sinks.
    pub(super) fn tell(&mut self, mut status: Status) {
        status.lateness_s = percentiles(&self.lateness_us);
        status.failed_sends = self.failed_sends;
        if self.tells_status {
            let degraded = self.outlets.hub.condition(&status).level() > Level::Ok;
            self.failed_sends += self.outlets.sinks.send(&self.outlets.encoders.status(status.at, degraded));
            for feed in Feed::ALL.into_iter().filter(|&feed| self.outlets.sinks.want(feed)) {
                let sensors = status.sensors.iter().map(SensorStatus::item);
                for datagram in self.outlets.encoders.sensors(feed, status.at, sensors) {
                    self.failed_sends += self.outlets.sinks.send_of(feed, &datagram);
                }
            }
            status.failed_sends = self.failed_sends;
        }
        self.outlets.hub.tell(status);
    }
}
