//! Messages of the log: sensor data, and the outputs of cells.

use std::net::{IpAddr, Ipv6Addr, SocketAddr};

use asterix::DataSource;
use fusion::slots::Slot;
use fusion::time::Time;
use sha2::{Digest, Sha256};

use super::audience::Audience;
use super::malformed_message::MalformedMessage;
use super::overload::SheddingLevel;
use super::region::CellMessage;
use site::territory::CellName;

/// First octets of an input: without the gateway's name, as written by version 0.6.0, and with it.
const INPUT: &[u8; 4] = b"UTM1";
const INPUT_OF: &[u8; 4] = b"UTM2";
/// First octets of an output: one that used all inputs, as written by version 0.6.0, and one that lists refused inputs.
const OUTPUT: &[u8; 4] = b"UTO2";
const OUTPUT_REFUSING: &[u8; 4] = b"UTO3";
/// Size of an address with its port, in octets. IPv4 addresses are mapped into IPv6.
const ADDRESS: usize = 18;

/// A datagram received by a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceivedDatagram {
    /// Time of reception at the gateway's socket.
    pub received: Time,
    /// Address of the sender.
    pub from: SocketAddr,
    /// Destination address.
    pub to: SocketAddr,
    /// Payload, at most 65,535 octets.
    pub payload: Vec<u8>,
}

/// The gateway that sent a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputOrigin {
    /// Name of the gateway, at most 255 octets.
    pub gateway: String,
    /// Sending time by the gateway's clock. Each attempt has its own.
    pub sent: Time,
    /// Hash of the configuration shared by all members; 0 if not stated.
    pub config: u64,
}

/// Header of an input, before its datagrams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputHeader {
    /// The gateway; `None` if a gateway of version 0.6.0 sent it.
    pub origin: Option<InputOrigin>,
    /// The first sensor of the line.
    pub sensor: DataSource,
    /// The slot of reception.
    pub slot: Slot,
    /// Index of the message within its slot, from 0.
    pub part: u16,
    /// Whether it is the last message of its slot.
    pub is_last: bool,
}

impl InputHeader {
    /// Parses the beginning of a body. `None` if the body is not an input.
    ///
    /// # Errors
    /// The body is truncated.
    pub fn of(body: &[u8]) -> Result<Option<Self>, MalformedMessage> {
        match BodyReader::of_input(body) {
            Some((mut unread, has_gateway)) => Self::read(&mut unread, has_gateway).map(Some),
            None => Ok(None),
        }
    }

    fn read(unread: &mut BodyReader, has_gateway: bool) -> Result<Self, MalformedMessage> {
        let origin = if has_gateway { Some(InputOrigin::read(unread)?) } else { None };
        let [sac, sic] = unread.take()?;
        let slot = Slot(i64::from_be_bytes(unread.take()?));
        let part = u16::from_be_bytes(unread.take()?);
        let [is_last] = unread.take()?;
        Ok(Self { origin, sensor: DataSource { sac, sic }, slot, part, is_last: is_last != 0 })
    }
}

impl InputOrigin {
    fn read(unread: &mut BodyReader) -> Result<Self, MalformedMessage> {
        let [length] = unread.take()?;
        let gateway = String::from_utf8_lossy(unread.octets(length.into())?).into_owned();
        let sent = Time::from_nanos(i64::from_be_bytes(unread.take()?));
        Ok(Self { gateway, sent, config: u64::from_be_bytes(unread.take()?) })
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

/// Datagrams that a gateway received on a line within a slot. A message without datagrams states that the line was silent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GatewayInput {
    /// The gateway that sent it; `None` if not stated, as by version 0.6.0.
    pub origin: Option<InputOrigin>,
    /// The first sensor of the line.
    pub sensor: DataSource,
    /// The slot of reception.
    pub slot: Slot,
    /// Index of the message within its slot, from 0.
    pub part: u16,
    /// Whether it is the last message of its slot from this gateway.
    pub is_last: bool,
    /// Datagrams in the order of reception.
    pub datagrams: Vec<ReceivedDatagram>,
}

impl GatewayInput {
    /// Serialises the message: `UTM2`, gateway (length in 1 octet, name), sending time (8 octets, nanoseconds since 1970, big
    /// endian as all that follows), hash of the configuration (8), SAC, SIC, slot (8), part (2), whether it is the last (1); then
    /// for each datagram the time of reception (8, nanoseconds since 1970), sender and destination (16 + 2 each), length (2),
    /// octets. Without an origin it begins with `UTM1`, followed by SAC.
    pub fn body(&self) -> Vec<u8> {
        let Self { origin, sensor, slot, part, is_last, datagrams } = self;
        let mut body = if origin.is_some() { INPUT_OF } else { INPUT }.to_vec();
        origin.iter().for_each(|origin| origin.write(&mut body));
        body.extend([sensor.sac, sensor.sic]);
        body.extend(slot.0.to_be_bytes());
        body.extend(part.to_be_bytes());
        body.push((*is_last).into());
        for ReceivedDatagram { received, from, to, payload } in datagrams {
            let payload = &payload[..payload.len().min(u16::MAX.into())];
            body.extend(received.nanos().to_be_bytes());
            body.extend(address(from));
            body.extend(address(to));
            body.extend((payload.len() as u16).to_be_bytes());
            body.extend(payload);
        }
        body
    }

