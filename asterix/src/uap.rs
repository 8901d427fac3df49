//! User application profiles: the order of a category's items and how long each is.

use core::ops::Deref;

use crate::fault::{Fault, FaultKind};
use crate::fspec::{Frns, Fspec};
use crate::joined::Joined;
use crate::layout::Layout;
use crate::lengths::{Length, Lengths};

/// One item of a category's user application profile. Another structure takes another one, made by [`UapItem::new`].
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
    pub(crate) length: Length,
    joined: Joined,
}

impl UapItem {
    /// The item of this field reference number, number, name and structure.
    pub const fn new(frn: u8, item: &'static str, name: &'static str, layout: Layout) -> Self {
        Self { frn, item, name, layout, length: Length::of(&layout), joined: Joined::of(item) }
    }

    /// As [`Layout::measure`].
    #[inline]
    pub fn measure(&self, octets: &[u8]) -> Result<usize, FaultKind> {
        self.length.measure(octets)
    }

    /// Its number as a key in JSON.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }
}

/// The user application profile of a category, or of an edition of one: its items in the order of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    items: &'static [UapItem],
    lengths: Lengths,
}

impl Profile {
    /// That of these items.
    ///
    /// Panics where a field reference number is not 1 to 56.
    pub const fn new(items: &'static [UapItem]) -> Self {
        Self { items, lengths: Lengths::of(items) }
    }

    /// The items.
    pub const fn items(&self) -> &'static [UapItem] {
        self.items
    }

    /// Octets of the record of this category at the front of `octets`, which go to the end of the block. Offsets in the fault
    /// count from its FSPEC.
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

/// The item with this field reference number, of items in their order.
#[inline]
pub(crate) fn find(uap: &[UapItem], frn: u8) -> Option<&UapItem> {
    // It stands at its place, or before where numbers are left out.
    match uap.get(usize::from(frn).wrapping_sub(1)) {
        Some(item) if item.frn == frn => Some(item),
        _ => uap.iter().find(|item| item.frn == frn),
    }
}

/// Octets of the record at the front of `octets`, which go to the end of the block, measured item by item: what is wrong
/// with it, mostly.
///
/// The items are looked at in the order of the record, up to the first of which the category knows no length. Only then
/// an FSPEC with more octets than any record needs is found out.
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

/// The items of a whole record, `octets` from its FSPEC to its end: each with its own octets.
///
/// For records that were decoded, or written by [`crate::Record::encode_into`]; of another the rest is left out.
pub fn items<'a>(
    uap: &'static [UapItem],
    octets: &'a [u8],
) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> {
    let fspec = Fspec::at_front(octets);
    // Where one octet of I129/120 does not end the record at its end, it has three.
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
