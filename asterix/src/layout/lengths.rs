//! Lengths of records and items. They are derived from the layouts once, when the crate is compiled or the table of an edition is
//! read, so that measuring a record does not read its fields, nor items of fixed length.

use super::uap::{self, UapItem};
use super::{Field, Layout, Subfield, bits_of, octets_of};
use crate::fault::FaultKind;
use crate::fspec::{Frns, Fspec};
use crate::variable::Chain;

/// Rule for the length of an item (EUROCONTROL-SPEC-0149, part 1, section 4.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Length {
    /// Fixed number of octets.
    Fixed(usize),
    /// Each octet states whether another follows.
    Extended,
    /// Each part, with this number of octets, states whether another follows.
    Chained(usize),
    /// Parts of different lengths, see [`Layout::Parts`].
    Parts(&'static [&'static [Field]]),
    /// The first octet is the number of parts, each with this number of octets.
    Repetitive(usize),
    /// The first octet is the length of the item.
    Explicit,
    /// The primary subfield announces some of these subfields.
    Compound {
        subfields: &'static [Subfield],
        /// Numbers of all subfields, and of those with a length of one octet.
        all: Frns,
        single: Frns,
    },
    /// The first octet is the number of items, each of which follows its field reference number.
    Sequence(&'static [UapItem]),
    /// Unknown: no subfield is defined.
    Undefined,
}

impl Length {
    /// The rule for items with this layout.
    pub const fn of(layout: &Layout) -> Self {
        match *layout {
            // The length of the latter is known only after the whole record.
            Layout::Fields(fields) | Layout::OneOrThree(fields) => Self::Fixed(octets_of(fields)),
            Layout::Extended(_) => Self::Extended,
            Layout::Codes => Self::Chained(1),
            Layout::Chained(fields) => Self::Chained(bits_of(fields).div_ceil(8)),
            Layout::Parts(parts) => Self::Parts(parts),
            Layout::Repetitive(fields) => Self::Repetitive(octets_of(fields)),
            Layout::Explicit(_) => Self::Explicit,
            Layout::Compound(subfields) => {
                let (mut all, mut single, mut index) = (Frns::NONE, Frns::NONE, 0);
                while index < subfields.len() {
                    let place = index as u8 + 1;
                    all = all.with(place, true);
                    single = single.with(place, matches!(subfields[index].length, Self::Fixed(1)));
                    index += 1;
                }
                Self::Compound { subfields, all, single }
            }
            Layout::Sequence(items) => Self::Sequence(items),
        }
    }

    /// Length, in octets, of the item at the start of `octets`, which extend to the end of the block.
    #[inline]
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        let length = self.claimed(octets)?;
        if length <= octets.len() { Ok(length) } else { Err(FaultKind::ItemPastEnd) }
    }

    /// Length, in octets, that the item at the start of `octets` states, even if `octets` are shorter.
    #[inline(always)] // the lengths that most items have take no call
    fn claimed(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        if let Self::Fixed(length) = *self {
            return Ok(length);
        }
        if let Self::Extended = self
            && let Some(front) = Fspec::at_front(octets)
        {
            // Up to eight octets, an extended item ends like an FSPEC.
            return Ok(front.length());
        }
        self.claimed_at_length(octets)
    }

    /// The stated length of an item with any rule.
    fn claimed_at_length(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        match *self {
            Self::Fixed(length) => Ok(length),
            Self::Compound { subfields, all, single } => compound(subfields, all, single, octets),
            Self::Repetitive(part) => {
                let count = octets.first().ok_or(FaultKind::NoRepetitionCount)?;
                Ok(1 + usize::from(*count) * part)
            }
            Self::Explicit => match octets.first() {
                None => Err(FaultKind::ItemPastEnd),
                Some(0) => Err(FaultKind::LengthZero),
                Some(&length) => Ok(length.into()),
            },
            Self::Extended => extended(octets),
            Self::Chained(part) => chained(octets, part).ok_or(FaultKind::ItemPastEnd),
            Self::Parts(parts) => parts_of(parts, octets),
            Self::Sequence(items) => sequence(items, octets),
            Self::Undefined => Err(FaultKind::ReservedSubfield),
        }
    }
}

/// Lengths of items, arranged for the octets of an FSPEC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lengths([Seven; Fspec::MAX_OCTETS]);

/// Lengths of the up to seven items of one octet of an FSPEC.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seven {
    /// Bits of defined items.
    defined: u8,
    /// Bits of defined items whose length is not fixed.
    varying: u8,
    /// Total length of the items of fixed length, in octets, indexed by the upper seven bits of the FSPEC octet.
    fixed: [u16; 128],
}

