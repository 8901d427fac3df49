//! What the engine is told: plots of radars, fixes of transponders and bearings of cameras, in the site's frame and UTC.

mod host;
mod identity;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

pub use host::Host;
pub use identity::{Identity, NAME_MAX, Space};

use crate::declaration::Declaration;
use crate::frames::Enu;
use crate::time::Time;

/// A sensor: its place in [`Settings::sensors`](crate::Settings::sensors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SensorIndex(pub u16);

/// A radar track: the radar and its track number (I048/161, 12 bits). Orders by sensor, then number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct RadarTrackKey {
    /// The radar.
    pub sensor: SensorIndex,
    /// The radar's own track number, 0 to 4095.
    pub number: u16,
}

/// One radar detection.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plot {
    /// The radar track it belongs to.
    pub track: RadarTrackKey,
    /// Time of detection.
    pub time: Time,
    /// Position in the site's frame; where `height_measured` is false, at an assumed height.
    pub position: Enu,
    /// Whether the radar measured the height (I048/110).
    pub height_measured: bool,
    /// Slant range from its own radar, metres.
    pub slant_range_m: f64,
    /// Probability that it is a UAV, 0 to 1; `None` where the radar does not say.
    pub uav_probability: Option<f64>,
    /// Velocity over ground in the site's frame, m/s, east and north (I048/200).
    pub velocity: Option<Vector2<f64>>,
}

impl Plot {
    /// A plot of a measured position and nothing else, at this slant range from its radar, metres.
    pub fn new(track: RadarTrackKey, time: Time, position: Enu, slant_range_m: f64) -> Self {
        Self {
            track,
            time,
            position,
            height_measured: true,
            slant_range_m,
            uav_probability: None,
            velocity: None,
        }
    }
}

impl Fix {
    /// A fix of a position and nothing else.
    pub fn new(sensor: SensorIndex, identity: Identity, time: Time, position: Enu) -> Self {
        Self {
            sensor,
            host: Host::default(),
            identity,
            items: UasItems::of(identity),
            aircraft: Aircraft::default(),
            time,
            position,
            height_measured: true,
            accuracy_m: None,
            height_sigma_m: None,
            velocity: None,
            climb_m_s: None,
        }
    }
}

/// Who is on board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum AircraftKind {
    /// Nobody: a drone.
    #[default]
    Unmanned,
    /// Somebody.
    Crewed,
    /// No aircraft: a vehicle on the ground of an aerodrome.
    Vehicle,
}

/// What else a report says of its aircraft, to be published unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Aircraft {
    /// Who is on board.
    pub kind: AircraftKind,
    /// Its callsign, without spaces around and filled with NULs behind (I021/170); all NUL: not known.
    pub callsign: [u8; 8],
    /// Emitter category (I021/020).
    pub emitter_category: Option<u8>,
    /// What it declares by Remote ID.
    pub declared: Declaration,
}

impl Aircraft {
    /// The same with what is not known taken from an earlier report of the aircraft: some items come less often.
    pub fn or(self, earlier: Self) -> Self {
        let of_category = if self.emitter_category.is_some() { self } else { earlier };
        Self {
            kind: if of_category.emitter_category.is_some() { of_category.kind } else { self.kind },
            callsign: if self.callsign == [0; 8] { earlier.callsign } else { self.callsign },
            emitter_category: of_category.emitter_category,
            declared: self.declared.or(earlier.declared),
        }
    }
}

/// The identifying items of a CAT129 report as received, to be sent on unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UasItems {
    /// I129/020.
    pub manufacturer: Option<[u8; 3]>,
    /// I129/030.
    pub model: Option<[u8; 3]>,
    /// I129/040.
    pub serial_number: [u8; 12],
    /// I129/050.
    pub registration_country: Option<[u8; 2]>,
}

impl UasItems {
    /// Those that an identity says: of a serial number its last 12 octets, which is what I129/040 has room for, and its
    /// country. An aircraft without a serial number has none.
    pub fn of(identity: Identity) -> Self {
        let mut items = Self::default();
        if let Some(serial) = identity.serial() {
            let last = &serial[serial.len().saturating_sub(items.serial_number.len())..];
            items.serial_number[..last.len()].copy_from_slice(last);
            items.registration_country = <[u8; 2]>::try_from(identity.country()).ok();
        }
        items
    }
}

