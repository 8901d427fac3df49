//! A strict hand-written parser of CAT015, CAT021, CAT062 and CAT063 that finds the ends of records from the lengths of their
//! items. It shares no code and no table with the crate.

/// The rule for the length of an item.
#[derive(Clone, Copy, Debug)]
pub enum Length {
    /// A fixed number of octets.
    Octets(usize),
    /// Octets of which all but the last have the lowest bit set; at most 16.
    Extended,
    /// Octets of which all but the last have the lowest bit set; any number.
    Codes,
    /// One octet; if its lowest bit is set, a second one, whose lowest bit has no such meaning.
    OneOrTwo,
    /// Groups of three octets; if the last octet of a group has the lowest bit set, another group follows.
    ThreeEach,
    /// A count, and this number of octets for each.
    Each(usize),
    /// An octet with the length of the item.
    Explicit,
    /// A primary subfield with this maximum number of octets, and subfields.
    Compound(usize, &'static [Length]),
    /// An undefined item.
    None,
}

use Length::{Codes, Compound, Each, Explicit, Extended, None as No, Octets as O, OneOrTwo, ThreeEach};

/// FRN 1 to 49 of CAT021 from edition 2.2 on; up to 2.1 FRN 37 is [`Length::OneOrTwo`].
pub const CAT021: [Length; 49] = [
    O(2), Extended, O(2), O(1), O(3), O(6), O(8),
    O(3), O(2), O(2), O(3), O(3), O(4), O(3),
    O(4), O(2), Extended, O(1), O(2), O(2), O(2),
    O(2), O(1), O(2), O(2), O(4), O(2), O(3),
    O(6), O(1), Compound(1, &[O(2), O(2), O(2), O(1)]), O(2), O(2), Compound(1, &[Extended, Each(15)]), O(1),
    O(1), Extended, O(1), Each(8), O(7), O(1), Compound(4, &[O(1); 23]),
    No, No, No, No, No, Explicit, Explicit,
];

/// FRN 37 of CAT021 up to edition 2.1.
pub const SURFACE_2_1: Length = OneOrTwo;

/// FRN 1 to 35 of CAT062.
pub const CAT062: [Length; 35] = [
    O(2), No, O(1), O(3), O(8), O(6), O(4),
    O(2), O(2), O(7),
    Compound(4, &[
        O(3), O(6), O(2), O(2), O(2), O(2), O(2),
        Extended, Each(15), O(2), O(2), O(7), O(2), O(2),
        O(2), O(2), O(2), O(2), O(1), O(8), O(1),
        O(6), O(2), O(1), Each(8), O(2), O(2), O(2),
    ]),
    O(2), Extended, Compound(2, &[O(1), O(1), O(1), O(1), O(2), O(1), O(1), O(1), O(1), O(1)]),
    O(1), Compound(5, &[O(1); 31]), O(2), O(2), O(2), O(2),
    Compound(3, &[
        O(2), O(7), O(4), O(1), O(4), O(1), O(4),
        O(4), O(3), O(2), O(2), Each(4), O(6), O(1),
        O(7), O(7), O(2), O(7),
    ]),
    Extended, O(1), Compound(1, &[O(1), O(4), O(6), O(2), O(2), O(1), O(1)]), O(2), ThreeEach,
    Compound(2, &[O(4), O(2), O(4), O(1), O(1), O(2), O(2), O(1)]),
    Compound(1, &[O(2), O(4), O(2), O(2), O(2), O(1)]),
    No, No, No, No, No, Explicit, Explicit,
];

/// FRN 1 to 26 of CAT015.
pub const CAT015: [Length; 26] = [
    O(2), O(1), O(1), Extended, Codes, O(3), O(2),
    Extended, O(2), Compound(1, &[O(2); 4]), Each(2), O(5), Compound(1, &[O(8), O(5), O(5)]),
    Compound(2, &[O(3), O(3), O(3), O(3), O(3), O(2), O(2), O(2)]),
    Compound(1, &[O(5), O(5), O(5), O(4)]), Compound(1, &[O(3), O(4), O(4), O(4)]),
    Compound(1, &[O(3), O(2), O(3), O(2), O(2), O(2)]), Compound(1, &[O(2), O(4), O(2), O(2), O(2)]), Each(5),
    Compound(2, &[O(3), O(3), O(3), O(3), O(3), O(4), O(2), O(4)]),
    Compound(2, &[O(3), O(2), O(2), O(3), O(1), O(1), O(1), O(1), O(1), O(1)]),
    Compound(1, &[O(2), O(2), O(2), O(2), O(3), O(4)]), Compound(1, &[O(2), O(2), O(2), O(2), O(3), O(4)]),
    Compound(1, &[O(1), O(1), O(2), O(1)]), Each(8), Explicit,
];

/// FRN 1 to 14 of CAT063.
pub const CAT063: [Length; 14] =
    [O(2), O(1), O(3), O(2), Extended, O(2), O(4), O(2), O(4), O(2), O(2), No, Explicit, Explicit];

/// Number of octets with the lowest bit set up to the first without; at most `most`.
fn chain(octets: &[u8], most: usize) -> Option<usize> {
    octets.iter().take(most).position(|octet| octet & 1 == 0).map(|last| last + 1)
}

/// Indices of the bits set in octets of seven bits and FX.
fn places(octets: &[u8]) -> impl Iterator<Item = usize> {
    octets
        .iter()
        .enumerate()
        .flat_map(|(index, octet)| (0..7).filter(move |bit| octet << bit & 0x80 != 0).map(move |bit| 7 * index + bit))
}

fn measure(length: Length, octets: &[u8]) -> Option<usize> {
    let end = match length {
        O(count) => count,
        Extended => chain(octets, 16)?,
        Codes => chain(octets, usize::MAX)?,
        OneOrTwo => 1 + usize::from(octets.first()? & 1),
        ThreeEach => 3 * ((0..).find(|part| octets.get(3 * part + 2).is_none_or(|last| last & 1 == 0))? + 1),
        Each(part) => 1 + usize::from(*octets.first()?) * part,
        Explicit => usize::from(*octets.first().filter(|&&octet| octet > 0)?),
        Compound(most, subfields) => {
            let primary = chain(octets, most)?;
            places(&octets[..primary]).try_fold(primary, |at, place| {
                Some(at + measure(*subfields.get(place)?, octets.get(at..)?)?)
            })?
        }
        No => return None,
    };
    (end <= octets.len()).then_some(end)
}

/// Length of the record at the start, in octets; `None` if it is not valid.
pub fn record(items: &[Length], octets: &[u8]) -> Option<usize> {
    let fspec = chain(octets, 8)?;
    places(&octets[..fspec])
        .try_fold(fspec, |at, place| Some(at + measure(*items.get(place)?, octets.get(at..)?)?))
}
