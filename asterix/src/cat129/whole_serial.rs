//! Serial numbers too long for I129/040, in the special purpose field.

use super::fusion_report;
use crate::bits;
use crate::{Explicit, Field, Kind};

/// Start of a field with a serial number only: the letters `UF` and version 3.
const MAGIC: [u8; 3] = *b"UF\x03";
/// The field of the serial number.
pub(super) const FIELD: Field = Field::new("serial_number", 8 * WholeSerial::OCTETS as u16, Kind::Ascii);

/// The whole serial number of an aircraft (ANSI/CTA-2063-A: up to 20 characters), of which I129/040 holds the last 12.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WholeSerial([u8; Self::OCTETS]);

impl WholeSerial {
    /// Maximum length of a serial number, in octets.
    pub const OCTETS: usize = 20;
    /// The fields of a special purpose field with a serial number only, after the length octet.
    pub const FIELDS: &'static [Field] =
        &[Field::new("magic", 24, Kind::Constant(bits::get(&MAGIC, 0, 24))), FIELD];

    /// A serial number of at most 20 octets, padded with blanks; `None` if it is longer.
    pub fn new(serial: &[u8]) -> Option<Self> {
        let mut octets = [b' '; Self::OCTETS];
        octets.get_mut(..serial.len())?.copy_from_slice(serial);
        Some(Self(octets))
    }

    /// All octets, with trailing blanks.
    pub const fn octets(&self) -> &[u8; Self::OCTETS] {
        &self.0
    }

    /// The last 12 characters, which I129/040 holds.
    pub fn last(&self) -> [u8; 12] {
        let length = self.0.iter().rposition(|octet| !matches!(octet, 0 | b' ')).map_or(0, |last| last + 1);
        let end = length.max(12);
        core::array::from_fn(|at| self.0[end - 12 + at])
    }

    /// Decodes a special purpose field of layout `UF` version 2 or 3; `None` for any other.
    pub fn read(field: &Explicit) -> Option<Self> {
        let contents = field.contents();
        let before = match *contents.first_chunk()? {
            MAGIC => MAGIC.len(),
            fusion_report::MAGIC_WITH_SERIAL => fusion_report::OCTETS,
            _ => return None,
        };
        contents.get(before..)?.try_into().ok().map(Self)
    }

    /// The special purpose field of version 3, which holds only the serial number.
    pub fn to_field(&self) -> Explicit {
        let mut contents = [0; MAGIC.len() + Self::OCTETS];
        contents[..MAGIC.len()].copy_from_slice(&MAGIC);
        contents[MAGIC.len()..].copy_from_slice(&self.0);
        Explicit::new(&contents).expect("23 octets fit a special purpose field")
    }
}
