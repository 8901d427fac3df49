//! FINAL recordings: what surveillance recorders write, one record for each message received on a line.
//!
//! | octets | what |
//! |---|---|
//! | 2 | length of the whole record, these two and the trailer included, big-endian |
//! | 1, 1 | number of the board and of the line it was received on; usually 0 |
//! | 1 | recording day; usually 0 |
//! | 3 | time of reception: hundredths of a second since midnight, big-endian |
//! | length - 12 | one or more ASTERIX data blocks |
//! | 4 | trailer: `a5 a5 a5 a5` |
//!
//! Sources: Luciad, *ASTERIX Final format* (<https://dev.luciad.com/portal/productDocumentation/LuciadFusion/docs/articles/guide/asterix/finalformat.html>),
//! and the reader of Croatia Control (<https://github.com/CroatiaControlLtd/asterix>, `asterixfinalsubformat.hxx`), which
//! agree. Neither says from when days are counted, and where the octet is in use it may be anything; so it is not looked
//! at, and the day is told by the user (see `clock.rs`). Neither says which time it is; it is taken for UTC.

use super::Datagram;
use super::error::Damage;
use super::window::Window;
use crate::time::{DAY, SECOND};

/// Octets before the data.
pub(super) const HEADER: usize = 8;
/// Octets behind the data.
const TRAILER: [u8; 4] = [0xA5; 4];
/// Octets of a record without data.
const SHORTEST: usize = HEADER + TRAILER.len();
/// Unit of the time, nanoseconds.
const HUNDREDTH: i64 = SECOND / 100;

const RECORD: &str = "FINAL record";

/// The next record's data.
pub(super) fn next(window: &mut Window) -> Result<Option<Datagram>, Damage> {
    let position = window.position();
    let octets = window.peek(HEADER)?;
    if octets.is_empty() {
        return Ok(None);
    }
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
    let payload = octets[HEADER..length - TRAILER.len()].to_vec();
    window.consume(length);
    let origin = position + HEADER as u64;
    Ok(Some(Datagram { received: None, since_midnight, endpoints: None, origin, payload }))
}

/// Octets of the record with this header.
pub(super) fn length(header: &[u8; HEADER]) -> usize {
    u16::from_be_bytes([header[0], header[1]]).into()
}

/// Nanoseconds; `None` for what no day has.
pub(super) fn since_midnight(header: &[u8; HEADER]) -> Option<i64> {
    let hundredths = u32::from_be_bytes([0, header[5], header[6], header[7]]);
    let nanos = i64::from(hundredths) * HUNDREDTH;
    (nanos < DAY).then_some(nanos)
}

/// Whether a record ends as it must.
pub(super) fn ends_well(record: &[u8]) -> bool {
    record.len() >= SHORTEST && record.ends_with(&TRAILER)
}
