//! MAVLink telemetry logs (`.tlog`), as ground stations write them: consecutive records.
//!
//! | octets | what |
//! |---|---|
//! | 8 | time of reception: microseconds since 1970, UTC, big-endian |
//! | 8 to 280 | a MAVLink frame, of version 1 or 2 |
//!
//! [`crate::gateways::mavlink`] translates positions, aircraft with ADS-B and Remote ID. After damage, the next record is
//! one with a correct checksum, or one that another record follows.

use super::chain::{MOST, first_place};
use super::error::Damage;
use super::receivers::SiteReceivers;
use super::skipped::{SkipReason, SkippedFrames};
use super::window::ReadWindow;
use super::{CapturedDatagram, PayloadKind};
use crate::gateways::mavlink::{self, MavlinkDropReason, MavlinkTranslator};
use fusion::time::Time;

/// Octets of the time.
const STAMP: usize = 8;
/// Octets of the shortest frame.
const FRAME_LEAST: usize = 8;
/// First octets of frames of version 1 and 2.
const MAGIC: [u8; 2] = [0xfe, 0xfd];
/// Range of the times in a log, in microseconds: from 2000 to 2100.
const TIMES_US: std::ops::Range<u64> = 946_684_800_000_000..4_102_444_800_000_000;
/// Number of consecutive records by which a file is recognised, unless it ends earlier.
const RECOGNISED: usize = 4;

/// Reader of such a file.
#[derive(Debug)]
pub(super) struct Tlog {
    translator: MavlinkTranslator,
}

/// A whole record.
#[derive(Clone, Copy)]
struct LogRecord {
    received: Time,
    /// Length in octets, including the time.
    length: usize,
    /// Whether the checksum of its frame is correct; `None` if it cannot be verified.
    is_sound: Option<bool>,
}

/// Whether the first records of a file are consecutive.
pub(super) fn begins(window: &mut ReadWindow) -> bool {
    let mut place = 0;
    for found in 0..RECOGNISED {
        if found > 0 && window.glimpse(place + 1).len() == place {
            return true;
        }
        let Some(record) = whole_record(window, place) else { return false };
        place += record.length;
    }
    true
}

impl Tlog {
    /// Reader of a file of this site.
    pub(super) fn open(receivers: &SiteReceivers) -> Self {
        Self { translator: MavlinkTranslator::new(receivers.mavlink.clone()) }
    }

    /// The next position, or octets that belong to no record; all other records are counted in `skipped`.
    pub(super) fn next(
        &mut self,
        window: &mut ReadWindow,
        skipped: &mut SkippedFrames,
    ) -> Result<Option<CapturedDatagram>, Damage> {
        loop {
            if window.peek(1)?.is_empty() {
                return Ok(None);
            }
            let origin = window.position();
            let Some(record) = credible_record(window, 0) else {
                return lost(window).map(Some);
            };
            let frame = &window.glimpse(record.length)[STAMP..record.length];
            let translated = self.translator.frame_at(frame, record.received);
            window.consume(record.length);
            match translated {
                Ok(Some(payload)) => {
                    return Ok(Some(CapturedDatagram {
                        received: Some(record.received),
                        origin,
                        payload,
                        contents: PayloadKind::Translated,
                        ..CapturedDatagram::default()
                    }));
                }
                Ok(None) => skipped.add(SkipReason::NotPosition),
                Err(reason) => skipped.add(reason_of(reason)),
            }
        }
    }
}

/// Octets up to the next record, at most [`MOST`]; an error if the file ends within a record.
fn lost(window: &mut ReadWindow) -> Result<CapturedDatagram, Damage> {
    let next = first_place(window, 1, |window, place| credible_record(window, place).is_some());
    let octets = window.peek(next.unwrap_or(1))?;
    if next.is_none() && has_stamp(octets) {
        let start = octets.get(STAMP..).and_then(|frame| frame.first_chunk());
        let needed = STAMP + start.and_then(|start| mavlink::frame_length(*start)).unwrap_or(FRAME_LEAST);
        if octets.len() < needed {
            return Err(Damage::Cut { record: "record of a MAVLink log", present: octets.len(), needed });
        }
    }
    let origin = window.position();
    let octets = window.glimpse(next.unwrap_or(MOST));
    let payload = octets[..next.unwrap_or(octets.len().min(MOST))].to_vec();
    window.consume(payload.len());
    Ok(CapturedDatagram { origin, payload, contents: PayloadKind::Unframed, ..CapturedDatagram::default() })
}

