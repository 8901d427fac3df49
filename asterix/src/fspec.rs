//! The field specification (FSPEC), which states the items of a record.

use alloc::vec::Vec;

use crate::fault::FaultKind;

/// The FSPEC of a record.
///
/// An octet has seven field reference numbers (FRN), the first in the highest bit; the lowest bit (FX) states that another octet
/// follows. Trailing octets without an item are legal and occur, so the length is stored in addition to the bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fspec {
    /// The octets with their FX bits, the first in the highest bits.
    bits: u64,
    /// Number of octets, 1 to [`Fspec::MAX_OCTETS`].
    length: u8,
}

/// The FX bit of each of the eight octets.
const EXTENSIONS: u64 = 0x0101_0101_0101_0101;

impl Fspec {
    /// Maximum length of an FSPEC, in octets. CAT048 needs 4 octets, CAT129 3; the others allow for padding.
    pub const MAX_OCTETS: usize = 8;

    /// Decodes the FSPEC at the start of `octets`.
    pub fn read(octets: &[u8]) -> Result<Self, FaultKind> {
        Self::at_front(octets).ok_or_else(|| {
            let ends = octets.iter().any(|octet| octet & 1 == 0);
            if ends { FaultKind::FspecTooLong } else { FaultKind::FspecPastEnd }
        })
    }

    /// The octets at the start up to the first without FX; `None` if there is none in the first [`Fspec::MAX_OCTETS`].
    #[inline]
    pub(crate) fn at_front(octets: &[u8]) -> Option<Self> {
        let word = front_word(octets);
        let ends = !word & EXTENSIONS;
        let length = ends.leading_zeros() / 8 + 1;
        // After eight octets no bits remain.
        let behind = u64::MAX.checked_shr(8 * length).unwrap_or(0);
        (ends != 0).then_some(Self { bits: word & !behind, length: length as u8 })
    }

    /// The shortest FSPEC for the items that are `present` (index 0 is FRN 1), followed by `padding` empty octets, limited to
    /// [`Fspec::MAX_OCTETS`].
    pub fn of<const N: usize>(present: [bool; N], padding: u8) -> Self {
        const { assert!(N <= 7 * Self::MAX_OCTETS) };
        let frns = present.iter().zip(1..).fold(Frns::NONE, |frns, (&present, frn)| frns.with(frn, present));
        Self::announcing(frns, padding)
    }

    /// Like [`Fspec::of`], for a set of field reference numbers.
    #[inline]
    pub(crate) const fn announcing(frns: Frns, padding: u8) -> Self {
        let Frns(bits) = frns;
        let length = minimal_length(bits).saturating_add(padding);
        let length = if length > Self::MAX_OCTETS as u8 { Self::MAX_OCTETS as u8 } else { length };
        let all_but_last = EXTENSIONS & !(u64::MAX >> (8 * (length - 1)));
        Self { bits: bits | all_but_last, length }
    }

    /// Whether the item with this field reference number (1 to 56) is present.
    #[inline]
    pub const fn has(self, frn: u8) -> bool {
        self.bits >> (63 - bit_index(frn)) & 1 == 1
    }

    /// Length in octets.
    pub const fn length(self) -> usize {
        self.length as usize
    }

    /// Number of octets after the last one that announces an item (after the first, if none does).
    pub const fn padding(self) -> u8 {
        self.length - minimal_length(self.bits & !EXTENSIONS)
    }

    /// Whether `defined` contains every item that it announces.
    #[inline]
    pub(crate) const fn is_within(self, defined: Frns) -> bool {
        self.announced().0 & !defined.0 == 0
    }

    /// The items that it announces.
    #[inline]
    pub(crate) const fn announced(self) -> Frns {
        Frns(self.bits & !EXTENSIONS)
    }

    /// The FSPEC of octets with these bits, the first in the highest bits; all but the last must have FX.
    pub(crate) const fn from_bits(bits: u64, length: u8) -> Self {
        Self { bits, length }
    }

    /// The octets, and how many of them are used.
    pub(crate) const fn octets(self) -> ([u8; Self::MAX_OCTETS], usize) {
        (self.bits.to_be_bytes(), self.length())
    }

    /// Appends the octets.
    pub fn encode_into(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.bits.to_be_bytes()[..self.length()]);
    }
}

/// The shortest FSPEC that announces these field reference numbers (1 to 56), in any order.
impl FromIterator<u8> for Fspec {
    fn from_iter<I: IntoIterator<Item = u8>>(frns: I) -> Self {
        Self::announcing(frns.into_iter().fold(Frns::NONE, |frns, frn| frns.with(frn, true)), 0)
    }
}

