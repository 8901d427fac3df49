//! User application profiles: the order of a category's items and how long each is.

use crate::{Chain, Fault, FaultKind, Fspec};

/// One item of a category's user application profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UapItem {
    /// Field reference number, counted from 1: the item's place in the FSPEC and in the record.
    pub frn: u8,
    /// Number of the item in its category, `"040"`, or `"SP"`, `"RE"`.
    pub item: &'static str,
    /// Name of the item.
    pub name: &'static str,
    /// How its length is found.
    pub format: Format,
}

/// How the length of an item is found (ASTERIX part 1, EUROCONTROL-SPEC-0149, section 4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Always this many octets.
    Fixed(usize),
    /// Octets of which all but the last have the lowest bit (FX) set.
    Extended,
    /// One octet that counts the repetitions (0 is allowed), then that many times this many octets.
    Repetitive(usize),
    /// One octet (the primary subfield) whose bits 8 to 2 announce these subfields, then those that are announced.
    /// Bits beyond the subfields are spare; its lowest bit (FX) must be 0.
    Compound(&'static [Format]),
    /// One octet that counts all octets of the item, itself included.
    Explicit,
    /// I129/120 alone: 1 octet or 3, see [`crate::cat129::OperationalRisk`].
    OneOrThree,
}

impl Format {
    /// Octets of the item at the front of `octets`, which go to the end of the block.
    ///
    /// [`Format::OneOrThree`] counts as 1: which of the two it is shows only after the whole record.
    pub fn measure(self, octets: &[u8]) -> Result<usize, FaultKind> {
        let length = match self {
            Self::Fixed(length) => length,
            Self::OneOrThree => 1,
            Self::Extended => match octets.iter().take(Chain::MAX_OCTETS).position(|octet| octet & 1 == 0) {
                Some(last) => last + 1,
                None if octets.len() < Chain::MAX_OCTETS => return Err(FaultKind::ItemPastEnd),
                None => return Err(FaultKind::ChainTooLong),
            },
            Self::Repetitive(size) => {
                let count = *octets.first().ok_or(FaultKind::NoRepetitionCount)?;
                1 + usize::from(count) * size
            }
            Self::Explicit => match *octets.first().ok_or(FaultKind::ItemPastEnd)? {
                0 => return Err(FaultKind::LengthZero),
                length => usize::from(length),
            },
            Self::Compound(subfields) => {
                let primary = *octets.first().ok_or(FaultKind::ItemPastEnd)?;
                if primary & 1 == 1 {
                    return Err(FaultKind::PrimarySubfieldExtended);
                }
                let mut length = 1;
                for (index, subfield) in subfields.iter().enumerate() {
                    if primary & (0x80 >> index) != 0 {
                        let rest = octets.get(length..).ok_or(FaultKind::ItemPastEnd)?;
                        length += subfield.measure(rest)?;
                    }
                }
                length
            }
        };
        if length <= octets.len() { Ok(length) } else { Err(FaultKind::ItemPastEnd) }
    }
}

/// A line of a profile.
pub(crate) const fn item(frn: u8, item: &'static str, name: &'static str, format: Format) -> UapItem {
    UapItem { frn, item, name, format }
}

/// Reads the FSPEC at the front of a record that announces no item beyond those of `uap`.
pub(crate) fn read_fspec(category: u8, uap: &[UapItem], octets: &[u8]) -> Result<Fspec, Fault> {
    match Fspec::read(octets) {
        Ok(fspec) if fspec.first_above(uap.len() as u8).is_none() => Ok(fspec),
        _ => Err(explain(category, uap, octets)),
    }
}

/// Finds what is wrong with a record, the first thing in the order of its octets.
///
/// The readers of the categories carry no bookkeeping; only when one fails is the record walked again, item by item.
pub(crate) fn explain(category: u8, uap: &[UapItem], octets: &[u8]) -> Fault {
    walk(category, uap, octets).err().unwrap_or_else(|| {
        // Not reached: the table and the reader of a category agree, which the tests of both hold them to.
        debug_assert!(false, "CAT{category:03}: the reader refused a record that its table accepts");
        Fault { category: Some(category), item: None, offset: 0, kind: FaultKind::ItemPastEnd }
    })
}

