//! Remote ID on the way in: what a datagram holds of it, and whose a position is.
//!
//! A datagram is one message or message pack as a drone broadcasts it, or a gateway's lines, each a JSON object:
//! `{"time": …, "transmitter": "…", "rssi": …, "receiver": "…", "message": "hexadecimal"}`. Who a drone is comes in another
//! message than where it is, and is known by its transmitter's address.

use std::net::SocketAddr;

use jiff::SignedDuration;
use remote_id::{Location, Message, messages};
use serde::{Deserialize, Serialize};

use super::generations::Generations;
use crate::gateways::remote_id::{Line, Refusal as LineRefusal, is_broadcast, is_lines, lines};
use crate::normalise::{Refusal, identity, operator};
use fusion::Identity;
use fusion::declaration::Declaration;
use fusion::time::Time;

/// An identity stands for the positions of its transmitter so long.
const BOUND: SignedDuration = SignedDuration::from_secs(5);
/// Validity of what a transmitter declares of its aircraft and operator, after the last such message.
const DECLARED: SignedDuration = SignedDuration::from_secs(60);
/// A position without a time that is the one before is heard again within this time, and after it a new one: the drone hovers.
const AGAIN: SignedDuration = SignedDuration::from_millis(500);
/// Positions of a transmitter that are remembered, to know them again.
const REMEMBERED: usize = 4;

/// Why a gateway's line, or a message, is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineFault {
    /// What is wrong with the line.
    #[error(transparent)]
    Line(#[from] LineRefusal),
    /// What is wrong with the message.
    #[error(transparent)]
    Message(remote_id::Fault),
}

impl LineFault {
    /// A short name that stays the same over releases, for counters.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Line(refusal) => refusal.name(),
            Self::Message(_) => "remote_id_message",
        }
    }
}

/// What a datagram holds of Remote ID; `None`: it holds something else.
pub(super) fn heard(payload: &[u8], from: Option<SocketAddr>) -> Option<Vec<Result<Line, LineFault>>> {
    if is_broadcast(payload) {
        let transmitter = from.map_or_else(|| "unknown".to_owned(), |from| from.to_string());
        let octets = payload.to_vec();
        return Some(vec![Ok(Line { time: None, transmitter, rssi_dbm: None, receiver: None, octets })]);
    }
    is_lines(payload).then(|| lines(payload).map(|line| Ok(Line::parse(line)?)).collect())
}

/// What a broadcast says.
#[derive(Debug, PartialEq)]
pub(super) enum Said {
    /// Where a drone is, who it is, and what other messages declare of it.
    Position(Identity, Location, Declaration),
    /// Who it is, or who and where its operator is.
    Identity,
    /// Nothing that is used, and why.
    Unused(Refusal),
    /// A message cannot be read.
    Faulty(LineFault),
}

/// What is known of a transmitter.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Transmitter {
    /// Who it is, and when it said so.
    identity: Option<(Identity, Time)>,
    /// The declarations of its messages other than positions, and the time of the last one.
    declared: Option<(Declaration, Time)>,
    /// Its last positions, the newest first: frames overtake one another.
    #[serde(with = "as_octets")]
    locations: [Option<Location>; REMEMBERED],
    /// Reception of the newest of them.
    located: Time,
}

/// The transmitters heard lately.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Transmitters(Generations<String, Transmitter>);

impl Transmitters {
    /// Takes in a broadcast, message by message. Who a pack says it is holds for the whole pack.
    pub(super) fn hear(&mut self, heard: &Line, now: Time) -> Vec<Said> {
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
            Ok(Message::BasicId(id)) if identity(&id).is_some() => Said::Identity,
            Ok(Message::BasicId(_)) => Said::Unused(Refusal::NoIdentity),
            Ok(Message::Location(location)) => known.locate(location, now),
            Ok(Message::System(_) | Message::OperatorId(_)) => Said::Identity,
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
            // Another aircraft's operator is another one.
            if self.identity.is_some_and(|(known, _)| known.space() == said.space() && known != said) {
                self.declared = None;
            }
            self.identity = Some((said, now));
        }
    }

    /// Takes in a message that declares something.
    fn declare(&mut self, now: Time, change: impl FnOnce(&mut Declaration)) {
        let mut declared = self.declaration(now);
        change(&mut declared);
        self.declared = Some((declared, now));
    }

    /// The declaration, while it is valid.
    fn declaration(&self, now: Time) -> Declaration {
        let standing = self.declared.filter(|(_, since)| (now - *since).abs() <= DECLARED);
        standing.map(|(declared, _)| declared).unwrap_or_default()
    }

    fn locate(&mut self, location: Location, now: Time) -> Said {
        // French beacons, and others, do not say when the drone was there.
        let hovers = location.seconds_of_hour().is_none()
            && self.locations[0] == Some(location)
            && (now - self.located).abs() > AGAIN;
        if self.locations.contains(&Some(location)) && !hovers {
            return Said::Unused(Refusal::Repeated);
        }
        match self.identity.filter(|(_, since)| (now - *since).abs() <= BOUND) {
            Some((identity, _)) => {
                if !hovers {
                    self.locations.rotate_right(1);
                    self.locations[0] = Some(location);
                }
                self.located = now;
                Said::Position(identity, location, self.declaration(now))
            }
            None => Said::Unused(Refusal::NoIdentity),
        }
    }
}

/// Positions in a checkpoint: as they were sent.
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
