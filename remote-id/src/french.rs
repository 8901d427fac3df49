//! The French electronic identification ("signalement électronique", decree of 27 December 2019, annex): an element of a Wi-Fi
//! beacon that consists of values with type, length and contents. Numbers are big-endian.

use super::{
    BasicId, HeightAbove, IdType, Location, LocationContent, Message, Status, System, SystemContent, UaType,
    pack,
};

/// Maximum length of the identity in a Basic ID, in octets.
const ID_MOST: usize = 20;
/// Length of the codes of manufacturer and model in a French identifier; a serial number with leading zeros follows.
const CODES: usize = 6;
const FRENCH_ID: usize = 30;
/// Degrees per count.
const DEGREES: f64 = 1e-5;

/// Contents of a French beacon; `None`: absent, or not of the length that the decree requires.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct French<'a> {
    /// French identifier: codes of manufacturer and model, three characters each, and a serial number of 24 characters.
    pub french_id: Option<&'a [u8]>,
    /// Serial number (ANSI/CTA-2063-A).
    pub serial: Option<&'a [u8]>,
    /// Latitude and longitude, degrees, WGS-84, in steps of 1e-5.
    pub place_deg: Option<[f64; 2]>,
    /// Altitude, whole metres above mean sea level.
    pub altitude_amsl_m: Option<f64>,
    /// Height, whole metres above the place of take-off.
    pub height_m: Option<f64>,
    /// Latitude and longitude of the place of take-off, degrees.
    pub take_off_deg: Option<[f64; 2]>,
    /// Speed over ground, whole metres per second.
    pub speed_m_s: Option<f64>,
    /// Course over ground, whole degrees clockwise from true north.
    pub course_deg: Option<f64>,
}

impl<'a> French<'a> {
    /// Reads the values after vendor and type of the element; unknown types are ignored. `None`: there are no known values.
    pub fn new(mut octets: &'a [u8]) -> Option<Self> {
        let mut read = Self::default();
        let (mut place, mut take_off) = ([None; 2], [None; 2]);
        while let [kind, length, rest @ ..] = octets
            && let Some((value, behind)) = rest.split_at_checked(usize::from(*length))
        {
            match kind {
                2 => read.french_id = Some(value).filter(|id| id.len() == FRENCH_ID),
                3 => read.serial = Some(value).filter(|id| !id.is_empty()),
                4 => place[0] = degrees(value),
                5 => place[1] = degrees(value),
                6 => read.altitude_amsl_m = metres(value),
                7 => read.height_m = metres(value),
                8 => take_off[0] = degrees(value),
                9 => take_off[1] = degrees(value),
                10 => read.speed_m_s = <[u8; 1]>::try_from(value).ok().map(|[speed]| speed.into()),
                11 => read.course_deg = value.try_into().ok().map(|value| u16::from_be_bytes(value).into()),
                _ => {}
            }
            octets = behind;
        }
        let both = |[latitude, longitude]: [Option<f64>; 2]| Some([latitude?, longitude?]);
        (read.place_deg, read.take_off_deg) = (both(place), both(take_off));
        (read != Self::default()).then_some(read)
    }

    /// The identity as a Basic ID: the serial number, or else the French identifier as a registration, without the leading zeros
    /// of its serial number. `None`: absent, or longer than 20 octets.
    pub fn basic_id(&self) -> Option<BasicId> {
        let fits = |id: &Vec<u8>| id.len() <= ID_MOST;
        let serial = self.serial.map(<[u8]>::to_vec).filter(fits);
        let french = self.french_id.map(|id| {
            let (codes, serial) = id.split_at(CODES);
            let filled = serial.iter().take_while(|octet| **octet == b'0').count();
            [codes, &serial[filled..]].concat()
        });
        let serial = serial.map(|id| (IdType::SerialNumber, id));
        let french = french.filter(fits).map(|id| (IdType::Registration, id));
        serial.or(french).map(|(id_type, id)| BasicId::new(id_type, UaType::None, &id))
    }

    /// The contents as a pack of messages: Basic ID, Location, and the place of take-off as that of the operator. `undulation_m`
    /// is the height of the geoid above the ellipsoid.
    pub fn pack(&self, undulation_m: f64) -> Option<Vec<u8>> {
        let location = Location::new(&LocationContent {
            status: Status::Undeclared,
            course_deg: self.course_deg,
            speed_m_s: self.speed_m_s,
            climb_m_s: None,
            place_deg: self.place_deg,
            pressure_altitude_m: None,
            geodetic_altitude_m: self.altitude_amsl_m.map(|metres| metres + undulation_m),
            height_m: self.height_m.map(|metres| (metres, HeightAbove::TakeOff)),
            accuracy_h_m: None,
            accuracy_v_m: None,
            accuracy_pressure_m: None,
            accuracy_speed_m_s: None,
            seconds_of_hour: None,
            accuracy_time_s: None,
        });
        let system = self.take_off_deg.map(|place| {
            System::new(&SystemContent {
                location_type: 0,
                classification: 0,
                operator_deg: Some(place),
                area_count: 1,
                area_radius_m: 0.0,
                area_ceiling_m: None,
                area_floor_m: None,
                category_and_class: [0; 2],
                operator_altitude_m: None,
                time_s: 0,
            })
        });
        let messages = [
            self.basic_id().map(Message::BasicId),
            self.place_deg.map(|_| Message::Location(location)),
            system.map(Message::System),
        ];
        pack(&messages.into_iter().flatten().collect::<Vec<_>>())
    }
}

fn degrees(value: &[u8]) -> Option<f64> {
    value.try_into().ok().map(|value| f64::from(i32::from_be_bytes(value)) * DEGREES)
}

fn metres(value: &[u8]) -> Option<f64> {
    value.try_into().ok().map(|value| i16::from_be_bytes(value).into())
}
