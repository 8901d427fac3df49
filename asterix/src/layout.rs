//! Meaning of the bits of an item: the specification's tables as data.
//!
//! The typed items are generated from these descriptions (`item.rs`), and profiles list them. Code that prints or builds
//! records of any category iterates over them.

pub(crate) mod lengths;
pub(crate) mod uap;

use core::fmt;

use crate::bits;
use crate::fault::FaultKind;
use crate::joined::Joined;
use crate::variable::Explicit;
use lengths::Length;
use uap::UapItem;

/// A run of bits in an item. To change the key, create a new field with [`Field::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Name in lower case with its unit, unique in the item: `"rho_m"`; empty for the only field of an item.
    pub key: &'static str,
    /// Number of bits.
    pub bits: u16,
    /// Meaning of the bits.
    pub kind: Kind,
    joined: Joined,
}

/// Meaning of the bits of a [`Field`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// Spare bits: zero in a new record, kept as read.
    Spare,
    /// An unsigned integer: a count, or a code of a table of the specification.
    Count,
    /// An unsigned integer of which this value means "unknown" or "none".
    CountOr(u64),
    /// An unsigned integer whose count 0 represents this number.
    CountFrom(u64),
    /// A physical value: the count times `lsb`.
    Quantity(Quantity),
    /// Octal digits, three bits each: Mode 1, 2, 3/A and C codes.
    Octal,
    /// Bits without inner structure, four per hexadecimal digit; more than 64 begin with an octet.
    Hex,
    /// A 24-bit aircraft address: hexadecimal, by custom in capital letters.
    Address,
    /// Characters of 8 bits, ASCII.
    Ascii,
    /// Characters of 6 bits (ICAO Annex 10, volume IV, table 3-7).
    Icao,
    /// This number only: identifies a layout of a special purpose field.
    Constant(u64),
    /// The value of another field determines the meaning; an integer if it selects no case.
    Depends(&'static Dependence),
}

/// The meanings of a field, selected by the value of a previous field of the same list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dependence {
    /// Key of the selecting field.
    pub on: &'static str,
    /// Values of the selecting field, each with the field to use, which has the same number of bits and another key.
    pub cases: &'static [(u64, Field)],
}

impl Dependence {
    /// The field selected by the octets, in which `fields` begin at bit `at`; `None` if no case applies.
    pub fn case(&self, fields: &[Field], octets: &[u8], mut at: usize) -> Option<&'static Field> {
        for field in fields {
            if field.key == self.on {
                let said = field.count(octets, at);
                return self.cases.iter().find(|(value, _)| *value == said).map(|(_, case)| case);
            }
            at += usize::from(field.bits);
        }
        None
    }
}

/// Conversion of a count to a physical value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Whether the count is in two's complement.
    pub signed: bool,
    /// Value of one count, in the unit of the field's key.
    pub lsb: f64,
    /// Number of decimals sufficient to restore the count by rounding.
    pub decimals: u8,
    /// The count that means "unknown", if there is one.
    pub unknown: Option<u64>,
}

