//! `replay --udp`: what the service would send.

use jiff::SignedDuration;
use tracing::warn;

use super::Usage;
use crate::app::{Failure, open_sinks};
use crate::config::{Config, PictureKind};
use crate::formats::{Cat129Encoder, pack, status_block};
use crate::live::{Health, SensorState};
use crate::net::send::Sinks;
use crate::picture::Picture;
use crate::pipeline::Event;
use fusion::time::{SECOND, Time};

/// The outputs, and the health of the sensors, which the CAT065 status tells. Every time is one of the recording.
pub struct Broadcast {
    sinks: Sinks,
    encoder: Cat129Encoder,
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
            encoder: Cat129Encoder::of(config),
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
            self.failed += self.sinks.send(&status_block(self.encoder.source, at, degraded));
        }
        for (kind, picture) in [(PictureKind::Lagged, Some(picture)), (PictureKind::Now, now)] {
            for payload in picture.iter().flat_map(|picture| pack(&picture.tracks, &self.encoder)) {
                self.failed += self.sinks.send_of(kind, &payload);
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
