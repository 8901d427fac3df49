//! Items without a fixed length. Their octets are kept inline as they were read, so that encoding gives them back.

use std::io::{ErrorKind, Read, Seek, Write};

use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter, ctx::Order};
use smallvec::SmallVec;

/// What the readers of this module return when an item contradicts itself. It never leaves the crate: the fault that does
/// is found by a second walk over the record.
pub(crate) const REFUSED: DekuError = DekuError::Io(ErrorKind::InvalidData);

/// How many octets an item of variable length holds without allocating.
const INLINE: usize = 32;

/// Appends the next `more` octets to `octets`.
fn read_more<R: Read + Seek>(
    reader: &mut Reader<R>,
    octets: &mut SmallVec<[u8; INLINE]>,
    mut more: usize,
) -> Result<(), DekuError> {
    // By way of the stack, because to lengthen the vector first and to read into it is slower.
    let mut buffer = [0; INLINE];
    while more > 0 {
        let part = more.min(INLINE);
        reader.read_bytes(part, &mut buffer, Order::Msb0)?;
        octets.extend_from_slice(&buffer[..part]);
        more -= part;
    }
    Ok(())
}

fn read_octet<R: Read + Seek>(reader: &mut Reader<R>) -> Result<u8, DekuError> {
    let mut octet = [0];
    reader.read_bytes_const::<1>(&mut octet, Order::Msb0)?;
    Ok(octet[0])
}

/// An extended item: octets of seven bits, the lowest bit (FX) of all but the last set.
///
/// Held inline, so copying one allocates nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Chain {
    /// Zero beyond `length`.
    octets: [u8; Self::MAX_OCTETS],
    /// 1 to [`Chain::MAX_OCTETS`].
    length: u8,
}

impl Chain {
    /// The longest chain that is read. I048/020 has 6 octets in edition 1.32.
    pub const MAX_OCTETS: usize = 16;

    /// One octet, whose bits 8 to 2 are those of `bits`.
    pub const fn new(bits: u8) -> Self {
        let mut octets = [0; Self::MAX_OCTETS];
        octets[0] = bits & !1;
        Self { octets, length: 1 }
    }

    /// The octets, FX bits included; at least one.
    pub fn octets(&self) -> &[u8] {
        &self.octets[..usize::from(self.length)]
    }

    /// The octet at `index` (0 is the first part, 1 the first extension), or `None` where the chain ends before.
    pub const fn octet(&self, index: usize) -> Option<u8> {
        if index < self.length as usize { Some(self.octets[index]) } else { None }
    }

    /// The chain with bits 8 to 2 of the octet at `index` replaced where `mask` has ones; extended with zero octets to
    /// reach it.
    ///
    /// Panics when `index` is not below [`Chain::MAX_OCTETS`].
    #[must_use]
    pub const fn with(mut self, index: usize, mask: u8, bits: u8) -> Self {
        while (self.length as usize) <= index {
            self.octets[self.length as usize - 1] |= 1;
            self.length += 1;
        }
        let mask = mask & !1;
        self.octets[index] = self.octets[index] & !mask | bits & mask;
        self
    }
}

impl DekuReader<'_> for Chain {
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let mut octets = [0; Self::MAX_OCTETS];
        for (index, octet) in octets.iter_mut().enumerate() {
            *octet = read_octet(reader)?;
            if *octet & 1 == 0 {
                return Ok(Self { octets, length: index as u8 + 1 });
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
        let mut octets = SmallVec::new();
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
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let length = read_octet(reader)?;
        if length == 0 {
            return Err(REFUSED);
        }
        let mut octets = SmallVec::new();
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
