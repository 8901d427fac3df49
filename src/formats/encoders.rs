//! Everything that the service sends over UDP.

use asterix::DataSource;
use asterix::cat063::SensorStatus;

use super::cat062::service;
use super::cat063::sensor_datagrams;
use super::{Cat062Encoder, Cat129Encoder, pack, status_block};
use crate::config::{Category, Config, Feed, PictureKind};
use crate::picture::PictureTrack;
use fusion::time::Time;

/// The encoders of every [`Feed`], and of the status. Pictures have to come in order, those of a feed that nobody wants may
/// be left out.
#[derive(Clone, Debug)]
pub struct Encoders {
    source: DataSource,
    /// Of the configuration, in its order.
    sensors: Vec<DataSource>,
    cat129: Cat129Encoder,
    lagged: Cat062Encoder,
    now: Cat062Encoder,
}

impl Encoders {
    /// Of a configuration; no track has begun yet.
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

    /// Which track has which number of CAT062, as octets.
    pub fn checkpoint(&self) -> Vec<u8> {
        postcard::to_stdvec(&(self.lagged.numbers(), self.now.numbers()))
            .expect("numbers can be written down")
    }

    /// Goes on with a checkpoint; whether it is one.
    pub fn go_on(&mut self, octets: &[u8]) -> bool {
        let Ok((lagged, now)) = postcard::from_bytes(octets) else { return false };
        self.lagged.go_on(lagged);
        self.now.go_on(now);
        true
    }

    /// The datagrams of a picture of `time`.
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

    /// The service's own status (CAT065), for every destination.
    pub fn status(&self, time: Time, degraded: bool) -> Vec<u8> {
        status_block(self.source, time, degraded)
    }

    /// The state of the sensors, in the order of the configuration (CAT063); for destinations of CAT062 only.
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