    /// Parses a body.
    ///
    /// # Errors
    /// The body is not an input, or is truncated.
    pub fn parse(body: &[u8]) -> Result<Self, MalformedMessage> {
        let (mut unread, has_gateway) = BodyReader::of_input(body).ok_or(MalformedMessage::Beginning)?;
        let InputHeader { origin, sensor, slot, part, is_last } =
            InputHeader::read(&mut unread, has_gateway)?;
        let mut datagrams = Vec::new();
        while !unread.0.is_empty() {
            let received = Time::from_nanos(i64::from_be_bytes(unread.take()?));
            let (from, to) = (unread.address()?, unread.address()?);
            let length = u16::from_be_bytes(unread.take()?);
            datagrams.push(ReceivedDatagram {
                received,
                from,
                to,
                payload: unread.octets(length.into())?.to_vec(),
            });
        }
        Ok(Self { origin, sensor, slot, part, is_last, datagrams })
    }

    /// Identifier by which the log recognises copies: two gateways that received the same datagrams within a slot write the same
    /// identifier. A message without datagrams is unique to its gateway: the message of a gateway whose clock is ahead arrives
    /// first and is refused, and must not hide the other's.
    pub fn id(&self) -> String {
        let Self { origin, sensor, slot, part, datagrams, .. } = self;
        let mut hash = Sha256::new();
        if datagrams.is_empty() {
            origin.iter().for_each(|origin| hash.update(&origin.gateway));
        }
        datagrams.iter().for_each(|datagrams| hash.update(&datagrams.payload));
        let hash = input::hex::text(&hash.finalize()[..16]);
        format!("{}.{}.{}.{part}.{hash}", sensor.sac, sensor.sic, slot.0)
    }
}

/// A message handled by a cell, in the order of the log.
#[derive(Clone, Debug, PartialEq)]
pub enum LoggedMessage {
    /// Datagrams received by a gateway.
    Input(GatewayInput),
    /// A message from another cell or an operator.
    Message(Box<CellMessage>),
}

impl LoggedMessage {
    /// Parses a body for a cell with this audience. `None` if it is for other cells.
    ///
    /// # Errors
    /// The body is of no known version, or is truncated.
    pub fn parse(
        body: &[u8],
        cell: &CellName,
        audience: &Audience,
    ) -> Result<Option<Self>, MalformedMessage> {
        let Some(header) = InputHeader::of(body)? else {
            let message = CellMessage::parse(body)?;
            return Ok((message.to == *cell).then(|| Self::Message(message.into())));
        };
        // Most lines are not for this cell; their datagrams are not parsed.
        if !audience.includes(header.sensor) {
            return Ok(None);
        }
        GatewayInput::parse(body).map(|input| Some(Self::Input(input)))
    }

    /// Identifier by which the log recognises copies.
    pub fn id(&self) -> String {
        match self {
            Self::Input(input) => input.id(),
            Self::Message(message) => message.id(),
        }
    }
}

/// A published slot of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellOutput {
    /// The slot.
    pub slot: Slot,
    /// Number of the lease under which the slot was made.
    pub epoch: u64,
    /// Sequence of the input after which the slot was made.
    pub after_input: u64,
    /// Sequences of inputs refused since the previous slot, in order. Their gateway's clock, their slot or their configuration is
    /// wrong.
    pub refused: Vec<u64>,
    /// Level of load shedding from this slot on ([`SheddingLevel`]).
    pub level: SheddingLevel,
    /// The picture.
    pub picture: Vec<u8>,
}

