//! ASTERIX in the framings of two recorders, with octets before or after each block.
//!
//! | framing | header of the file | before each record | after it |
//! |---|---|---|---|
//! | ORADIS | none | u16: octets of the record, including these six; u32: milliseconds since midnight; both big-endian | none |
//! | GPS | 2,200 octets, or none | none | 10 octets |
//!
//! Source: the samples and the reader of Croatia Control (<https://github.com/CroatiaControlLtd/asterix>), which skips all
//! of them. The meaning of the ORADIS time is inferred from its samples, in which it is shortly after the
//! blocks' times of day. The octets of the GPS framing are undocumented, so its blocks have no time of reception. ORADIS also
//! occurs in UDP datagrams.
//!
//! After damage, the next record is one whose blocks can be decoded, and that is followed by another record or the end of
//! the file.

use std::ops::Range;

use super::chain::{MOST, first_place, is_filled, is_readable, whole_block};
use super::error::Damage;
use super::raw::HEADER;
use super::window::ReadWindow;
use super::{CapturedDatagram, PayloadKind};
use fusion::time::DAY;

/// Octets before the blocks of an ORADIS record.
const ORADIS_HEADER: usize = 6;
/// Length of a file's header in GPS framing, in octets.
const GPS_HEADER: usize = 2200;
/// Octets after each block in GPS framing.
const GPS_TRAILER: usize = 10;
/// Number of consecutive records by which a file is recognised, unless it ends earlier.
const RECOGNISED: usize = 3;
/// Nanoseconds in a millisecond.
const MILLISECOND: i64 = 1_000_000;

/// Framing of the records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RecorderFraming {
    Oradis,
    Gps,
}

/// A whole record.
#[derive(Clone, Copy, Debug)]
struct FramedRecord {
    /// Octets before the blocks, of the blocks, and after them.
    parts: [usize; 3],
    since_midnight: Option<i64>,
}

impl FramedRecord {
    fn length(&self) -> usize {
        self.parts.iter().sum()
    }

    fn blocks(&self) -> Range<usize> {
        self.parts[0]..self.parts[0] + self.parts[1]
    }
}

/// Reader of such a file.
#[derive(Debug)]
pub(super) struct Framed {
    framing: RecorderFraming,
    /// Octets of the file's header that are still to be skipped.
    header: usize,
}

/// Reader of the file that begins with these octets; `None` if it does not have this framing.
pub(super) fn recognise(window: &mut ReadWindow, framing: RecorderFraming) -> Option<Framed> {
    let begins = |window: &mut ReadWindow, mut place| {
        for found in 0..RECOGNISED {
            if found > 0 && window.glimpse(place + 1).len() == place {
                return found > 1 || framing == RecorderFraming::Oradis;
            }
            let Some(record) = readable_record(window, framing, place) else { return false };
            place += record.length();
        }
        true
    };
    let headers: &[usize] = if framing == RecorderFraming::Gps { &[0, GPS_HEADER] } else { &[0] };
    let header = *headers.iter().find(|header| begins(window, **header))?;
    Some(Framed { framing, header })
}

impl Framed {
    /// Framing of its records.
    pub(super) fn framing(&self) -> RecorderFraming {
        self.framing
    }

    /// Blocks of the next record, or octets that belong to none.
    pub(super) fn next(&mut self, window: &mut ReadWindow) -> Result<Option<CapturedDatagram>, Damage> {
        let header = std::mem::take(&mut self.header);
        let present = window.peek(header)?.len();
        window.consume(present.min(header));
        if window.peek(1)?.is_empty() {
            return Ok(None);
        }
        let origin = window.position();
        let Some(record) = credible_record(window, self.framing, 0) else {
            return self.lost(window).map(Some);
        };
        let [before, length, _] = record.parts;
        let payload = window.peek(record.length())?[record.blocks()].to_vec();
        window.consume(record.length());
        debug_assert_eq!(payload.len(), length);
        Ok(Some(CapturedDatagram {
            origin: origin + before as u64,
            payload,
            since_midnight: record.since_midnight,
            ..CapturedDatagram::default()
        }))
    }

    /// Octets up to the next record, at most [`MOST`]; an error if the file ends within a record.
    fn lost(&self, window: &mut ReadWindow) -> Result<CapturedDatagram, Damage> {
        let framing = self.framing;
        let next = first_place(window, 1, |window, place| {
            readable_record(window, framing, place).is_some()
                && credible_record(window, framing, place).is_some()
        });
        if next.is_none() {
            // A read error does not mean the end of the file.
            window.failed()?;
        }
        let octets = window.glimpse(next.unwrap_or(MOST));
        let payload = octets[..next.unwrap_or(octets.len().min(MOST))].to_vec();
        if next.is_none()
            && let Some(needed) = cut_record(framing, &payload)
        {
            return Err(Damage::Cut { record: "record", present: payload.len(), needed });
        }
        let origin = window.position();
        window.consume(payload.len());
        Ok(CapturedDatagram {
            origin,
            payload,
            contents: PayloadKind::Unframed,
            ..CapturedDatagram::default()
        })
    }
}

