//! Raw ASTERIX: concatenated data blocks, each with CAT (1 octet), LEN (2 octets, big-endian, counting these three) and
//! records.
//!
//! A block is returned once the two headers after it have been seen. Almost always these are similar to earlier ones.
//! Otherwise, either a new category begins, or octets were lost, added or changed: the file is searched for the next chain
//! of blocks (`chain.rs`). If LEN leads there block by block, the file is sound, and the new header is learned. If not, the
//! octets up to the chain belong to no block and are returned as such. So in a sound file every LEN is followed, whatever
//! its categories.

use super::chain::{BlockLengths, MOST, leads_to, whole_block};
use super::error::Damage;
use super::window::ReadWindow;
use super::{CapturedDatagram, PayloadKind};

/// Octets of CAT and LEN.
pub(super) const HEADER: usize = 3;
/// Number of consecutive similar headers that show that the file is sound here.
const CHAIN: usize = 3;

/// LEN of the block that begins with these octets; `None` if fewer than three.
pub(super) fn block_length(octets: &[u8]) -> Option<usize> {
    match octets {
        [_, high, low, ..] => Some(u16::from_be_bytes([*high, *low]).into()),
        _ => None,
    }
}

/// Reader of a raw file.
#[derive(Debug, Default)]
pub(super) struct RawReader {
    known: BlockLengths,
    /// Whether the position is within octets that belong to no block, whose end has not been found.
    lost: bool,
    ahead: ExaminedAhead,
}

/// Headers ahead that are similar to earlier ones; each is examined once.
#[derive(Clone, Copy, Debug, Default)]
struct ExaminedAhead {
    /// Their number, at most [`CHAIN`].
    headers: usize,
    /// Octets up to the header after them.
    octets: usize,
}

impl ExaminedAhead {
    /// Advances by a block of `length` octets.
    fn pass(&mut self, length: usize) {
        let headers = self.headers.saturating_sub(1);
        *self = Self { headers, octets: if self.headers == 0 { 0 } else { self.octets - length } };
    }
}

impl RawReader {
    /// The next block, or at most [`MOST`] octets that belong to none. A last block cut by the end of the file is returned
    /// as it is, for the decoder to report.
    pub(super) fn next(&mut self, window: &mut ReadWindow) -> Result<Option<CapturedDatagram>, Damage> {
        if window.peek(1)?.is_empty() {
            return Ok(None);
        }
        let origin = window.position();
        let (contents, length) = self.step(window)?;
        let payload = window.peek(length)?[..length].to_vec();
        window.consume(length);
        match contents {
            PayloadKind::Blocks => self.ahead.pass(length),
            PayloadKind::Unframed | PayloadKind::Translated => self.ahead = ExaminedAhead::default(),
        }
        Ok(Some(CapturedDatagram { origin, contents, payload, ..CapturedDatagram::default() }))
    }

    /// Contents and length of the next octets.
    fn step(&mut self, window: &mut ReadWindow) -> Result<(PayloadKind, usize), Damage> {
        if self.lost {
            match self.known.find(window, 0) {
                Some(0) => self.lost = false,
                Some(next) => return Ok((PayloadKind::Unframed, next)),
                None => return self.rest(window),
            }
        }
        let mut goes_on = self.goes_on(window);
        if goes_on && self.ahead.headers > 0 {
            // The usual case: this header is similar to earlier ones, and the next one shows that the block is whole.
            let header = window.glimpse(HEADER);
            self.known.learn(header);
            return Ok((PayloadKind::Blocks, block_length(header).unwrap_or(0)));
        }
        let Some(length) = whole_block(window, 0) else {
            return match self.known.find(window, 1) {
                Some(next) => Ok((PayloadKind::Unframed, next)),
                None => self.rest(window),
            };
        };
        if self.known.is_empty() {
            let octets = window.glimpse(length + 1);
            if octets.get(length) == octets.first() {
                self.known.learn(octets);
                goes_on = self.goes_on(window);
            }
        }
        if !goes_on {
            match self.known.find(window, 1) {
                // The damage is after this block, or in its records.
                Some(next) if length < next && !leads_to(window, next) => {
                    let believed = self.known.credible(window, 0).is_some();
                    return Ok(if believed {
                        (PayloadKind::Blocks, length)
                    } else {
                        (PayloadKind::Unframed, next)
                    });
                }
                Some(next) if !leads_to(window, next) && !self.known.is_sound(window, length) => {
                    return Ok((PayloadKind::Unframed, next));
                }
                // A new category whose LEN leads to known blocks; or no sign that LEN is wrong.
                _ => {}
            }
        }
        self.known.learn(window.glimpse(HEADER));
        Ok((PayloadKind::Blocks, length))
    }

    /// Whether the header here and the two after it, or those up to the end of the file, are similar to earlier ones.
    fn goes_on(&mut self, window: &mut ReadWindow) -> bool {
        let Self { known, ahead, .. } = self;
        while ahead.headers < CHAIN {
            match window.glimpse(ahead.octets + HEADER).get(ahead.octets..) {
                Some([]) => return true,
                Some(header) if known.is_familiar(header) => {
                    ahead.octets += block_length(header).unwrap_or(0);
                    ahead.headers += 1;
                }
                _ => return false,
            }
        }
        true
    }

    /// If no block begins within reach: the remainder of the file, or octets that belong to no block.
    fn rest(&mut self, window: &mut ReadWindow) -> Result<(PayloadKind, usize), Damage> {
        // A read error does not mean the end of the file.
        window.failed()?;
        let rest = window.peek(MOST + 1)?.len();
        if rest <= MOST && !self.lost {
            return Ok((PayloadKind::Blocks, rest));
        }
        self.lost = true;
        Ok((PayloadKind::Unframed, rest.min(MOST)))
    }
}