/// The structure of an item, which determines its length (EUROCONTROL-SPEC-0149, part 1, section 4.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// Consecutive fields of a fixed whole number of octets.
    Fields(&'static [Field]),
    /// Octets of seven bits; all but the last have the lowest bit (FX) set. Octets beyond those described are kept.
    Extended(&'static [&'static [Field]]),
    /// Octets with a code of seven bits and FX, which states that another octet follows.
    Codes,
    /// Parts of whole octets. If the fields of a part leave its last bit free, that bit is FX, which states that the next part
    /// follows. Otherwise it is the last part. Further parts are not allowed.
    Parts(&'static [&'static [Field]]),
    /// These fields and FX, which fill whole octets; repeated while FX states that another follows.
    Chained(&'static [Field]),
    /// One octet with the number of repetitions (0 is allowed), then that number of these fields.
    Repetitive(&'static [Field]),
    /// A primary subfield whose bits announce the subfields that follow: seven per octet and FX, which is set only if there are
    /// more subfields to announce.
    Compound(&'static [Subfield]),
    /// One octet with the length of the item, including itself.
    Explicit(Contents),
    /// I129/120 only: these fields of one octet, and two more octets or none; see [`crate::cat129::OperationalRisk`].
    OneOrThree(&'static [Field]),
    /// Random field sequencing, in the oldest categories: one octet with a count, then that number of items of this list, each
    /// after its field reference number.
    Sequence(&'static [UapItem]),
}

/// A part of a compound item. To change the structure, create a new subfield with [`Subfield::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subfield {
    /// Name in lower case, with its unit if it is a single value; empty for an undefined subfield, whose length is unknown.
    pub key: &'static str,
    /// Structure of the subfield.
    pub layout: Layout,
    pub(crate) length: Length,
    joined: Joined,
}

impl Subfield {
    /// A bit of the primary subfield for which the specification defines no subfield.
    pub(crate) const UNDEFINED: Self = Self::new("", Layout::Fields(&[]));

    /// A subfield with this key and structure.
    pub const fn new(key: &'static str, layout: Layout) -> Self {
        let length = if key.is_empty() { Length::Undefined } else { Length::of(&layout) };
        Self { key, layout, length, joined: Joined::of(key) }
    }

    /// Like [`Layout::measure`], without reading the fields.
    #[inline]
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        self.length.measure(octets)
    }

    /// The key for JSON.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }
}

/// Possible contents after the length octet of an explicit item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contents {
    /// Any octets, whose meaning the users define.
    Opaque,
    /// One of these forms, or any octets.
    Known(&'static [Form]),
    /// A reserved expansion field: one octet whose eight bits announce these subfields, then the subfields; or any octets.
    Expansion(&'static [Subfield]),
}

/// A user-defined form of an explicit item. An item has this form if its length and all [`Kind::Constant`] fields agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Name of the form in JSON. Forms with the same name differ in their fields.
    pub key: &'static str,
    /// Fields after the length octet.
    pub fields: &'static [Field],
}

impl Field {
    /// A field with this key, number of bits and meaning.
    pub const fn new(key: &'static str, bits: u16, kind: Kind) -> Self {
        Self { key, bits, kind, joined: Joined::of(key) }
    }

    /// The key for JSON.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }

    /// The bits of this field if it begins at bit `at` of `octets`: at most 64 bits, or the first 64 of a text.
    ///
    /// Panics if the field exceeds the octets.
    #[inline]
    pub fn count(&self, octets: &[u8], at: usize) -> u64 {
        bits::get(octets, at, usize::from(self.bits.min(64)))
    }

    /// Sets the bits of this field, at most 64, to the lowest bits of `count`; the field begins at bit `at` of `octets`.
    ///
    /// Panics if the field exceeds the octets.
    #[inline]
    pub fn set_count(&self, octets: &mut [u8], at: usize, count: u64) {
        bits::put(octets, at, usize::from(self.bits.min(64)), count);
    }
}

/// Total length of `fields`, in octets.
pub const fn octets_of(fields: &[Field]) -> usize {
    let bits = bits_of(fields);
    assert!(bits % 8 == 0, "the fields are whole octets");
    bits / 8
}

/// Total number of bits of `fields`.
pub(crate) const fn bits_of(fields: &[Field]) -> usize {
    let (mut index, mut bits) = (0, 0);
    while index < fields.len() {
        bits += fields[index].bits as usize;
        index += 1;
    }
    bits
}

impl Layout {
    /// Index of the first bit of the field with this key, for accessors. An unknown key does not compile.
    pub(crate) const fn place(&self, key: &str) -> usize {
        let place = match self {
            Self::Fields(fields) => place_in(fields, key),
            Self::Extended(parts) | Self::Parts(parts) => {
                let (mut index, mut octets) = (0, 0);
                loop {
                    assert!(index < parts.len(), "no part of the item has this field");
                    if let Some(place) = place_in(parts[index], key) {
                        break Some(8 * octets + place);
                    }
                    octets += bits_of(parts[index]).div_ceil(8);
                    index += 1;
                }
            }
            _ => None,
        };
        place.expect("the item has this field")
    }

    /// Length, in octets, of the item at the start of `octets`, which extend to the end of the block.
    ///
    /// [`Layout::OneOrThree`] counts as 1: its length is known only after the whole record.
    ///
    /// [`UapItem::measure`] and [`Subfield::measure`] return the same without reading the fields.
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        Length::of(self).measure(octets)
    }
}

/// A field of a layout.
pub(crate) const fn field(key: &'static str, bits: u16, kind: Kind) -> Field {
    Field::new(key, bits, kind)
}

/// A physical value that is never unknown.
pub(crate) const fn quantity(signed: bool, lsb: f64, decimals: u8) -> Kind {
    Kind::Quantity(Quantity { signed, lsb, decimals, unknown: None })
}

/// A reserved expansion field with these subfields.
pub(crate) const fn expansion(subfields: &'static [Subfield]) -> Layout {
    Layout::Explicit(Contents::Expansion(subfields))
}

/// Whether two texts are equal, for use in constants.
const fn same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut index = 0;
    while index < one.len() && index < other.len() && one[index] == other[index] {
        index += 1;
    }
    index == one.len() && index == other.len()
}