/// The first eight octets as one word; missing octets are replaced by FX bits.
#[inline]
fn front_word(octets: &[u8]) -> u64 {
    match octets.first_chunk() {
        Some(eight) => u64::from_be_bytes(*eight),
        None => octets.iter().rev().fold(EXTENSIONS, |word, &octet| word >> 8 | u64::from(octet) << 56),
    }
}

/// A set of field reference numbers, each in its bit of an FSPEC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frns(u64);

impl Frns {
    /// The empty set.
    pub const NONE: Self = Self(0);

    /// The set with this number (1 to 56) added, if it is `present`.
    #[inline]
    #[must_use]
    pub const fn with(self, frn: u8, present: bool) -> Self {
        Self(self.0 | (present as u64) << (63 - bit_index(frn)))
    }

    /// The size of the set.
    #[inline]
    pub const fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The numbers announced by the first eight octets of an FSPEC of any length.
    pub fn at_front(fspec: &[u8]) -> Self {
        let (first, _) = fspec.split_at(fspec.len().min(Fspec::MAX_OCTETS));
        Self(front_word(first) & !EXTENSIONS)
    }

    /// The numbers in ascending order.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = u8> {
        let Self(mut left) = self;
        core::iter::from_fn(move || {
            let bit = left.leading_zeros();
            left &= !(1_u64 << 63).checked_shr(bit)?;
            Some((bit - bit / 8 + 1) as u8)
        })
    }

    /// The first eight numbers as bits of one octet without FX, the first in the highest bit.
    pub const fn eight(self) -> u8 {
        (self.0 >> 56) as u8 | (self.0 >> 55) as u8 & 1
    }
}

/// Index of the bit of this field reference number, counted from the highest bit.
const fn bit_index(frn: u8) -> u8 {
    (frn - 1) + (frn - 1) / 7
}

/// Number of octets up to the last one that is not zero; at least one.
const fn minimal_length(bits: u64) -> u8 {
    let used = (71 - bits.trailing_zeros() as u8) / 8;
    if used == 0 { 1 } else { used }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_frns_over_several_octets() {
        let fspec = Fspec::read(&[0x81, 0x03, 0x02, 0xff]).unwrap();
        let present: Vec<u8> = (1..=56).filter(|&frn| fspec.has(frn)).collect();
        assert_eq!(present, [1, 14, 21]);
        assert_eq!((fspec.length(), fspec.padding()), (3, 0));
    }

    #[test]
    fn counts_trailing_octets_without_an_item() {
        for (octets, length, padding) in [
            (&[0xf7, 0x5f, 0x8f, 0x00][..], 4, 1),
            (&[0x81, 0x01, 0x00][..], 3, 2),
            (&[0x01, 0x80][..], 2, 0),
            (&[0x00][..], 1, 0),
            (&[0x01, 0x00][..], 2, 1),
            (&[0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x02][..], 8, 0),
        ] {
            let fspec = Fspec::read(octets).unwrap();
            assert_eq!((fspec.length(), fspec.padding()), (length, padding), "{octets:02x?}");
            let present = core::array::from_fn::<bool, 56, _>(|index| fspec.has(index as u8 + 1));
            let mut out = Vec::new();
            Fspec::of(present, fspec.padding()).encode_into(&mut out);
            assert_eq!(out, octets);
            let backwards = (1..=56).rev().filter(|frn| present[usize::from(*frn) - 1]);
            assert_eq!(backwards.collect::<Fspec>(), Fspec::of(present, 0));
        }
    }

    #[test]
    fn ends_and_limits() {
        assert_eq!(Fspec::read(&[]), Err(FaultKind::FspecPastEnd));
        assert_eq!(Fspec::read(&[0xff; 7]), Err(FaultKind::FspecPastEnd));
        assert_eq!(Fspec::read(&[0xff; 20]), Err(FaultKind::FspecPastEnd));
        assert_eq!(
            Fspec::read(&[0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x00]),
            Err(FaultKind::FspecTooLong)
        );
        assert_eq!(Fspec::of([true; 3], u8::MAX).length(), 8);
    }

    #[test]
    fn finds_items_that_a_category_does_not_define() {
        let defined =
            [1, 2, 3, 4, 5, 6, 7, 13, 14].iter().fold(Frns::NONE, |frns, &frn| frns.with(frn, true));
        for (octets, within) in [
            (&[0xfe][..], true),
            (&[0xff, 0x06][..], true),
            (&[0x01, 0x80][..], false),
            (&[0x01, 0x08][..], false),
            (&[0x01, 0x07, 0x80][..], false),
            (&[0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x02][..], false),
            (&[0x01, 0x01, 0x00][..], true),
        ] {
            assert_eq!(Fspec::read(octets).unwrap().is_within(defined), within, "{octets:02x?}");
        }
    }
}
