//! Identity and position of the track: I062/015, 040, 060, 100, 105, 120, 135, 245, 270, 300.

use core::fmt;

use crate::aircraft::AircraftIdentification;
use crate::bits;
use crate::item::items;

items! {
    /// I062/015, service identification, assigned by the system.
    /// The number, 0 to 255.
    pub struct ServiceIdentification(1) = count 8 "" number / with_number: u8;

    /// I062/040, track number assigned by the system.
    /// The number, 0 to 65535.
    pub struct TrackNumber(2) = count 16 "" number / with_number: u16;
}

impl TrackNumber {
    /// The track with this number.
    pub const fn new(number: u16) -> Self {
        Self(number.to_be_bytes())
    }
}

items! {
    /// I062/060, Mode 3/A code of the track.
    pub struct Mode3A(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// CH: the code has changed.
        flag 1 "ch" is_changed / with_changed;
        spare 1 "spare";
        /// The code, 0 to octal 7777: four octal digits, as `Display` writes them.
        octal 12 "mode_3a" code / with_code: u16;
    }
}

impl fmt::Display for Mode3A {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04o}", self.code())
    }
}

items! {
    /// I062/100, calculated position in the system's Cartesian plane.
    pub struct CartesianPosition(6) {
        /// X, metres east of the system reference point: LSB 0.5 m, -4,194,304 to 4,194,303.5 m.
        signed 24 "x_m" x_m / with_x_m = 0.5, 1;
        /// Y, metres north of the system reference point: LSB 0.5 m, -4,194,304 to 4,194,303.5 m.
        signed 24 "y_m" y_m / with_y_m = 0.5, 1;
    }

    /// I062/105, calculated position in WGS-84. Values out of range are decoded; see [`Position::in_range`].
    pub struct Position(8) {
        /// Latitude in degrees, north positive: LSB 180/2^25 degrees (0.6 m), -90 to 90 degrees.
        signed 32 "latitude_deg" latitude_deg / with_latitude_deg = 180.0 / 33_554_432.0, 6;
        /// Longitude in degrees, east positive: LSB 180/2^25 degrees (0.6 m along the equator), -180 to below 180 degrees.
        signed 32 "longitude_deg" longitude_deg / with_longitude_deg = 180.0 / 33_554_432.0, 6;
    }
}

impl Position {
    /// The nearest position; `None` outside -90 to 90 degrees of latitude or -180 to 180 degrees of longitude.
    pub fn new(latitude_deg: f64, longitude_deg: f64) -> Option<Self> {
        let position = Self::default().with_latitude_deg(latitude_deg)?.with_longitude_deg(longitude_deg)?;
        position.in_range().then_some(position)
    }

    /// Whether latitude is within 90 and longitude within 180 degrees.
    pub const fn in_range(self) -> bool {
        self.latitude_deg().abs() <= 90.0 && self.longitude_deg().abs() <= 180.0
    }
}

items! {
    /// I062/120, Mode 2 code of the track.
    pub struct Mode2(2) {
        spare 4 "spare";
        /// The code, 0 to octal 7777.
        octal 12 "mode_2" code / with_code: u16;
    }

    /// I062/135, calculated barometric altitude.
    pub struct BarometricAltitude(2) {
        /// QNH: corrected to the local pressure.
        flag 1 "qnh" is_corrected / with_corrected;
        /// Hundreds of feet: LSB 1/4 (25 ft), -15 to 1500; the bits hold -4096 to 4095.75.
        signed 15 "flight_level" flight_level / with_flight_level = 0.25, 2;
    }

    /// STI in I062/245: source of the identification.
    pub enum IdentificationSource {
        /// call sign or registration, from the aircraft.
        Downlinked = 0,
        /// call sign, not from the aircraft.
        Callsign = 1,
        /// registration, not from the aircraft.
        Registration = 2,
        /// not a valid code.
        Invalid = 3,
    }

    /// I062/245, target identification.
    pub struct TargetIdentification(7) {
        /// STI, source of the identification.
        code 2 "sti" source / with_source: IdentificationSource;
        spare 6 "spare";
        icao 48 "chr";
    }
}

impl TargetIdentification {
    /// This identification, from this source.
    pub fn new(source: IdentificationSource, identification: AircraftIdentification) -> Self {
        let word = identification.octets().iter().fold(0, |word, &octet| word << 8 | u64::from(octet));
        Self(bits::set([0; 7], 8, 48, word)).with_source(source)
    }

    /// The eight characters.
    pub fn identification(self) -> AircraftIdentification {
        let [_, characters @ ..] = self.0;
        AircraftIdentification::from_octets(characters)
    }
}

items! {
    /// I062/270, size and orientation: one octet and, where sent, its extensions. Absent values are 0.
    extended pub struct TargetSize {
        first {
            /// Length in metres: LSB 1 m, 0 to 127 m.
            count 7 "length_m" length_m / with_length_m: u8;
        }
        extension {
            /// Orientation in degrees, clockwise from true north: LSB 360/128 degrees (2.8125), 0 to below 360 degrees.
            unsigned 7 "orientation_deg" orientation_deg / with_orientation_deg = 360.0 / 128.0, 1;
        }
        extension {
            /// Width in metres: LSB 1 m, 0 to 127 m.
            count 7 "width_m" width_m / with_width_m: u8;
        }
    }

    /// I062/300: fleet of a vehicle.
    pub enum Fleet {
        /// unknown.
        Unknown = 0,
        /// maintenance of air traffic control equipment.
        ControlEquipment = 1,
        /// maintenance of the airport.
        Airport = 2,
        /// fire brigade.
        Fire = 3,
        /// bird scarer.
        BirdScarer = 4,
        /// snow plough.
        SnowPlough = 5,
        /// runway sweeper.
        Sweeper = 6,
        /// emergency.
        Emergency = 7,
        /// police.
        Police = 8,
        /// bus.
        Bus = 9,
        /// tug.
        Tug = 10,
        /// grass cutter.
        GrassCutter = 11,
        /// fuel.
        Fuel = 12,
        /// baggage.
        Baggage = 13,
        /// catering.
        Catering = 14,
        /// maintenance of aircraft.
        Aircraft = 15,
        /// follow-me car.
        FollowMe = 16,
    }

    /// I062/300, vehicle fleet identification.
    /// The fleet.
    pub struct FleetIdentification(1) = code 8 "" fleet / with_fleet: Fleet;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identification_stands_behind_its_source() {
        let rot = AircraftIdentification::new("ROT415").unwrap();
        let item = TargetIdentification::new(IdentificationSource::Callsign, rot);
        assert_eq!(item.octets(), [0x40, 0x48, 0xf5, 0x34, 0xc7, 0x58, 0x20]);
        assert_eq!((item.source(), item.identification()), (IdentificationSource::Callsign, rot));
    }

    #[test]
    fn position_is_on_the_earth() {
        let position = Position::new(-45.0, 90.0).unwrap();
        assert_eq!(position.octets(), [0xff, 0x80, 0, 0, 0x01, 0, 0, 0]);
        assert_eq!(Position::new(90.1, 0.0), None);
        assert!(!Position::from_octets([0x7f; 8]).in_range());
    }
}
