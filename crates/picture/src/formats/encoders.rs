//! All data that the service sends over UDP.

use asterix::DataSource;
use asterix::cat063::SensorStatus;

use super::cat062::service;
use super::cat063::sensor_datagrams;
use super::{Cat062Encoder, Cat129Encoder, pack, status_block};
use crate::PictureTrack;
use fusion::time::Time;
use site::config::{Category, Config, Feed, PictureKind};

/// Encoders of every [`Feed`] and of the status. Pictures have to be encoded in order; those of an unused feed may be skipped.
#[derive(Clone, Debug)]
pub struct Encoders {
    source: DataSource,
    /// Sensors in the order of the configuration.
    sensors: Vec<DataSource>,
    cat129: Cat129Encoder,
    lagged: Cat062Encoder,
    now: Cat062Encoder,
}

impl Encoders {
    /// Encoders of a configuration, without any tracks.
    pub fn new(config: &Config) -> Self {
        let cat129 = Cat129Encoder::of(config);
        Self {
            source: cat129.source,
            sensors: config
                .sensors
                .iter()
                .map(|sensor| DataSource { sac: sensor.sac, sic: sensor.sic })
                .collect(),
            cat129,
            lagged: Cat062Encoder::new(config, PictureKind::Lagged),
            now: Cat062Encoder::new(config, PictureKind::Now),
        }
    }

    /// CAT062 track numbers in use, as octets.
    pub fn checkpoint(&self) -> Vec<u8> {
        postcard::to_stdvec(&(self.lagged.numbers(), self.now.numbers()))
            .expect("numbers can be written down")
    }

    /// Restores a checkpoint. Returns whether the octets are one.
    pub fn resume(&mut self, octets: &[u8]) -> bool {
        let Ok((lagged, now)) = postcard::from_bytes(octets) else { return false };
        self.lagged.resume(lagged);
        self.now.resume(now);
        true
    }

    /// Datagrams of a picture of time `time`.
    pub fn picture<'a>(
        &mut self,
        feed: Feed,
        time: Time,
        tracks: impl IntoIterator<Item = &'a PictureTrack>,
    ) -> Vec<Vec<u8>> {
        match (feed.category, feed.picture) {
            (Category::Cat129, _) => pack(tracks, &self.cat129),
            (Category::Cat062, PictureKind::Lagged) => self.lagged.encode(time, tracks),
            (Category::Cat062, PictureKind::Now) => self.now.encode(time, tracks),
        }
    }

    /// Status of the service (CAT065), for every destination.
    pub fn status(&self, time: Time, degraded: bool) -> Vec<u8> {
        status_block(self.source, time, degraded)
    }

    /// State of the sensors (CAT063), in the order of the configuration; only for CAT062 destinations.
    pub fn sensors(
        &self,
        feed: Feed,
        time: Time,
        sensors: impl IntoIterator<Item = SensorStatus>,
    ) -> Vec<Vec<u8>> {
        match feed.category {
            Category::Cat129 => Vec::new(),
            Category::Cat062 => {
                let sensors = self.sensors.iter().copied().zip(sensors);
                sensor_datagrams(self.source, service(feed.picture), time, sensors)
            }
        }
    }
}
