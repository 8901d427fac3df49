//! Location: position and motion of the aircraft, message type 1 (F3411-22a table 6).

use super::count::nearest;
use super::octets::LENGTH;

/// Position and motion of the aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Location(pub(crate) [u8; LENGTH]);

/// Operational status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Undeclared.
    Undeclared,
    /// On the ground.
    Ground,
    /// In the air.
    Airborne,
    /// Emergency.
    Emergency,
    /// Failure of the Remote ID system.
    SystemFailure,
    /// A reserved number.
    Reserved(u8),
}

/// Reference of a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightAbove {
    /// Place of take-off.
    TakeOff,
    /// Ground below the aircraft.
    Ground,
}

/// The values of a location message; `None`: unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocationContent {
    /// Operational status.
    pub status: Status,
    /// Course over ground, degrees clockwise from true north; steps of 1.
    pub course_deg: Option<f64>,
    /// Speed over ground, metres per second; steps of 0.25 up to 63.75 and of 0.75 above, up to 254.25.
    pub speed_m_s: Option<f64>,
    /// Vertical speed, metres per second, from -62 to 62; steps of 0.5.
    pub climb_m_s: Option<f64>,
    /// Latitude and longitude, degrees, WGS-84; steps of 1e-7.
    pub place_deg: Option<[f64; 2]>,
    /// Pressure altitude, metres; steps of 0.5, from -999.5 to 31,767.5.
    pub pressure_altitude_m: Option<f64>,
    /// Height above the WGS-84 ellipsoid, metres; steps of 0.5, from -999.5 to 31,767.5.
    pub geodetic_altitude_m: Option<f64>,
    /// Height, metres, and its reference; steps of 0.5, from -999.5 to 31,767.5.
    pub height_m: Option<(f64, HeightAbove)>,
    /// Radius that contains 95 % of the horizontal errors, metres; sent as the smallest of twelve values that is not less.
    pub accuracy_h_m: Option<f64>,
    /// Bound of 95 % of the errors of the geodetic altitude, metres; one of six values.
    pub accuracy_v_m: Option<f64>,
    /// Bound of 95 % of the errors of the pressure altitude, metres; one of six values.
    pub accuracy_pressure_m: Option<f64>,
    /// Bound of 95 % of the errors of the speed, metres per second; one of four values.
    pub accuracy_speed_m_s: Option<f64>,
    /// Seconds since the full hour of UTC; steps of 0.1.
    pub seconds_of_hour: Option<f64>,
    /// Accuracy of the time, seconds; steps of 0.1 up to 1.5.
    pub accuracy_time_s: Option<f64>,
}

/// Degrees per count.
const DEGREES: f64 = 1e-7;
/// Radii that contain 95 % of the horizontal errors, metres, by code minus one.
const HORIZONTAL_M: [f64; 12] =
    [18_520.0, 7_408.0, 3_704.0, 1_852.0, 926.0, 555.6, 185.2, 92.6, 30.0, 10.0, 3.0, 1.0];
/// Bounds of 95 % of the errors of heights, metres, by code minus one.
const VERTICAL_M: [f64; 6] = [150.0, 45.0, 25.0, 10.0, 3.0, 1.0];
/// Bounds of 95 % of the errors of speeds, metres per second, by code minus one.
const SPEED_M_S: [f64; 4] = [10.0, 3.0, 1.0, 0.3];

