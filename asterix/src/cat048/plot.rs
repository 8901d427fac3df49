//! Where the radar saw the target: I048/040, 090, 110.

use deku::{DekuRead, DekuWrite};

use crate::item::Describe;
use crate::items::{nearest, sign_extend};
use crate::layout::{count, field, quantity};
use crate::{Kind, Layout};

/// Metres in a nautical mile.
const NAUTICAL_MILE_M: f64 = 1852.0;
/// Metres in a foot.
const FOOT_M: f64 = 0.3048;

/// I048/040, measured position in polar co-ordinates, local to the radar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct PolarPosition {
    /// Slant range RHO: LSB 1/256 NM (7.234375 m), 0 to below 256 NM.
    pub rho: u16,
    /// Azimuth THETA from the radar's north, clockwise: LSB 360/65536 degrees (about 0.0055 degrees).
    pub theta: u16,
}

impl PolarPosition {
    /// The nearest position. `None` when the range is not in 0 to below 256 NM (474,112 m) or a number is not finite;
    /// any finite azimuth is brought into one turn.
    pub fn new(range_m: f64, azimuth_deg: f64) -> Option<Self> {
        let rho = nearest(range_m * 256.0 / NAUTICAL_MILE_M, 0, i32::from(u16::MAX))?;
        let theta = nearest(azimuth_deg.rem_euclid(360.0) * 65536.0 / 360.0, 0, 65536)?;
        Some(Self { rho: rho as u16, theta: theta as u16 })
    }

    /// Slant range in nautical miles, exact.
    pub fn range_nm(self) -> f64 {
        f64::from(self.rho) / 256.0
    }

    /// Slant range in metres.
    pub fn range_m(self) -> f64 {
        f64::from(self.rho) * (NAUTICAL_MILE_M / 256.0)
    }

    /// Azimuth in degrees, 0 to below 360, exact.
    pub fn azimuth_deg(self) -> f64 {
        f64::from(self.theta) * (360.0 / 65536.0)
    }
}

impl Describe for PolarPosition {
    const LAYOUT: Layout = Layout::Fields(&[
        quantity("rho_m", 16, false, NAUTICAL_MILE_M / 256.0, 1),
        quantity("theta_deg", 16, false, 360.0 / 65536.0, 3),
    ]);
}

/// I048/090, flight level from the transponder's Mode C or Mode S reply.
///
/// The level is signed, as edition 1.32 says; earlier editions leave it open, and radars send negative levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct FlightLevel(u16);

impl FlightLevel {
    /// The item as it stands: V, G and 14 bits of level.
    pub const fn from_word(word: u16) -> Self {
        Self(word)
    }

    /// The nearest level, validated and not garbled; `None` outside -2048 to 2047.75.
    pub fn new(flight_level: f64) -> Option<Self> {
        let count = nearest(flight_level * 4.0, -0x2000, 0x1fff)?;
        Some(Self(count as u16 & 0x3fff))
    }

    /// The item as it stands.
    pub const fn word(self) -> u16 {
        self.0
    }

    /// V = 0: the code is validated.
    pub const fn is_validated(self) -> bool {
        self.0 & 0x8000 == 0
    }

    /// G = 1: the code is garbled.
    pub const fn is_garbled(self) -> bool {
        self.0 & 0x4000 != 0
    }

    /// The level in counts: LSB 1/4 flight level (25 ft), -8192 to 8191.
    pub const fn count(self) -> i16 {
        sign_extend(self.0 as u32, 14) as i16
    }

    /// The flight level (hundreds of feet above the 1013.25 hPa surface), exact.
    pub fn flight_level(self) -> f64 {
        f64::from(self.count()) / 4.0
    }
}

impl Describe for FlightLevel {
    const LAYOUT: Layout =
        Layout::Fields(&[count("v", 1), count("g", 1), quantity("flight_level", 14, true, 0.25, 2)]);
}

/// I048/110, height measured by a 3D radar, above mean sea level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct Height3D(u16);

impl Height3D {
    /// The item as it stands: two spare bits and 14 bits of height.
    pub const fn from_word(word: u16) -> Self {
        Self(word)
    }

    /// The nearest height; `None` outside -62,423 m to 62,415 m.
    pub fn from_metres(height_m: f64) -> Option<Self> {
        let count = nearest(height_m / (25.0 * FOOT_M), -0x2000, 0x1fff)?;
        Some(Self(count as u16 & 0x3fff))
    }

    /// The item as it stands.
    pub const fn word(self) -> u16 {
        self.0
    }

    /// The height in counts: LSB 25 ft (7.62 m), -8192 to 8191.
    pub const fn count(self) -> i16 {
        sign_extend(self.0 as u32, 14) as i16
    }

    /// Height in feet, exact.
    pub fn height_ft(self) -> f64 {
        f64::from(self.count()) * 25.0
    }

    /// Height in metres.
    pub fn height_m(self) -> f64 {
        self.height_ft() * FOOT_M
    }
}

impl Describe for Height3D {
    const LAYOUT: Layout =
        Layout::Fields(&[field("spare", 2, Kind::Spare), quantity("height_m", 14, true, 25.0 * FOOT_M, 2)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polar_position() {
        let position = PolarPosition::new(1852.0, 90.0).unwrap();
        assert_eq!(position, PolarPosition { rho: 256, theta: 0x4000 });
        assert_eq!((position.range_nm(), position.range_m(), position.azimuth_deg()), (1.0, 1852.0, 90.0));
        assert_eq!(PolarPosition::new(0.0, -90.0).unwrap().theta, 0xc000);
        assert_eq!(PolarPosition::new(0.0, 359.999).unwrap().theta, 0); // nearer to north than to the last count
        assert_eq!(PolarPosition::new(0.0, -1e-20).unwrap().theta, 0);
        assert_eq!(PolarPosition::new(474_108.0, 0.0).unwrap().rho, u16::MAX);
        for (range_m, azimuth_deg) in [(474_112.0, 0.0), (-4.0, 0.0), (f64::NAN, 0.0), (1.0, f64::INFINITY)] {
            assert_eq!(PolarPosition::new(range_m, azimuth_deg), None);
        }
    }

    #[test]
    fn flight_level_is_signed() {
        let level = FlightLevel::from_word(0xfffb);
        assert_eq!((level.count(), level.flight_level()), (-5, -1.25));
        assert!(!level.is_validated() && level.is_garbled());
        assert_eq!(FlightLevel::new(-1.25), Some(FlightLevel::from_word(0x3ffb)));
        assert_eq!(FlightLevel::new(370.0).map(FlightLevel::word), Some(1480));
        assert_eq!(FlightLevel::new(2048.0), None);
    }

    #[test]
    fn height_is_signed_and_its_spare_bits_are_not_height() {
        let height = Height3D::from_word(0xfffe);
        assert_eq!((height.count(), height.height_ft()), (-2, -50.0));
        assert!((height.height_m() + 15.24).abs() < 1e-12);
        assert_eq!(Height3D::from_metres(-15.24).map(Height3D::word), Some(0x3ffe));
        assert_eq!(Height3D::from_metres(3.81).map(Height3D::count), Some(1)); // half a count
        assert_eq!(Height3D::from_metres(62_420.0), None);
    }
}
