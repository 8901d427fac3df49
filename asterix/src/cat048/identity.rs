//! What the transponder says it is: I048/070, 220, 240.

use std::fmt;

use crate::bits;
use crate::item::items;

items! {
    /// I048/070 (5.2.10), Mode 3/A code.
    pub struct Mode3A(2) {
        /// V = 0: the code is validated.
        unset 1 "v" is_validated / with_validated;
        /// G = 1: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L = 1: the code was not extracted during the last scan.
        flag 1 "l" is_not_extracted / with_not_extracted;
        spare 1 "spare";
        /// The code, 0 to octal 7777: four octal digits, as [`Mode3A`]'s `Display` writes them.
        octal 12 "mode_3a" code / with_code: u16;
    }
}

impl Mode3A {
    /// A validated code read from the reply, or `None` above octal 7777.
    pub const fn new(code: u16) -> Option<Self> {
        Self([0; 2]).with_code(code)
    }
}

impl fmt::Display for Mode3A {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04o}", self.code())
    }
}

items! {
    /// I048/220 (5.2.22), the aircraft's 24-bit Mode S address.
    /// The address, 24 bits; usually written as six hexadecimal digits, as `Display` does.
    pub struct AircraftAddress(3) = address 24 "" address / with_address: u32;
}

impl AircraftAddress {
    /// The address, or `None` above 24 bits.
    pub const fn new(address: u32) -> Option<Self> {
        Self([0; 3]).with_address(address)
    }
}

impl fmt::Display for AircraftAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:06X}", self.address())
    }
}

items! {
    /// I048/240 (5.2.24), aircraft identification: eight characters of 6 bits (ICAO Annex 10, volume IV, table 3-7).
    pub struct AircraftIdentification(6) {
        icao 48 "";
    }
}

impl AircraftIdentification {
    /// The identification made of capital letters, digits and spaces, filled up with spaces to eight characters;
    /// `None` for a longer text or another character.
    pub fn new(text: &str) -> Option<Self> {
        if text.len() > 8 {
            return None;
        }
        let mut octets = [0; 6];
        for index in 0..8 {
            let code = match text.as_bytes().get(index).copied().unwrap_or(b' ') {
                letter @ b'A'..=b'Z' => letter - b'A' + 1,
                other @ (b' ' | b'0'..=b'9') => other,
                _ => return None,
            };
            bits::put(&mut octets, 6 * index, 6, code.into());
        }
        Some(Self(octets))
    }

    /// The eight characters in ASCII, trailing spaces included; `?` for a code that stands for no character.
    pub fn characters(self) -> [u8; 8] {
        std::array::from_fn(|index| match bits::get(&self.0, 6 * index, 6) as u8 {
            letter @ 1..=26 => letter - 1 + b'A',
            other @ (32 | 48..=57) => other,
            _ => b'?',
        })
    }
}

impl fmt::Display for AircraftIdentification {
    /// Without trailing spaces.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let characters = self.characters();
        f.write_str(std::str::from_utf8(&characters).unwrap_or_default().trim_end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_3a_is_octal() {
        let code = Mode3A::from_octets([0xe8, 0x04]);
        assert_eq!((code.code(), code.to_string().as_str()), (0o4004, "4004"));
        assert!(!code.is_validated() && code.is_garbled() && code.is_not_extracted());
        assert_eq!(Mode3A::new(0o7000).map(Mode3A::octets), Some([0x0e, 0x00]));
        assert_eq!(Mode3A::new(0o10000), None);
    }

    #[test]
    fn aircraft_address() {
        let address = AircraftAddress::new(0x4a_08eb).unwrap();
        assert_eq!((address.address(), address.to_string().as_str()), (0x4a_08eb, "4A08EB"));
        assert_eq!(AircraftAddress::new(1 << 24), None);
    }

    #[test]
    fn aircraft_identification() {
        let id = AircraftIdentification::new("ROT415").unwrap();
        assert_eq!(id.characters(), *b"ROT415  ");
        assert_eq!(id.to_string(), "ROT415");
        // R = 18, O = 15, T = 20, 4 = 52: 010010 001111 010100 110100
        assert_eq!(id.octets()[..3], [0x48, 0xf5, 0x34]);
        assert_eq!(AircraftIdentification([0; 6]).to_string(), "????????");
        assert_eq!(AircraftIdentification::new("rot"), None);
        assert_eq!(AircraftIdentification::new("123456789"), None);
    }
}
