//! Finds where blocks resume after damage, from the appearance of blocks in the file.
//!
//! No mark begins a block, but its LEN states where the next one begins. Blocks resume where [`STRONG`] consecutive ones
//! are similar to those seen so far, or can be decoded; fewer suffice at the end of the file. In radar data about one place
//! in a thousand looks like a header by chance, three in a row one in 10⁹.

use asterix::{blocks, profile, profiles};

use super::raw::{HEADER, block_length};
use super::window::ReadWindow;

/// Largest block or datagram, octets, and the stretch that is searched at a time.
pub(super) const MOST: usize = u16::MAX as usize;

/// Number of consecutive blocks that are accepted as a chain.
const STRONG: usize = 3;

/// LEN from which a block of a new category is rejected in a search, because its end would have to be waited for. Only
/// radar video has blocks larger than an Ethernet frame.
const LARGE: usize = 0x0900;

/// The blocks of a file so far: the longest LEN of each category, 0 where there was none.
#[derive(Debug)]
pub(super) struct BlockLengths {
    longest: Box<[u16; 256]>,
    is_empty: bool,
}

impl Default for BlockLengths {
    fn default() -> Self {
        Self { longest: Box::new([0; 256]), is_empty: true }
    }
}

impl BlockLengths {
    /// Whether no block has been learned.
    pub(super) fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// Learns the header of a block.
    pub(super) fn learn(&mut self, header: &[u8]) {
        if let (Some(&category), Some(length)) = (header.first(), block_length(header)) {
            let longest = &mut self.longest[usize::from(category)];
            *longest = (*longest).max(length as u16);
            self.is_empty = false;
        }
    }

    /// Whether a header is similar to those seen: of a known category, and at most twice as long.
    pub(super) fn is_familiar(&self, header: &[u8]) -> bool {
        let (Some(&category), Some(length)) = (header.first(), block_length(header)) else { return false };
        category != 0 && length >= HEADER && length <= 2 * usize::from(self.longest[usize::from(category)])
    }

    /// LEN of the block at `place`, if it is whole, not empty, and either familiar or fully decodable.
    pub(super) fn credible(&self, window: &mut ReadWindow, place: usize) -> Option<usize> {
        let header = window.glimpse(place + HEADER).get(place..)?;
        let (category, length) = (*header.first()?, block_length(header).filter(|length| *length > HEADER)?);
        if self.is_familiar(header) {
            return (window.glimpse(place + length).len() >= place + length).then_some(length);
        }
        (profile(category).is_some() && length < LARGE && is_readable_at(window, place, length))
            .then_some(length)
    }

    /// Whether the block of `length` octets here can be decoded, and a chain follows it.
    pub(super) fn is_sound(&self, window: &mut ReadWindow, length: usize) -> bool {
        is_readable_at(window, 0, length) && self.begins(window, length)
    }

    /// The first place from `from` on, and before [`MOST`], where a chain of credible blocks begins.
    pub(super) fn find(&self, window: &mut ReadWindow, from: usize) -> Option<usize> {
        first_place(window, from, |window, place| self.begins(window, place))
    }

    fn begins(&self, window: &mut ReadWindow, mut place: usize) -> bool {
        for count in 0..STRONG {
            if window.glimpse(place + 1).len() == place {
                return count > 0;
            }
            let Some(length) = self.credible(window, place) else { return false };
            place += length;
        }
        true
    }
}

/// Whether a chain of decodable blocks begins within the stretch that is searched at a time.
pub(super) fn is_near(window: &mut ReadWindow) -> bool {
    let known = BlockLengths::default();
    let chain = |window: &mut ReadWindow, mut place: usize| {
        (0..STRONG).all(|_| known.credible(window, place).inspect(|length| place += length).is_some())
    };
    first_place(window, 1, chain).is_some()
}

/// The first place from `from` on, before [`MOST`] and before the end of the file, for which `holds` returns `true`.
pub(super) fn first_place(
    window: &mut ReadWindow,
    from: usize,
    mut holds: impl FnMut(&mut ReadWindow, usize) -> bool,
) -> Option<usize> {
    for place in from..MOST {
        if window.glimpse(place + 1).len() <= place {
            return None;
        }
        if holds(window, place) {
            return Some(place);
        }
    }
    None
}

/// Applies [`is_readable`] at `place`.
fn is_readable_at(window: &mut ReadWindow, place: usize, length: usize) -> bool {
    window.glimpse(place + length).get(place..place + length).is_some_and(is_readable)
}

/// Whether these octets are blocks of known categories whose records can all be decoded.
pub(super) fn is_readable(octets: &[u8]) -> bool {
    let measured =
        |block: asterix::Block<'_>| profiles(block.category).find_map(|items| block.measure(items).ok());
    octets.len() > HEADER
        && blocks(octets)
            .all(|block| block.is_ok_and(|block| measured(block).is_some_and(|records| records > 0)))
}

/// Whether these octets consist of whole blocks.
pub(super) fn is_filled(octets: &[u8]) -> bool {
    blocks(octets).all(|block| block.is_ok())
}

/// LEN of the block at `place`, if the file holds all of it.
pub(super) fn whole_block(window: &mut ReadWindow, place: usize) -> Option<usize> {
    let length =
        block_length(window.glimpse(place + HEADER).get(place..)?).filter(|length| *length >= HEADER)?;
    (window.glimpse(place + length).len() >= place + length).then_some(length)
}

/// Whether consecutive blocks lead from here to exactly `place`.
pub(super) fn leads_to(window: &mut ReadWindow, place: usize) -> bool {
    let mut at = 0;
    while at < place {
        let Some(length) = whole_block(window, at) else { return false };
        at += length;
    }
    at == place
}
