//! Items with parts of different lengths. Their octets are kept as read.

use core::fmt;

use deku::no_std_io::{Read, Seek, Write};
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};

use crate::bits;
use crate::layout::Field;
use crate::octets::{REFUSED, read_octet};

/// Parts of whole octets, `N` octets at most. If bit n of `FX` is set, the lowest bit of octet n states whether another octet
/// follows. If it is not set and n is not the last octet, another one always follows.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Parts<const N: usize, const FX: u8> {
    /// Zero after the last part.
    octets: [u8; N],
}

impl<const N: usize, const FX: u8> Parts<N, FX> {
    /// The first part, all bits 0.
    pub(crate) const fn new() -> Self {
        Self { octets: [0; N] }
    }

    const fn ends_at(&self, index: usize) -> bool {
        index + 1 == N || FX >> index & 1 == 1 && self.octets[index] & 1 == 0
    }

    const fn length(&self) -> usize {
        let mut index = 0;
        while !self.ends_at(index) {
            index += 1;
        }
        index + 1
    }

    /// The octets, FX bits included.
    pub fn octets(&self) -> &[u8] {
        &self.octets[..self.length()]
    }
}

/// Like [`bits::get`]; absent parts count as 0.
pub(crate) const fn get<const N: usize, const FX: u8>(
    parts: &Parts<N, FX>,
    offset: usize,
    width: usize,
) -> u64 {
    bits::get(&parts.octets, offset, width)
}

/// Like [`bits::set`]; absent parts before the field are added with zeros.
pub(crate) const fn set<const N: usize, const FX: u8>(
    parts: Parts<N, FX>,
    offset: usize,
    width: usize,
    value: u64,
) -> Parts<N, FX> {
    let mut octets = parts.octets;
    let mut index = 0;
    while index < offset / 8 {
        octets[index] |= FX >> index & 1;
        index += 1;
    }
    Parts { octets: bits::set(octets, offset, width, value) }
}

/// The octets of these parts that end with FX: those whose fields leave the last bit free.
pub(crate) const fn extensions(parts: &[&[Field]]) -> u8 {
    let (mut index, mut octets, mut extensions) = (0, 0, 0);
    while index < parts.len() {
        let bits = crate::layout::bits_of(parts[index]);
        octets += bits.div_ceil(8);
        if bits % 8 == 7 {
            extensions |= 1 << (octets - 1);
        }
        index += 1;
    }
    extensions
}

/// Total length of these parts, in octets.
pub(crate) const fn octets_of_all(parts: &[&[Field]]) -> usize {
    let (mut index, mut octets) = (0, 0);
    while index < parts.len() {
        octets += crate::layout::bits_of(parts[index]).div_ceil(8);
        index += 1;
    }
    octets
}

impl<const N: usize, const FX: u8> fmt::Debug for Parts<N, FX> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Parts({:02x?})", self.octets())
    }
}

impl<const N: usize, const FX: u8> DekuReader<'_> for Parts<N, FX> {
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let mut parts = Self::new();
        for index in 0..N {
            parts.octets[index] = read_octet(reader)?;
            if parts.ends_at(index) {
                break;
            }
        }
        // A part after the last one is not defined.
        let goes_on = FX >> (N - 1) & parts.octets[N - 1] & 1 == 1;
        if goes_on { Err(REFUSED) } else { Ok(parts) }
    }
}

impl<const N: usize, const FX: u8> DekuWriter for Parts<N, FX> {
    fn to_writer<W: Write + Seek>(&self, writer: &mut Writer<W>, (): ()) -> Result<(), DekuError> {
        writer.write_bytes(self.octets())
    }
}