/// Index of the first bit of the field with this key; `None` if there is none.
const fn place_in(fields: &[Field], key: &str) -> Option<usize> {
    let (mut index, mut bits) = (0, 0);
    while index < fields.len() {
        if same(fields[index].key, key) {
            return Some(bits);
        }
        bits += fields[index].bits as usize;
        index += 1;
    }
    None
}

/// Formats an item of fixed length as a struct with its fields.
pub(crate) fn debug(f: &mut fmt::Formatter<'_>, name: &str, fields: &[Field], octets: &[u8]) -> fmt::Result {
    let mut shown = f.debug_struct(name);
    let mut at = 0;
    for field in fields {
        let width = usize::from(field.bits);
        let count = bits::get(octets, at, width.min(64));
        match field.kind {
            Kind::Spare if count == 0 => {}
            Kind::Quantity(quantity) => {
                shown.field(field.key, &quantity.value(count, width));
            }
            Kind::Octal => {
                shown.field(field.key, &format_args!("{count:#o}"));
            }
            Kind::Hex => {
                shown.field(field.key, &format_args!("{count:#x}"));
            }
            _ => {
                shown.field(field.key, &count);
            }
        }
        at += width;
    }
    shown.finish()
}

impl Quantity {
    /// The physical value of a count of `width` bits.
    #[inline]
    pub fn value(self, count: u64, width: usize) -> f64 {
        let count = if self.signed { bits::signed(count, width) as f64 } else { count as f64 };
        count * self.lsb
    }

    /// The count of `width` bits nearest to a physical value, halves away from zero; `None` if it is out of range.
    pub fn count(self, value: f64, width: usize) -> Option<u64> {
        bits::nearest_count(value / self.lsb, width, self.signed).map(|count| count & bits::mask(width))
    }
}

/// A type with a layout.
pub trait Describe {
    /// The structure of the type and the meaning of its bits.
    const LAYOUT: Layout;
}

impl<const N: usize> Describe for [u8; N] {
    /// A text of ASCII characters.
    const LAYOUT: Layout = Layout::Fields(&[field("", 8 * N as u16, Kind::Ascii)]);
}

impl Describe for Explicit {
    const LAYOUT: Layout = Layout::Explicit(Contents::Opaque);
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn count(key: &'static str, bits: u16) -> Field {
        field(key, bits, Kind::Count)
    }

