//! Remote ID in the pipeline: decodes its datagrams, and assigns positions to identities.
//!
//! A datagram is a message or message pack as broadcast by a drone, or the lines of a gateway, each a JSON object:
//! `{"time": …, "transmitter": "…", "rssi": …, "receiver": "…", "message": "hexadecimal"}`. A drone sends its identity and its
//! position in different messages, which the address of the transmitter joins.

use std::net::SocketAddr;

use jiff::SignedDuration;
use remote_id::{Location, Message, messages};
use serde::{Deserialize, Serialize};

use super::generations::Generations;
use crate::gateways::remote_id::{BroadcastLine, LineRefusal, is_broadcast, is_lines, lines};
use crate::normalise::{Refusal, identity, operator};
use fusion::Identity;
use fusion::declaration::Declaration;
use fusion::time::Time;

/// Time for which an identity applies to the positions of its transmitter.
const BOUND: SignedDuration = SignedDuration::from_secs(5);
/// Time for which the declaration of an aircraft and operator is valid after the last message with one.
const DECLARED: SignedDuration = SignedDuration::from_secs(60);
/// A position without a time that equals the previous one is a repetition within this time. Later the drone is hovering.
const AGAIN: SignedDuration = SignedDuration::from_millis(500);
/// Number of a transmitter's positions that are remembered to recognise repetitions.
const REMEMBERED: usize = 4;

/// Error in a gateway's line or in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineFault {
    /// Error in the line.
    #[error(transparent)]
    Line(#[from] LineRefusal),
    /// Error in the message.
    #[error(transparent)]
    Message(remote_id::Fault),
}

impl LineFault {
    /// Short name for counters, stable across releases.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Line(refusal) => refusal.name(),
            Self::Message(_) => "remote_id_message",
        }
    }
}

/// The Remote ID lines of a datagram; `None`: the datagram is not Remote ID.
pub(super) fn heard(
    payload: &[u8],
    from: Option<SocketAddr>,
) -> Option<Vec<Result<BroadcastLine, LineFault>>> {
    if is_broadcast(payload) {
        let transmitter = from.map_or_else(|| "unknown".to_owned(), |from| from.to_string());
        let octets = payload.to_vec();
        return Some(vec![Ok(BroadcastLine {
            time: None,
            transmitter,
            rssi_dbm: None,
            receiver: None,
            octets,
        })]);
    }
    is_lines(payload).then(|| lines(payload).map(|line| Ok(BroadcastLine::parse(line)?)).collect())
}

/// Content of a message of a broadcast.
#[derive(Debug, PartialEq)]
pub(super) enum RemoteIdOutcome {
    /// Position and identity of a drone, and the declaration from other messages.
    Position(Identity, Location, Declaration),
    /// Identity of the drone, or identity and position of its operator.
    Identity,
    /// A message that is not used, with the reason.
    Unused(Refusal),
    /// A message that cannot be read.
    Faulty(LineFault),
}

/// State of a transmitter.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Transmitter {
    /// Identity, and the time at which it was sent.
    identity: Option<(Identity, Time)>,
    /// Declaration from messages other than positions, and the time of the last one.
    declared: Option<(Declaration, Time)>,
    /// Latest positions, newest first: frames may overtake one another.
    #[serde(with = "as_octets")]
    locations: [Option<Location>; REMEMBERED],
    /// Time of reception of the newest position.
    located: Time,
}

/// Transmitters received recently.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Transmitters(Generations<String, Transmitter>);

