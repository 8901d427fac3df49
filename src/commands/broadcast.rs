//! `replay --udp`: sends what the live service would send.

use jiff::SignedDuration;
use tracing::warn;

use super::Usage;
use crate::app::{AppError, open_sinks};
use fusion::time::{SECOND, Time};
use input::pipeline::Event;
use picture::Picture;
use picture::formats::Encoders;
use service::live::{SensorMonitor, SensorState, SensorStatus};
use service::net::send::UdpDestinations;
use site::config::{Config, Feed, PictureKind};

/// The outputs, and the health of the sensors for CAT065 and CAT063. All times are times of the recording.
pub struct Broadcast {
    sinks: UdpDestinations,
    encoders: Encoders,
    /// Health of the sensors, if a status is sent.
    health: Option<SensorMonitor>,
    /// Time from a slot's centre to its transmission.
    due_after: SignedDuration,
    next_status: Option<Time>,
    failed: u64,
}

impl Broadcast {
    /// Opens the outputs of the configuration.
    ///
    /// # Errors
    /// The configuration has no output, or one cannot be opened.
    pub fn open(config: &Config) -> Result<Self, AppError> {
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

    /// Starts the recording, or restarts it.
    pub fn begin(&mut self, config: &Config, first: Time) {
        self.health = config.output.status.then(|| SensorMonitor::new(config, first));
        self.next_status = None;
        self.encoders = Encoders::new(config);
    }

    /// Records an event of the received data.
    pub fn note(&mut self, event: &Event, received: Time) {
        if let Some(health) = &mut self.health {
            health.note(event, received);
        }
    }

    /// Sends the pictures of a slot. The status is sent before the first one of each second.
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

    /// Number of datagrams that could not be sent.
    pub fn failed(&self) -> u64 {
        self.failed
    }
}