impl Location {
    /// A message with these values, each rounded to the nearest one that the message can hold.
    pub fn new(content: &LocationContent) -> Self {
        let mut octets = [0; LENGTH];
        octets[0] = 0x12;
        let above_ground = matches!(content.height_m, Some((_, HeightAbove::Ground)));
        octets[1] = content.status.number() << 4 | u8::from(above_ground) << 2;
        match content.course_deg {
            Some(degrees) => {
                let whole = nearest(degrees.rem_euclid(360.0), 1.0, 0.0, 360.0) as u16 % 360;
                octets[1] |= u8::from(whole >= 180) << 1;
                octets[2] = (whole % 180) as u8;
            }
            None => (octets[1], octets[2]) = (octets[1] | 0b10, 181),
        }
        match content.speed_m_s {
            // Within the range of the fine steps.
            Some(speed_m_s) if speed_m_s < 0.25 * 255.5 => {
                octets[3] = nearest(speed_m_s, 0.25, 0.0, 255.0) as u8;
            }
            Some(speed_m_s) => {
                octets[1] |= 1;
                octets[3] = nearest(speed_m_s - 0.25 * 255.0, 0.75, 0.0, 254.0) as u8;
            }
            None => (octets[1], octets[3]) = (octets[1] | 1, u8::MAX),
        }
        octets[4] = (nearest(content.climb_m_s.unwrap_or(63.0), 0.5, -124.0, 126.0) as i8).cast_unsigned();
        let place_deg = content.place_deg.unwrap_or_default();
        for (at, degrees) in [5, 9].into_iter().zip(place_deg) {
            let count = nearest(degrees, DEGREES, f64::from(i32::MIN), f64::from(i32::MAX)) as i32;
            octets[at..at + 4].copy_from_slice(&count.to_le_bytes());
        }
        let height_m = content.height_m.map(|(metres, _)| metres);
        for (at, metres) in
            [13, 15, 17].into_iter().zip([content.pressure_altitude_m, content.geodetic_altitude_m, height_m])
        {
            octets[at..at + 2].copy_from_slice(&altitude_octets(metres));
        }
        octets[19] = code(&VERTICAL_M, content.accuracy_v_m) << 4 | code(&HORIZONTAL_M, content.accuracy_h_m);
        octets[20] = code(&VERTICAL_M, content.accuracy_pressure_m) << 4
            | code(&SPEED_M_S, content.accuracy_speed_m_s);
        let tenths =
            content.seconds_of_hour.map_or(u16::MAX, |seconds| nearest(seconds, 0.1, 0.0, 36_000.0) as u16);
        octets[21..23].copy_from_slice(&tenths.to_le_bytes());
        octets[23] = content.accuracy_time_s.map_or(0, |seconds| nearest(seconds, 0.1, 1.0, 15.0) as u8);
        Self(octets)
    }

    /// The values of the message.
    pub fn content(&self) -> LocationContent {
        LocationContent {
            status: self.status(),
            course_deg: self.course_deg(),
            speed_m_s: self.speed_m_s(),
            climb_m_s: self.climb_m_s(),
            place_deg: Some(self.place_deg()).filter(|place| *place != [0.0; 2]),
            pressure_altitude_m: self.pressure_altitude_m(),
            geodetic_altitude_m: self.geodetic_altitude_m(),
            height_m: self.height_m(),
            accuracy_h_m: self.accuracy_h_m(),
            accuracy_v_m: self.accuracy_v_m(),
            accuracy_pressure_m: self.accuracy_pressure_m(),
            accuracy_speed_m_s: self.accuracy_speed_m_s(),
            seconds_of_hour: self.seconds_of_hour(),
            accuracy_time_s: self.accuracy_time_s(),
        }
    }

    /// Number of the operational status, 0 (undeclared) to 15.
    pub fn status_number(&self) -> u8 {
        self.0[1] >> 4
    }

    /// Operational status.
    pub fn status(&self) -> Status {
        match self.status_number() {
            0 => Status::Undeclared,
            1 => Status::Ground,
            2 => Status::Airborne,
            3 => Status::Emergency,
            4 => Status::SystemFailure,
            number => Status::Reserved(number),
        }
    }

    /// Course over ground, degrees clockwise from true north; `None`: unknown, or beyond 359.
    pub fn course_deg(&self) -> Option<f64> {
        let east_or_west = if self.0[1] & 0b10 == 0 { 0 } else { 180 };
        let degrees = u16::from(self.0[2]) + east_or_west;
        (degrees < 360).then_some(f64::from(degrees))
    }

    /// Speed over ground, metres per second, in steps of 0.25 up to 63.75 and of 0.75 above; `None`: unknown.
    pub fn speed_m_s(&self) -> Option<f64> {
        let count = f64::from(self.0[3]);
        match self.0[1] & 1 {
            0 => Some(0.25 * count),
            _ if self.0[3] == u8::MAX => None,
            _ => Some(0.75 * count + 0.25 * 255.0),
        }
    }

    /// Vertical speed, metres per second, in steps of 0.5; `None`: unknown.
    pub fn climb_m_s(&self) -> Option<f64> {
        let climb_m_s = 0.5 * f64::from(self.0[4].cast_signed());
        (climb_m_s != 63.0).then_some(climb_m_s)
    }

