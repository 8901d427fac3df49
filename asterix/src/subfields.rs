//! What announces the subfields of an item, and parts that repeat.

use std::io::{Read, Seek, Write};

use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};
use smallvec::SmallVec;

use crate::layout::{Describe, Layout, Subfield};
use crate::variable::{REFUSED, read_octet};

/// The primary subfield of a compound item: seven bits an octet, the first at the top.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Primary(u16);

impl Primary {
    /// FX of the first octet.
    const EXTENSION: u16 = 0x0100;

    const fn bit(index: u32) -> u16 {
        0x8000 >> (index + index / 7)
    }

    /// Reads one that announces no more than `subfields`.
    #[inline(always)]
    pub fn read<R: Read + Seek>(reader: &mut Reader<R>, subfields: &[Subfield]) -> Result<Self, DekuError> {
        let mut bits = u16::from(read_octet(reader)?) << 8;
        if bits & Self::EXTENSION != 0 && subfields.len() > 7 {
            bits = bits & !Self::EXTENSION | u16::from(read_octet(reader)?);
        }
        let mut defined = 0;
        for (index, subfield) in subfields.iter().enumerate() {
            if !subfield.key.is_empty() {
                defined |= Self::bit(index as u32);
            }
        }
        if bits & !defined == 0 { Ok(Self(bits)) } else { Err(REFUSED) }
    }

    #[inline]
    pub const fn has(self, index: u32) -> bool {
        self.0 & Self::bit(index) != 0
    }

    #[must_use]
    pub const fn with(self, index: u32, present: bool) -> Self {
        if present { Self(self.0 | Self::bit(index)) } else { self }
    }

    pub fn write<W: Write + Seek>(self, writer: &mut Writer<W>) -> Result<(), DekuError> {
        let [first, second] = self.0.to_be_bytes();
        if second == 0 { writer.write_bytes(&[first]) } else { writer.write_bytes(&[first | 1, second]) }
    }
}

/// The octet in front of a reserved expansion field's contents: eight bits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Eight(u8);

impl Eight {
    pub fn read<R: Read + Seek>(reader: &mut Reader<R>, _: &[Subfield]) -> Result<Self, DekuError> {
        read_octet(reader).map(Self)
    }

    pub const fn has(self, index: u32) -> bool {
        self.0 << index & 0x80 != 0
    }

    #[must_use]
    pub const fn with(self, index: u32, present: bool) -> Self {
        Self(self.0 | (present as u8) << (7 - index))
    }

    pub fn write<W: Write + Seek>(self, writer: &mut Writer<W>) -> Result<(), DekuError> {
        writer.write_bytes(&[self.0])
    }
}

/// A repetitive item: up to 255 parts of the same kind, of which four take no allocation.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Repeated<T>(SmallVec<[T; 4]>);

impl<T: Clone> Repeated<T> {
    /// These parts in this order, or `None` for more than 255.
    pub fn new(parts: &[T]) -> Option<Self> {
        (parts.len() <= usize::from(u8::MAX)).then(|| Self(parts.into()))
    }
}

impl<T: for<'a> DekuReader<'a>> Repeated<T> {
    #[inline(never)]
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

impl<T> std::ops::Deref for Repeated<T> {
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