impl Lengths {
    /// The lengths of records with these items.
    pub const fn of(items: &[UapItem]) -> Self {
        let mut sevens = [Seven { defined: 0, varying: 0, fixed: [0; 128] }; Fspec::MAX_OCTETS];
        let mut index = 0;
        while index < items.len() {
            let place = items[index].frn as usize - 1;
            sevens[place / 7] = sevens[place / 7].with(0x80 >> (place % 7), items[index].length);
            index += 1;
        }
        Self(sevens)
    }

    /// Length, in octets, of the record at the start of `octets`; `None`, without a reason, if it is not valid.
    ///
    /// `items` must be those from which `self` was created.
    #[inline]
    pub fn measure(&self, items: &[UapItem], octets: &[u8]) -> Option<usize> {
        let mut length = Fspec::at_front(octets)?.length();
        for (index, (seven, octet)) in self.0.iter().zip(&octets[..length]).enumerate() {
            let mut left = octet & !1;
            if left & !seven.defined != 0 {
                return None;
            }
            let mut varying = left & seven.varying;
            while varying != 0 {
                let bit = varying.leading_zeros() as u8;
                let behind = 0x7f >> bit;
                length += usize::from(seven.fixed[usize::from((left & !behind) >> 1)]);
                let item = uap::find(items, 7 * index as u8 + bit + 1)?;
                length += item.length.claimed(octets.get(length..)?).ok()?;
                left &= behind;
                varying &= behind;
            }
            length += usize::from(seven.fixed[usize::from(left >> 1)]);
        }
        (length <= octets.len()).then_some(length)
    }
}

impl Seven {
    /// Adds the item of this bit.
    const fn with(mut self, bit: u8, length: Length) -> Self {
        self.defined |= bit;
        let Length::Fixed(octets) = length else {
            self.varying |= bit;
            return self;
        };
        let mut bits = 0;
        while bits < self.fixed.len() {
            if bits as u8 & bit >> 1 != 0 {
                self.fixed[bits] += octets as u16;
            }
            bits += 1;
        }
        self
    }
}

/// Number of octets at the start up to the first without FX, up to the maximum length of a [`Chain`].
fn extended(octets: &[u8]) -> Result<usize, FaultKind> {
    let most = octets.get(..Chain::MAX_OCTETS);
    chained(most.unwrap_or(octets), 1).ok_or(if most.is_some() {
        FaultKind::ChainTooLong
    } else {
        FaultKind::ItemPastEnd
    })
}

/// Number of octets of the parts at the start, each of `part` octets, up to the first without FX; `None` if all have FX.
fn chained(octets: &[u8], part: usize) -> Option<usize> {
    let ends = |part: &[u8]| part.last().is_some_and(|octet| octet & 1 == 0);
    octets.chunks_exact(part).position(ends).map(|last| (last + 1) * part)
}

/// Length of a primary subfield, which must announce subfields of `all` only, and of these subfields.
#[inline]
fn compound(subfields: &[Subfield], all: Frns, single: Frns, octets: &[u8]) -> Result<usize, FaultKind> {
    let most = subfields.len().div_ceil(7);
    let primary = match Fspec::at_front(octets) {
        Some(primary) if primary.length() <= most => primary,
        _ if octets.len() < most => return Err(FaultKind::ItemPastEnd),
        _ => return Err(FaultKind::PrimarySubfieldExtended),
    };
    if !primary.is_within(all) {
        return Err(FaultKind::ReservedSubfield);
    }
    let mut length = primary.length();
    if primary.is_within(single) {
        return Ok(length + primary.announced().count());
    }
    for number in primary.announced().iter() {
        let rest = octets.get(length..).ok_or(FaultKind::ItemPastEnd)?;
        length += subfields[usize::from(number) - 1].length.measure(rest)?;
    }
    Ok(length)
}

/// Length of the parts at the start, see [`Layout::Parts`].
fn parts_of(parts: &[&[Field]], octets: &[u8]) -> Result<usize, FaultKind> {
    let mut length = 0;
    for part in parts {
        let bits = bits_of(part);
        length += bits.div_ceil(8);
        let last = octets.get(length - 1).ok_or(FaultKind::ItemPastEnd)?;
        if bits % 8 == 0 || last & 1 == 0 {
            return Ok(length);
        }
    }
    Err(FaultKind::ChainTooLong)
}

/// Length of a sequence of items: the count, and items that each follow their field reference number.
fn sequence(items: &[UapItem], octets: &[u8]) -> Result<usize, FaultKind> {
    let count = *octets.first().ok_or(FaultKind::NoRepetitionCount)?;
    let mut length = 1;
    for _ in 0..count {
        let frn = *octets.get(length).ok_or(FaultKind::ItemPastEnd)?;
        let item = uap::find(items, frn).ok_or(FaultKind::ReservedFrn)?;
        length += 1 + item.length.measure(&octets[length + 1..])?;
    }
    Ok(length)
}