    /// Latitude and longitude, degrees, WGS-84, unchecked; both are 0 if the aircraft does not know its position.
    pub fn place_deg(&self) -> [f64; 2] {
        self.place_counts().map(|count| f64::from(count) * DEGREES)
    }

    /// Latitude and longitude, in 1e-7 degrees.
    pub fn place_counts(&self) -> [i32; 2] {
        [5, 9].map(|at| i32::from_le_bytes(self.chunk(at)))
    }

    /// Pressure altitude, metres above the level of 1013.25 hPa; `None`: unknown.
    pub fn pressure_altitude_m(&self) -> Option<f64> {
        altitude_m(self.chunk(13))
    }

    /// Height above the WGS-84 ellipsoid, metres; `None`: unknown.
    pub fn geodetic_altitude_m(&self) -> Option<f64> {
        altitude_m(self.chunk(15))
    }

    /// Height, metres, and its reference; `None`: unknown.
    pub fn height_m(&self) -> Option<(f64, HeightAbove)> {
        let above = if self.0[1] & 0b100 == 0 { HeightAbove::TakeOff } else { HeightAbove::Ground };
        altitude_m(self.chunk(17)).map(|metres| (metres, above))
    }

    /// Radius that contains 95 % of the horizontal errors, metres; `None`: unknown.
    pub fn accuracy_h_m(&self) -> Option<f64> {
        coded(&HORIZONTAL_M, self.0[19] & 0xf)
    }

    /// Bound of 95 % of the errors of the geodetic altitude, metres; `None`: unknown.
    pub fn accuracy_v_m(&self) -> Option<f64> {
        coded(&VERTICAL_M, self.0[19] >> 4)
    }

    /// Bound of 95 % of the errors of the pressure altitude, metres; `None`: unknown.
    pub fn accuracy_pressure_m(&self) -> Option<f64> {
        coded(&VERTICAL_M, self.0[20] >> 4)
    }

    /// Bound of 95 % of the errors of the speed, metres per second; `None`: unknown.
    pub fn accuracy_speed_m_s(&self) -> Option<f64> {
        coded(&SPEED_M_S, self.0[20] & 0xf)
    }

    /// Time of the position, seconds since the full hour of UTC, in steps of 0.1; `None`: unknown, or beyond the hour.
    pub fn seconds_of_hour(&self) -> Option<f64> {
        let tenths = u16::from_le_bytes(self.chunk(21));
        (tenths <= 36_000).then_some(f64::from(tenths) * 0.1)
    }

    /// Accuracy of the time, seconds; `None`: unknown.
    pub fn accuracy_time_s(&self) -> Option<f64> {
        let tenths = self.0[23] & 0xf;
        (tenths > 0).then_some(f64::from(tenths) * 0.1)
    }

    fn chunk<const N: usize>(&self, at: usize) -> [u8; N] {
        *self.0[at..].first_chunk().expect("25 octets")
    }
}

impl Status {
    fn number(self) -> u8 {
        match self {
            Self::Undeclared => 0,
            Self::Ground => 1,
            Self::Airborne => 2,
            Self::Emergency => 3,
            Self::SystemFailure => 4,
            Self::Reserved(number) => number & 0xf,
        }
    }
}

/// Code of the smallest of `values` that is not less than `value`; 0 if there is none or the value is unknown.
fn code(values: &[f64], value: Option<f64>) -> u8 {
    // The values are in descending order.
    value.map_or(0, |value| values.iter().take_while(|&&of| of >= value).count() as u8)
}

/// An altitude in steps of 0.5 m above -1000 m; the lowest known altitude has the count 1, because 0 is unknown.
pub(crate) fn altitude_octets(metres: Option<f64>) -> [u8; 2] {
    let count = metres.map_or(0, |metres| nearest(metres + 1000.0, 0.5, 1.0, f64::from(u16::MAX)) as u16);
    count.to_le_bytes()
}

/// The altitude of a count of steps of 0.5 m above -1000 m; 0 is unknown.
pub(crate) fn altitude_m(octets: [u8; 2]) -> Option<f64> {
    let count = u16::from_le_bytes(octets);
    (count > 0).then_some(0.5 * f64::from(count) - 1000.0)
}

/// The value of a code; 0 and reserved codes are unknown.
fn coded(values: &[f64], code: u8) -> Option<f64> {
    values.get(usize::from(code).checked_sub(1)?).copied()
}