impl CellOutput {
    /// Serialises the output: `UTO3`, slot, epoch, the input's sequence (8 octets each, big endian as all that follows), step
    /// (1), number of refused inputs (4), the distance of each to that input (8), the picture. Without refused inputs it begins
    /// with `UTO2`, and the picture follows the step.
    pub fn body(&self) -> Vec<u8> {
        let mut body = if self.refused.is_empty() { OUTPUT } else { OUTPUT_REFUSING }.to_vec();
        body.extend(self.slot.0.to_be_bytes());
        body.extend(self.epoch.to_be_bytes());
        body.extend(self.after_input.to_be_bytes());
        body.push(self.level.0);
        if !self.refused.is_empty() {
            body.extend((self.refused.len() as u32).to_be_bytes());
            self.refused.iter().for_each(|refused| body.extend((self.after_input - refused).to_be_bytes()));
        }
        body.extend(&self.picture);
        body
    }

    /// Parses a body.
    ///
    /// # Errors
    /// The body is not an output, or is truncated.
    pub fn parse(body: &[u8]) -> Result<Self, MalformedMessage> {
        let (unread, has_refused) = match body.strip_prefix(OUTPUT) {
            Some(unread) => (unread, false),
            None => (body.strip_prefix(OUTPUT_REFUSING).ok_or(MalformedMessage::Beginning)?, true),
        };
        let mut unread = BodyReader(unread);
        let slot = Slot(i64::from_be_bytes(unread.take()?));
        let epoch = u64::from_be_bytes(unread.take()?);
        let after_input = u64::from_be_bytes(unread.take()?);
        let [level] = unread.take()?;
        let mut refused = Vec::new();
        if has_refused {
            for _ in 0..u32::from_be_bytes(unread.take()?) {
                refused.push(after_input.saturating_sub(u64::from_be_bytes(unread.take()?)));
            }
        }
        Ok(Self {
            slot,
            epoch,
            after_input,
            refused,
            level: SheddingLevel(level),
            picture: unread.0.to_vec(),
        })
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

/// The unread rest of a body.
struct BodyReader<'a>(&'a [u8]);

impl<'a> BodyReader<'a> {
    /// The rest of an input after its first octets, and whether it names its gateway; `None` if the body is not an input.
    fn of_input(body: &'a [u8]) -> Option<(Self, bool)> {
        let with_gateway = body.strip_prefix(INPUT_OF).map(|unread| (Self(unread), true));
        with_gateway.or_else(|| body.strip_prefix(INPUT).map(|unread| (Self(unread), false)))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], MalformedMessage> {
        let (taken, unread) = self.0.split_first_chunk().ok_or(MalformedMessage::Short)?;
        self.0 = unread;
        Ok(*taken)
    }

    fn octets(&mut self, length: usize) -> Result<&'a [u8], MalformedMessage> {
        let (taken, unread) = self.0.split_at_checked(length).ok_or(MalformedMessage::Short)?;
        self.0 = unread;
        Ok(taken)
    }

    fn address(&mut self) -> Result<SocketAddr, MalformedMessage> {
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

    fn any_origin() -> impl Strategy<Value = InputOrigin> {
        ("[a-z0-9é-]{0,40}", any::<i64>(), any::<u64>()).prop_map(|(gateway, sent, config)| InputOrigin {
            gateway,
            sent: Time::from_nanos(sent),
            config,
        })
    }

    fn any_datagram() -> impl Strategy<Value = ReceivedDatagram> {
        let octets = prop::collection::vec(any::<u8>(), 0..300);
        (any::<i64>(), any_address(), any_address(), octets).prop_map(|(received, from, to, payload)| {
            ReceivedDatagram { received: Time::from_nanos(received), from, to, payload }
        })
    }

    proptest! {
        #[test]
        fn input_round_trips(
            (sac, sic, slot, part, is_last) in any::<(u8, u8, i64, u16, bool)>(),
            datagrams in prop::collection::vec(any_datagram(), 0..6),
            origin in prop::option::of(any_origin()),
        ) {
            let input = GatewayInput { origin, sensor: DataSource { sac, sic }, slot: Slot(slot), part, is_last, datagrams };
            let body = input.body();
            prop_assert_eq!(GatewayInput::parse(&body), Ok(input.clone()));
            // A truncated body is a shorter message or an error.
            for cut in 0..body.len() {
                if let Ok(shorter) = GatewayInput::parse(&body[..cut]) {
                    prop_assert!(shorter.datagrams.len() < input.datagrams.len());
                }
            }
            let GatewayInput { origin, sensor, slot, part, is_last, .. } = input;
            prop_assert_eq!(InputHeader::of(&body), Ok(Some(InputHeader { origin, sensor, slot, part, is_last })));
        }

        #[test]
        fn output_round_trips(
            (slot, epoch, after_input, level) in any::<(i64, u64, u64, u8)>(),
            mut refused in prop::collection::vec(any::<u64>(), 0..5),
            picture in prop::collection::vec(any::<u8>(), 0..100),
        ) {
            refused.iter_mut().for_each(|refused| *refused = after_input.saturating_sub(*refused));
            let output = CellOutput { slot: Slot(slot), epoch, after_input, refused, level: SheddingLevel(level), picture };
            prop_assert_eq!(CellOutput::parse(&output.body()), Ok(output));
        }

        #[test]
        fn octets_are_a_message_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = (GatewayInput::parse(&octets), CellOutput::parse(&octets));
            for begin in [INPUT, INPUT_OF, OUTPUT, OUTPUT_REFUSING] {
                let octets = [begin, &octets[..]].concat();
                let _ = (GatewayInput::parse(&octets), CellOutput::parse(&octets), InputHeader::of(&octets));
            }
        }
    }