    #[test]
    fn measures_every_format() {
        const TWO: Layout = Layout::Fields(&[count("a", 12), count("b", 4)]);
        const THREE: Layout = Layout::Repetitive(&[count("", 24)]);
        const CHAIN: Layout = Layout::Extended(&[]);
        const PAIRS: Layout = Layout::Chained(&[count("a", 12), count("b", 3)]);
        const OPAQUE: Layout = Layout::Explicit(Contents::Opaque);
        const DOPPLER: Layout = Layout::Compound(&[
            Subfield::new("cal", TWO),
            Subfield::new("rds", Layout::Repetitive(&[count("", 48)])),
            Subfield::UNDEFINED,
        ]);
        const LONG: Layout = Layout::Compound(&[Subfield::new("a", TWO); 9]);
        const SEQUENCE: Layout =
            Layout::Sequence(&[UapItem::new(3, "030", "", TWO), UapItem::new(9, "090", "", THREE)]);
        let full = [0x01; 17];
        let many = [[0x01; 98].as_slice(), &[0x00; 2]].concat();
        for (layout, octets, expected) in [
            (TWO, &[0, 0, 0][..], Ok(2)),
            (TWO, &[0][..], Err(FaultKind::ItemPastEnd)),
            (CHAIN, &[1, 3, 2, 0][..], Ok(3)),
            (CHAIN, &[1, 3][..], Err(FaultKind::ItemPastEnd)),
            (CHAIN, &[][..], Err(FaultKind::ItemPastEnd)),
            (CHAIN, &full[..], Err(FaultKind::ChainTooLong)),
            (Layout::Codes, &many[..], Ok(99)),
            (Layout::Codes, &full[..], Err(FaultKind::ItemPastEnd)),
            (PAIRS, &many[..], Ok(100)),
            (PAIRS, &full[..], Err(FaultKind::ItemPastEnd)),
            (THREE, &[0][..], Ok(1)),
            (THREE, &[2, 0, 0, 0, 0, 0, 0][..], Ok(7)),
            (THREE, &[2, 0, 0, 0, 0, 0][..], Err(FaultKind::ItemPastEnd)),
            (THREE, &[][..], Err(FaultKind::NoRepetitionCount)),
            (OPAQUE, &[1][..], Ok(1)),
            (OPAQUE, &[3, 0, 0, 0][..], Ok(3)),
            (OPAQUE, &[0, 0][..], Err(FaultKind::LengthZero)),
            (OPAQUE, &[3, 0][..], Err(FaultKind::ItemPastEnd)),
            (OPAQUE, &[][..], Err(FaultKind::ItemPastEnd)),
            (DOPPLER, &[0x00][..], Ok(1)),
            (DOPPLER, &[0x80, 0, 0][..], Ok(3)),
            (DOPPLER, &[0xc0, 0, 0, 1, 0, 0, 0, 0, 0, 0][..], Ok(10)),
            (DOPPLER, &[0x40, 0][..], Ok(2)),
            (DOPPLER, &[0x20, 0][..], Err(FaultKind::ReservedSubfield)),
            (DOPPLER, &[0x02, 0][..], Err(FaultKind::ReservedSubfield)),
            (DOPPLER, &[0x80, 0][..], Err(FaultKind::ItemPastEnd)),
            (DOPPLER, &[0x40][..], Err(FaultKind::NoRepetitionCount)),
            (DOPPLER, &[0x81, 0, 0][..], Err(FaultKind::PrimarySubfieldExtended)),
            (DOPPLER, &[][..], Err(FaultKind::ItemPastEnd)),
            (LONG, &[0x01, 0x80, 0, 0][..], Ok(4)),
            (LONG, &[0x03, 0x40, 0, 0, 0, 0][..], Ok(6)),
            (LONG, &[0x02, 0, 0][..], Ok(3)),
            (LONG, &[0x01, 0x00][..], Ok(2)),
            (LONG, &[0x01, 0x20, 0, 0][..], Err(FaultKind::ReservedSubfield)),
            (LONG, &[0x01, 0x81, 0, 0][..], Err(FaultKind::PrimarySubfieldExtended)),
            (LONG, &[0x01][..], Err(FaultKind::ItemPastEnd)),
            (SEQUENCE, &[0][..], Ok(1)),
            (SEQUENCE, &[2, 3, 0, 0, 9, 1, 0, 0, 0, 7][..], Ok(9)),
            (SEQUENCE, &[2, 3, 0, 0, 9][..], Err(FaultKind::NoRepetitionCount)),
            (SEQUENCE, &[2, 3, 0, 0][..], Err(FaultKind::ItemPastEnd)),
            (SEQUENCE, &[1, 3, 0][..], Err(FaultKind::ItemPastEnd)),
            (SEQUENCE, &[1, 4, 0, 0][..], Err(FaultKind::ReservedFrn)),
            (SEQUENCE, &[][..], Err(FaultKind::NoRepetitionCount)),
        ] {
            assert_eq!(layout.measure(octets), expected, "{layout:?} of {octets:02x?}");
        }
    }
}
