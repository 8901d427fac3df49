//! Reading octets: what all readers of items share.

use deku::DekuError;
use deku::error::NeedSize;
use deku::no_std_io::{self, ErrorKind, Read, Seek};
use deku::reader::{Leftover, Reader};

/// Returned by a reader if an item contradicts itself. It stays inside the crate: a second pass over the record
/// finds the fault to report.
pub(crate) const REFUSED: DekuError = DekuError::Io(ErrorKind::InvalidData);

/// Reads one octet.
#[inline(always)]
pub(crate) fn read_octet<R: Read + Seek>(reader: &mut Reader<R>) -> Result<u8, DekuError> {
    read_octets(reader).map(u8::from_be_bytes)
}

/// Reads several octets at once; deku reads the elements of an array one by one.
#[inline(always)]
pub(crate) fn read_octets<const N: usize, R: Read + Seek>(
    reader: &mut Reader<R>,
) -> Result<[u8; N], DekuError> {
    let mut octets = [0; N];
    fill(reader, &mut octets)?;
    Ok(octets)
}

/// Fills these octets, like [`Reader::read_bytes`], which the compiler does not inline in records with many items. The reader is
/// kept in registers as long as no call takes its address.
#[inline(always)]
pub(crate) fn fill<R: Read + Seek>(reader: &mut Reader<R>, octets: &mut [u8]) -> Result<(), DekuError> {
    let ahead = match (&reader.leftover, &mut *octets) {
        (None, _) => 0,
        // An octet that deku has read ahead, for a type outside this crate that contains this one.
        (Some(Leftover::Byte(octet)), [first, ..]) => {
            *first = *octet;
            1
        }
        _ => return Err(REFUSED),
    };
    reader.leftover = None;
    let bits = 8 * octets.len();
    reader.as_mut().read_exact(&mut octets[ahead..]).map_err(|error| incomplete(&error, bits))?;
    reader.bits_read += bits;
    Ok(())
}

#[cold]
fn incomplete(error: &no_std_io::Error, bits: usize) -> DekuError {
    match error.kind() {
        ErrorKind::UnexpectedEof => DekuError::Incomplete(NeedSize::new(bits)),
        kind => DekuError::Io(kind),
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;
    use std::io::Cursor;

    use deku::DekuReader;

    use super::*;
    use crate::TimeOfDay;

    /// Reads a time of day after deku has read `ahead`.
    fn read(ahead: Option<u8>, octets: &[u8]) -> (Result<[u8; 3], DekuError>, Vec<u8>) {
        let mut reader = Reader::new(Cursor::new(octets));
        reader.leftover = ahead.map(Leftover::Byte);
        let time = TimeOfDay::from_reader_with_ctx(&mut reader, ());
        let mut rest = Vec::new();
        reader.into_inner().read_to_end(&mut rest).unwrap();
        (time.map(TimeOfDay::octets), rest)
    }

    #[test]
    fn reads_what_deku_looked_at_first() {
        assert_eq!(read(None, &[1, 2, 3, 4]), (Ok([1, 2, 3]), [4].into()));
        assert_eq!(read(Some(9), &[1, 2, 3]), (Ok([9, 1, 2]), [3].into()));
        let incomplete = || Err(DekuError::Incomplete(NeedSize::new(24)));
        assert_eq!(read(None, &[1, 2]).0, incomplete());
        assert_eq!(read(Some(9), &[1]).0, incomplete());
    }
}
