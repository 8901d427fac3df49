//! What the engine is told: plots of radars and fixes of transponders, in the site's frame and UTC.

use std::cmp::Ordering;
use std::fmt;
use std::ops::Range;

use nalgebra::Vector2;

use crate::frames::Enu;
use crate::time::Time;

/// A sensor: its place in [`Settings::sensors`](crate::Settings::sensors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SensorIndex(pub u16);

/// A radar track: the radar and its track number (I048/161, 12 bits). Orders by sensor, then number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RadarTrackKey {
    /// The radar.
    pub sensor: SensorIndex,
    /// The radar's own track number, 0 to 4095.
    pub number: u16,
}

/// One radar detection.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        let mut items = UasItems::default();
        items.serial_number.copy_from_slice(&identity.octets[..COUNTRY.start]);
        Self { sensor, identity, items, time, position, accuracy_m: None, velocity: None, climb_m_s: None }
    }
}

/// Who a transponder says it is: serial number and registration country, without leading and trailing spaces and NULs.
/// Ordered by octets.
///
/// ```
/// use utm_fusion_engine::Identity;
///
/// let identity = Identity::new(b"A12         ", Some(b"NO")).unwrap();
/// assert_eq!((identity.serial(), identity.country()), (&b"A12"[..], &b"NO"[..]));
/// assert_eq!(Identity::new(&[b' '; 12], None), None);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identity {
    // The serial number, then the country from `COUNTRY` on: each trimmed, then filled with NULs behind, which keeps the order
    // of the octets. Two words altogether, so that a comparison takes no more than two: identities are looked for in every slot.
    octets: [u8; 16],
}

/// Where in an identity's octets the country is; what is behind that is NUL.
const COUNTRY: Range<usize> = 12..14;

impl Identity {
    /// `None` where the serial number is blank.
    pub fn new(serial: &[u8; 12], country: Option<&[u8; 2]>) -> Option<Self> {
        let mut octets = [0; 16];
        octets[..COUNTRY.start].copy_from_slice(&trimmed(serial));
        octets[COUNTRY].copy_from_slice(&trimmed(country.unwrap_or(&[0; 2])));
        (octets[0] != 0).then_some(Self { octets })
    }

    /// The trimmed serial number.
    pub fn serial(&self) -> &[u8] {
        filled(&self.octets[..COUNTRY.start])
    }

    /// The trimmed registration country; empty where there is none.
    pub fn country(&self) -> &[u8] {
        filled(&self.octets[COUNTRY])
    }
}

impl Ord for Identity {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        u128::from_be_bytes(self.octets).cmp(&u128::from_be_bytes(other.octets))
    }
}

impl PartialOrd for Identity {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Without the NULs behind.
fn filled(octets: &[u8]) -> &[u8] {
    let length = octets.iter().rposition(|&octet| octet != 0).map_or(0, |last| last + 1);
    &octets[..length]
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.serial().escape_ascii(), self.octets[COUNTRY].escape_ascii())
    }
}

fn trimmed<const N: usize>(octets: &[u8; N]) -> [u8; N] {
    let blank = |octet: &u8| matches!(octet, 0 | b' ');
    let mut out = [0; N];
    let start = octets.iter().position(|octet| !blank(octet)).unwrap_or(N);
    let end = octets.iter().rposition(|octet| !blank(octet)).map_or(start, |last| last + 1);
    out[..end - start].copy_from_slice(&octets[start..end]);
    out
}

/// The identifying items of a CAT129 report as received, to be sent on unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// One transponder report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// The receiving sensor.
    pub sensor: SensorIndex,
    /// Who sent it.
    pub identity: Identity,
    /// Its identifying items as received.
    pub items: UasItems,
    /// Time of the report.
    pub time: Time,
    /// Position in the site's frame.
    pub position: Enu,
    /// Reported accuracy of the position, metres: the radius that holds half of its errors (I129/110).
    pub accuracy_m: Option<f64>,
    /// Velocity over ground, m/s, east and north at its own place (I129/185).
    pub velocity: Option<Vector2<f64>>,
    /// Rate of climb, m/s (I129/220).
    pub climb_m_s: Option<f64>,
}

impl Fix {
    /// The type of its transponder.
    pub fn transponder_type(&self) -> TransponderType {
        TransponderType::of(self.sensor, &self.items)
    }
}

/// Transponders of one make and model that one receiver hears: they are taken to err alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// A plot or a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Report {
    /// From a radar.
    Plot(Plot),
    /// From a transponder.
    Fix(Fix),
}

impl Report {
    /// The report's own time.
    pub fn time(&self) -> Time {
        match self {
            Self::Plot(plot) => plot.time,
            Self::Fix(fix) => fix.time,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identities_are_trimmed_and_leading_zeros_count() {
        let identity = |serial: &[u8; 12], country| Identity::new(serial, country);
        let plain = identity(b"A12\0\0\0\0\0\0\0\0\0", None).unwrap();
        assert_eq!(identity(b"  A12 \0  \0  ", Some(b"  ")), Some(plain));
        assert_eq!(plain.serial(), b"A12");
        assert_ne!(identity(b"0A12        ", None), Some(plain));
        assert_ne!(identity(b"A12         ", Some(b"NO")), Some(plain));
        assert_eq!(identity(b" \0          ", Some(b"NO")), None);
    }

    #[test]
    fn identities_are_ordered_by_octets() {
        let identity = |serial, country| Identity::new(serial, country).unwrap();
        let ordered = [
            identity(b"A12         ", None),
            identity(b"A12         ", Some(b"GB")),
            identity(b"A12         ", Some(b"NO")),
            identity(b"A12B        ", None),
            identity(b"A12BCDEFGHI1", Some(b"NO")),
            identity(b"A12BCDEFGHI2", None),
            identity(b"B           ", None),
            identity(b"\xff           ", None),
        ];
        assert!(ordered.is_sorted_by(|one, next| one < next));
    }
}
