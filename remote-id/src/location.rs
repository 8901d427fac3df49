//! Where it is, and how it moves: message type 1 (F3411-22a table 6).

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
    /// What it is doing.
    pub fn status(&self) -> Status {
        match self.0[1] >> 4 {
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

/// Steps of 0.5 m from 1000 m below zero on; 0 is what is not known.
fn altitude_m(octets: [u8; 2]) -> Option<f64> {
    let count = u16::from_le_bytes(octets);
    (count > 0).then_some(0.5 * f64::from(count) - 1000.0)
}

/// The value of a code; 0, and what has no meaning yet, is not known.
fn coded(values: &[f64], code: u8) -> Option<f64> {
    values.get(usize::from(code).checked_sub(1)?).copied()
}
