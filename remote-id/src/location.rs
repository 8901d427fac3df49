//! Where it is, and how it moves: message type 1 (F3411-22a table 6).

use super::count::nearest;
use super::message::LENGTH;

/// Where it is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Location(pub(crate) [u8; LENGTH]);

/// What it is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It does not say.
    Undeclared,
    /// On the ground.
    Ground,
    /// In the air.
    Airborne,
    /// In distress.
    Emergency,
    /// Its Remote ID does not work as it should.
    SystemFailure,
    /// A number without a meaning yet.
    Reserved(u8),
}

/// What its height is counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightAbove {
    /// From where it took off.
    TakeOff,
    /// From the ground below it.
    Ground,
}

/// What a location says, field by field; `None`: unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocationContent {
    /// What it is doing.
    pub status: Status,
    /// Course over ground, degrees clockwise from true north; steps of 1.
    pub course_deg: Option<f64>,
    /// Speed over ground, metres a second; steps of 0.25 up to 63.75 and of 0.75 above, up to 254.25.
    pub speed_m_s: Option<f64>,
    /// Climb, metres a second; steps of 0.5, up to 62 either way.
    pub climb_m_s: Option<f64>,
    /// Latitude and longitude, degrees, WGS-84; steps of 1e-7.
    pub place_deg: Option<[f64; 2]>,
    /// Pressure altitude, metres; steps of 0.5, from -999.5 to 31,767.5.
    pub pressure_altitude_m: Option<f64>,
    /// Height above the WGS-84 ellipsoid, metres; the same steps.
    pub geodetic_altitude_m: Option<f64>,
    /// Height, metres, and what it is counted from; the same steps.
    pub height_m: Option<(f64, HeightAbove)>,
    /// Radius, metres, that holds 95 % of the errors over ground: sent as the least of twelve that is no smaller.
    pub accuracy_h_m: Option<f64>,
    /// The same of the geodetic altitude, of six.
    pub accuracy_v_m: Option<f64>,
    /// The same of the pressure altitude, of six.
    pub accuracy_pressure_m: Option<f64>,
    /// The same of the speed, metres a second, of four.
    pub accuracy_speed_m_s: Option<f64>,
    /// Seconds since the full hour of UTC; steps of 0.1.
    pub seconds_of_hour: Option<f64>,
    /// How much that may be wrong, seconds; steps of 0.1 up to 1.5.
    pub accuracy_time_s: Option<f64>,
}

/// Degrees of a count.
const DEGREES: f64 = 1e-7;
/// Radii, metres, that hold 95 % of the errors over ground, by their code less one.
const HORIZONTAL_M: [f64; 12] =
    [18_520.0, 7_408.0, 3_704.0, 1_852.0, 926.0, 555.6, 185.2, 92.6, 30.0, 10.0, 3.0, 1.0];
/// The same of heights.
const VERTICAL_M: [f64; 6] = [150.0, 45.0, 25.0, 10.0, 3.0, 1.0];
/// The same of speeds, metres a second.
const SPEED_M_S: [f64; 4] = [10.0, 3.0, 1.0, 0.3];

impl Location {
    /// Of what it says: each value as the nearest that the message holds.
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
            // As much as the fine steps hold.
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

    /// What it says.
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

    /// Number of what it is doing, 0 (undeclared) to 15.
    pub fn status_number(&self) -> u8 {
        self.0[1] >> 4
    }

    /// What it is doing.
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

    /// Speed over ground, metres a second, in steps of 0.25 up to 63.75 and of 0.75 above; `None`: unknown.
    pub fn speed_m_s(&self) -> Option<f64> {
        let count = f64::from(self.0[3]);
        match self.0[1] & 1 {
            0 => Some(0.25 * count),
            _ if self.0[3] == u8::MAX => None,
            _ => Some(0.75 * count + 0.25 * 255.0),
        }
    }

    /// Climb, metres a second, in steps of 0.5; `None`: unknown.
    pub fn climb_m_s(&self) -> Option<f64> {
        let climb_m_s = 0.5 * f64::from(self.0[4].cast_signed());
        (climb_m_s != 63.0).then_some(climb_m_s)
    }

    /// Latitude and longitude, degrees, WGS-84, whatever they are: both are 0 where it does not know its place.
    pub fn place_deg(&self) -> [f64; 2] {
        self.place_counts().map(|count| f64::from(count) * DEGREES)
    }

    /// The same in 1e-7 degrees.
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

    /// Height, metres, and what it is counted from; `None`: unknown.
    pub fn height_m(&self) -> Option<(f64, HeightAbove)> {
        let above = if self.0[1] & 0b100 == 0 { HeightAbove::TakeOff } else { HeightAbove::Ground };
        altitude_m(self.chunk(17)).map(|metres| (metres, above))
    }

    /// Radius, metres, that holds 95 % of the errors over ground; `None`: unknown.
    pub fn accuracy_h_m(&self) -> Option<f64> {
        coded(&HORIZONTAL_M, self.0[19] & 0xf)
    }

    /// The same of the geodetic altitude, metres.
    pub fn accuracy_v_m(&self) -> Option<f64> {
        coded(&VERTICAL_M, self.0[19] >> 4)
    }

    /// The same of the pressure altitude, metres.
    pub fn accuracy_pressure_m(&self) -> Option<f64> {
        coded(&VERTICAL_M, self.0[20] >> 4)
    }

    /// The same of the speed, metres a second.
    pub fn accuracy_speed_m_s(&self) -> Option<f64> {
        coded(&SPEED_M_S, self.0[20] & 0xf)
    }

    /// When it was there: seconds since the full hour of UTC, in steps of 0.1; `None`: unknown, or beyond the hour.
    pub fn seconds_of_hour(&self) -> Option<f64> {
        let tenths = u16::from_le_bytes(self.chunk(21));
        (tenths <= 36_000).then_some(f64::from(tenths) * 0.1)
    }

    /// How much that may be wrong, seconds; `None`: unknown.
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

/// The code of the least value that is no smaller; 0 where there is none, or nothing is known.
fn code(values: &[f64], value: Option<f64>) -> u8 {
    // The values fall.
    value.map_or(0, |value| values.iter().take_while(|&&of| of >= value).count() as u8)
}

/// Steps of 0.5 m from 1000 m below zero on, from the first that is not the unknown one.
pub(crate) fn altitude_octets(metres: Option<f64>) -> [u8; 2] {
    let count = metres.map_or(0, |metres| nearest(metres + 1000.0, 0.5, 1.0, f64::from(u16::MAX)) as u16);
    count.to_le_bytes()
}

/// Steps of 0.5 m from 1000 m below zero on; 0 is what is not known.
pub(crate) fn altitude_m(octets: [u8; 2]) -> Option<f64> {
    let count = u16::from_le_bytes(octets);
    (count > 0).then_some(0.5 * f64::from(count) - 1000.0)
}

/// The value of a code; 0, and what has no meaning yet, is not known.
fn coded(values: &[f64], code: u8) -> Option<f64> {
    values.get(usize::from(code).checked_sub(1)?).copied()
}
