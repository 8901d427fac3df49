//! Receivers of a site, for recordings that are translated while they are read.

use asterix::DataSource;

use super::stamps::StampKind;
use crate::gateways::adsb::LatLonDeg;
use crate::gateways::mavlink::{MavlinkSensors, RemoteIdReceiver, every_system};
use site::config::{Config, Sensor, SensorKind};

/// Receivers of a site, by which recordings of formats other than ASTERIX are translated.
#[derive(Clone, Debug)]
pub struct SiteReceivers {
    /// SAC and SIC of the records made from 1090 MHz frames.
    pub adsb: DataSource,
    /// A place near the 1090 MHz receiver, latitude and longitude in degrees; needed for positions on the ground.
    pub place: Option<LatLonDeg>,
    /// Kind of the stamps of 1090 MHz frames.
    pub stamps: StampKind,
    /// Sensors of a MAVLink log.
    pub mavlink: MavlinkSensors,
}

/// Without a site: SAC and SIC are 0, and drones are named by their system numbers.
impl Default for SiteReceivers {
    fn default() -> Self {
        let none = DataSource { sac: 0, sic: 0 };
        let mavlink = MavlinkSensors {
            drones: Some((none, every_system())),
            aircraft: Some(none),
            remote_id: Some(RemoteIdReceiver::default()),
        };
        Self { adsb: none, place: None, stamps: StampKind::Auto, mavlink }
    }
}

impl SiteReceivers {
    /// Receivers of a configuration: the first sensor of kind `adsb`, and for each kind the first sensor with a `mavlink`
    /// connection, or otherwise the first one.
    pub fn of(config: &Config) -> Self {
        let source = |sensor: &Sensor| DataSource { sac: sensor.sac, sic: sensor.sic };
        let first =
            |wanted: fn(&SensorKind) -> bool| config.sensors.iter().find(|sensor| wanted(&sensor.kind));
        let usual = Self::default();
        let adsb = first(|kind| matches!(kind, SensorKind::AdsB(_)));
        let connected = MavlinkSensors::of(config.sensors.iter(), |_| true);
        let own = first(SensorKind::is_transponder).map_or(usual.adsb, source);
        let mavlink = MavlinkSensors {
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

    /// Sets the kind of stamps.
    #[must_use]
    pub fn with_stamps(self, stamps: StampKind) -> Self {
        Self { stamps, ..self }
    }
}
