//! ASTERIX in the framings of two recorders: octets in front of each block, or behind it.
//!
//! | framing | header of the file | in front of each record | behind it |
//! |---|---|---|---|
//! | ORADIS | none | u16: octets of the record, these six included; u32: milliseconds since midnight; both big-endian | none |
//! | GPS | 2,200 octets, or none | none | 10 octets |
//!
//! Source: the samples and the reader of Croatia Control (<https://github.com/CroatiaControlLtd/asterix>), which skips all of
//! them. The time of ORADIS is found from its samples: the blocks' own times of day are that long before it. What the octets of
//! a GPS framing say is not known, so its blocks have no time of reception. ORADIS is found in UDP datagrams, too.
//!
//! Behind damage the next record is one whose blocks can be decoded, and that another record or the end of the file follows.

use std::ops::Range;

use super::chain::{MOST, first_place, is_filled, is_readable, whole_block};
use super::error::Damage;
use super::raw::HEADER;
use super::window::Window;
use super::{Contents, Datagram};
use fusion::time::DAY;

/// Octets in front of the blocks of an ORADIS record.
const ORADIS_HEADER: usize = 6;
/// Octets of the header of a file in GPS framing.
const GPS_HEADER: usize = 2200;
/// Octets behind each block in GPS framing.
const GPS_TRAILER: usize = 10;
/// Records in a row by which a file is recognised, unless it ends before.
const RECOGNISED: usize = 3;
/// Nanoseconds in a millisecond.
const MILLISECOND: i64 = 1_000_000;

/// How records are framed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Framing {
    Oradis,
    Gps,
}

/// A whole record.
#[derive(Clone, Copy, Debug)]
struct FramedRecord {
    /// Octets in front of the blocks, of the blocks, and behind them.
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

/// Reads such a file.
#[derive(Debug)]
pub(super) struct Framed {
    framing: Framing,
    /// Octets of the file's header that are still to be skipped.
    header: usize,
}

/// The reader of the file whose first octets these are; `None` where it has not this framing.
pub(super) fn recognise(window: &mut Window, framing: Framing) -> Option<Framed> {
    let begins = |window: &mut Window, mut place| {
        for found in 0..RECOGNISED {
            if found > 0 && window.glimpse(place + 1).len() == place {
                return found > 1 || framing == Framing::Oradis;
            }
            let Some(record) = readable_record(window, framing, place) else { return false };
            place += record.length();
        }
        true
    };
    let headers: &[usize] = if framing == Framing::Gps { &[0, GPS_HEADER] } else { &[0] };
    let header = *headers.iter().find(|header| begins(window, **header))?;
    Some(Framed { framing, header })
}

impl Framed {
    /// How its records are framed.
    pub(super) fn framing(&self) -> Framing {
        self.framing
    }

    /// The blocks of the next record, or octets that belong to none.
    pub(super) fn next(&mut self, window: &mut Window) -> Result<Option<Datagram>, Damage> {
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
        Ok(Some(Datagram {
            origin: origin + before as u64,
            payload,
            since_midnight: record.since_midnight,
            ..Datagram::default()
        }))
    }

    /// The octets up to the next record, at most [`MOST`]; an error where the file ends in the middle of one.
    fn lost(&self, window: &mut Window) -> Result<Datagram, Damage> {
        let framing = self.framing;
        let next = first_place(window, 1, |window, place| {
            readable_record(window, framing, place).is_some()
                && credible_record(window, framing, place).is_some()
        });
        if next.is_none() {
            // Octets that could not be read are no end of the file.
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
        Ok(Datagram { origin, payload, contents: Contents::Unframed, ..Datagram::default() })
    }
}

/// Octets of the record that begins here, if the file ends before it does.
fn cut_record(framing: Framing, octets: &[u8]) -> Option<usize> {
    let needed = match framing {
        Framing::Oradis => oradis_length(octets)?,
        Framing::Gps => super::raw::block_length(octets)?,
    };
    (octets.len() < needed).then_some(needed)
}

/// The record at `place`, if the file holds all of it. Of a last one in GPS framing the octets behind it may be missing.
fn whole_record(window: &mut Window, framing: Framing, place: usize) -> Option<FramedRecord> {
    match framing {
        Framing::Oradis => {
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
        Framing::Gps => {
            let category = *window.glimpse(place + 1).get(place)?;
            let length = whole_block(window, place).filter(|_| category != 0)?;
            let behind = window.glimpse(place + length + GPS_TRAILER).len() - (place + length);
            Some(FramedRecord { parts: [0, length, behind.min(GPS_TRAILER)], since_midnight: None })
        }
    }
}

/// The same, if its blocks can be decoded.
fn readable_record(window: &mut Window, framing: Framing, place: usize) -> Option<FramedRecord> {
    let record = whole_record(window, framing, place)?;
    let blocks = record.blocks();
    let octets = window.glimpse(place + blocks.end).get(place + blocks.start..place + blocks.end)?;
    is_readable(octets).then_some(record)
}

/// The same, if it can be decoded, or a record or the end of the file follows it; in GPS framing one that can be decoded. Where
/// nothing of the kind follows, the octets behind the block are not taken for those of its framing.
fn credible_record(window: &mut Window, framing: Framing, place: usize) -> Option<FramedRecord> {
    let record = whole_record(window, framing, place)?;
    let next = place + record.length();
    let is_followed = window.glimpse(next + 1).len() == next
        || match framing {
            Framing::Oradis => whole_record(window, framing, next).is_some(),
            Framing::Gps => readable_record(window, framing, next).is_some(),
        };
    if is_followed {
        return Some(record);
    }
    let [before, blocks, _] = readable_record(window, framing, place)?.parts;
    Some(FramedRecord { parts: [before, blocks, 0], ..record })
}

/// Octets of the ORADIS record that begins with these, if its header and the one of its first block fit each other.
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

/// Where the blocks of each ORADIS record are, if a datagram consists of such records and nothing else.
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

/// The blocks of a datagram in ORADIS framing; `None` if it has none.
pub(crate) fn oradis_blocks(payload: &[u8]) -> Option<Vec<u8>> {
    let records = oradis_records(payload)?;
    Some(records.into_iter().flat_map(|blocks| &payload[blocks]).copied().collect())
}

/// The datagram, or of one in ORADIS framing a datagram for the blocks of each record.
pub(super) fn unwrapped(datagram: Datagram) -> Vec<Datagram> {
    let records = match datagram.contents {
        Contents::Blocks => oradis_records(&datagram.payload),
        Contents::Unframed | Contents::Translated => None,
    };
    let Some(records) = records else { return vec![datagram] };
    let part = |blocks: Range<usize>| Datagram {
        origin: datagram.origin + blocks.start as u64,
        payload: datagram.payload[blocks].to_vec(),
        ..datagram.clone()
    };
    records.into_iter().map(part).collect()
}
