//! What the transponder says it is: I048/070, 220, 240.

use std::fmt;

use deku::{DekuRead, DekuWrite};

use crate::item::{Describe, octets};
use crate::items::{octets24, word24};
use crate::layout::{count, field};
use crate::{Kind, Layout};

/// I048/070, Mode 3/A code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct Mode3A(u16);

impl Mode3A {
    /// The item as it stands: V, G, L, a spare bit and 12 bits of code.
    pub const fn from_word(word: u16) -> Self {
        Self(word)
    }

    /// A validated code read from the reply, or `None` above octal 7777.
    pub const fn new(code: u16) -> Option<Self> {
        if code <= 0o7777 { Some(Self(code)) } else { None }
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

    /// L = 1: the code was not extracted during the last scan.
    pub const fn is_not_extracted(self) -> bool {
        self.0 & 0x2000 != 0
    }

    /// The code, 0 to octal 7777: four octal digits, as [`Mode3A`]'s `Display` writes them.
    pub const fn code(self) -> u16 {
        self.0 & 0o7777
    }
}

impl fmt::Display for Mode3A {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04o}", self.code())
    }
}

impl Describe for Mode3A {
    const LAYOUT: Layout = Layout::Fields(&[
        count("v", 1),
        count("g", 1),
        count("l", 1),
        field("spare", 1, Kind::Spare),
        field("mode_3a", 12, Kind::Octal),
    ]);
}

/// I048/220, the aircraft's 24-bit Mode S address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AircraftAddress([u8; 3]);

octets!(AircraftAddress, 3);

impl AircraftAddress {
    /// The address, or `None` above 24 bits.
    pub const fn new(address: u32) -> Option<Self> {
        if address >> 24 == 0 { Some(Self(octets24(address))) } else { None }
    }

    /// The address, 24 bits; usually written as six hexadecimal digits, as `Display` does.
    pub const fn address(self) -> u32 {
        word24(self.0)
    }
}

impl fmt::Display for AircraftAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:06X}", self.address())
    }
}

impl Describe for AircraftAddress {
    const LAYOUT: Layout = Layout::Fields(&[field("", 24, Kind::Address)]);
}

/// I048/240, aircraft identification: eight characters of 6 bits (ICAO Annex 10, volume IV, table 3-7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AircraftIdentification([u8; 6]);

octets!(AircraftIdentification, 6);

impl AircraftIdentification {
    /// The identification made of capital letters, digits and spaces, filled up with spaces to eight characters;
    /// `None` for a longer text or another character.
    pub fn new(text: &str) -> Option<Self> {
        if text.len() > 8 {
            return None;
        }
        let mut word = 0;
        for index in 0..8 {
            let code = match text.as_bytes().get(index).copied().unwrap_or(b' ') {
                letter @ b'A'..=b'Z' => letter - b'A' + 1,
                other @ (b' ' | b'0'..=b'9') => other,
                _ => return None,
            };
            word = word << 6 | u64::from(code);
        }
        let [_, _, octets @ ..] = word.to_be_bytes();
        Some(Self(octets))
    }

    /// The item as it stands.
    pub const fn from_octets(octets: [u8; 6]) -> Self {
        Self(octets)
    }

    /// The item as it stands.
    pub const fn octets(self) -> [u8; 6] {
        self.0
    }

    /// The eight characters in ASCII, trailing spaces included; `?` for a code that stands for no character.
    pub fn characters(self) -> [u8; 8] {
        let [a, b, c, d, e, f] = self.0;
        let word = u64::from_be_bytes([0, 0, a, b, c, d, e, f]);
        std::array::from_fn(|index| match (word >> (42 - 6 * index) & 0x3f) as u8 {
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

impl Describe for AircraftIdentification {
    const LAYOUT: Layout = Layout::Fields(&[field("", 48, Kind::Icao)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_3a_is_octal() {
        let code = Mode3A::from_word(0xe804);
        assert_eq!((code.code(), code.to_string().as_str()), (0o4004, "4004"));
        assert!(!code.is_validated() && code.is_garbled() && code.is_not_extracted());
        assert_eq!(Mode3A::new(0o7000).map(Mode3A::word), Some(0x0e00));
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
