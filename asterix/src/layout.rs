//! What the bits of an item mean: the specification's tables as data.
//!
//! The typed items are made from these descriptions (`item.rs`), profiles list them, and whoever prints or builds records
//! without knowing their category walks them.

use core::fmt;

use crate::bits;
use crate::fault::FaultKind;
use crate::joined::Joined;
use crate::lengths::Length;
use crate::uap::UapItem;
use crate::variable::Explicit;

/// A run of bits in an item. Another key takes another one, made by [`Field::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Its name in lower case with its unit, unique in the item: `"rho_m"`; empty for the only field of an item.
    pub key: &'static str,
    /// How many bits.
    pub bits: u16,
    /// What they are.
    pub kind: Kind,
    joined: Joined,
}

/// What the bits of a [`Field`] are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// Nothing; zero in a record built anew, kept as read.
    Spare,
    /// A whole number, unsigned: a count, or a code of a table of the specification.
    Count,
    /// A whole number, unsigned, of which this value means "unknown" or "none".
    CountOr(u64),
    /// A whole number, unsigned, whose count 0 stands for this number.
    CountFrom(u64),
    /// A physical value: the count times `lsb`.
    Quantity(Quantity),
    /// Octal digits, three bits each: Mode 1, 2, 3/A and C codes.
    Octal,
    /// Bits without an inner order, four to a hexadecimal digit; those of more than 64 begin with an octet.
    Hex,
    /// A 24-bit aircraft address: hexadecimal, by custom in capital letters.
    Address,
    /// Characters of 8 bits, ASCII.
    Ascii,
    /// Characters of 6 bits (ICAO Annex 10, volume IV, table 3-7).
    Icao,
    /// This number and no other: how a layout of a special purpose field is recognised.
    Constant(u64),
    /// What another field says; a whole number where it says none of it.
    Depends(&'static Dependence),
}

/// What a field is, as one that stands before it among the same fields says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dependence {
    /// The key of that field.
    pub on: &'static str,
    /// What it says, and this field then: without a number, of as many bits.
    pub cases: &'static [(u64, Field)],
}

impl Dependence {
    /// The field that is meant by the octets, of which `fields` begin at bit `at`; `None` where no case is.
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

/// How a count becomes a physical value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Whether the count is in two's complement.
    pub signed: bool,
    /// Value of one count, in the unit of the field's key.
    pub lsb: f64,
    /// Decimals that are enough to round back to the count.
    pub decimals: u8,
    /// The count that means "unknown", where there is one.
    pub unknown: Option<u64>,
}