fn reason_of(reason: MavlinkDropReason) -> SkipReason {
    match reason {
        MavlinkDropReason::Cut => SkipReason::Truncated,
        MavlinkDropReason::Checksum => SkipReason::Checksum,
        MavlinkDropReason::Incompatible => SkipReason::Malformed,
        MavlinkDropReason::OtherMessage | MavlinkDropReason::NoPosition => SkipReason::NotPosition,
        MavlinkDropReason::UnknownSystem => SkipReason::UnknownSystem,
        MavlinkDropReason::OutOfRange => SkipReason::Implausible,
    }
}

/// Whether these octets begin with a time within range and, as far as they go, a frame.
fn has_stamp(octets: &[u8]) -> bool {
    let time = octets.first_chunk().map(|stamp| u64::from_be_bytes(*stamp));
    time.is_some_and(|time_us| TIMES_US.contains(&time_us))
        && octets.get(STAMP).is_none_or(|magic| MAGIC.contains(magic))
}

/// The record at `place`, if the file holds all of it.
fn whole_record(window: &mut ReadWindow, place: usize) -> Option<LogRecord> {
    // Time and magic octet first: most places have neither, and the file need not be read far ahead.
    let octets = window.glimpse(place + STAMP + 1).get(place..).filter(|octets| octets.len() > STAMP)?;
    if !has_stamp(octets) {
        return None;
    }
    let time_us = u64::from_be_bytes(*octets.first_chunk()?);
    let received = Time::from_nanos(i64::try_from(time_us).ok()?.checked_mul(1000)?);
    let start = *window.glimpse(place + STAMP + 3).get(place + STAMP..)?.first_chunk()?;
    let length = STAMP + mavlink::frame_length(start)?;
    let frame = window.glimpse(place + length).get(place + STAMP..place + length)?;
    Some(LogRecord { received, length, is_sound: mavlink::is_sound(frame) })
}

/// The record at `place`, if its checksum is correct, or another record or the end of the file follows it.
fn credible_record(window: &mut ReadWindow, place: usize) -> Option<LogRecord> {
    let record = whole_record(window, place)?;
    let next = place + record.length;
    if record.is_sound == Some(true) {
        return Some(record);
    }
    let follows = window.glimpse(next + STAMP + 1).get(next..)?;
    (follows.is_empty() || has_stamp(follows)).then_some(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(octets: &[u8]) -> ReadWindow {
        ReadWindow::new(Box::new(std::io::Cursor::new(octets.to_vec())))
    }

    /// A record with a message of which only the length is known.
    fn record(second: u64) -> Vec<u8> {
        let time_us = (1_790_000_000 + second) * 1_000_000;
        [&time_us.to_be_bytes()[..], &[0xfe, 3, 0, 1, 1, 200], &[1, 2, 3], &[4, 5]].concat()
    }

    #[test]
    fn log_is_recognised_by_records_in_a_row() {
        let log = (0..5).flat_map(record).collect::<Vec<_>>();
        assert!(begins(&mut window(&log)));
        assert!(begins(&mut window(&log[..19])), "one record alone");
        assert!(!begins(&mut window(&log[..30])), "the second is cut");
        let mut damaged = log.clone();
        damaged[19] = 0xff;
        assert!(!begins(&mut window(&damaged)), "a time of the far future");
        assert!(!begins(&mut window(&[])));
    }

    #[test]
    fn octets_between_records_are_counted_as_unframed() {
        let log = [record(0), record(1), vec![7; 10], record(2), record(3)].concat();
        let mut window = window(&log);
        let (mut tlog, mut skipped) = (Tlog::open(&SiteReceivers::default()), SkippedFrames::default());
        let lost = tlog.next(&mut window, &mut skipped).unwrap().unwrap();
        // The record before the damage cannot be verified, and no record follows it.
        assert_eq!((lost.origin, lost.payload.len(), lost.contents), (19, 29, PayloadKind::Unframed));
        assert!(tlog.next(&mut window, &mut skipped).unwrap().is_none());
        assert_eq!(skipped.count(SkipReason::NotPosition), 3);
    }

    #[test]
    fn file_ending_within_a_record_is_reported() {
        let log = [record(0), record(1)].concat();
        let mut window = window(&log[..log.len() - 3]);
        let (mut tlog, mut skipped) = (Tlog::open(&SiteReceivers::default()), SkippedFrames::default());
        let damage = tlog.next(&mut window, &mut skipped).unwrap_err();
        assert!(matches!(damage, Damage::Cut { present: 16, needed: 19, .. }), "{damage:?}");
        assert_eq!(skipped.total(), 1);
    }
}
