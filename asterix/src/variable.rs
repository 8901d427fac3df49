//! Items of variable length. Their octets are stored inline as read, so that encoding restores them.

use core::fmt;

use deku::no_std_io::{Read, Seek, Write};
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};
use smallvec::SmallVec;

use crate::bits;
use crate::octets::{REFUSED, fill, read_octet};

/// Number of octets that an item of variable length holds without allocation.
const INLINE: usize = 24;

/// Appends the next `more` octets to `octets`.
#[inline(always)]
fn read_more<R: Read + Seek>(
    reader: &mut Reader<R>,
    octets: &mut SmallVec<[u8; INLINE]>,
    mut more: usize,
) -> Result<(), DekuError> {
    // Uses the stack: extending the vector first and reading into it is slower.
    let mut buffer = [0; INLINE];
    while more > 0 {
        let part = more.min(INLINE);
        fill(reader, &mut buffer[..part])?;
        octets.extend_from_slice(&buffer[..part]);
        more -= part;
    }
    Ok(())
}

/// An extended item: octets of seven bits; all but the last have the lowest bit (FX) set.
///
/// Stored inline, so copying needs no allocation.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Chain {
    /// Zero after the chain.
    octets: [u8; Self::MAX_OCTETS],
}

impl Chain {
    /// Maximum length of a chain, in octets. I048/020 has 6 octets in edition 1.32.
    pub const MAX_OCTETS: usize = 16;

    /// The FX bit of every octet.
    const EXTENSIONS: u128 = u128::MAX / 0xff;

    /// A chain of one octet, whose bits 8 to 2 are those of `bits`.
    pub const fn new(bits: u8) -> Self {
        Self { octets: ((bits & !1) as u128).to_le_bytes() }
    }

    /// Number of octets up to the first without FX.
    const fn length(&self) -> usize {
        let ends = !u128::from_be_bytes(self.octets) & Self::EXTENSIONS;
        ends.leading_zeros() as usize / 8 + 1
    }

    /// The octets with their FX bits; at least one.
    pub fn octets(&self) -> &[u8] {
        &self.octets[..self.length()]
    }

    /// The octet at `index` (0 is the first part, 1 the first extension); `None` after the end of the chain.
    pub const fn octet(&self, index: usize) -> Option<u8> {
        if index < self.length() { Some(self.octets[index]) } else { None }
    }

    /// The chain with bits 8 to 2 of the octet at `index` replaced where `mask` has ones; extended with zero octets if it is
    /// shorter.
    ///
    /// Panics if `index` is not below [`Chain::MAX_OCTETS`].
    #[must_use]
    pub const fn with(self, index: usize, mask: u8, bits: u8) -> Self {
        let mut chain = self.reaching(index);
        let mask = mask & !1;
        chain.octets[index] = chain.octets[index] & !mask | bits & mask;
        chain
    }

    /// The chain, extended with zero octets up to `index` if it is shorter.
    const fn reaching(mut self, index: usize) -> Self {
        let mut last = self.length() - 1;
        while last < index {
            self.octets[last] |= 1;
            last += 1;
        }
        self
    }
}

/// Like [`crate::bits::get`]; absent extensions count as 0.
#[inline]
pub(crate) const fn get(chain: &Chain, offset: usize, width: usize) -> u64 {
    bits::get(&chain.octets, offset, width)
}

/// Like [`crate::bits::set`], in one octet of the chain, which is extended if it is shorter.
pub(crate) const fn set(chain: Chain, offset: usize, width: usize, value: u64) -> Chain {
    let Chain { octets } = chain.reaching(offset / 8);
    Chain { octets: bits::set(octets, offset, width, value) }
}

impl fmt::Debug for Chain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Chain({:02x?})", self.octets())
    }
}

impl DekuReader<'_> for Chain {
    // Inlined, as is everything that most records need: if a call stores a value piece by piece and its caller loads it at once,
    // the processor stalls.
    #[inline(always)]
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let first = read_octet(reader)?;
        if first & 1 == 0 {
            return Ok(Self::new(first));
        }
        let mut word = u128::from(first) << 120;
        for index in 1..Self::MAX_OCTETS {
            let octet = read_octet(reader)?;
            word |= u128::from(octet) << (120 - 8 * index);
            if octet & 1 == 0 {
                return Ok(Self { octets: word.to_be_bytes() });
            }
        }
        Err(REFUSED)
    }
}

impl DekuWriter for Chain {
    fn to_writer<W: Write + Seek>(&self, writer: &mut Writer<W>, (): ()) -> Result<(), DekuError> {
        writer.write_bytes(self.octets())
    }
}

/// An explicit item, SP or RE: a length octet that counts itself, and up to 254 octets whose meaning the users of the category
/// define.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Explicit(SmallVec<[u8; INLINE]>);

impl Explicit {
    /// The item with these contents; `None` if they are longer than 254 octets.
    pub fn new(contents: &[u8]) -> Option<Self> {
        let length = u8::try_from(contents.len() + 1).ok()?;
        let mut octets = SmallVec::with_capacity(contents.len() + 1);
        octets.push(length);
        octets.extend_from_slice(contents);
        Some(Self(octets))
    }

    /// The octets after the length octet.
    pub fn contents(&self) -> &[u8] {
        &self.0[1..]
    }

    /// The whole item with its length octet.
    pub fn octets(&self) -> &[u8] {
        &self.0
    }
}

impl DekuReader<'_> for Explicit {
    #[inline(always)]
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let length = read_octet(reader)?;
        if length == 0 {
            return Err(REFUSED);
        }
        let mut octets = SmallVec::with_capacity(usize::from(length));
        octets.push(length);
        read_more(reader, &mut octets, usize::from(length) - 1)?;
        Ok(Self(octets))
    }
}

impl DekuWriter for Explicit {
    fn to_writer<W: Write + Seek>(&self, writer: &mut Writer<W>, (): ()) -> Result<(), DekuError> {
        writer.write_bytes(&self.0)
    }
}
