//! User application profiles: the order and the lengths of a category's items.

use core::ops::Deref;

use super::Layout;
use super::lengths::{Length, Lengths};
use crate::fault::{Fault, FaultKind};
use crate::fspec::{Frns, Fspec};
use crate::joined::Joined;

/// An item of a category's user application profile. To change the structure, create a new item with [`UapItem::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UapItem {
    /// Field reference number, counted from 1: the place of the item in the FSPEC and in the record.
    pub frn: u8,
    /// Number of the item in its category, `"040"`, or `"SP"`, `"RE"`.
    pub item: &'static str,
    /// Name of the item.
    pub name: &'static str,
    /// Meaning of its octets, and rule for its length.
    pub layout: Layout,
    pub(crate) length: Length,
    joined: Joined,
}

impl UapItem {
    /// An item with this field reference number, number, name and structure.
    pub const fn new(frn: u8, item: &'static str, name: &'static str, layout: Layout) -> Self {
        Self { frn, item, name, layout, length: Length::of(&layout), joined: Joined::of(item) }
    }

    /// Like [`Layout::measure`], without reading the fields.
    #[inline]
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        self.length.measure(octets)
    }

    /// The item number as a key for JSON.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }
}

/// The user application profile of a category or edition: its items in the order of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    items: &'static [UapItem],
    lengths: Lengths,
}

impl Profile {
    /// The profile with these items.
    ///
    /// Panics if a field reference number is not in 1 to 56.
    pub const fn new(items: &'static [UapItem]) -> Self {
        Self { items, lengths: Lengths::of(items) }
    }

    /// The items.
    pub const fn items(&self) -> &'static [UapItem] {
        self.items
    }

    /// Length, in octets, of the record of this category at the start of `octets`, which extend to the end of the block. Offsets
    /// in the fault are relative to the FSPEC.
    #[inline]
    pub(crate) fn measure(&self, category: u8, octets: &[u8]) -> Result<usize, Fault> {
        self.lengths.measure(self.items, octets).map_or_else(|| walk(category, self.items, octets), Ok)
    }
}

impl Deref for Profile {
    type Target = [UapItem];

    fn deref(&self) -> &[UapItem] {
        self.items
    }
}

impl IntoIterator for &Profile {
    type Item = &'static UapItem;
    type IntoIter = core::slice::Iter<'static, UapItem>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}

/// The item with this field reference number, in a list sorted by that number.
#[inline]
pub(crate) fn find(uap: &[UapItem], frn: u8) -> Option<&UapItem> {
    // The item is at its place, or before it if numbers are missing.
    match uap.get(usize::from(frn).wrapping_sub(1)) {
        Some(item) if item.frn == frn => Some(item),
        _ => uap.iter().find(|item| item.frn == frn),
    }
}

/// Length, in octets, of the record at the start of `octets`, which extend to the end of the block. Measures it item by item,
/// mostly to find its fault.
///
/// The items are examined in the order of the record, up to the first of unknown length. Only then an FSPEC with more octets
/// than any record needs is reported.
#[cold]
pub(crate) fn walk(category: u8, uap: &[UapItem], octets: &[u8]) -> Result<usize, Fault> {
    let fault = |item, offset, kind| Fault { category: Some(category), item, offset, kind };
    let Some(last) = octets.iter().position(|octet| octet & 1 == 0) else {
        return Err(fault(None, 0, FaultKind::FspecPastEnd));
    };
    let fspec = &octets[..=last];
    let mut offset = fspec.len();
    for frn in Frns::at_front(fspec).iter() {
        let Some(item) = find(uap, frn) else {
            return Err(fault(None, usize::from(frn - 1) / 7, FaultKind::ReservedFrn));
        };
        match item.measure(&octets[offset..]) {
            Ok(length) => offset += length,
            Err(kind) => return Err(fault(Some(item.item), offset, kind)),
        }
    }
    if fspec.len() > Fspec::MAX_OCTETS {
        return Err(fault(None, 0, FaultKind::FspecTooLong));
    }
    Ok(offset)
}

/// The items of a complete record, whose `octets` extend from its FSPEC to its end, each with its octets.
///
/// For records that were decoded or encoded by [`crate::Record::encode_into`]; otherwise the rest after a fault is left out.
pub fn items<'a>(
    uap: &'static [UapItem],
    octets: &'a [u8],
) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> {
    let fspec = Fspec::at_front(octets);
    // If the record does not end at its end with one octet of I129/120, the item has three.
    let either = uap.iter().any(|item| matches!(item.layout, Layout::OneOrThree(_)));
    let long = either && walk(0, uap, octets) != Ok(octets.len());
    let mut offset = fspec.map_or(0, Fspec::length);
    let announced = fspec.map_or(Frns::NONE, Fspec::announced);
    announced.iter().filter_map(|frn| find(uap, frn)).map_while(move |item| {
        let rest = octets.get(offset..)?;
        let mut length = item.measure(rest).ok()?;
        if long && matches!(item.layout, Layout::OneOrThree(_)) {
            length = 3;
        }
        offset += length;
        Some((item, rest.get(..length)?))
    })
}
