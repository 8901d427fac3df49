//! FINAL recordings, written by surveillance recorders: one record for each message received on a line.
//!
//! | octets | what |
//! |---|---|
//! | 2 | length of the whole record, including these two and the trailer, big-endian |
//! | 1, 1 | numbers of the board and of the line on which it was received; usually 0 |
//! | 1 | recording day; usually 0 |
//! | 3 | time of reception: hundredths of a second since midnight, big-endian |
//! | length - 12 | one or more ASTERIX data blocks |
//! | 4 | trailer: `a5 a5 a5 a5` |
//!
//! Sources: Luciad, *ASTERIX Final format*
//! (<https://dev.luciad.com/portal/productDocumentation/LuciadFusion/docs/articles/guide/asterix/finalformat.html>), and
//! the reader of Croatia Control (<https://github.com/CroatiaControlLtd/asterix>, `asterixfinalsubformat.hxx`), which
//! agree. Neither states the origin of the day count, so the day is ignored and set by the user (see `clock.rs`). Neither
//! states the time scale; UTC is assumed.
//!
//! After damage, the next record is one that ends in the trailer and either follows another or contains whole blocks only.
//! Blocks at the start and end of a damaged record's data are returned without a time, the rest as [`PayloadKind::Unframed`].

use std::collections::VecDeque;

use asterix::blocks;

use super::chain::{MOST, first_place, is_filled, is_readable};
use super::error::Damage;
use super::window::ReadWindow;
use super::{CapturedDatagram, PayloadKind};
use fusion::time::{DAY, SECOND};

/// Octets before the data.
pub(super) const HEADER: usize = 8;
/// Octets after the data.
const TRAILER: [u8; 4] = [0xA5; 4];
/// Length of a record without data, in octets.
const SHORTEST: usize = HEADER + TRAILER.len();
/// Unit of the time, in nanoseconds.
const HUNDREDTH: i64 = SECOND / 100;

const RECORD: &str = "FINAL record";

/// Reader of a FINAL recording.
#[derive(Debug, Default)]
pub(super) struct FinalRecording {
    /// The parts of the current record that are still to be returned.
    parts: VecDeque<RecordPart>,
}

/// A part of a record.
#[derive(Debug)]
struct RecordPart {
    /// Its contents; `None` for header or trailer of a sound record, which are not returned.
    contents: Option<PayloadKind>,
    /// Length in octets.
    length: usize,
    /// Reception time stated by the record.
    since_midnight: Option<i64>,
}

impl FinalRecording {
    /// The next record's data, or a part of a damaged one.
    pub(super) fn next(&mut self, window: &mut ReadWindow) -> Result<Option<CapturedDatagram>, Damage> {
        loop {
            if self.parts.is_empty() {
                if window.peek(1)?.is_empty() {
                    return Ok(None);
                }
                self.parts = match sound_record(window) {
                    Ok(parts) => parts,
                    Err(damage) => damaged_record(window, damage)?,
                };
            }
            let Some(RecordPart { contents, length, since_midnight }) = self.parts.pop_front() else {
                continue;
            };
            let origin = window.position();
            let octets = &window.peek(length)?[..length];
            let datagram = contents.map(|contents| CapturedDatagram {
                origin,
                payload: octets.to_vec(),
                contents,
                since_midnight,
                ..CapturedDatagram::default()
            });
            window.consume(length);
            if datagram.is_some() {
                return Ok(datagram);
            }
        }
    }
}

/// Parts of the record that begins here: header, data of one datagram (broken or not), trailer.
fn sound_record(window: &mut ReadWindow) -> Result<VecDeque<RecordPart>, Damage> {
    let octets = window.peek(HEADER)?;
    let Some(header) = octets.first_chunk::<HEADER>() else {
        return Err(Damage::Cut { record: RECORD, present: octets.len(), needed: HEADER });
    };
    let (length, since_midnight) = (length(header), since_midnight(header));
    if length < SHORTEST {
        let fault = format!("claims {length} octets; {SHORTEST} is the least");
        return Err(Damage::Garbled { record: RECORD, fault });
    }
    let octets = window.peek(length)?;
    if octets.len() < length {
        return Err(Damage::Cut { record: RECORD, present: octets.len(), needed: length });
    }
    if !ends_well(&octets[..length]) {
        let fault = format!("of {length} octets does not end in a5 a5 a5 a5");
        return Err(Damage::Garbled { record: RECORD, fault });
    }
    let data = &octets[HEADER..length - TRAILER.len()];
    let parts = [(None, HEADER), (Some(PayloadKind::Blocks), data.len()), (None, TRAILER.len())];
    if !is_filled(data)
        && (1..length).any(|place| is_behind_trailer(window, place) && is_whole(window, place))
    {
        // The length is wrong, and leads to the end of a later record.
        let fault = format!("of {length} octets holds others");
        return Err(Damage::Garbled { record: RECORD, fault });
    }
    let part = |(contents, length)| RecordPart { contents, length, since_midnight };
    Ok(parts.into_iter().map(part).collect())
}

