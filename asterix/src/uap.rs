//! User application profiles: the order of a category's items and how long each is.

use crate::fault::{Fault, FaultKind};
use crate::fspec::Fspec;
use crate::layout::Layout;

/// One item of a category's user application profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UapItem {
    /// Field reference number, counted from 1: the item's place in the FSPEC and in the record.
    pub frn: u8,
    /// Number of the item in its category, `"040"`, or `"SP"`, `"RE"`.
    pub item: &'static str,
    /// Name of the item.
    pub name: &'static str,
    /// What its octets mean, and how its length is found.
    pub layout: Layout,
}

/// Octets of the record at the front of `octets`, which go to the end of the block, measured item by item.
///
/// The items are looked at in the order of the record, up to the first of which the category knows no length. Only then
/// an FSPEC with more octets than any record needs is found out.
pub(crate) fn walk(category: u8, uap: &[UapItem], octets: &[u8]) -> Result<usize, Fault> {
    let fault = |item, offset, kind| Fault { category: Some(category), item, offset, kind };
    let Some(last) = octets.iter().position(|octet| octet & 1 == 0) else {
        return Err(fault(None, 0, FaultKind::FspecPastEnd));
    };
    let fspec = &octets[..=last];
    let mut offset = fspec.len();
    for frn in 1..=7 * Fspec::MAX_OCTETS as u8 {
        let (octet, bit) = (usize::from(frn - 1) / 7, (frn - 1) % 7);
        if fspec.get(octet).is_none_or(|octet| octet & (0x80 >> bit) == 0) {
            continue;
        }
        let Some(item) = uap.iter().find(|item| item.frn == frn) else {
            return Err(fault(None, octet, FaultKind::ReservedFrn));
        };
        match item.layout.measure(&octets[offset..]) {
            Ok(length) => offset += length,
            Err(kind) => return Err(fault(Some(item.item), offset, kind)),
        }
    }
    if fspec.len() > Fspec::MAX_OCTETS {
        return Err(fault(None, 0, FaultKind::FspecTooLong));
    }
    Ok(offset)
}

/// The items of a whole record, `octets` from its FSPEC to its end: each with its own octets.
///
/// For records that were decoded, or written by [`crate::Record::encode_into`]; of another the rest is left out.
pub fn items<'a>(
    uap: &'static [UapItem],
    octets: &'a [u8],
) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> {
    let fspec = Fspec::read(octets).ok();
    // Where one octet of I129/120 does not end the record at its end, it has three.
    let either = uap.iter().any(|item| matches!(item.layout, Layout::OneOrThree(_)));
    let long = either && walk(0, uap, octets) != Ok(octets.len());
    let mut offset = fspec.map_or(0, Fspec::length);
    uap.iter().filter(move |item| fspec.is_some_and(|fspec| fspec.has(item.frn))).map_while(move |item| {
        let rest = octets.get(offset..)?;
        let mut length = item.layout.measure(rest).ok()?;
        if long && matches!(item.layout, Layout::OneOrThree(_)) {
            length = 3;
        }
        offset += length;
        Some((item, rest.get(..length)?))
    })
}
