//! Raw ASTERIX: concatenated data blocks, each CAT (1 octet), LEN (2 octets, big-endian, counting these three), records.

use super::Datagram;
use super::error::Damage;
use super::window::Window;

/// Octets of CAT and LEN.
pub(super) const HEADER: usize = 3;

/// LEN of the block that begins with these octets; `None` if fewer than three.
pub(super) fn block_length(octets: &[u8]) -> Option<usize> {
    match octets {
        [_, high, low, ..] => Some(u16::from_be_bytes([*high, *low]).into()),
        _ => None,
    }
}

/// The next block. Where no whole block begins (LEN below 3 or past the end, padding, a stray octet or two) what
/// follows is handed out as it is, so that the decoder reports it with its offset, and `ended` is set: without a
/// trustworthy LEN nobody knows where the next block begins.
pub(super) fn next(window: &mut Window, ended: &mut bool) -> Result<Option<Datagram>, Damage> {
    let origin = window.position();
    let octets = window.peek(HEADER)?;
    if octets.is_empty() {
        return Ok(None);
    }
    let mut length = block_length(octets).unwrap_or(0);
    if length < HEADER || window.peek(length)?.len() < length {
        *ended = true;
        // As much as a datagram can hold; behind damage in a large file there may be gigabytes.
        let most = usize::from(u16::MAX);
        length = window.peek(most)?.len().min(most);
    }
    let payload = window.peek(length)?[..length].to_vec();
    window.consume(length);
    Ok(Some(Datagram { received: None, since_midnight: None, endpoints: None, origin, payload }))
}
