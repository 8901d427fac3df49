//! Remote ID on the way in: what a datagram holds of it, and whose a position is.
//!
//! A datagram is one message or message pack as a drone broadcasts it, or a gateway's lines, each a JSON object:
//! `{"time": …, "transmitter": "…", "rssi": …, "receiver": "…", "message": "hexadecimal"}`. Who a drone is comes in another
//! message than where it is, and is known by its transmitter's address.

use std::net::SocketAddr;

use jiff::{SignedDuration, Timestamp};
use remote_id::{LENGTH, Location, Message, messages};
use serde::Deserialize;

use super::generations::Generations;
use crate::normalise::{Refusal, identity};
use fusion::Identity;
use fusion::time::{SECOND, Time};

/// An identity stands for the positions of its transmitter so long.
const BOUND: SignedDuration = SignedDuration::from_secs(5);
/// Positions of a transmitter that are remembered, to know them again.
const REMEMBERED: usize = 4;
/// Longest name of a transmitter or a receiver, octets.
const NAME_MAX: usize = 64;

/// Why a gateway's line, or a message, is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineFault {
    /// It is no JSON object with the members that it must have.
    #[error("the line is no JSON object with a transmitter and a message")]
    NotAnObject,
    /// The message is no octets in hexadecimal.
    #[error("the message of the line is not hexadecimal")]
    NotHexadecimal,
    /// The transmitter or the receiver has a name of more than 64 octets, or none.
    #[error("a name in the line is empty or longer than 64 octets")]
    Name,
    /// The time is none.
    #[error("the time of the line is neither RFC 3339 nor seconds since 1970")]
    Time,
    /// What is wrong with the message.
    #[error(transparent)]
    Message(remote_id::Fault),
}

impl LineFault {
    /// A short name that stays the same over releases, for counters.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotAnObject => "line_not_an_object",
            Self::NotHexadecimal => "line_not_hexadecimal",
            Self::Name => "line_name",
            Self::Time => "line_time",
            Self::Message(_) => "remote_id_message",
        }
    }
}

/// A broadcast that a receiver heard.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Heard {
    transmitter: String,
    /// The id of its sensor, where the gateway says it.
    pub(super) receiver: Option<String>,
    /// When the gateway heard it, where it says that.
    pub(super) stamped: Option<Time>,
    /// The message or the pack.
    octets: Vec<u8>,
}

