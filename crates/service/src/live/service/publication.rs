//! Slots between making and publication: they are ready at their deadline.

use std::collections::VecDeque;
use std::sync::Arc;

use jiff::SignedDuration;

use super::{Outlets, percentiles};
use crate::clock::WallClock;
use crate::live::condition::ServiceLevel;
use crate::live::health::SensorStatus;
use crate::live::published::{PublishedPicture, Status};
use crate::net::send::UdpDestinations;
use crate::record::RecordingItem;
use fusion::time::Time;
use picture::conflicts::ConflictWatch;
use picture::formats::Encoders;
use site::config::{Config, Feed, PictureKind};

/// Number of slots over which lateness is taken: ten minutes.
const LATENESS: usize = 2400;

/// Sends slots when they are due, and publishes them to readers.
pub(super) struct Publisher {
    pub(super) outlets: Outlets,
    pub(super) clock: WallClock,
    /// Slots to be published, in order.
    ready: VecDeque<ReadySlot>,
    /// Evaluates conflicts, and the published slots that still wait for it.
    pub(super) watch: Option<ConflictWatch>,
    pub(super) unevaluated: VecDeque<Arc<PublishedPicture>>,
    lateness_us: VecDeque<u32>,
    /// Number of failed sends.
    pub(super) failed_sends: u64,
    /// Number of delayed datagrams since the last slot.
    pub(super) waited: usize,
    max_accuracy_m: f64,
    sends_status: bool,
}

/// A slot that is made, and published when it is due.
pub(super) struct ReadySlot {
    frame: PublishedPicture,
    /// Datagrams of the feeds with a destination, and of the recorded feed.
    payloads: Vec<(Feed, Vec<Vec<u8>>)>,
}

impl ReadySlot {
    pub(super) fn new(
        frame: PublishedPicture,
        sinks: &UdpDestinations,
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
    pub(super) fn new(config: &Config, outlets: Outlets, clock: WallClock) -> Self {
        Self {
            watch: ConflictWatch::of(config),
            unevaluated: VecDeque::new(),
            ready: VecDeque::new(),
            lateness_us: VecDeque::new(),
            failed_sends: 0,
            waited: 0,
            max_accuracy_m: config.output.max_accuracy_m,
            sends_status: config.output.status,
            outlets,
            clock,
        }
    }

    /// Queues a slot until it is due.
    pub(super) fn enqueue(&mut self, frame: PublishedPicture) {
        let Outlets { sinks, encoders, .. } = &mut self.outlets;
        self.ready.push_back(ReadySlot::new(frame, sinks, encoders, self.max_accuracy_m));
    }

    /// Time at which the next slot is to be published.
    pub(super) fn next_due(&self) -> Option<Time> {
        self.ready.front().map(ReadySlot::due)
    }

    /// Publishes the slots that are due by now. A slot due later than `lead` from now means that the clock stepped back,
    /// and is published too.
    pub(super) fn publish_due(&mut self, now: Time, lead: SignedDuration) {
        while let Some(ready) = self.ready.pop_front() {
            if ready.frame.due > now && ready.frame.due - now <= lead {
                return self.ready.push_front(ready);
            }
            self.publish(ready);
        }
    }

    /// Sends a slot, publishes it to readers, and records its lateness.
    fn publish(&mut self, ready: ReadySlot) {
        let frame = self.send(ready);
        let late_us = (frame.published_at.nanos() - frame.due.nanos()).max(0) / 1000;
        if self.lateness_us.len() == LATENESS {
            self.lateness_us.pop_front();
        }
        self.lateness_us.push_back(u32::try_from(late_us).unwrap_or(u32::MAX));
        let frame = self.outlets.hub.publish_live(frame, std::mem::take(&mut self.waited));
        self.queue_evaluation(frame);
    }

    /// Publishes all slots that are made; their lateness says nothing about the service.
    pub(super) fn publish_pending(&mut self) {
        while let Some(ready) = self.ready.pop_front() {
            let frame = self.send(ready);
            let frame = self.outlets.hub.publish(frame);
            self.queue_evaluation(frame);
        }
    }

    /// Sends and records a slot, which is published now.
    fn send(&mut self, ReadySlot { mut frame, payloads }: ReadySlot) -> PublishedPicture {
        for (feed, payloads) in payloads {
            for payload in payloads {
                self.failed_sends += self.outlets.sinks.send_of(feed, &payload);
                if feed == Feed::RECORDED {
                    let due = frame.due;
                    self.record(|| RecordingItem::Output { due, payload });
                }
            }
        }
        frame.published_at = self.clock.now();
        frame
    }
    pub(super) fn record(&mut self, item: impl FnOnce() -> RecordingItem) {
        if let Some(recorder) = &mut self.outlets.recorder {
            recorder.offer(item());
        }
    }

    /// Publishes the status to readers and sinks.
    pub(super) fn publish_status(&mut self, mut status: Status) {
        status.lateness_s = percentiles(&self.lateness_us);
        status.failed_sends = self.failed_sends;
        if self.sends_status {
            let degraded = self.outlets.hub.condition(&status).level() > ServiceLevel::Ok;
            self.failed_sends += self.outlets.sinks.send(&self.outlets.encoders.status(status.at, degraded));
            for feed in Feed::ALL.into_iter().filter(|&feed| self.outlets.sinks.want(feed)) {
                let sensors = status.sensors.iter().map(SensorStatus::item);
                for datagram in self.outlets.encoders.sensors(feed, status.at, sensors) {
                    self.failed_sends += self.outlets.sinks.send_of(feed, &datagram);
                }
            }
            status.failed_sends = self.failed_sends;
        }
        self.outlets.hub.publish_status(status);
    }
}
