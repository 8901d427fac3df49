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

/// Beginnings of the body of an input: without the name of its gateway, as the version before wrote it, and with it.
const INPUT: &[u8; 4] = b"UTM1";
const INPUT_OF: &[u8; 4] = b"UTM2";
/// The same of an output: one that used all inputs, as the version before wrote it, and one that lists those refused.
const OUTPUT: &[u8; 4] = b"UTO2";
const OUTPUT_REFUSING: &[u8; 4] = b"UTO3";
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

/// The gateway that sent a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Its name, at most 255 octets.
    pub gateway: String,
    /// When it handed this message on, by its own clock; another time for each try.
    pub sent: Time,
    /// Hash of the configuration that all members share; 0: not stated.
    pub config: u64,
}

/// The header of an input, before its datagrams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// `None`: a gateway of the version before sent it.
    pub origin: Option<Origin>,
    /// The sensor.
    pub sensor: DataSource,
    /// The slot in which it was received.
    pub slot: Slot,
    /// Of a slot with much the messages are numbered from 0.
    pub part: u16,
    /// Whether it is the last of its slot.
    pub is_last: bool,
}

impl Header {
    /// Reads the beginning of a body. `None`: the body is no input.
    ///
    /// # Errors
    /// The body is cut.
    pub fn of(body: &[u8]) -> Result<Option<Self>, Malformed> {
        match Reader::of_input(body) {
            Some((mut rest, is_named)) => Self::read(&mut rest, is_named).map(Some),
            None => Ok(None),
        }
    }

    fn read(rest: &mut Reader, is_named: bool) -> Result<Self, Malformed> {
        let origin = if is_named { Some(Origin::read(rest)?) } else { None };
        let [sac, sic] = rest.take()?;
        let slot = Slot(i64::from_be_bytes(rest.take()?));
        let part = u16::from_be_bytes(rest.take()?);
        let [is_last] = rest.take()?;
        Ok(Self { origin, sensor: DataSource { sac, sic }, slot, part, is_last: is_last != 0 })
    }
}

impl Origin {
    fn read(rest: &mut Reader) -> Result<Self, Malformed> {
        let [length] = rest.take()?;
        let gateway = String::from_utf8_lossy(rest.octets(length.into())?).into_owned();
        let sent = Time::from_nanos(i64::from_be_bytes(rest.take()?));
        Ok(Self { gateway, sent, config: u64::from_be_bytes(rest.take()?) })
    }

    fn write(&self, body: &mut Vec<u8>) {
        let Self { gateway, sent, config } = self;
        let length = u8::try_from(gateway.len()).unwrap_or(u8::MAX);
        body.push(length);
        body.extend(&gateway.as_bytes()[..length.into()]);
        body.extend(sent.nanos().to_be_bytes());
        body.extend(config.to_be_bytes());
    }
}

