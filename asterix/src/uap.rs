//! User application profiles: the order of a category's items and how long each is.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::marker::PhantomData;

use deku::ctx::Order;
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};

use crate::fspec::Frns;
use crate::{Fault, FaultKind, Fspec, Layout, Record};

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

/// The profile of a category, where this crate knows one.
pub fn profile(category: u8) -> Option<&'static [UapItem]> {
    Some(match category {
        34 => &crate::cat034::UAP,
        48 => &crate::cat048::UAP,
        65 => &crate::cat065::UAP,
        129 => &crate::cat129::UAP,
        _ => return None,
    })
}

/// A line of a profile.
pub(crate) const fn item(frn: u8, item: &'static str, name: &'static str, layout: Layout) -> UapItem {
    UapItem { frn, item, name, layout }
}

/// Implements [`Record`] for the record of a category: its items by field reference number, and how it is decoded and
/// encoded.
macro_rules! record {
    ($category:literal { $($frn:literal $item:ident,)* } $decode:path, $encode:path) => {
        impl crate::Record for Record {
            const CATEGORY: u8 = $category;
            const UAP: &'static [crate::UapItem] = &UAP;

            fn data_source(&self) -> Option<crate::DataSource> {
                self.data_source
            }

            fn time_of_day(&self) -> Option<crate::TimeOfDay> {
                self.time_of_day
            }

            fn fspec(&self) -> crate::Fspec {
                let frns = crate::fspec::Frns::NONE$(.with($frn, self.$item.is_some()))*;
                crate::Fspec::announcing(frns, self.fspec_padding)
            }

            fn decode(octets: &[u8]) -> Result<(Self, usize), crate::Fault> {
                $decode(octets)
            }

            fn encode_into(&self, out: &mut Vec<u8>) {
                $encode(self, out);
            }
        }
    };
}

pub(crate) use record;

/// The field reference numbers that a profile defines, as bits of an FSPEC.
struct Defined<R>(PhantomData<R>);

impl<R: Record> Defined<R> {
    const FRNS: Frns = Frns::of(R::UAP);
}

/// Reads the FSPEC at the front of a record that announces no item beyond those of its category.
#[inline]
pub(crate) fn read_fspec<R: Record>(octets: &[u8]) -> Result<Fspec, Fault> {
    match Fspec::read(octets) {
        Ok(fspec) if fspec.is_within(Defined::<R>::FRNS) => Ok(fspec),
        _ => Err(explain::<R>(octets)),
    }
}

/// Decodes the record at the front of `octets`, see [`Record::decode`].
#[inline(always)]
pub(crate) fn decode<R>(octets: &[u8]) -> Result<(R, usize), Fault>
where
    R: Record + for<'a> DekuReader<'a, Fspec>,
{
    let fspec = read_fspec::<R>(octets)?;
    let mut items = Octets(&octets[fspec.length()..]);
    match R::from_reader_with_ctx(&mut Reader::new(&mut items), fspec) {
        Ok(record) => Ok((record, octets.len() - items.0.len())),
        Err(_) => Err(explain::<R>(octets)),
    }
}

/// Reads the item with this field reference number, if the record has it.
///
/// In place of the `cond` that deku offers: it goes by way of a function that returns the item through memory, which takes
/// longer than reading it.
#[inline(always)]
pub(crate) fn read<T, R>(reader: &mut Reader<R>, fspec: Fspec, frn: u8) -> Result<Option<T>, DekuError>
where
    T: for<'a> DekuReader<'a>,
    R: Read + Seek,
{
    if fspec.has(frn) { T::from_reader_with_ctx(reader, ()).map(Some) } else { Ok(None) }
}

/// As [`read`], of an item that is kept as octets.
#[inline(always)]
pub(crate) fn read_octets<const N: usize, R: Read + Seek>(
    reader: &mut Reader<R>,
    fspec: Fspec,
    frn: u8,
) -> Result<Option<[u8; N]>, DekuError> {
    if !fspec.has(frn) {
        return Ok(None);
    }
    let mut octets = [0; N];
    reader.read_bytes_const_into::<N>(&mut octets, Order::Msb0)?;
    Ok(Some(octets))
}

/// Octets that are read from the front: `Cursor` without its position, which the compiler sees through.
pub(crate) struct Octets<'a>(pub &'a [u8]);

impl Read for Octets<'_> {
    #[inline(always)]
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = buffer.len().min(self.0.len());
        self.read_exact(&mut buffer[..length])?;
        Ok(length)
    }

    #[inline(always)]
    fn read_exact(&mut self, buffer: &mut [u8]) -> io::Result<()> {
        match self.0.split_at_checked(buffer.len()) {
            Some((read, rest)) => {
                buffer.copy_from_slice(read);
                self.0 = rest;
                Ok(())
            }
            None => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }
}

impl Seek for Octets<'_> {
    /// Nothing that is read here goes back.
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// Appends a record, see [`Record::encode_into`].
#[inline]
pub(crate) fn encode<R: Record + DekuWriter<Fspec>>(record: &R, out: &mut Vec<u8>) {
    let fspec = record.fspec();
    fspec.encode_into(out);
    record
        .to_writer(&mut Writer::new(Appender(out)), fspec)
        .expect("writing whole octets to a vector cannot fail");
}

/// Appends what is written to a vector.
pub(crate) struct Appender<'a>(pub &'a mut Vec<u8>);

impl Write for Appender<'_> {
    #[inline(always)]
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.0.extend_from_slice(octets);
        Ok(octets.len())
    }

    #[inline(always)]
    fn write_all(&mut self, octets: &[u8]) -> io::Result<()> {
        self.0.extend_from_slice(octets);
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Appender<'_> {
    /// Nothing that is written here goes back.
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// Finds what is wrong with a record, the first thing in the order of its octets.
///
/// The readers of the categories carry no bookkeeping; only when one fails is the record walked again, item by item.
#[cold]
pub(crate) fn explain<R: Record>(octets: &[u8]) -> Fault {
    walk(R::CATEGORY, R::UAP, octets).err().unwrap_or_else(|| {
        // Not reached: the table and the reader of a category agree, which the tests of both hold them to.
        debug_assert!(false, "CAT{:03}: the reader refused a record that its table accepts", R::CATEGORY);
        Fault { category: Some(R::CATEGORY), item: None, offset: 0, kind: FaultKind::ItemPastEnd }
    })
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
