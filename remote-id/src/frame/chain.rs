//! Reassembly of Bluetooth advertising data that continue in further packets (AUX_CHAIN_IND) or reports.

use std::borrow::Cow;
use std::collections::VecDeque;

use super::bluetooth::{self, Part};
use super::{Advertisement, Link, NotHeard, Transport, advertisements, at_least_one};
use crate::message::is_pack_header;

/// Maximum number of advertisers with incomplete data; a further one discards the oldest.
const WAITING_MOST: usize = 16;
/// Maximum length of advertising data, in octets (Core 5.4, volume 4 part E, section 7.8.54).
const DATA_MOST: usize = 1650;
/// Lengths of a message, and of the header of a pack, in octets.
const MESSAGE: usize = crate::LENGTH;
const PACK_HEADER: usize = 3;

/// Reads frames in the order of their reception, and reassembles advertisements from several frames.
///
/// The complete messages of a pack are returned at once, the others with the packet that completes them. Messages that remain
/// incomplete are returned as they are with the next data of their advertiser.
#[derive(Clone, Debug, Default)]
pub struct Listener(VecDeque<Chain>);

/// The data of an advertiser received so far.
#[derive(Clone, Debug)]
struct Chain {
    address: [u8; 6],
    set: u16,
    data: Vec<u8>,
    /// Number of messages of its Remote ID already returned.
    given: usize,
}

impl Listener {
    /// Reads a frame as [`advertisements`] does, and continues the data that earlier frames began.
    ///
    /// # Errors
    /// The frame carries no advertisement, or is damaged.
    pub fn hear<'a>(&mut self, link: Link, frame: &'a [u8]) -> Result<Vec<Advertisement<'a>>, NotHeard> {
        let Some((parts, is_cut)) = bluetooth::parts(link, frame)? else {
            return advertisements(link, frame);
        };
        let mut found = Vec::new();
        parts.into_iter().for_each(|part| self.take(part, &mut found));
        at_least_one(found, is_cut)
    }

    fn take<'a>(&mut self, part: Part<'a>, found: &mut Vec<Advertisement<'a>>) {
        let belongs = |chain: &Chain| {
            let is_same = Some(chain.set) == part.set;
            is_same && part.address.is_none_or(|address| part.may_continue && chain.address == address)
        };
        let known = self.0.iter().position(belongs).and_then(|at| self.0.remove(at));
        let mut chain = match (known, part.address) {
            (Some(mut chain), _) => {
                chain.data.extend(part.data);
                chain.data.truncate(DATA_MOST);
                chain
            }
            (None, Some(address)) => {
                // The rest of the advertiser's previous data is lost.
                if let Some(at) = self.0.iter().position(|chain| chain.address == address)
                    && let Some(mut lost) = self.0.remove(at)
                {
                    found.extend(lost.next(false));
                }
                match part.set.filter(|_| part.has_more) {
                    Some(set) => Chain { address, set, data: part.data.to_vec(), given: 0 },
                    None => return bluetooth::service_data(found, address, part.data),
                }
            }
            (None, None) => return,
        };
        found.extend(chain.next(part.has_more));
        if part.has_more {
            if self.0.len() == WAITING_MOST
                && let Some(mut lost) = self.0.pop_front()
            {
                found.extend(lost.next(false));
            }
            self.0.push_back(chain);
        }
    }
}

impl Chain {
    /// The messages of the first Remote ID not returned yet: the complete ones if more data may follow, otherwise all.
    fn next(&mut self, has_more: bool) -> Option<Advertisement<'static>> {
        let (counter, octets) = bluetooth::remote_id_of(&self.data)?;
        let octets = if is_pack_header(octets) {
            let (header, messages) = octets.split_at(PACK_HEADER);
            let count = usize::from(header[2]);
            let whole = count.min(messages.len() / MESSAGE);
            let (end, rest) = if has_more { (whole, whole * MESSAGE) } else { (count, messages.len()) };
            let left = end.checked_sub(self.given).filter(|left| *left > 0)?;
            let begin = self.given * MESSAGE;
            self.given = end;
            [&[header[0], header[1], left as u8], &messages[begin..rest.max(begin)]].concat()
        } else if self.given == 0 && (octets.len() >= MESSAGE || !has_more) {
            self.given = 1;
            octets.to_vec()
        } else {
            return None;
        };
        let octets = Cow::Owned(octets);
        Some(Advertisement { transport: Transport::Bluetooth, transmitter: self.address, counter, octets })
    }
}
