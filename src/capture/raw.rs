//! Raw ASTERIX: concatenated data blocks, each CAT (1 octet), LEN (2 octets, big-endian, counting these three), records.
//!
//! A block is returned once the two headers behind it have been seen. Almost always these are like those before. Otherwise
//! either something new comes, or octets were lost, added or changed: the file is searched for the next chain of blocks
//! (`chain.rs`). If LEN leads there block by block, nothing is wrong, and the new header is learnt; if not, the octets up to
//! there belong to no block and are returned as such. So in a sound file every LEN is followed, whatever its categories.

use super::chain::{Known, MOST, leads_to, whole_block};
use super::error::Damage;
use super::window::Window;
use super::{Contents, Datagram};

/// Octets of CAT and LEN.
pub(super) const HEADER: usize = 3;
/// Consecutive headers like those before that show that nothing is wrong here.
const CHAIN: usize = 3;

/// LEN of the block that begins with these octets; `None` if fewer than three.
pub(super) fn block_length(octets: &[u8]) -> Option<usize> {
    match octets {
        [_, high, low, ..] => Some(u16::from_be_bytes([*high, *low]).into()),
        _ => None,
    }
}

/// Reads a raw file.
#[derive(Debug, Default)]
pub(super) struct Raw {
    known: Known,
    /// Within octets that belong to no block, whose end has not been found.
    lost: bool,
    ahead: Ahead,
}

/// Headers ahead that are like those before; each is examined once.
#[derive(Clone, Copy, Debug, Default)]
struct Ahead {
    /// Their number, at most [`CHAIN`].
    headers: usize,
    /// Octets up to the header behind them.
    octets: usize,
}

impl Ahead {
    /// A block of `length` octets has been read.
    fn pass(&mut self, length: usize) {
        let headers = self.headers.saturating_sub(1);
        *self = Self { headers, octets: if self.headers == 0 { 0 } else { self.octets - length } };
    }
}

impl Raw {
    /// The next block, or at most [`MOST`] octets that belong to none. A last block cut by the end of the file is returned as it
    /// is, for the decoder to report.
    pub(super) fn next(&mut self, window: &mut Window) -> Result<Option<Datagram>, Damage> {
        if window.peek(1)?.is_empty() {
            return Ok(None);
        }
        let origin = window.position();
        let (contents, length) = self.step(window)?;
        let payload = window.peek(length)?[..length].to_vec();
        window.consume(length);
        match contents {
            Contents::Blocks => self.ahead.pass(length),
            Contents::Unframed | Contents::Translated => self.ahead = Ahead::default(),
        }
        Ok(Some(Datagram { origin, contents, payload, ..Datagram::default() }))
    }

    /// Contents and length of what comes next.
    fn step(&mut self, window: &mut Window) -> Result<(Contents, usize), Damage> {
        if self.lost {
            match self.known.find(window, 0) {
                Some(0) => self.lost = false,
                Some(next) => return Ok((Contents::Unframed, next)),
                None => return self.rest(window),
            }
        }
        let mut goes_on = self.goes_on(window);
        if goes_on && self.ahead.headers > 0 {
            // As almost always: this header is like those before, and the next one shows that the block is whole.
            let header = window.glimpse(HEADER);
            self.known.learn(header);
            return Ok((Contents::Blocks, block_length(header).unwrap_or(0)));
        }
        let Some(length) = whole_block(window, 0) else {
            return match self.known.find(window, 1) {
                Some(next) => Ok((Contents::Unframed, next)),
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
                // The damage is behind this block, or in its records.
                Some(next) if length < next && !leads_to(window, next) => {
                    let believed = self.known.credible(window, 0).is_some();
                    return Ok(if believed {
                        (Contents::Blocks, length)
                    } else {
                        (Contents::Unframed, next)
                    });
                }
                Some(next) if !leads_to(window, next) && !self.known.is_sound(window, length) => {
                    return Ok((Contents::Unframed, next));
                }
                // Something new, and LEN leads to what is known; or nothing there says that LEN is wrong.
                _ => {}
            }
        }
        self.known.learn(window.glimpse(HEADER));
        Ok((Contents::Blocks, length))
    }

    /// Whether the header here and the two behind it, or those up to the end of the file, are like those before.
    fn goes_on(&mut self, window: &mut Window) -> bool {
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

    /// Where no block begins within reach: the remainder of the file, or octets that belong to no block.
    fn rest(&mut self, window: &mut Window) -> Result<(Contents, usize), Damage> {
        // Octets that could not be read are no end of the file.
        window.failed()?;
        let rest = window.peek(MOST + 1)?.len();
        if rest <= MOST && !self.lost {
            return Ok((Contents::Blocks, rest));
        }
        self.lost = true;
        Ok((Contents::Unframed, rest.min(MOST)))
    }
}