/// The structure of an item, which also says how its length is found (EUROCONTROL-SPEC-0149, part 1, section 4.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// Fields one after the other, always the same whole number of octets.
    Fields(&'static [Field]),
    /// Octets of seven bits, of which all but the last have the lowest bit (FX) set. Further octets than those described
    /// are kept.
    Extended(&'static [&'static [Field]]),
    /// Octets of a code of seven bits and FX, which says that another follows.
    Codes,
    /// Parts of whole octets. Where the fields of one leave the last bit, that is FX, and set where the next part follows;
    /// where they do not, it is the last part. There are no further ones.
    Parts(&'static [&'static [Field]]),
    /// These fields and FX, which fill whole octets, as often as FX says that another follows.
    Chained(&'static [Field]),
    /// One octet that counts the repetitions (0 is allowed), then that many times these fields.
    Repetitive(&'static [Field]),
    /// A primary subfield whose bits announce the subfields that follow: seven an octet and FX, which is set only while
    /// there are more subfields to announce.
    Compound(&'static [Subfield]),
    /// One octet that counts all octets of the item, itself included.
    Explicit(Contents),
    /// I129/120 alone: these fields, which are one octet, and two more octets or none; see
    /// [`crate::cat129::OperationalRisk`].
    OneOrThree(&'static [Field]),
    /// Random field sequencing, in the oldest categories: one octet that counts, then that many times the field reference
    /// number of one of these items and that item.
    Sequence(&'static [UapItem]),
}

/// A part of a compound item. Another structure takes another one, made by [`Subfield::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subfield {
    /// Its name in lower case, with the unit when it is a single value; empty where the specification defines none: such a
    /// subfield cannot be measured.
    pub key: &'static str,
    /// Its structure.
    pub layout: Layout,
    pub(crate) length: Length,
    joined: Joined,
}

impl Subfield {
    /// A bit of the primary subfield that the specification leaves without a subfield.
    pub(crate) const UNDEFINED: Self = Self::new("", Layout::Fields(&[]));

    /// The subfield of this key and structure.
    pub const fn new(key: &'static str, layout: Layout) -> Self {
        let length = if key.is_empty() { Length::Undefined } else { Length::of(&layout) };
        Self { key, layout, length, joined: Joined::of(key) }
    }

    /// As [`Layout::measure`].
    #[inline]
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        self.length.measure(octets)
    }

    /// Its key as JSON has it.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }
}

/// What may stand behind the length octet of an explicit item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contents {
    /// Anything: users agree on it among themselves.
    Opaque,
    /// Anything, or one of these forms.
    Known(&'static [Form]),
    /// Anything, or a reserved expansion field: one octet whose eight bits announce these subfields, then those.
    Expansion(&'static [Subfield]),
}

/// Fields of an explicit item that users agree on: it has them where its length and all [`Kind::Constant`] agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Name of the form in JSON. Forms with the same name differ in their fields.
    pub key: &'static str,
    /// Fields, from the first octet behind the length octet.
    pub fields: &'static [Field],
}

impl Field {
    /// The field of this key, so many bits, and meaning.
    pub const fn new(key: &'static str, bits: u16, kind: Kind) -> Self {
        Self { key, bits, kind, joined: Joined::of(key) }
    }

    /// Its key as JSON has it.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }

    /// The bits of this field where it begins at bit `at` of `octets`: of its at most 64 bits, or of the first 64 of a text.
    ///
    /// Panics beyond the octets.
    #[inline]
    pub fn count(&self, octets: &[u8], at: usize) -> u64 {
        bits::get(octets, at, usize::from(self.bits.min(64)))
    }

    /// Sets the bits of this field, at most 64, where it begins at bit `at` of `octets`, to the low bits of `count`.
    ///
    /// Panics beyond the octets.
    #[inline]
    pub fn set_count(&self, octets: &mut [u8], at: usize, count: u64) {
        bits::put(octets, at, usize::from(self.bits.min(64)), count);
    }
}

/// Octets that `fields` take together.
pub const fn octets_of(fields: &[Field]) -> usize {
    let bits = bits_of(fields);
    assert!(bits % 8 == 0, "the fields are whole octets");
    bits / 8
}

/// Bits that `fields` take together.
pub(crate) const fn bits_of(fields: &[Field]) -> usize {
    let (mut index, mut bits) = (0, 0);
    while index < fields.len() {
        bits += fields[index].bits as usize;
        index += 1;
    }
    bits
}

impl Layout {
    /// The bit at which the field with this key begins, for accessors: a key without a field does not compile.
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

    /// Octets of the item at the front of `octets`, which go to the end of the block.
    ///
    /// [`Layout::OneOrThree`] counts as 1: which of the two it is shows only after the whole record.
    ///
    /// [`UapItem::measure`] and [`Subfield::measure`] do the same without a look at the fields.
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        Length::of(self).measure(octets)
    }
}

/// A line of a layout.
pub(crate) const fn field(key: &'static str, bits: u16, kind: Kind) -> Field {
    Field::new(key, bits, kind)
}

/// A physical value that is always known.
pub(crate) const fn quantity(signed: bool, lsb: f64, decimals: u8) -> Kind {
    Kind::Quantity(Quantity { signed, lsb, decimals, unknown: None })
}

/// A reserved expansion field of these subfields.
pub(crate) const fn expansion(subfields: &'static [Subfield]) -> Layout {
    Layout::Explicit(Contents::Expansion(subfields))
}

/// Whether two texts are the same, in a constant.
const fn same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut index = 0;
    while index < one.len() && index < other.len() && one[index] == other[index] {
        index += 1;
    }
    index == one.len() && index == other.len()
}

/// The bit at which the field with this key begins; `None` where no field has it.
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

/// Prints an item of a fixed length as a struct with its fields.
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

    /// The count of `width` bits nearest to a physical value, halves away from zero; `None` out of range.
    pub fn count(self, value: f64, width: usize) -> Option<u64> {
        bits::nearest_count(value / self.lsb, width, self.signed).map(|count| count & bits::mask(width))
    }
}

/// What has a place in the description of a category.
pub trait Describe {
    /// Its structure and what its bits mean.
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
