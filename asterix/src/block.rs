//! Data blocks and the records in them.

use alloc::vec::Vec;

use crate::DataSource;
use crate::fault::{Fault, FaultKind};
use crate::layout::uap::Profile;
use crate::record::Record;

/// Length of a block header (CAT and LEN), in octets.
const HEADER: usize = 3;

/// Iterates over the data blocks of a datagram or of a part of a file.
///
/// A [`Fault`] ends the iteration if LEN is not valid or the rest is too short for a header, because the start of the next
/// block is then unknown. The blocks before it are valid.
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
                // One or two octets: the first may be padding and no CAT.
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

/// A data block: CAT, LEN and records of one category.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block<'a> {
    /// The category (CAT).
    pub category: u8,
    /// Offset of its CAT octet from the start of the datagram.
    pub offset: usize,
    /// The whole block with its header.
    pub octets: &'a [u8],
}

impl<'a> Block<'a> {
    /// The octets after the header: the records.
    pub fn contents(&self) -> &'a [u8] {
        &self.octets[HEADER..]
    }

    /// The data source of the first record, without decoding the rest; `None` if the record does not begin with one.
    pub fn first_source(&self) -> Option<DataSource> {
        let contents = self.contents();
        let fspec = contents.iter().position(|octet| octet & 1 == 0)? + 1;
        let begins = contents.first().is_some_and(|octet| octet & 0x80 != 0);
        let source = contents.get(fspec..fspec + 2).filter(|_| begins)?;
        Some(DataSource { sac: source[0], sic: source[1] })
    }

    /// Number of records in the block, found by the profile of its category without decoding them.
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

    /// The records of the block in order, decoded as `R`.
    ///
    /// The caller must check [`Block::category`]: the octets of another category have no meaning as `R`.
    pub fn records<R: Record<Edition = ()>>(&self) -> Records<'a, R> {
        self.records_in(())
    }

    /// The records of the block in order, decoded in an edition, for categories whose editions differ in layout, such as CAT021.
    pub fn records_in<R: Record>(&self, edition: R::Edition) -> Records<'a, R> {
        debug_assert_eq!(self.category, R::CATEGORY, "records of another category");
        Records { rest: self.contents(), offset: self.offset + HEADER, edition }
    }
}

/// The iterator of [`Block::records`]: the records up to the end of the block or to the first [`Fault`]. The fault is returned
/// once and last, because the end of a bad record is unknown.
#[derive(Clone, Debug)]
pub struct Records<'a, R: Record> {
    rest: &'a [u8],
    offset: usize,
    edition: R::Edition,
}

/// A record with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Located<R> {
    /// Offset of its FSPEC from the start of the datagram.
    pub offset: usize,
    /// Length in octets, with the FSPEC.
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
        // The record is decoded in the place of the return value: moving it takes as long as decoding several items.
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

/// Error: the records do not fit into one block, whose LEN has 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a block of {length} octets does not fit LEN, which ends at 65535")]
pub struct BlockTooLong {
    /// Length that the block would have, in octets, with its header.
    pub length: usize,
}

/// Appends a block with `records`. If they do not fit, `out` remains unchanged.
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