/// Octets of the record at the front of `octets`, which go to the end of the block, measured item by item.
///
/// An FSPEC that announces what no record has (a reserved item, or more octets than needed) is the last thing looked
/// at: the items before it may already run out of octets.
pub(crate) fn walk(category: u8, uap: &[UapItem], octets: &[u8]) -> Result<usize, Fault> {
    let fault = |item, offset, kind| Fault { category: Some(category), item, offset, kind };
    let Some(last) = octets.iter().position(|octet| octet & 1 == 0) else {
        return Err(fault(None, 0, FaultKind::FspecPastEnd));
    };
    let fspec = &octets[..=last];
    let announces = |frn: u8| {
        let (octet, bit) = (usize::from(frn - 1) / 7, (frn - 1) % 7);
        fspec.get(octet).is_some_and(|octet| octet & (0x80 >> bit) != 0)
    };
    let mut offset = fspec.len();
    for item in uap.iter().filter(|item| announces(item.frn)) {
        match item.format.measure(&octets[offset..]) {
            Ok(length) => offset += length,
            Err(kind) => return Err(fault(Some(item.item), offset, kind)),
        }
    }
    if let Some(frn) = (uap.len() as u8 + 1..=7 * Fspec::MAX_OCTETS as u8).find(|&frn| announces(frn)) {
        return Err(fault(None, usize::from(frn - 1) / 7, FaultKind::ReservedFrn));
    }
    if fspec.len() > Fspec::MAX_OCTETS {
        return Err(fault(None, 0, FaultKind::FspecTooLong));
    }
    Ok(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_every_format() {
        const DOPPLER: Format = Format::Compound(&[Format::Fixed(2), Format::Repetitive(6)]);
        let full = [0x01; 17];
        for (format, octets, expected) in [
            (Format::Fixed(2), &[0, 0, 0][..], Ok(2)),
            (Format::Fixed(2), &[0][..], Err(FaultKind::ItemPastEnd)),
            (Format::Extended, &[1, 3, 2, 0][..], Ok(3)),
            (Format::Extended, &[1, 3][..], Err(FaultKind::ItemPastEnd)),
            (Format::Extended, &[][..], Err(FaultKind::ItemPastEnd)),
            (Format::Extended, &full[..], Err(FaultKind::ChainTooLong)),
            (Format::Repetitive(3), &[0][..], Ok(1)),
            (Format::Repetitive(3), &[2, 0, 0, 0, 0, 0, 0][..], Ok(7)),
            (Format::Repetitive(3), &[2, 0, 0, 0, 0, 0][..], Err(FaultKind::ItemPastEnd)),
            (Format::Repetitive(3), &[][..], Err(FaultKind::NoRepetitionCount)),
            (Format::Explicit, &[1][..], Ok(1)),
            (Format::Explicit, &[3, 0, 0, 0][..], Ok(3)),
            (Format::Explicit, &[0, 0][..], Err(FaultKind::LengthZero)),
            (Format::Explicit, &[3, 0][..], Err(FaultKind::ItemPastEnd)),
            (Format::Explicit, &[][..], Err(FaultKind::ItemPastEnd)),
            (DOPPLER, &[0x00][..], Ok(1)),
            (DOPPLER, &[0x80, 0, 0][..], Ok(3)),
            (DOPPLER, &[0xc0, 0, 0, 1, 0, 0, 0, 0, 0, 0][..], Ok(10)),
            (DOPPLER, &[0x40, 0][..], Ok(2)),
            (DOPPLER, &[0x3e, 0][..], Ok(1)),
            (DOPPLER, &[0x80, 0][..], Err(FaultKind::ItemPastEnd)),
            (DOPPLER, &[0x40][..], Err(FaultKind::NoRepetitionCount)),
            (DOPPLER, &[0x81, 0, 0][..], Err(FaultKind::PrimarySubfieldExtended)),
            (DOPPLER, &[][..], Err(FaultKind::ItemPastEnd)),
        ] {
            assert_eq!(format.measure(octets), expected, "{format:?} of {octets:02x?}");
        }
    }
}
