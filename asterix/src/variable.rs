//! Items without a fixed length. Their octets are kept inline as they were read, so that encoding gives them back.

use core::fmt;

use deku::no_std_io::{ErrorKind, Read, Seek, Write};
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};
use smallvec::SmallVec;

use crate::bits;
use crate::item::{fill, read_octets};

/// What the readers of this module return when an item contradicts itself. It never leaves the crate: the fault that does
/// is found by a second walk over the record.
pub(crate) const REFUSED: DekuError = DekuError::Io(ErrorKind::InvalidData);

/// How many octets an item of variable length holds without allocating.
const INLINE: usize = 24;

/// Appends the next `more` octets to `octets`.
#[inline(always)]
fn read_more<R: Read + Seek>(
    reader: &mut Reader<R>,
    octets: &mut SmallVec<[u8; INLINE]>,
    mut more: usize,
) -> Result<(), DekuError> {
    // By way of the stack, because to lengthen the vector first and to read into it is slower.
    let mut buffer = [0; INLINE];
    while more > 0 {
        let part = more.min(INLINE);
        fill(reader, &mut buffer[..part])?;
        octets.extend_from_slice(&buffer[..part]);
        more -= part;
    }
    Ok(())
}

#[inline(always)]
pub(crate) fn read_octet<R: Read + Seek>(reader: &mut Reader<R>) -> Result<u8, DekuError> {
    read_octets(reader).map(u8::from_be_bytes)
}

/// An extended item: octets of seven bits, the lowest bit (FX) of all but the last set.
///
/// Held inline, so copying one allocates nothing.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Chain {
    /// Zero beyond the chain.
    octets: [u8; Self::MAX_OCTETS],
}

impl Chain {
    /// The longest chain that is read. I048/020 has 6 octets in edition 1.32.
    pub const MAX_OCTETS: usize = 16;

    /// The FX bit of every octet.
    const EXTENSIONS: u128 = u128::MAX / 0xff;

    /// One octet, whose bits 8 to 2 are those of `bits`.
    pub const fn new(bits: u8) -> Self {
        Self { octets: ((bits & !1) as u128).to_le_bytes() }
    }

    /// How many octets there are: up to the first without FX.
    const fn length(&self) -> usize {
        let ends = !u128::from_be_bytes(self.octets) & Self::EXTENSIONS;
        ends.leading_zeros() as usize / 8 + 1
    }

    /// The octets, FX bits included; at least one.
    pub fn octets(&self) -> &[u8] {
        &self.octets[..self.length()]
    }

    /// The octet at `index` (0 is the first part, 1 the first extension), or `None` where the chain ends before.
    pub const fn octet(&self, index: usize) -> Option<u8> {
        if index < self.length() { Some(self.octets[index]) } else { None }
    }

    /// The chain with bits 8 to 2 of the octet at `index` replaced where `mask` has ones; extended with zero octets to
    /// reach it.
    ///
    /// Panics when `index` is not below [`Chain::MAX_OCTETS`].
    #[must_use]
    pub const fn with(self, index: usize, mask: u8, bits: u8) -> Self {
        let mut chain = self.reaching(index);
        let mask = mask & !1;
        chain.octets[index] = chain.octets[index] & !mask | bits & mask;
        chain
    }

    /// The chain, extended with zero octets to reach the octet at `index`.
    const fn reaching(mut self, index: usize) -> Self {
        let mut last = self.length() - 1;
        while last < index {
            self.octets[last] |= 1;
            last += 1;
        }
        self
    }
}

/// As [`crate::bits::get`]; what an absent extension would say is 0.
#[inline]
pub(crate) const fn get(chain: &Chain, offset: usize, width: usize) -> u64 {
    bits::get(&chain.octets, offset, width)
}

/// As [`crate::bits::set`], in one octet of the chain, which is extended to reach it.
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
    // Inlined, as is everything that most records hold: what a call leaves in memory piece by piece and its caller fetches
    // at once stalls the processor.
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

/// An explicit item, SP or RE: a length octet that counts itself, and up to 254 octets whose meaning the users of the
/// category agree on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Explicit(SmallVec<[u8; INLINE]>);

impl Explicit {
    /// The field with these contents, or `None` when they are more than 254 octets.
    pub fn new(contents: &[u8]) -> Option<Self> {
        let length = u8::try_from(contents.len() + 1).ok()?;
        let mut octets = SmallVec::with_capacity(contents.len() + 1);
        octets.push(length);
        octets.extend_from_slice(contents);
        Some(Self(octets))
    }

    /// What follows the length octet.
    pub fn contents(&self) -> &[u8] {
        &self.0[1..]
    }

    /// The whole item, length octet included.
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

/// How the contents of a reserved expansion field are read from it and put into it.
macro_rules! expansion_field {
    ($name:ident) => {
        impl $name {
            /// Reads a reserved expansion field. `None` where its octets are not what this edition says, or where
            /// [`to_field`](Self::to_field) would not give the same octets: such a field is of another edition or damaged,
            /// and its octets are all that is known.
            pub fn read(field: &$crate::Explicit) -> Option<Self> {
                let mut contents = $crate::record::Forward(field.contents());
                let mut reader = deku::reader::Reader::new(&mut contents);
                let read = <Self as deku::DekuReader<'_>>::from_reader_with_ctx(&mut reader, ()).ok()?;
                (read.to_field().as_ref() == Some(field)).then_some(read)
            }

            /// The field that says this; `None` when it is longer than 254 octets.
            pub fn to_field(&self) -> Option<$crate::Explicit> {
                let mut contents = alloc::vec::Vec::new();
                $crate::record::append(self, &mut contents);
                $crate::Explicit::new(&contents)
            }
        }
    };
}

pub(crate) use expansion_field;
