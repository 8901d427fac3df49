//! Messages and packs of them.

use super::octets::{LENGTH, trimmed};
use super::{BasicId, Fault, Location, System};

/// Maximum number of messages in a pack that is read (F3411-19: 10, F3411-22: 9). Packs that are written have at most nine.
pub const PACK_MOST: u8 = 10;
const PACK_MADE: u8 = 9;
/// Number of published protocol versions: F3411-19 (0), F3411-22 (1, 2).
const VERSIONS: u8 = 3;

/// A message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// Identity of the aircraft.
    BasicId(BasicId),
    /// Position and motion of the aircraft.
    Location(Location),
    /// Authentication data, undecoded: one page of several.
    Authentication([u8; LENGTH]),
    /// Purpose of the flight.
    SelfId(SelfId),
    /// Position of the operator.
    System(System),
    /// Registration of the operator.
    OperatorId(OperatorId),
}

impl Message {
    /// Decodes a message.
    ///
    /// # Errors
    /// The version or the type does not exist.
    pub fn new(octets: [u8; LENGTH]) -> Result<Self, Fault> {
        let (kind, version) = (octets[0] >> 4, octets[0] & 0xf);
        if version >= VERSIONS {
            return Err(Fault::Version { version });
        }
        match kind {
            0 => Ok(Self::BasicId(BasicId(octets))),
            1 => Ok(Self::Location(Location(octets))),
            2 => Ok(Self::Authentication(octets)),
            3 => Ok(Self::SelfId(SelfId(octets))),
            4 => Ok(Self::System(System(octets))),
            5 => Ok(Self::OperatorId(OperatorId(octets))),
            PACK => Err(Fault::NestedPack),
            _ => Err(Fault::Kind { kind }),
        }
    }

    /// The octets of the message.
    pub fn octets(&self) -> &[u8; LENGTH] {
        match self {
            Self::BasicId(BasicId(octets))
            | Self::Location(Location(octets))
            | Self::Authentication(octets)
            | Self::SelfId(SelfId(octets))
            | Self::System(System(octets))
            | Self::OperatorId(OperatorId(octets)) => octets,
        }
    }

    /// Protocol version: 0 (F3411-19), 1 or 2 (F3411-22).
    pub fn version(&self) -> u8 {
        self.octets()[0] & 0xf
    }
}

/// Purpose of the flight, in the operator's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelfId(pub(crate) [u8; LENGTH]);

impl SelfId {
    /// The text without its padding; octets may have any value.
    pub fn words(&self) -> &[u8] {
        trimmed(&self.0[2..])
    }
}

/// Identity of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OperatorId(pub(crate) [u8; LENGTH]);

impl OperatorId {
    /// The operator's registration without its padding; octets may have any value. This is personal data.
    pub fn id(&self) -> &[u8] {
        trimmed(&self.0[2..22])
    }
}

/// Message type of a pack.
const PACK: u8 = 0xf;
/// Length of the header of a pack, in octets.
const PACK_HEADER: usize = 3;

/// The messages of an advertisement, whose octets after the counter are a message or a pack. A faulty message does not affect
/// those after it; a fault of the pack is the last item.
pub fn messages(octets: &[u8]) -> Messages<'_> {
    match *octets {
        [first, length, count, ref rest @ ..] if first >> 4 == PACK => {
            let version = first & 0xf;
            let fault = if version >= VERSIONS {
                Some(Fault::Version { version })
            } else if usize::from(length) != LENGTH {
                Some(Fault::PackLength { length })
            } else if count == 0 || count > PACK_MOST {
                Some(Fault::PackCount { count })
            } else {
                None
            };
            match fault {
                Some(fault) => Messages { rest: &[], count: 0, done: 0, fault: Some(fault) },
                None => Messages { rest, count, done: 0, fault: None },
            }
        }
        _ => Messages { rest: octets, count: 1, done: 0, fault: None },
    }
}

/// Whether the octets begin with the header of a pack.
pub(crate) fn is_pack_header(octets: &[u8]) -> bool {
    let [first, length, count, ..] = *octets else { return false };
    first >> 4 == PACK && usize::from(length) == LENGTH && (1..=PACK_MOST).contains(&count)
}

/// Number of octets missing from a pack; `None`: the pack is complete, or this is no pack.
pub(crate) fn missing(octets: &[u8]) -> Option<usize> {
    let whole = PACK_HEADER + LENGTH * usize::from(*octets.get(2)?);
    let missing = whole.checked_sub(octets.len()).filter(|missing| *missing > 0);
    missing.filter(|_| is_pack_header(octets))
}

/// A pack of these messages; `None` if there are none or more than nine.
pub fn pack(messages: &[Message]) -> Option<Vec<u8>> {
    let count = u8::try_from(messages.len()).ok().filter(|count| (1..=PACK_MADE).contains(count))?;
    let mut octets = vec![PACK << 4 | 2, LENGTH as u8, count];
    messages.iter().for_each(|message| octets.extend(message.octets()));
    Some(octets)
}

/// The messages of a pack, or a single message.
#[derive(Clone, Debug)]
pub struct Messages<'a> {
    rest: &'a [u8],
    count: u8,
    done: u8,
    /// Fault of the pack.
    fault: Option<Fault>,
}

impl Iterator for Messages<'_> {
    type Item = Result<Message, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(fault) = self.fault.take() {
            return Some(Err(fault));
        }
        if self.done == self.count {
            return None;
        }
        let Some((octets, rest)) = self.rest.split_first_chunk::<LENGTH>() else {
            let (count, ends_in) = (self.count, self.done + 1);
            self.done = count;
            let there = self.rest.len();
            return Some(Err(if count == 1 {
                Fault::Short { there }
            } else {
                Fault::PackCut { count, ends_in }
            }));
        };
        (self.rest, self.done) = (rest, self.done + 1);
        Some(Message::new(*octets))
    }
}