    /// Timestamps and senders differ; the identifier depends on the octets, in order.
    #[test]
    fn same_datagrams_from_two_gateways_have_one_id() {
        let datagrams = |received, payload: &[u8]| ReceivedDatagram {
            received: Time::from_nanos(received),
            from: "127.0.0.1:5000".parse().unwrap(),
            to: "239.1.1.1:8048".parse().unwrap(),
            payload: payload.to_vec(),
        };
        let input = |datagrams| GatewayInput {
            origin: None,
            sensor: DataSource { sac: 25, sic: 200 },
            slot: Slot(7),
            part: 0,
            is_last: true,
            datagrams,
        };
        let one = input(vec![datagrams(1, b"a"), datagrams(2, b"b")]);
        let other = input(vec![datagrams(3, b"a"), datagrams(4, b"b")]);
        let swapped = input(vec![datagrams(3, b"b"), datagrams(4, b"a")]);
        assert_eq!(one.id(), other.id());
        assert_ne!(one.id(), swapped.id());
        assert!(one.id().starts_with("25.200.7.0."), "{}", one.id());
    }
    /// Messages of version 0.6.0 have no gateway names and no lists of refused inputs.
    #[test]
    fn messages_of_version_0_6_0_are_read() {
        let input = "55544d3119c8000000000000000700000118b1d5a5c9f4c000\
                     00000000000000000000ffff7f0000011388\
                     00000000000000000000ffffef0101011f70\
                     0003616263";
        let octets = |text: &str| -> Vec<u8> {
            let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
            let octet = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
            digits.chunks(2).map(octet).collect()
        };
        let found = GatewayInput::parse(&octets(input)).unwrap();
        assert_eq!((found.origin.as_ref(), found.sensor), (None, DataSource { sac: 25, sic: 200 }));
        assert_eq!((found.slot, found.part, found.is_last, found.datagrams.len()), (Slot(7), 0, true, 1));
        assert_eq!((&found.datagrams[0].payload[..], found.datagrams[0].to.port()), (&b"abc"[..], 8048));
        assert_eq!(found.body(), octets(input));
        let output = "55544f320000000000000007000000000000000300000000000000090170";
        let found = CellOutput::parse(&octets(output)).unwrap();
        let expected = CellOutput {
            slot: Slot(7),
            epoch: 3,
            after_input: 9,
            refused: Vec::new(),
            level: SheddingLevel(1),
            picture: b"p".to_vec(),
        };
        assert_eq!((&found, found.body()), (&expected, octets(output)));
    }

    /// The first message may be refused, and must not hide the second.
    #[test]
    fn empty_messages_of_two_gateways_are_distinct() {
        let input = |gateway: &str, sent, datagrams| GatewayInput {
            origin: Some(InputOrigin {
                gateway: gateway.to_owned(),
                sent: Time::from_nanos(sent),
                config: 0,
            }),
            sensor: DataSource { sac: 25, sic: 200 },
            slot: Slot(7),
            part: 0,
            is_last: true,
            datagrams,
        };
        assert_ne!(input("g0", 1, Vec::new()).id(), input("g1", 1, Vec::new()).id());
        assert_eq!(input("g0", 1, Vec::new()).id(), input("g0", 2, Vec::new()).id(), "it is tried again");
        let address = "127.0.0.1:5000".parse().unwrap();
        let datagrams = vec![ReceivedDatagram {
            received: Time::default(),
            from: address,
            to: address,
            payload: vec![1],
        }];
        assert_eq!(input("g0", 1, datagrams.clone()).id(), input("g1", 2, datagrams).id());
    }
}