/// Length of the record that begins here, if the file ends within it.
fn cut_record(framing: RecorderFraming, octets: &[u8]) -> Option<usize> {
    let needed = match framing {
        RecorderFraming::Oradis => oradis_length(octets)?,
        RecorderFraming::Gps => super::raw::block_length(octets)?,
    };
    (octets.len() < needed).then_some(needed)
}

/// The record at `place`, if the file holds all of it. In GPS framing the octets after the last block may be missing.
fn whole_record(window: &mut ReadWindow, framing: RecorderFraming, place: usize) -> Option<FramedRecord> {
    match framing {
        RecorderFraming::Oradis => {
            let start = window.glimpse(place + ORADIS_HEADER + HEADER).get(place..)?;
            let length = oradis_length(start)?;
            let record = window.glimpse(place + length).get(place..place + length)?;
            let data = &record[ORADIS_HEADER..];
            let since_midnight = oradis_since_midnight(record)?;
            is_filled(data).then_some(FramedRecord {
                parts: [ORADIS_HEADER, data.len(), 0],
                since_midnight: Some(since_midnight),
            })
        }
        RecorderFraming::Gps => {
            let category = *window.glimpse(place + 1).get(place)?;
            let length = whole_block(window, place).filter(|_| category != 0)?;
            let behind = window.glimpse(place + length + GPS_TRAILER).len() - (place + length);
            Some(FramedRecord { parts: [0, length, behind.min(GPS_TRAILER)], since_midnight: None })
        }
    }
}

/// The record at `place`, if its blocks can be decoded.
fn readable_record(window: &mut ReadWindow, framing: RecorderFraming, place: usize) -> Option<FramedRecord> {
    let record = whole_record(window, framing, place)?;
    let blocks = record.blocks();
    let octets = window.glimpse(place + blocks.end).get(place + blocks.start..place + blocks.end)?;
    is_readable(octets).then_some(record)
}

/// The record at `place`, if its blocks can be decoded, or a record or the end of the file follows it; in GPS framing the
/// following record has to be decodable. Otherwise the octets after the block do not count as its framing.
fn credible_record(window: &mut ReadWindow, framing: RecorderFraming, place: usize) -> Option<FramedRecord> {
    let record = whole_record(window, framing, place)?;
    let next = place + record.length();
    let is_followed = window.glimpse(next + 1).len() == next
        || match framing {
            RecorderFraming::Oradis => whole_record(window, framing, next).is_some(),
            RecorderFraming::Gps => readable_record(window, framing, next).is_some(),
        };
    if is_followed {
        return Some(record);
    }
    let [before, blocks, _] = readable_record(window, framing, place)?.parts;
    Some(FramedRecord { parts: [before, blocks, 0], ..record })
}

/// Length of the ORADIS record that begins with these octets, if its header and that of its first block are consistent.
fn oradis_length(octets: &[u8]) -> Option<usize> {
    let length = usize::from(u16::from_be_bytes(*octets.first_chunk()?));
    let block = octets.get(ORADIS_HEADER..)?;
    let block_length = super::raw::block_length(block)?;
    oradis_since_midnight(octets)?;
    (block[0] != 0 && block_length >= HEADER && ORADIS_HEADER + block_length <= length).then_some(length)
}

/// Nanoseconds since midnight; `None` for 24 h or more.
fn oradis_since_midnight(record: &[u8]) -> Option<i64> {
    let milliseconds = u32::from_be_bytes(*record.get(2..)?.first_chunk()?);
    let nanos = i64::from(milliseconds) * MILLISECOND;
    (nanos < DAY).then_some(nanos)
}

/// Ranges of the blocks in each ORADIS record, if a datagram consists of such records only.
fn oradis_records(payload: &[u8]) -> Option<Vec<Range<usize>>> {
    let mut found = Vec::new();
    let mut place = 0;
    while place < payload.len() {
        let end = place + oradis_length(&payload[place..])?;
        let blocks = place + ORADIS_HEADER..end;
        if !payload.get(blocks.clone()).is_some_and(is_filled) {
            return None;
        }
        found.push(blocks);
        place = end;
    }
    (!found.is_empty()).then_some(found)
}

/// Blocks of a datagram in ORADIS framing; `None` without this framing.
pub fn oradis_blocks(payload: &[u8]) -> Option<Vec<u8>> {
    let records = oradis_records(payload)?;
    Some(records.into_iter().flat_map(|blocks| &payload[blocks]).copied().collect())
}

/// The datagram; one in ORADIS framing is split into a datagram for each record.
pub(super) fn unwrapped(datagram: CapturedDatagram) -> Vec<CapturedDatagram> {
    let records = match datagram.contents {
        PayloadKind::Blocks => oradis_records(&datagram.payload),
        PayloadKind::Unframed | PayloadKind::Translated => None,
    };
    let Some(records) = records else { return vec![datagram] };
    let part = |blocks: Range<usize>| CapturedDatagram {
        origin: datagram.origin + blocks.start as u64,
        payload: datagram.payload[blocks].to_vec(),
        ..datagram.clone()
    };
    records.into_iter().map(part).collect()
}