impl Transmitters {
    /// Processes the messages of a broadcast. An identity in a message pack applies to the whole pack.
    pub(super) fn hear(&mut self, heard: &BroadcastLine, now: Time) -> Vec<RemoteIdOutcome> {
        let all: Vec<_> = messages(&heard.octets).collect();
        let known = self.0.of(heard.transmitter.clone(), now, Transmitter::default);
        let mut nobody = Transmitter::default();
        let known = known.unwrap_or(&mut nobody);
        for message in &all {
            match message {
                Ok(Message::BasicId(id)) => {
                    known.note(identity(id), now);
                    known.declare(now, |declared| declared.ua_type = Some(id.ua_type_number()));
                }
                Ok(Message::System(system)) => {
                    known.declare(now, |declared| declared.operator = operator(system));
                }
                Ok(Message::OperatorId(operator)) => known.declare(now, |declared| {
                    declared.operator_id = [0; 20];
                    declared.operator_id.iter_mut().zip(operator.id()).for_each(|(to, of)| *to = *of);
                }),
                _ => {}
            }
        }
        let said = |message: Result<Message, _>| match message {
            Ok(Message::BasicId(id)) if identity(&id).is_some() => RemoteIdOutcome::Identity,
            Ok(Message::BasicId(_)) => RemoteIdOutcome::Unused(Refusal::NoIdentity),
            Ok(Message::Location(location)) => known.locate(location, now),
            Ok(Message::System(_) | Message::OperatorId(_)) => RemoteIdOutcome::Identity,
            Ok(_) => RemoteIdOutcome::Unused(Refusal::NotUsed),
            Err(fault) => RemoteIdOutcome::Faulty(LineFault::Message(fault)),
        };
        all.into_iter().map(said).collect()
    }
}

impl Transmitter {
    /// Updates the identity. If a drone sends several, a serial number has priority over a registration, and a registration over
    /// an identity of one flight or session.
    fn note(&mut self, said: Option<Identity>, now: Time) {
        let Some(said) = said else { return };
        let counts = self
            .identity
            .is_none_or(|(known, since)| said.space() <= known.space() || (now - since).abs() > BOUND);
        if counts {
            // A different aircraft has a different operator.
            if self.identity.is_some_and(|(known, _)| known.space() == said.space() && known != said) {
                self.declared = None;
            }
            self.identity = Some((said, now));
        }
    }

    /// Updates the declaration with a message.
    fn declare(&mut self, now: Time, change: impl FnOnce(&mut Declaration)) {
        let mut declared = self.declaration(now);
        change(&mut declared);
        self.declared = Some((declared, now));
    }

    /// The declaration, if it is still valid.
    fn declaration(&self, now: Time) -> Declaration {
        let standing = self.declared.filter(|(_, since)| (now - *since).abs() <= DECLARED);
        standing.map(|(declared, _)| declared).unwrap_or_default()
    }

    fn locate(&mut self, location: Location, now: Time) -> RemoteIdOutcome {
        // Some beacons, the French ones among them, send no time with a position.
        let hovers = location.seconds_of_hour().is_none()
            && self.locations[0] == Some(location)
            && (now - self.located).abs() > AGAIN;
        if self.locations.contains(&Some(location)) && !hovers {
            return RemoteIdOutcome::Unused(Refusal::Repeated);
        }
        match self.identity.filter(|(_, since)| (now - *since).abs() <= BOUND) {
            Some((identity, _)) => {
                if !hovers {
                    self.locations.rotate_right(1);
                    self.locations[0] = Some(location);
                }
                self.located = now;
                RemoteIdOutcome::Position(identity, location, self.declaration(now))
            }
            None => RemoteIdOutcome::Unused(Refusal::NoIdentity),
        }
    }
}

/// Encodes positions in a checkpoint as they were received.
mod as_octets {
    use remote_id::{LENGTH, Location, Message};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::REMEMBERED;

    type Sent = [Option<[u8; LENGTH]>; REMEMBERED];

    pub(super) fn serialize<S: Serializer>(
        locations: &[Option<Location>; REMEMBERED],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        locations.map(|location| location.map(|sent| *Message::Location(sent).octets())).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<[Option<Location>; REMEMBERED], D::Error> {
        let mut locations = [None; REMEMBERED];
        for (location, sent) in locations.iter_mut().zip(Sent::deserialize(deserializer)?) {
            *location = match sent.map(Message::new) {
                None => None,
                Some(Ok(Message::Location(location))) => Some(location),
                Some(_) => return Err(D::Error::custom("no position")),
            };
        }
        Ok(locations)
    }
}

#[cfg(test)]
mod tests;
