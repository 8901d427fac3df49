//! The engine's input: plots of radars, fixes of transponders and bearings of cameras, in the site's frame and UTC.

mod host;
mod identity;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

pub use host::Host;
pub use identity::{Identity, NAME_MAX, Space};

use crate::declaration::Declaration;
use crate::frames::Enu;
use crate::time::Time;

/// A sensor: its index in [`Settings::sensors`](crate::Settings::sensors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SensorIndex(pub u16);

/// A radar track: the radar and its track number (I048/161, 12 bits). Ordered by sensor, then number.
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
    /// Position in the site's frame; at an assumed height if `height_measured` is false.
    pub position: Enu,
    /// Whether the radar measured the height (I048/110).
    pub height_measured: bool,
    /// Slant range from the radar, metres.
    pub slant_range_m: f64,
    /// Probability that the target is a UAV, 0 to 1; `None` if the radar does not report it.
    pub uav_probability: Option<f64>,
    /// Velocity over ground in the site's frame, m/s, east and north (I048/200).
    pub velocity: Option<Vector2<f64>>,
}

impl Plot {
    /// Creates a plot of a measured position without further data; `slant_range_m` is the distance from its radar,
    /// metres.
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
    /// Creates a fix of a position without further data.
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

/// Whether a transponder's carrier is an aircraft with people on board, a drone, or a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum AircraftKind {
    /// A drone.
    #[default]
    Unmanned,
    /// An aircraft with people on board.
    Crewed,
    /// A vehicle on the ground of an aerodrome.
    Vehicle,
}

/// Further reported data on an aircraft, published unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Aircraft {
    /// Crewed aircraft, drone or vehicle.
    pub kind: AircraftKind,
    /// Callsign, without surrounding spaces and padded with NULs (I021/170); all NUL: not known.
    pub callsign: [u8; 8],
    /// Emitter category (I021/020).
    pub emitter_category: Option<u8>,
    /// Remote ID declarations.
    pub declared: Declaration,
}

impl Aircraft {
    /// This data, with unknown values taken from an earlier report of the aircraft: some items are sent less often.
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

/// The identifying items of a CAT129 report, forwarded unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UasItems {
    /// Manufacturer, I129/020.
    pub manufacturer: Option<[u8; 3]>,
    /// Model, I129/030.
    pub model: Option<[u8; 3]>,
    /// Serial number, I129/040.
    pub serial_number: [u8; 12],
    /// Country of registration, I129/050.
    pub registration_country: Option<[u8; 2]>,
}

impl UasItems {
    /// Derives the items from an identity: the last 12 octets of a serial number, the size of I129/040, and its
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
    /// Identity of the transponder.
    pub identity: Identity,
    /// Identifying items as received.
    pub items: UasItems,
    /// Further reported data on the aircraft.
    pub aircraft: Aircraft,
    /// Time of the report.
    pub time: Time,
    /// Position in the site's frame; at an assumed height if `height_measured` is false.
    pub position: Enu,
    /// Whether the transponder reports its height.
    pub height_measured: bool,
    /// Reported accuracy of the position, metres: the radius that holds half of its errors (I129/110).
    pub accuracy_m: Option<f64>,
    /// Standard deviation of the height, metres, if it differs from that of the receiver's reports.
    pub height_sigma_m: Option<f64>,
    /// Velocity over ground, m/s, east and north at the aircraft's position (I129/185).
    pub velocity: Option<Vector2<f64>>,
    /// Rate of climb, m/s (I129/220).
    pub climb_m_s: Option<f64>,
}

/// Standard deviation above which a reported height is too uncertain to be compared with a radar's, metres.
const COARSE_HEIGHT_M: f64 = 100.0;

impl Fix {
    /// Whether the height can be compared with other measurements. A flight level without the day's pressure cannot.
    pub fn has_fine_height(&self) -> bool {
        self.height_measured && self.height_sigma_m.is_none_or(|sigma_m| sigma_m <= COARSE_HEIGHT_M)
    }

    /// Type of the transponder.
    pub fn transponder_type(&self) -> TransponderType {
        TransponderType::of(self.sensor, &self.items)
    }
}

/// Transponders of one make and model at one receiver, which are assumed to have the same errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TransponderType {
    /// The receiver, which may set the time stamps.
    pub receiver: SensorIndex,
    /// Manufacturer, I129/020.
    pub manufacturer: Option<[u8; 3]>,
    /// Model, I129/030.
    pub model: Option<[u8; 3]>,
}

impl TransponderType {
    /// Type of a transponder whose items this receiver receives.
    pub(crate) fn of(receiver: SensorIndex, items: &UasItems) -> Self {
        let &UasItems { manufacturer, model, .. } = items;
        Self { receiver, manufacturer, model }
    }
}

/// A camera's track: the camera and its own number for the object (I015/161). Ordered by sensor, then number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CameraTrackKey {
    /// The camera.
    pub sensor: SensorIndex,
    /// The camera's track number.
    pub number: u16,
}

/// One bearing of a camera: the direction of an object, without its distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bearing {
    /// The camera track.
    pub track: CameraTrackKey,
    /// Time of the measurement.
    pub time: Time,
    /// Azimuth, radians: clockwise from the north of the site's frame, as seen from the camera.
    pub azimuth: f64,
    /// Elevation above the horizontal plane of the site's frame, radians.
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

/// A radar track or transponder that has flown to where another engine tracks it. Its missing reports are not a
/// silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Departed {
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
    fn missing_items_are_taken_from_an_earlier_report() {
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
