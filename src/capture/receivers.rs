//! The receivers of a site, for recordings that are translated while they are read.

use asterix::DataSource;

use super::stamps::Stamps;
use crate::config::{Config, Sensor, SensorKind, mavlink_sensors};
use crate::gateways::adsb::Place;
use crate::gateways::mavlink::{RemoteIdReceiver, Sensors, every_system};

/// The receivers of a site, by which recordings of other formats than ASTERIX are translated.
#[derive(Clone, Debug)]
pub struct Receivers {
    /// SAC and SIC of the records that 1090 MHz frames become.
    pub adsb: DataSource,
    /// A place near the 1090 MHz receiver, latitude and longitude in degrees: positions on the ground need one.
    pub place: Option<Place>,
    /// Kind of the stamps of 1090 MHz frames.
    pub stamps: Stamps,
    /// Sensors of a MAVLink log.
    pub mavlink: Sensors,
}

/// Without a site: SAC and SIC are 0, and drones are called by their system numbers.
impl Default for Receivers {
    fn default() -> Self {
        let none = DataSource { sac: 0, sic: 0 };
        let mavlink = Sensors {
            drones: Some((none, every_system())),
            aircraft: Some(none),
            remote_id: Some(RemoteIdReceiver::default()),
        };
        Self { adsb: none, place: None, stamps: Stamps::Auto, mavlink }
    }
}

impl Receivers {
    /// Those of a site: the first sensor of kind `adsb`; of each kind the first sensor with a `mavlink` connection, or else the
    /// first one.
    pub fn of(config: &Config) -> Self {
        let source = |sensor: &Sensor| DataSource { sac: sensor.sac, sic: sensor.sic };
        let first =
            |wanted: fn(&SensorKind) -> bool| config.sensors.iter().find(|sensor| wanted(&sensor.kind));
        let usual = Self::default();
        let adsb = first(|kind| matches!(kind, SensorKind::AdsB(_)));
        let connected = mavlink_sensors(config.sensors.iter(), |_| true);
        let own = first(SensorKind::is_transponder).map_or(usual.adsb, source);
        let mavlink = Sensors {
            drones: connected.drones.or_else(|| Some((own, every_system()))),
            aircraft: connected.aircraft.or_else(|| Some(adsb.map_or(usual.adsb, source))),
            remote_id: connected.remote_id.or(usual.mavlink.remote_id),
        };
        let (latitude_deg, longitude_deg, _) = config.origin();
        Self {
            adsb: adsb.map_or(usual.adsb, source),
            place: Some([latitude_deg, longitude_deg]),
            mavlink,
            stamps: usual.stamps,
        }
    }

    /// The same with stamps of a stated kind.
    #[must_use]
    pub fn with_stamps(self, stamps: Stamps) -> Self {
        Self { stamps, ..self }
    }
}
