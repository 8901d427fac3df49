//! Messages of the log: what sensors sent, and what a cell makes of it.

use std::net::{IpAddr, Ipv6Addr, SocketAddr};

use asterix::DataSource;
use fusion::slots::Slot;
use fusion::time::Time;
use sha2::{Digest, Sha256};

use super::cells::Audience;
use super::region::Letter;
use super::relief::Step;
use crate::territory::CellName;

/// What the body of an input begins with.
const INPUT: &[u8; 4] = b"UTM1";
/// And that of an output.
const OUTPUT: &[u8; 4] = b"UTO2";
/// Octets of an address with its port: IPv6, or IPv4 mapped into it.
const ADDRESS: usize = 18;

/// Why octets are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Malformed {
    /// They begin as no message of this version does.
    #[error("not a message of this version")]
    Beginning,
    /// They end too early.
    #[error("the message is not whole")]
    Short,
}

/// A datagram as a gateway heard it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heard {
    /// When, by the gateway's socket.
    pub received: Time,
    /// Who sent it.
    pub from: SocketAddr,
    /// Where it was sent to.
    pub to: SocketAddr,
    /// Its octets, at most 65,535.
    pub payload: Vec<u8>,
}

/// What a gateway heard of a sensor within a slot; nothing of it is a sign of life, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// The sensor.
    pub sensor: DataSource,
    /// The slot in which it was received.
    pub slot: Slot,
    /// Of a slot with much the messages are numbered from 0.
    pub part: u16,
    /// Whether it is the last of its slot: nothing more of this slot comes from this gateway.
    pub is_last: bool,
    /// In the order in which they were heard.
    pub heard: Vec<Heard>,
}

impl Input {
    /// The body: `UTM1`, SAC, SIC, slot (8 octets, big endian as all that follows), part (2), whether it is the last (1); then of
    /// each datagram the time of reception (8, nanoseconds since 1970), sender and destination (16 + 2 each), length (2), octets.
    pub fn body(&self) -> Vec<u8> {
        let Self { sensor, slot, part, is_last, heard } = self;
        let mut body = INPUT.to_vec();
        body.extend([sensor.sac, sensor.sic]);
        body.extend(slot.0.to_be_bytes());
        body.extend(part.to_be_bytes());
        body.push((*is_last).into());
        for Heard { received, from, to, payload } in heard {
            let payload = &payload[..payload.len().min(u16::MAX.into())];
            body.extend(received.nanos().to_be_bytes());
            body.extend(address(from));
            body.extend(address(to));
            body.extend((payload.len() as u16).to_be_bytes());
            body.extend(payload);
        }
        body
    }

    /// Reads a body.
    ///
    /// # Errors
    /// It is none, or cut.
    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let mut rest = Reader(body.strip_prefix(INPUT).ok_or(Malformed::Beginning)?);
        let [sac, sic] = rest.take()?;
        let slot = Slot(i64::from_be_bytes(rest.take()?));
        let part = u16::from_be_bytes(rest.take()?);
        let [is_last] = rest.take()?;
        let mut heard = Vec::new();
        while !rest.0.is_empty() {
            let received = Time::from_nanos(i64::from_be_bytes(rest.take()?));
            let (from, to) = (rest.address()?, rest.address()?);
            let length = u16::from_be_bytes(rest.take()?);
            heard.push(Heard { received, from, to, payload: rest.octets(length.into())?.to_vec() });
        }
        Ok(Self { sensor: DataSource { sac, sic }, slot, part, is_last: is_last != 0, heard })
    }

    /// What the log knows copies by: two gateways that heard the same within a slot say the same.
    pub fn id(&self) -> String {
        let Self { sensor, slot, part, heard, .. } = self;
        let mut hash = Sha256::new();
        heard.iter().for_each(|heard| hash.update(&heard.payload));
        let hash = crate::hex::text(&hash.finalize()[..16]);
        format!("{}.{}.{}.{part}.{hash}", sensor.sac, sensor.sic, slot.0)
    }
}

/// What a cell handles, in the order of the log.
#[derive(Clone, Debug, PartialEq)]
pub enum Logged {
    /// What a gateway heard.
    Input(Input),
    /// What another cell, or an operator, writes to it.
    Letter(Box<Letter>),
}

impl Logged {
    /// Reads a body that is for a cell with this audience. `None`: it is for other cells.
    ///
    /// # Errors
    /// It is none of this version, or cut.
    pub fn parse(body: &[u8], cell: &CellName, audience: &Audience) -> Result<Option<Self>, Malformed> {
        let Some(rest) = body.strip_prefix(INPUT) else {
            let letter = Letter::parse(body)?;
            return Ok((letter.to == *cell).then(|| Self::Letter(letter.into())));
        };
        // Of most cells most lines are not: their datagrams are not even looked at.
        let [sac, sic] = Reader(rest).take()?;
        if !audience.hears(DataSource { sac, sic }) {
            return Ok(None);
        }
        Input::parse(body).map(|input| Some(Self::Input(input)))
    }

    /// What the log knows copies by.
    pub fn id(&self) -> String {
        match self {
            Self::Input(input) => input.id(),
            Self::Letter(letter) => letter.id(),
        }
    }
}

