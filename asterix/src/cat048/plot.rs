//! Position measured by the radar: I048/040, 090, 110.

use crate::bits;
use crate::item::items;

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;

items! {
    /// I048/040 (5.2.4), measured position in polar co-ordinates, local to the radar.
    pub struct PolarPosition(4) {
        /// Slant range RHO in metres: LSB 1/256 NM (7.234375 m), 0 to below 256 NM.
        unsigned 16 "rho_m" range_m / with_range_m = 1852.0 / 256.0, 1;
        /// Azimuth THETA in degrees from the radar's north, clockwise: LSB 360/65536 degrees (about 0.0055), 0 to below 360
        /// degrees.
        angle 16 "theta_deg" azimuth_deg / with_azimuth_deg = 360.0 / 65536.0, 3;
    }
}

impl PolarPosition {
    /// The nearest position. `None` if the range is not in 0 to below 256 NM (474,112 m) or a number is not finite; any finite
    /// azimuth is reduced to one turn.
    pub fn new(range_m: f64, azimuth_deg: f64) -> Option<Self> {
        Self::default().with_range_m(range_m)?.with_azimuth_deg(azimuth_deg)
    }
}

items! {
    /// I048/090 (5.2.12), flight level from the transponder's Mode C or Mode S reply.
    ///
    /// The level is signed, as edition 1.32 states. Earlier editions leave this open, and radars send negative levels.
    pub struct FlightLevel(2) {
        /// V = 0: the code is validated.
        unset 1 "v" is_validated / with_validated;
        /// G = 1: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// The flight level (hundreds of feet above the 1013.25 hPa surface), exact: LSB 1/4 (25 ft), -2048 to 2047.75.
        signed 14 "flight_level" flight_level / with_flight_level = 0.25, 2;
    }
}

impl FlightLevel {
    /// The nearest level, validated and not garbled; `None` outside -2048 to 2047.75.
    pub fn new(flight_level: f64) -> Option<Self> {
        Self::default().with_flight_level(flight_level)
    }
}

items! {
    /// I048/110 (5.2.14), height measured by a 3D radar, above mean sea level.
    pub struct Height3D(2) {
        spare 2 "spare";
        signed 14 "height_m" = 25.0 * FOOT_M, 2;
    }
}

impl Height3D {
    /// The nearest height; `None` outside -62,423 m to 62,415 m.
    pub fn from_metres(height_m: f64) -> Option<Self> {
        let count = bits::nearest_count(height_m / (25.0 * FOOT_M), 14, true)?;
        Some(Self(bits::set([0; 2], 2, 14, count)))
    }

    /// Height in feet, exact: LSB 25 ft (7.62 m), -204,800 to 204,775 ft.
    pub const fn height_ft(self) -> f64 {
        bits::signed(bits::get(&self.0, 2, 14), 14) as f64 * 25.0
    }

    /// Height in metres.
    pub const fn height_m(self) -> f64 {
        self.height_ft() * FOOT_M
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polar_position() {
        let position = PolarPosition::new(1852.0, 90.0).unwrap();
        assert_eq!(position.octets(), [1, 0, 0x40, 0]);
        assert_eq!((position.range_m(), position.azimuth_deg()), (1852.0, 90.0));
        let theta = |azimuth_deg| {
            let [_, _, theta @ ..] = PolarPosition::new(0.0, azimuth_deg).unwrap().octets();
            u16::from_be_bytes(theta)
        };
        assert_eq!(theta(-90.0), 0xc000);
        assert_eq!(theta(359.999), 0); // nearer to north than to the last count
        assert_eq!(theta(-1e-20), 0);
        assert_eq!(PolarPosition::new(474_108.0, 0.0).unwrap().octets(), [0xff, 0xff, 0, 0]);
        for (range_m, azimuth_deg) in [(474_112.0, 0.0), (-4.0, 0.0), (f64::NAN, 0.0), (1.0, f64::INFINITY)] {
            assert_eq!(PolarPosition::new(range_m, azimuth_deg), None);
        }
    }

    #[test]
    fn flight_level_is_signed() {
        let level = FlightLevel::from_octets([0xff, 0xfb]);
        assert_eq!(level.flight_level(), -1.25);
        assert!(!level.is_validated() && level.is_garbled());
        assert_eq!(FlightLevel::new(-1.25), Some(FlightLevel::from_octets([0x3f, 0xfb])));
        assert_eq!(FlightLevel::new(370.0).map(FlightLevel::octets), Some(1480_u16.to_be_bytes()));
        assert_eq!(FlightLevel::new(2048.0), None);
    }

    #[test]
    fn height_is_signed_and_its_spare_bits_are_not_height() {
        let height = Height3D::from_octets([0xff, 0xfe]);
        assert_eq!(height.height_ft(), -50.0);
        assert!((height.height_m() + 15.24).abs() < 1e-12);
        assert_eq!(Height3D::from_metres(-15.24).map(Height3D::octets), Some([0x3f, 0xfe]));
        assert_eq!(Height3D::from_metres(3.81).map(Height3D::height_ft), Some(25.0)); // half a count
        assert_eq!(Height3D::from_metres(62_420.0), None);
    }
}