/// What a gateway heard of a sensor within a slot; nothing of it is a sign of life, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// The gateway that sent it; `None`: not stated, as by the version before.
    pub origin: Option<Origin>,
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
    /// The body: `UTM2`, gateway (length in 1 octet, name), when it was sent (8 octets, nanoseconds since 1970, big endian as all
    /// that follows), hash of the configuration (8), SAC, SIC, slot (8), part (2), whether it is the last (1); then of each datagram
    /// the time of reception (8, nanoseconds since 1970), sender and destination (16 + 2 each), length (2), octets. Without an origin
    /// `UTM1`, and SAC at once.
    pub fn body(&self) -> Vec<u8> {
        let Self { origin, sensor, slot, part, is_last, heard } = self;
        let mut body = if origin.is_some() { INPUT_OF } else { INPUT }.to_vec();
        origin.iter().for_each(|origin| origin.write(&mut body));
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
        let (mut rest, is_named) = Reader::of_input(body).ok_or(Malformed::Beginning)?;
        let Header { origin, sensor, slot, part, is_last } = Header::read(&mut rest, is_named)?;
        let mut heard = Vec::new();
        while !rest.0.is_empty() {
            let received = Time::from_nanos(i64::from_be_bytes(rest.take()?));
            let (from, to) = (rest.address()?, rest.address()?);
            let length = u16::from_be_bytes(rest.take()?);
            heard.push(Heard { received, from, to, payload: rest.octets(length.into())?.to_vec() });
        }
        Ok(Self { origin, sensor, slot, part, is_last, heard })
    }

    /// What the log knows copies by: two gateways that heard the same within a slot say the same. A message without datagrams is
    /// each gateway's own: one of a gateway whose clock is ahead comes first, is refused, and must not hide the other's.
    pub fn id(&self) -> String {
        let Self { origin, sensor, slot, part, heard, .. } = self;
        let mut hash = Sha256::new();
        if heard.is_empty() {
            origin.iter().for_each(|origin| hash.update(&origin.gateway));
        }
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
        let Some(header) = Header::of(body)? else {
            let letter = Letter::parse(body)?;
            return Ok((letter.to == *cell).then(|| Self::Letter(letter.into())));
        };
        // Of most cells most lines are not: their datagrams are not even looked at.
        if !audience.hears(header.sensor) {
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
    /// Sequences of inputs that were not used since the slot before, in order: clocks of their gateways are wrong, or their slots.
    pub refused: Vec<u64>,
    /// What is left out from here on, because the owner cannot keep up ([`Step`]).
    pub step: Step,
    /// The picture.
    pub picture: Vec<u8>,
}

impl Output {
    /// The body: `UTO3`, slot, epoch, the input's sequence (8 octets each, big endian as all that follows), step (1), number of
    /// refused inputs (4), of each how far it is before that input (8), the picture. Where none was refused `UTO2`, and the picture
    /// behind the step.
    pub fn body(&self) -> Vec<u8> {
        let mut body = if self.refused.is_empty() { OUTPUT } else { OUTPUT_REFUSING }.to_vec();
        body.extend(self.slot.0.to_be_bytes());
        body.extend(self.epoch.to_be_bytes());
        body.extend(self.behind.to_be_bytes());
        body.push(self.step.0);
        if !self.refused.is_empty() {
            body.extend((self.refused.len() as u32).to_be_bytes());
            self.refused.iter().for_each(|refused| body.extend((self.behind - refused).to_be_bytes()));
        }
        body.extend(&self.picture);
        body
    }

    /// Reads a body.
    ///
    /// # Errors
    /// It is none, or cut.
    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let (rest, refuses) = match body.strip_prefix(OUTPUT) {
            Some(rest) => (rest, false),
            None => (body.strip_prefix(OUTPUT_REFUSING).ok_or(Malformed::Beginning)?, true),
        };
        let mut rest = Reader(rest);
        let slot = Slot(i64::from_be_bytes(rest.take()?));
        let epoch = u64::from_be_bytes(rest.take()?);
        let behind = u64::from_be_bytes(rest.take()?);
        let [step] = rest.take()?;
        let mut refused = Vec::new();
        if refuses {
            for _ in 0..u32::from_be_bytes(rest.take()?) {
                refused.push(behind.saturating_sub(u64::from_be_bytes(rest.take()?)));
            }
        }
        Ok(Self { slot, epoch, behind, refused, step: Step(step), picture: rest.0.to_vec() })
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
    /// The rest of an input, and whether it names its gateway; `None`: it is no input.
    fn of_input(body: &'a [u8]) -> Option<(Self, bool)> {
        let named = body.strip_prefix(INPUT_OF).map(|rest| (Self(rest), true));
        named.or_else(|| body.strip_prefix(INPUT).map(|rest| (Self(rest), false)))
    }

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

    fn any_origin() -> impl Strategy<Value = Origin> {
        ("[a-z0-9é-]{0,40}", any::<i64>(), any::<u64>()).prop_map(|(gateway, sent, config)| Origin {
            gateway,
            sent: Time::from_nanos(sent),
            config,
        })
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
            origin in prop::option::of(any_origin()),
        ) {
            let input = Input { origin, sensor: DataSource { sac, sic }, slot: Slot(slot), part, is_last, heard };
            let body = input.body();
            prop_assert_eq!(Input::parse(&body), Ok(input.clone()));
            // Cut anywhere it is a shorter message, or none.
            for cut in 0..body.len() {
                if let Ok(shorter) = Input::parse(&body[..cut]) {
                    prop_assert!(shorter.heard.len() < input.heard.len());
                }
            }
            let Input { origin, sensor, slot, part, is_last, .. } = input;
            prop_assert_eq!(Header::of(&body), Ok(Some(Header { origin, sensor, slot, part, is_last })));
        }

        #[test]
        fn an_output_comes_back(
            (slot, epoch, behind, step) in any::<(i64, u64, u64, u8)>(),
            mut refused in prop::collection::vec(any::<u64>(), 0..5),
            picture in prop::collection::vec(any::<u8>(), 0..100),
        ) {
            refused.iter_mut().for_each(|refused| *refused = behind.saturating_sub(*refused));
            let output = Output { slot: Slot(slot), epoch, behind, refused, step: Step(step), picture };
            prop_assert_eq!(Output::parse(&output.body()), Ok(output));
        }

        #[test]
        fn octets_are_a_message_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = (Input::parse(&octets), Output::parse(&octets));
            for begin in [INPUT, INPUT_OF, OUTPUT, OUTPUT_REFUSING] {
                let octets = [begin, &octets[..]].concat();
                let _ = (Input::parse(&octets), Output::parse(&octets), Header::of(&octets));
            }
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
            origin: None,
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
    /// Messages of 0.6.0, without names of gateways and lists of refused inputs.
    #[test]
    fn messages_of_the_version_before_are_read() {
        let input = "55544d3119c8000000000000000700000118b1d5a5c9f4c000\
                     00000000000000000000ffff7f0000011388\
                     00000000000000000000ffffef0101011f70\
                     0003616263";
        let octets = |text: &str| -> Vec<u8> {
            let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
            let octet = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
            digits.chunks(2).map(octet).collect()
        };
        let found = Input::parse(&octets(input)).unwrap();
        assert_eq!((found.origin.as_ref(), found.sensor), (None, DataSource { sac: 25, sic: 200 }));
        assert_eq!((found.slot, found.part, found.is_last, found.heard.len()), (Slot(7), 0, true, 1));
        assert_eq!((&found.heard[0].payload[..], found.heard[0].to.port()), (&b"abc"[..], 8048));
        assert_eq!(found.body(), octets(input));
        let output = "55544f320000000000000007000000000000000300000000000000090170";
        let found = Output::parse(&octets(output)).unwrap();
        let expected = Output {
            slot: Slot(7),
            epoch: 3,
            behind: 9,
            refused: Vec::new(),
            step: Step(1),
            picture: b"p".to_vec(),
        };
        assert_eq!((&found, found.body()), (&expected, octets(output)));
    }

    /// The first one may be refused, and must not be in the way of the second.
    #[test]
    fn empty_messages_of_two_gateways_are_no_copies() {
        let input = |gateway: &str, sent, heard| Input {
            origin: Some(Origin { gateway: gateway.to_owned(), sent: Time::from_nanos(sent), config: 0 }),
            sensor: DataSource { sac: 25, sic: 200 },
            slot: Slot(7),
            part: 0,
            is_last: true,
            heard,
        };
        assert_ne!(input("g0", 1, Vec::new()).id(), input("g1", 1, Vec::new()).id());
        assert_eq!(input("g0", 1, Vec::new()).id(), input("g0", 2, Vec::new()).id(), "it is tried again");
        let address = "127.0.0.1:5000".parse().unwrap();
        let heard = vec![Heard { received: Time::default(), from: address, to: address, payload: vec![1] }];
        assert_eq!(input("g0", 1, heard.clone()).id(), input("g1", 2, heard).id());
    }
}