/// A slot of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Which.
    pub slot: Slot,
    /// Whose: the number of the lease under which it was made.
    pub epoch: u64,
    /// It was made behind this message of the input.
    pub behind: u64,
    /// What is left out from here on, because the owner cannot keep up ([`Step`]).
    pub step: Step,
    /// The picture.
    pub picture: Vec<u8>,
}

impl Output {
    /// The body: `UTO2`, slot, epoch, the input's sequence (8 octets each, big endian), step (1), the picture.
    pub fn body(&self) -> Vec<u8> {
        let mut body = OUTPUT.to_vec();
        body.extend(self.slot.0.to_be_bytes());
        body.extend(self.epoch.to_be_bytes());
        body.extend(self.behind.to_be_bytes());
        body.push(self.step.0);
        body.extend(&self.picture);
        body
    }

    /// Reads a body.
    ///
    /// # Errors
    /// It is none, or cut.
    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let mut rest = Reader(body.strip_prefix(OUTPUT).ok_or(Malformed::Beginning)?);
        let slot = Slot(i64::from_be_bytes(rest.take()?));
        let epoch = u64::from_be_bytes(rest.take()?);
        let behind = u64::from_be_bytes(rest.take()?);
        let [step] = rest.take()?;
        Ok(Self { slot, epoch, behind, step: Step(step), picture: rest.0.to_vec() })
    }
}

fn address(address: &SocketAddr) -> [u8; ADDRESS] {
    let ip = match address.ip() {
        IpAddr::V4(ip) => ip.to_ipv6_mapped(),
        IpAddr::V6(ip) => ip,
    };
    let mut octets = [0; ADDRESS];
    octets[..16].copy_from_slice(&ip.octets());
    octets[16..].copy_from_slice(&address.port().to_be_bytes());
    octets
}

/// What is left of a body.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (taken, rest) = self.0.split_first_chunk().ok_or(Malformed::Short)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn octets(&mut self, length: usize) -> Result<&'a [u8], Malformed> {
        let (taken, rest) = self.0.split_at_checked(length).ok_or(Malformed::Short)?;
        self.0 = rest;
        Ok(taken)
    }

    fn address(&mut self) -> Result<SocketAddr, Malformed> {
        let ip = Ipv6Addr::from(self.take::<16>()?);
        let port = u16::from_be_bytes(self.take()?);
        Ok(SocketAddr::new(ip.to_canonical(), port))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_address() -> impl Strategy<Value = SocketAddr> {
        prop_oneof![
            any::<([u8; 4], u16)>().prop_map(|(ip, port)| SocketAddr::from((ip, port))),
            any::<([u8; 16], u16)>()
                .prop_map(|(ip, port)| { SocketAddr::new(Ipv6Addr::from(ip).to_canonical(), port) }),
        ]
    }

    fn any_heard() -> impl Strategy<Value = Heard> {
        let octets = prop::collection::vec(any::<u8>(), 0..300);
        (any::<i64>(), any_address(), any_address(), octets).prop_map(|(received, from, to, payload)| Heard {
            received: Time::from_nanos(received),
            from,
            to,
            payload,
        })
    }

    proptest! {
        #[test]
        fn an_input_comes_back(
            (sac, sic, slot, part, is_last) in any::<(u8, u8, i64, u16, bool)>(),
            heard in prop::collection::vec(any_heard(), 0..6),
        ) {
            let input = Input { sensor: DataSource { sac, sic }, slot: Slot(slot), part, is_last, heard };
            let body = input.body();
            prop_assert_eq!(Input::parse(&body), Ok(input.clone()));
            // Cut anywhere it is a shorter message, or none.
            for cut in 0..body.len() {
                if let Ok(shorter) = Input::parse(&body[..cut]) {
                    prop_assert!(shorter.heard.len() < input.heard.len());
                }
            }
        }

        #[test]
        fn an_output_comes_back(
            (slot, epoch, behind, step) in any::<(i64, u64, u64, u8)>(),
            picture in prop::collection::vec(any::<u8>(), 0..100),
        ) {
            let output = Output { slot: Slot(slot), epoch, behind, step: Step(step), picture };
            prop_assert_eq!(Output::parse(&output.body()), Ok(output));
        }

        #[test]
        fn octets_are_a_message_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = (Input::parse(&octets), Output::parse(&octets));
            let _ = (Input::parse(&[INPUT, &octets[..]].concat()), Output::parse(&[OUTPUT, &octets[..]].concat()));
        }
    }

    /// Their stamps differ, and where they come from: what counts are the octets, in order.
    #[test]
    fn two_gateways_that_heard_the_same_say_the_same() {
        let heard = |received, payload: &[u8]| Heard {
            received: Time::from_nanos(received),
            from: "127.0.0.1:5000".parse().unwrap(),
            to: "239.1.1.1:8048".parse().unwrap(),
            payload: payload.to_vec(),
        };
        let input = |heard| Input {
            sensor: DataSource { sac: 25, sic: 200 },
            slot: Slot(7),
            part: 0,
            is_last: true,
            heard,
        };
        let one = input(vec![heard(1, b"a"), heard(2, b"b")]);
        let other = input(vec![heard(3, b"a"), heard(4, b"b")]);
        let swapped = input(vec![heard(3, b"b"), heard(4, b"a")]);
        assert_eq!(one.id(), other.id());
        assert_ne!(one.id(), swapped.id());
        assert!(one.id().starts_with("25.200.7.0."), "{}", one.id());
    }
}