/// One transponder report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fix {
    /// The receiving sensor.
    pub sensor: SensorIndex,
    /// The host that sent the datagram.
    pub host: Host,
    /// Who sent it.
    pub identity: Identity,
    /// Its identifying items as received.
    pub items: UasItems,
    /// What else it says of its aircraft.
    pub aircraft: Aircraft,
    /// Time of the report.
    pub time: Time,
    /// Position in the site's frame; where `height_measured` is false, at an assumed height.
    pub position: Enu,
    /// Whether it says its height.
    pub height_measured: bool,
    /// Reported accuracy of the position, metres: the radius that holds half of its errors (I129/110).
    pub accuracy_m: Option<f64>,
    /// Standard deviation of the height, metres, where it is not that of its receiver's reports.
    pub height_sigma_m: Option<f64>,
    /// Velocity over ground, m/s, east and north at its own place (I129/185).
    pub velocity: Option<Vector2<f64>>,
    /// Rate of climb, m/s (I129/220).
    pub climb_m_s: Option<f64>,
}

/// Standard deviation from which on a stated height says too little to be compared with a radar's, metres.
const COARSE_HEIGHT_M: f64 = 100.0;

impl Fix {
    /// Whether its height can be compared with what others measure: a flight level without the pressure of the day cannot.
    pub fn has_fine_height(&self) -> bool {
        self.height_measured && self.height_sigma_m.is_none_or(|sigma_m| sigma_m <= COARSE_HEIGHT_M)
    }

    /// The type of its transponder.
    pub fn transponder_type(&self) -> TransponderType {
        TransponderType::of(self.sensor, &self.items)
    }
}

/// Transponders of one make and model that one receiver hears: they are taken to err alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TransponderType {
    /// The receiver: it may stamp the time.
    pub receiver: SensorIndex,
    /// I129/020.
    pub manufacturer: Option<[u8; 3]>,
    /// I129/030.
    pub model: Option<[u8; 3]>,
}

impl TransponderType {
    /// That of a transponder that this receiver hears send these items.
    pub(crate) fn of(receiver: SensorIndex, items: &UasItems) -> Self {
        let &UasItems { manufacturer, model, .. } = items;
        Self { receiver, manufacturer, model }
    }
}

/// A camera's track: the camera and its own number for what it looks at (I015/161). Orders by sensor, then number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CameraTrackKey {
    /// The camera.
    pub sensor: SensorIndex,
    /// Its number.
    pub number: u16,
}

/// One look of a camera: in which direction something is, not how far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bearing {
    /// What the camera calls it.
    pub track: CameraTrackKey,
    /// Time of the look.
    pub time: Time,
    /// Clockwise from the north of the site's frame, as seen from the camera, radians.
    pub azimuth: f64,
    /// Above the horizontal plane of the site's frame, radians.
    pub elevation: Option<f64>,
}

/// A plot, a fix or a bearing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// From a radar.
    Plot(Plot),
    /// From a transponder.
    Fix(Fix),
    /// From a camera.
    Bearing(Bearing),
}

/// Who has flown where this engine is told of nobody: it is not silent, it is elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Left {
    /// A radar track.
    Track(RadarTrackKey),
    /// A transponder.
    Transponder(Identity),
}

impl Report {
    /// The report's own time.
    pub fn time(&self) -> Time {
        match self {
            Self::Plot(plot) => plot.time,
            Self::Fix(fix) => fix.time,
            Self::Bearing(bearing) => bearing.time,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_serial_number_is_sent_by_its_last_octets() {
        let identity = Identity::new(b"1581F4FKD2291000A4B2", None).unwrap();
        assert_eq!(UasItems::of(identity).serial_number, *b"D2291000A4B2");
        assert_eq!(UasItems::of(Identity::of_address(1)), UasItems::default());
    }

    #[test]
    fn what_a_report_leaves_out_is_known_from_an_earlier_one() {
        let earlier = Aircraft {
            kind: AircraftKind::Unmanned,
            callsign: *b"UAV1\0\0\0\0",
            emitter_category: Some(13),
            ..Aircraft::default()
        };
        let bare = Aircraft { kind: AircraftKind::Crewed, ..Aircraft::default() };
        assert_eq!(bare.or(earlier), earlier);
        let vehicle =
            Aircraft { kind: AircraftKind::Vehicle, emitter_category: Some(20), ..Aircraft::default() };
        assert_eq!(vehicle.or(earlier), Aircraft { callsign: earlier.callsign, ..vehicle });
    }
}
