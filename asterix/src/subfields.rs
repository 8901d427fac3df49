//! Primary subfields, which announce the subfields of an item, and repeated parts.

use deku::no_std_io::{Read, Seek, Write};
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};
use smallvec::SmallVec;

use crate::fspec::{Frns, Fspec};
use crate::layout::{Describe, Layout, Subfield};
use crate::octets::{REFUSED, read_octet};

/// The subfields that an item defines, as a primary subfield announces them: seven per octet, like the items of an FSPEC.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Defined {
    subfields: Frns,
    /// Maximum length of the primary subfield, in octets.
    octets: u8,
}

impl Defined {
    pub const fn of(subfields: &[Subfield]) -> Self {
        assert!(subfields.len() <= 7 * Fspec::MAX_OCTETS, "a primary subfield announces them all");
        let (mut index, mut frns) = (0, Frns::NONE);
        while index < subfields.len() {
            frns = frns.with(index as u8 + 1, !subfields[index].key.is_empty());
            index += 1;
        }
        Self { subfields: frns, octets: subfields.len().div_ceil(7) as u8 }
    }
}

/// The primary subfield of a compound item: seven bits per octet, the first one highest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Primary(Fspec);

impl Primary {
    /// Decodes a primary subfield, which must announce only defined subfields.
    #[inline(always)]
    pub fn read<R: Read + Seek>(reader: &mut Reader<R>, defined: Defined) -> Result<Self, DekuError> {
        let mut octet = read_octet(reader)?;
        let (mut bits, mut length) = (u64::from(octet) << 56, 1);
        while octet & 1 == 1 && length < defined.octets {
            octet = read_octet(reader)?;
            bits |= u64::from(octet) << (56 - 8 * length);
            length += 1;
        }
        let primary = Fspec::from_bits(bits, length);
        let ends = octet & 1 == 0;
        if ends && primary.is_within(defined.subfields) { Ok(Self(primary)) } else { Err(REFUSED) }
    }

    /// A primary subfield that announces these subfields, with `padding` superfluous octets.
    pub const fn announcing(subfields: Frns, padding: u8) -> Self {
        Self(Fspec::announcing(subfields, padding))
    }

    #[inline]
    pub const fn has(self, index: u8) -> bool {
        self.0.has(index + 1)
    }

    /// Number of superfluous octets.
    pub const fn padding(self) -> u8 {
        self.0.padding()
    }

    pub fn write<W: Write + Seek>(self, writer: &mut Writer<W>) -> Result<(), DekuError> {
        let (octets, length) = self.0.octets();
        writer.write_bytes(&octets[..length])
    }
}

/// The octet with eight bits before the contents of a reserved expansion field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eight(u8);

impl Eight {
    pub fn read<R: Read + Seek>(reader: &mut Reader<R>, _: Defined) -> Result<Self, DekuError> {
        read_octet(reader).map(Self)
    }

    /// The octet that announces these subfields; the eighth subfield has the lowest bit.
    pub const fn announcing(subfields: Frns, _: u8) -> Self {
        Self(subfields.eight())
    }

    pub const fn has(self, index: u8) -> bool {
        self.0 << index & 0x80 != 0
    }

    pub fn write<W: Write + Seek>(self, writer: &mut Writer<W>) -> Result<(), DekuError> {
        writer.write_bytes(&[self.0])
    }
}

/// A repetitive item: up to 255 parts of the same kind. Up to four of them need no allocation.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Repeated<T>(SmallVec<[T; 4]>);

impl<T: Clone> Repeated<T> {
    /// These parts in this order; `None` if there are more than 255.
    pub fn new(parts: &[T]) -> Option<Self> {
        (parts.len() <= usize::from(u8::MAX)).then(|| Self(parts.into()))
    }
}

impl<T: for<'a> DekuReader<'a>> Repeated<T> {
    #[inline(always)]
    fn read<R: Read + Seek>(&mut self, reader: &mut Reader<R>) -> Result<(), DekuError> {
        let count = read_octet(reader)?;
        if count > 4 {
            self.0.reserve_exact(usize::from(count));
        }
        for _ in 0..count {
            self.0.push(T::from_reader_with_ctx(reader, ())?);
        }
        Ok(())
    }
}

impl<T> core::ops::Deref for Repeated<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T: Describe> Describe for Repeated<T> {
    const LAYOUT: Layout = match T::LAYOUT {
        Layout::Fields(fields) => Layout::Repetitive(fields),
        _ => panic!("what is repeated has a fixed length"),
    };
}

impl<T: for<'a> DekuReader<'a>> DekuReader<'_> for Repeated<T> {
    #[inline(always)]
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let mut repeated = Self(SmallVec::new());
        match repeated.read(reader) {
            Ok(()) => Ok(repeated),
            Err(error) => Err(error),
        }
    }
}

impl<T: DekuWriter> DekuWriter for Repeated<T> {
    fn to_writer<W: Write + Seek>(&self, writer: &mut Writer<W>, (): ()) -> Result<(), DekuError> {
        writer.write_bytes(&[self.0.len() as u8])?;
        for part in &self.0 {
            part.to_writer(writer, ())?;
        }
        Ok(())
    }
}
