//! Identity reported by an aircraft.

use core::fmt;

use crate::bits;
use crate::item::items;

items! {
    /// I048/220 (5.2.22), I021/080 and ADR in I062/380: the aircraft's 24-bit address.
    /// The 24-bit address, by custom six hexadecimal digits, as `Display` writes it.
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
    /// I048/240 (5.2.24), I021/170 and ID in I062/380, aircraft identification: eight characters of 6 bits (ICAO Annex 10, volume IV, table 3-7).
    pub struct AircraftIdentification(6) {
        icao 48 "";
    }
}

impl AircraftIdentification {
    /// The identification with this text of capital letters, digits and spaces, padded with spaces to eight characters; `None` if
    /// it is longer or has other characters.
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

    /// The eight characters in ASCII, with trailing spaces; `?` for an undefined code.
    pub fn characters(self) -> [u8; 8] {
        core::array::from_fn(|index| match bits::get(&self.0, 6 * index, 6) as u8 {
            letter @ 1..=26 => letter - 1 + b'A',
            other @ (32 | 48..=57) => other,
            _ => b'?',
        })
    }
}

impl fmt::Display for AircraftIdentification {
    /// Writes the identification without trailing spaces.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let characters = self.characters();
        f.write_str(core::str::from_utf8(&characters).unwrap_or_default().trim_end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
