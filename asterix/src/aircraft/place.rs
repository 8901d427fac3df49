//! Position reported by an aircraft.

use crate::item::items;

items! {
    /// I129/080 (5.2.8) and I021/131, position in WGS-84. Values out of range are decoded; see [`Position::in_range`].
    pub struct Position(8) {
        /// Latitude in degrees, north positive: LSB 180/2^30 degrees (1.9 cm), -90 to 90 degrees; the bits hold -360 to below
        /// 360.
        signed 32 "latitude_deg" latitude_deg / with_latitude_deg = 180.0 / 1_073_741_824.0, 8;
        /// Longitude in degrees, east positive: LSB 180/2^30 degrees (1.9 cm along the equator), -180 to 180 degrees; the bits
        /// hold -360 to below 360.
        signed 32 "longitude_deg" longitude_deg / with_longitude_deg = 180.0 / 1_073_741_824.0, 8;
    }

    /// I021/130, POS in I062/110 and I062/380: position in WGS-84 in 24 bits.
    pub struct CoarsePosition(6) {
        /// Latitude in degrees, north positive: LSB 180/2^23 degrees (2.4 m), -90 to 90 degrees; the bits hold -180 to below
        /// 180.
        signed 24 "latitude_deg" latitude_deg / with_latitude_deg = 180.0 / 8_388_608.0, 5;
        /// Longitude in degrees, east positive: LSB 180/2^23 degrees (2.4 m along the equator), -180 to below 180 degrees.
        signed 24 "longitude_deg" longitude_deg / with_longitude_deg = 180.0 / 8_388_608.0, 5;
    }
}

/// Constructor and range check of a position.
macro_rules! on_earth {
    ($($name:ident)*) => {$(
        impl $name {
            /// The nearest position; `None` outside -90 to 90 degrees of latitude, -180 to 180 degrees of longitude or what
            /// the bits hold.
            pub fn new(latitude_deg: f64, longitude_deg: f64) -> Option<Self> {
                let position =
                    Self::default().with_latitude_deg(latitude_deg)?.with_longitude_deg(longitude_deg)?;
                position.in_range().then_some(position)
            }

            /// Whether latitude is within 90 and longitude within 180 degrees.
            pub const fn in_range(self) -> bool {
                self.latitude_deg().abs() <= 90.0 && self.longitude_deg().abs() <= 180.0
            }
        }
    )*};
}

on_earth! { Position CoarsePosition }

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn position() {
        let position = Position::new(54.5, 15.0).unwrap();
        assert_eq!(position.octets(), [0x13, 0x60, 0xb6, 0x0b, 0x05, 0x55, 0x55, 0x55]);
        assert!(
            (position.latitude_deg() - 54.5).abs() < 1e-7 && (position.longitude_deg() - 15.0).abs() < 1e-7
        );
        let corner = Position::new(-90.0, 180.0).unwrap();
        assert_eq!(corner.octets(), [0xe0, 0, 0, 0, 0x40, 0, 0, 0]);
        assert!(corner.in_range());
        assert!(!Position::from_octets([0x20, 0, 0, 1, 0, 0, 0, 0]).in_range());
        assert!(!Position::from_octets([0, 0, 0, 0, 0x80, 0, 0, 0]).in_range());
        for (latitude_deg, longitude_deg) in [(90.1, 0.0), (0.0, -180.1), (f64::NAN, 0.0)] {
            assert_eq!(Position::new(latitude_deg, longitude_deg), None);
        }
    }
}
