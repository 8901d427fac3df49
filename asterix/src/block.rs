//! Data blocks and the records in them.

use alloc::vec::Vec;

use crate::DataSource;
use crate::fault::{Fault, FaultKind};
use crate::record::Record;
use crate::uap::Profile;

/// Octets of a block header: CAT and LEN.
const HEADER: usize = 3;

/// Walks the data blocks of one datagram or of a slice of a file.
///
/// A block whose LEN cannot be right ends the walk with a [`Fault`], as does a rest too short for a header: where the
/// next block begins is unknown. The blocks before it stand.
pub fn blocks(octets: &[u8]) -> Blocks<'_> {
    Blocks { octets, offset: 0 }
}

/// The iterator of [`blocks`].
#[derive(Clone, Debug)]
pub struct Blocks<'a> {
    octets: &'a [u8],
    offset: usize,
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<Block<'a>, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let offset = self.offset;
        let rest = &self.octets[offset..];
        let &category = rest.first()?;
        let length = match rest {
            [_, high, low, ..] => usize::from(u16::from_be_bytes([*high, *low])),
            _ => {
                // One or two octets: what looks like a CAT may be padding.
                self.offset = self.octets.len();
                return Some(Err(Fault {
                    category: None,
                    item: None,
                    offset,
                    kind: FaultKind::BlockPastEnd,
                }));
            }
        };
        let fault = |kind| Fault { category: Some(category), item: None, offset, kind };
        let block = if length < HEADER {
            Err(fault(FaultKind::BlockTooShort))
        } else {
            match rest.get(..length) {
                Some(octets) => Ok(Block { category, offset, octets }),
                None => Err(fault(FaultKind::BlockPastEnd)),
            }
        };
        self.offset = if block.is_ok() { offset + length } else { self.octets.len() };
        Some(block)
    }
}

impl core::iter::FusedIterator for Blocks<'_> {}

/// A data block: CAT, LEN and records of that category.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block<'a> {
    /// The category (CAT).
    pub category: u8,
    /// Where its CAT octet stands, counted from 0 at the start of the datagram.
    pub offset: usize,
    /// The whole block, header included.
    pub octets: &'a [u8],
}

impl<'a> Block<'a> {
    /// What follows the header: the records.
    pub fn contents(&self) -> &'a [u8] {
        &self.octets[HEADER..]
    }

    /// The data source of the first record, read without the rest of it; `None` where that does not begin with one.
    pub fn first_source(&self) -> Option<DataSource> {
        let contents = self.contents();
        let fspec = contents.iter().position(|octet| octet & 1 == 0)? + 1;
        let begins = contents.first().is_some_and(|octet| octet & 0x80 != 0);
        let source = contents.get(fspec..fspec + 2).filter(|_| begins)?;
        Some(DataSource { sac: source[0], sic: source[1] })
    }

    /// How many records the block holds, measured by the profile of its category and not read.
    pub fn measure(&self, profile: &Profile) -> Result<usize, Fault> {
        let (mut count, mut offset) = (0, HEADER);
        while offset < self.octets.len() {
            let length = profile
                .measure(self.category, &self.octets[offset..])
                .map_err(|fault| Fault { offset: self.offset + offset + fault.offset, ..fault })?;
            offset += length;
            count += 1;
        }
        Ok(count)
    }

    /// The records of the block, in order, read as records of `R`.
    ///
    /// The caller has looked at [`Block::category`]: the octets of another category make no sense as `R`.
    pub fn records<R: Record<Edition = ()>>(&self) -> Records<'a, R> {
        self.records_in(())
    }

    /// The same of a category whose editions are laid out differently, such as CAT021: in this one.
    pub fn records_in<R: Record>(&self, edition: R::Edition) -> Records<'a, R> {
        debug_assert_eq!(self.category, R::CATEGORY, "records of another category");
        Records { rest: self.contents(), offset: self.offset + HEADER, edition }
    }
}

/// The iterator of [`Block::records`]: every record up to the end of the block or to the first [`Fault`], which comes once
/// and last, because where a bad record ends is unknown.
#[derive(Clone, Debug)]
pub struct Records<'a, R: Record> {
    rest: &'a [u8],
    offset: usize,
    edition: R::Edition,
}

/// A record and where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Located<R> {
    /// Where its FSPEC begins, counted from 0 at the start of the datagram.
    pub offset: usize,
    /// Octets it takes, FSPEC included.
    pub length: usize,
    /// The record.
    pub record: R,
}

impl<R: Record> Iterator for Records<'_, R> {
    type Item = Result<Located<R>, Fault>;

    #[inline(always)] // the record is then moved once less
    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        // A record is put where it is returned before it is read: to move it takes as long as to read some items.
        let offset = self.offset;
        let mut next = Some(Ok(Located { offset, length: 0, record: R::default() }));
        if let Some(Ok(located)) = &mut next {
            match located.record.decode_into(self.rest, self.edition) {
                Ok(length) => {
                    self.rest = &self.rest[length..];
                    self.offset += length;
                    located.length = length;
                }
                Err(fault) => {
                    self.rest = &[];
                    next = Some(Err(Fault { offset: offset + fault.offset, ..fault }));
                }
            }
        }
        next
    }
}

impl<R: Record> core::iter::FusedIterator for Records<'_, R> {}

/// The records do not fit into one block: LEN has 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a block of {length} octets does not fit LEN, which ends at 65535")]
pub struct BlockTooLong {
    /// Octets that the block would have had, header included.
    pub length: usize,
}

/// Appends one block that holds `records`. When they do not fit, `out` is left as it was.
pub fn encode_block<R: Record>(records: &[R], out: &mut Vec<u8>) -> Result<(), BlockTooLong> {
    let start = out.len();
    out.extend_from_slice(&[R::CATEGORY, 0, 0]);
    for record in records {
        record.encode_into(out);
    }
    let length = out.len() - start;
    match u16::try_from(length) {
        Ok(len) => {
            out[start + 1..start + HEADER].copy_from_slice(&len.to_be_bytes());
            Ok(())
        }
        Err(_) => {
            out.truncate(start);
            Err(BlockTooLong { length })
        }
    }
}
