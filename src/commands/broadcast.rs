//! `replay --udp`: what the service would send.

use jiff::SignedDuration;
use tracing::warn;

use super::Usage;
use crate::app::{Failure, open_sinks};
use crate::config::{Config, Feed, PictureKind};
use crate::formats::Encoders;
use crate::live::{Health, SensorState, SensorStatus};
use crate::net::send::Sinks;
use crate::picture::Picture;
use crate::pipeline::Event;
use fusion::time::{SECOND, Time};

/// The outputs, and the health of the sensors, of which CAT065 and CAT063 are. Every time is one of the recording.
pub struct Broadcast {
    sinks: Sinks,
    encoders: Encoders,
    /// Where a status is sent.
    health: Option<Health>,
    /// From a slot's centre until it is sent.
    due_after: SignedDuration,
    next_status: Option<Time>,
    failed: u64,
}

impl Broadcast {
    /// To the outputs of the configuration.
    ///
    /// # Errors
    /// It names none, or one cannot be opened.
    pub fn open(config: &Config) -> Result<Self, Failure> {
        if config.output.asterix.is_empty() {
            return Err(
                Usage("--udp: the configuration names no output.asterix to send to".to_owned()).into()
            );
        }
        Ok(Self {
            sinks: open_sinks(config)?,
            encoders: Encoders::new(config),
            health: None,
            due_after: config.fusion.latency() - config.fusion.slot / 2,
            next_status: None,
            failed: 0,
        })
    }

    /// The recording begins, perhaps again.
    pub fn begin(&mut self, config: &Config, first: Time) {
        self.health = config.output.status.then(|| Health::new(config, first));
        self.next_status = None;
        self.encoders = Encoders::new(config);
    }

    /// Something happened to what was received.
    pub fn note(&mut self, event: &Event, received: Time) {
        if let Some(health) = &mut self.health {
            health.note(event, received);
        }
    }

    /// Sends the pictures of a deadline, and before the first one of each second the status.
    pub fn send(&mut self, picture: &Picture, now: Option<&Picture>) {
        let before = self.failed;
        let due = picture.time + self.due_after;
        if let Some(health) = &self.health
            && self.next_status.is_none_or(|next| next <= due)
        {
            let at = Time::from_nanos(due.nanos().div_euclid(SECOND) * SECOND);
            self.next_status = Some(Time::from_nanos(at.nanos() + SECOND));
            let sensors = health.sensors(due, |_| Vec::new());
            let degraded = sensors.iter().any(|sensor| sensor.state != SensorState::Operational);
            self.failed += self.sinks.send(&self.encoders.status(at, degraded));
            for feed in Feed::ALL.into_iter().filter(|&feed| self.sinks.want(feed)) {
                let items = sensors.iter().map(SensorStatus::item);
                for datagram in self.encoders.sensors(feed, at, items) {
                    self.failed += self.sinks.send_of(feed, &datagram);
                }
            }
        }
        for feed in Feed::ALL.into_iter().filter(|&feed| self.sinks.want(feed)) {
            let picture = match feed.picture {
                PictureKind::Lagged => Some(picture),
                PictureKind::Now => now,
            };
            let Some(picture) = picture else { continue };
            for payload in self.encoders.picture(feed, picture.time, &picture.tracks) {
                self.failed += self.sinks.send_of(feed, &payload);
            }
        }
        if before == 0 && self.failed > 0 {
            warn!("a datagram could not be sent: more are only counted");
        }
    }

    /// Datagrams that could not be sent.
    pub fn failed(&self) -> u64 {
        self.failed
    }
}