/// Parts of the octets up to the next record.
fn damaged_record(window: &mut ReadWindow, damage: Damage) -> Result<VecDeque<RecordPart>, Damage> {
    let next = find(window, 1);
    if next.is_none() {
        // A read error does not mean the end of the file.
        window.failed()?;
        if matches!(damage, Damage::Io(_) | Damage::Gzip(_) | Damage::Cut { .. }) {
            return Err(damage);
        }
    }
    let octets = window.peek(next.unwrap_or(MOST))?;
    let octets = &octets[..next.unwrap_or(octets.len().min(MOST))];
    let trailer = if ends_well(octets) { TRAILER.len() } else { 0 };
    let data = octets.get(HEADER..octets.len() - trailer).unwrap_or(&[]);
    let [front, gap, rest] = take_apart(data);
    let (blocks, unframed) = (PayloadKind::Blocks, PayloadKind::Unframed);
    let parts = if gap == data.len() {
        vec![(unframed, octets.len())]
    } else {
        vec![(unframed, HEADER), (blocks, front), (unframed, gap), (blocks, rest), (unframed, trailer)]
    };
    let parts = parts.into_iter().filter(|(_, length)| *length > 0);
    Ok(parts
        .map(|(contents, length)| RecordPart { contents: Some(contents), length, since_midnight: None })
        .collect())
}

/// Lengths in octets: of the blocks at the start, of the octets that belong to no block, and of the blocks at the end.
fn take_apart(data: &[u8]) -> [usize; 3] {
    let front = if is_filled(data) { data.len() } else { readable_blocks(data) };
    let rest = &data[front..];
    let gap = (0..rest.len()).find(|&place| is_readable(&rest[place..])).unwrap_or(rest.len());
    [front, gap, rest.len() - gap]
}

/// Length of the decodable blocks at the start, in octets.
fn readable_blocks(data: &[u8]) -> usize {
    let whole = blocks(data).map_while(Result::ok);
    whole.map(|block| block.octets).take_while(|octets| is_readable(octets)).map(<[u8]>::len).sum()
}

/// The first place from `from` on, and before [`MOST`], where a record begins.
pub(super) fn find(window: &mut ReadWindow, from: usize) -> Option<usize> {
    first_place(window, from, |window, place| {
        (is_behind_trailer(window, place) && whole_record(window, place).is_some()) || is_whole(window, place)
    })
}

fn is_behind_trailer(window: &mut ReadWindow, place: usize) -> bool {
    window.glimpse(place).get(..place).is_some_and(|octets| octets.ends_with(&TRAILER))
}

/// Whether a record of whole blocks only is at `place`.
fn is_whole(window: &mut ReadWindow, place: usize) -> bool {
    whole_record(window, place).is_some_and(|record| is_filled(&record[HEADER..record.len() - TRAILER.len()]))
}

/// The record at `place`, if its time is below 24 h and its trailer is in place.
fn whole_record(window: &mut ReadWindow, place: usize) -> Option<&[u8]> {
    let header = window.glimpse(place + HEADER).get(place..)?.first_chunk()?;
    let (length, _) = (length(header), since_midnight(header)?);
    let record = window.glimpse(place + length).get(place..place + length)?;
    ends_well(record).then_some(record)
}

/// Length in octets of the record with this header.
pub(super) fn length(header: &[u8; HEADER]) -> usize {
    u16::from_be_bytes([header[0], header[1]]).into()
}

/// Nanoseconds since midnight; `None` for 24 h or more.
pub(super) fn since_midnight(header: &[u8; HEADER]) -> Option<i64> {
    let hundredths = u32::from_be_bytes([0, header[5], header[6], header[7]]);
    let nanos = i64::from(hundredths) * HUNDREDTH;
    (nanos < DAY).then_some(nanos)
}

/// Whether a record ends in the trailer.
pub(super) fn ends_well(record: &[u8]) -> bool {
    record.len() >= SHORTEST && record.ends_with(&TRAILER)
}
