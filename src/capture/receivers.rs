//! The receivers of a site, for recordings that are translated while they are read.

use std::collections::BTreeMap;

use asterix::DataSource;

use super::stamps::Stamps;
use crate::config::{Config, ConnectionFormat, Sensor, SensorKind};
use crate::gateways::adsb::Place;
use crate::gateways::mavlink::{System, every_system};

/// The receivers of a site, by which recordings of other formats than ASTERIX are translated.
#[derive(Clone, Debug)]
pub struct Receivers {
    /// SAC and SIC of the records that 1090 MHz frames become.
    pub adsb: DataSource,
    /// A place near the 1090 MHz receiver, latitude and longitude in degrees: positions on the ground need one.
    pub place: Option<Place>,
    /// Kind of the stamps of 1090 MHz frames.
    pub stamps: Stamps,
    /// SAC and SIC of the records that MAVLink positions become.
    pub mavlink: DataSource,
    /// The drones of a MAVLink log, by their system numbers.
    pub systems: BTreeMap<u8, System>,
}

/// Without a site: SAC and SIC are 0, and drones are called by their system numbers.
impl Default for Receivers {
    fn default() -> Self {
        let none = DataSource { sac: 0, sic: 0 };
        Self { adsb: none, place: None, stamps: Stamps::Auto, mavlink: none, systems: every_system() }
    }
}

impl Receivers {
    /// Those of a site: the first sensor of kind `adsb`; the first transponder with a `mavlink` connection and its systems, or
    /// else the first transponder.
    pub fn of(config: &Config) -> Self {
        let source = |sensor: &Sensor| DataSource { sac: sensor.sac, sic: sensor.sic };
        let first =
            |wanted: fn(&SensorKind) -> bool| config.sensors.iter().find(|sensor| wanted(&sensor.kind));
        let usual = Self::default();
        let adsb = first(|kind| matches!(kind, SensorKind::AdsB(_)));
        let connected = config.sensors.iter().find_map(|sensor| {
            let of = sensor.connections.iter().find(|of| of.format == ConnectionFormat::Mavlink)?;
            Some((source(sensor), of.systems()))
        });
        let transponder = || {
            let sensor = first(SensorKind::is_transponder);
            (sensor.map_or(usual.mavlink, source), usual.systems.clone())
        };
        let (mavlink, systems) = connected.unwrap_or_else(transponder);
        let (latitude_deg, longitude_deg, _) = config.origin();
        Self {
            adsb: adsb.map_or(usual.adsb, source),
            place: Some([latitude_deg, longitude_deg]),
            mavlink,
            systems,
            ..usual
        }
    }

    /// The same with stamps of a stated kind.
    #[must_use]
    pub fn with_stamps(self, stamps: Stamps) -> Self {
        Self { stamps, ..self }
    }
}