/// A gateway's line; what else it may hold is nobody's business.
#[derive(Deserialize)]
struct Line<'a> {
    time: Option<Stamp<'a>>,
    #[serde(borrow)]
    transmitter: std::borrow::Cow<'a, str>,
    receiver: Option<String>,
    #[serde(borrow)]
    message: std::borrow::Cow<'a, str>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Stamp<'a> {
    Seconds(f64),
    #[serde(borrow)]
    Text(std::borrow::Cow<'a, str>),
}

/// Whether a datagram holds a gateway's lines: no category of ASTERIX begins so.
pub fn is_lines(payload: &[u8]) -> bool {
    payload.trim_ascii_start().first() == Some(&b'{')
}

/// Whether a datagram is a message or a pack as a drone broadcasts it, and not a block of ASTERIX of as many octets.
pub fn is_broadcast(payload: &[u8]) -> bool {
    let is_block = payload.get(1..3).is_some_and(|length| length == (payload.len() as u16).to_be_bytes());
    let is_whole = match *payload {
        [0xf0..=0xf2, length, count, ..] => {
            usize::from(length) == LENGTH && payload.len() == 3 + LENGTH * usize::from(count)
        }
        [first, ..] => payload.len() == LENGTH && first >> 4 <= 5 && first & 0xf <= 2,
        [] => false,
    };
    is_whole && !is_block
}

/// What a datagram holds of Remote ID; `None`: it holds something else.
pub(super) fn heard(payload: &[u8], from: Option<SocketAddr>) -> Option<Vec<Result<Heard, LineFault>>> {
    if is_broadcast(payload) {
        let transmitter = from.map_or_else(|| "unknown".to_owned(), |from| from.to_string());
        return Some(vec![Ok(Heard {
            transmitter,
            receiver: None,
            stamped: None,
            octets: payload.to_vec(),
        })]);
    }
    let lines = payload.split(|&octet| octet == b'\n').map(<[u8]>::trim_ascii);
    is_lines(payload).then(|| lines.filter(|line| !line.is_empty()).map(read).collect())
}

fn read(line: &[u8]) -> Result<Heard, LineFault> {
    let Line { time, transmitter, receiver, message } =
        serde_json::from_slice(line).map_err(|_| LineFault::NotAnObject)?;
    let is_name = |name: &str| (1..=NAME_MAX).contains(&name.len());
    if !is_name(&transmitter) || !receiver.as_deref().is_none_or(is_name) {
        return Err(LineFault::Name);
    }
    let stamped = match time {
        None => None,
        Some(Stamp::Seconds(seconds)) => {
            // Beyond that no time has nanoseconds.
            if seconds.is_nan() || seconds.abs() > 9e9 {
                return Err(LineFault::Time);
            }
            let (whole, rest) = (seconds.trunc() as i64, seconds.fract());
            Some(Time::from_nanos(whole * SECOND + (rest * SECOND as f64).round() as i64))
        }
        Some(Stamp::Text(text)) => {
            let time: Timestamp = text.parse().map_err(|_| LineFault::Time)?;
            Some(Time::from_nanos(i64::try_from(time.as_nanosecond()).map_err(|_| LineFault::Time)?))
        }
    };
    let octets = crate::hex::octets(&message).ok_or(LineFault::NotHexadecimal)?;
    Ok(Heard { transmitter: transmitter.into_owned(), receiver, stamped, octets })
}

/// What a broadcast says.
#[derive(Debug, PartialEq)]
pub(super) enum Said {
    /// Where a drone is, and who it is.
    Position(Identity, Location),
    /// Who it is.
    Identity,
    /// Nothing that is used, and why.
    Unused(Refusal),
    /// A message cannot be read.
    Faulty(LineFault),
}

/// What is known of a transmitter.
#[derive(Debug, Default)]
struct Transmitter {
    /// Who it is, and when it said so.
    identity: Option<(Identity, Time)>,
    /// Its last positions, the newest first: frames overtake one another.
    locations: [Option<Location>; REMEMBERED],
}

/// The transmitters heard lately.
#[derive(Debug, Default)]
pub(super) struct Transmitters(Generations<String, Transmitter>);

impl Transmitters {
    /// Takes in a broadcast, message by message. Who a pack says it is holds for the whole pack.
    pub(super) fn hear(&mut self, heard: &Heard, now: Time) -> Vec<Said> {
        let all: Vec<_> = messages(&heard.octets).collect();
        let known = self.0.of(heard.transmitter.clone(), now, Transmitter::default);
        let mut nobody = Transmitter::default();
        let known = known.unwrap_or(&mut nobody);
        for message in &all {
            if let Ok(Message::BasicId(id)) = message {
                known.note(identity(id), now);
            }
        }
        let said = |message: Result<Message, _>| match message {
            Ok(Message::BasicId(id)) if identity(&id).is_some() => Said::Identity,
            Ok(Message::BasicId(_)) => Said::Unused(Refusal::NoIdentity),
            Ok(Message::Location(location)) => known.locate(location, now),
            Ok(_) => Said::Unused(Refusal::NotUsed),
            Err(fault) => Said::Faulty(LineFault::Message(fault)),
        };
        all.into_iter().map(said).collect()
    }
}

impl Transmitter {
    /// Who it says it is. Of several identities of one drone a serial number counts, then a registration, then what holds for
    /// a flight or a session.
    fn note(&mut self, said: Option<Identity>, now: Time) {
        let Some(said) = said else { return };
        let counts = self
            .identity
            .is_none_or(|(known, since)| said.space() <= known.space() || (now - since).abs() > BOUND);
        if counts {
            self.identity = Some((said, now));
        }
    }

    fn locate(&mut self, location: Location, now: Time) -> Said {
        if self.locations.contains(&Some(location)) {
            return Said::Unused(Refusal::Repeated);
        }
        match self.identity.filter(|(_, since)| (now - *since).abs() <= BOUND) {
            Some((identity, _)) => {
                self.locations.rotate_right(1);
                self.locations[0] = Some(location);
                Said::Position(identity, location)
            }
            None => Said::Unused(Refusal::NoIdentity),
        }
    }
}

#[cfg(test)]
mod tests;
