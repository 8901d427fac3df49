//! Connection to a broker: MQTT 5 packets over a stream, at most one of them unacknowledged.

use std::io;
use std::time::Duration;

use bytes::BytesMut;
use rumqttc::v5::mqttbytes::v5::{
    self as packets, ConnAck, ConnAckProperties, Connect, ConnectProperties, ConnectReturnCode, Disconnect,
    DisconnectReasonCode, Filter, LastWill, Packet, PingReq, PubAckReason, Publish, PublishProperties,
    RetainForwardRule, Subscribe, SubscribeReasonCode,
};
use rumqttc::v5::mqttbytes::{Error, QoS};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, timeout, timeout_at};

use super::dial::{ByteStream, Dialer};

mod message;

pub(crate) use message::{
    ClientIdentity, Login, OutgoingMessage, PublishResult, ReceivedMessage, Subscription,
};

/// Timeout of a broker's answers. Chosen by judgement.
const PATIENCE: Duration = Duration::from_secs(10);
/// Keep-alive, in seconds.
const KEEP_ALIVE_S: u16 = 30;
/// Size of the largest packet that is read, in octets; larger than any alert.
const LARGEST: u32 = 1 << 20;
/// Packet identifiers of the only publication and the only subscription.
const PUBLICATION: u16 = 1;
const SUBSCRIPTION: u16 = 2;

/// Reason for the end of a connection.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BrokerError {
    #[error("{0}")]
    Io(#[from] io::Error),
    #[error("no answer within {} s", PATIENCE.as_secs())]
    Silent,
    #[error("the broker refuses the connection: {0:?}")]
    Refused(ConnectReturnCode),
    #[error("the broker takes no messages of QoS 1")]
    NoQos,
    #[error("the broker retains no messages")]
    NoRetain,
    #[error("the broker ends the connection: {0:?}")]
    Ended(DisconnectReasonCode),
    #[error("the broker refuses the subscription: {0:?}")]
    NotSubscribed(SubscribeReasonCode),
    #[error("the broker does not speak MQTT 5: {0}")]
    Garbled(Error),
}

pub(crate) struct BrokerConnection {
    stream: Box<dyn ByteStream>,
    /// Octets read but not parsed yet.
    read: BytesMut,
    /// Size of the largest packet that the broker accepts, in octets.
    largest: Option<u32>,
    /// Maximum time between two packets from this side.
    pause: Duration,
    /// Time of the next ping, unless another packet is sent before.
    ping_due: Instant,
}

impl BrokerConnection {
    pub async fn open(dial: &Dialer, caller: ClientIdentity<'_>) -> Result<Self, BrokerError> {
        let stream = timeout(PATIENCE, dial.dial()).await.map_err(|_| BrokerError::Silent)??;
        let mut connection = Self {
            stream,
            read: BytesMut::new(),
            largest: None,
            pause: Duration::ZERO,
            ping_due: Instant::now(),
        };
        let properties = ConnectProperties { max_packet_size: Some(LARGEST), ..ConnectProperties::new() };
        let connect = Connect {
            keep_alive: KEEP_ALIVE_S,
            client_id: caller.client_id.to_owned(),
            clean_start: true,
            properties: Some(properties),
        };
        let ClientIdentity { login, will, .. } = caller;
        let login = login.map(|Login { username, password }| packets::Login { username, password });
        let will = will.map(|OutgoingMessage { topic, payload, retain, .. }| {
            LastWill::new(topic, payload, QoS::AtLeastOnce, retain, None)
        });
        connection.write(&Packet::Connect(connect, will, login)).await?;
        let wanted = |packet: &Packet| match packet {
            Packet::ConnAck(answer) => Some(answer.clone()),
            _ => None,
        };
        let ConnAck { code, properties, .. } = connection.answer(wanted, |_| {}).await?;
        if code != ConnectReturnCode::Success {
            return Err(BrokerError::Refused(code));
        }
        let said = properties.as_ref();
        let of = |what: fn(&ConnAckProperties) -> Option<u8>| said.and_then(what);
        if of(|said| said.max_qos) == Some(0) {
            return Err(BrokerError::NoQos);
        }
        if of(|said| said.retain_available) == Some(0) {
            return Err(BrokerError::NoRetain);
        }
        connection.largest = said.and_then(|said| said.max_packet_size);
        let keep_alive_s = said.and_then(|said| said.server_keep_alive).filter(|&seconds| seconds > 0);
        connection.pause = Duration::from_secs(keep_alive_s.unwrap_or(KEEP_ALIVE_S).into()) / 2;
        connection.ping_due = Instant::now() + connection.pause;
        Ok(connection)
    }

    /// Publishes at QoS 1.
    pub async fn publish(
        &mut self,
        message: OutgoingMessage,
        found: impl FnMut(ReceivedMessage),
    ) -> Result<PublishResult, BrokerError> {
        let packet = publication(message, QoS::AtLeastOnce, PUBLICATION);
        if let Some(largest) = self.largest
            && packet.size() > largest as usize
        {
            return Ok(PublishResult::Refused(format!("the broker takes no more than {largest} octets")));
        }
        self.write(&packet).await?;
        let wanted = |packet: &Packet| match packet {
            Packet::PubAck(answer) if answer.pkid == PUBLICATION => Some(answer.reason),
            _ => None,
        };
        Ok(match self.answer(wanted, found).await? {
            PubAckReason::Success | PubAckReason::NoMatchingSubscribers => PublishResult::Taken,
            reason => PublishResult::Refused(format!("the broker refuses a message: {reason:?}")),
        })
    }

    /// Publishes at QoS 0, without an acknowledgement. Returns `false` if the message is larger than the broker accepts.
    pub async fn send(&mut self, message: OutgoingMessage) -> Result<bool, BrokerError> {
        let packet = publication(message, QoS::AtMostOnce, 0);
        if self.largest.is_some_and(|largest| packet.size() > largest as usize) {
            return Ok(false);
        }
        self.write(&packet).await?;
        Ok(true)
    }

    /// Subscribes without waiting for the acknowledgement. Retained messages arrive while other answers are awaited. A
    /// refused subscription is not reported.
    pub async fn subscribe(&mut self, subscription: Subscription) -> Result<(), BrokerError> {
        let Subscription { filter, nolocal, retained } = subscription;
        let retained = if retained { RetainForwardRule::OnEverySubscribe } else { RetainForwardRule::Never };
        let filter =
            Filter { nolocal, retain_forward_rule: retained, ..Filter::new(filter, QoS::AtMostOnce) };
        let subscribe = Subscribe { pkid: SUBSCRIPTION, ..Subscribe::new(filter, None) };
        self.write(&Packet::Subscribe(subscribe)).await
    }

    /// Subscribes, and waits for the broker's acknowledgement.
    pub(crate) async fn subscribed(
        &mut self,
        subscription: Subscription,
        found: impl FnMut(ReceivedMessage),
    ) -> Result<(), BrokerError> {
        self.subscribe(subscription).await?;
        let wanted = |packet: &Packet| match packet {
            Packet::SubAck(answer) if answer.pkid == SUBSCRIPTION => Some(answer.return_codes.clone()),
            _ => None,
        };
        let codes = self.answer(wanted, found).await?;
        match codes.into_iter().find(|code| !matches!(code, SubscribeReasonCode::Success(_))) {
            Some(code) => Err(BrokerError::NotSubscribed(code)),
            None => Ok(()),
        }
    }

    /// Time at which the broker needs a ping to keep the connection. Received messages do not postpone it: only packets
    /// from this side count as a sign of life (MQTT 5, 3.1.2.10).
    pub(crate) const fn ping_due(&self) -> Instant {
        self.ping_due
    }

    /// Sends a ping, and waits for the answer.
    pub async fn ping(&mut self, found: impl FnMut(ReceivedMessage)) -> Result<(), BrokerError> {
        self.write(&Packet::PingReq(PingReq)).await?;
        let wanted = |packet: &Packet| matches!(packet, Packet::PingResp(_)).then_some(());
        self.answer(wanted, found).await
    }

    /// Disconnects, so that the broker does not publish the last will.
    pub async fn end(mut self) -> Result<(), BrokerError> {
        self.write(&Packet::Disconnect(Disconnect::new(DisconnectReasonCode::NormalDisconnection))).await?;
        self.stream.shutdown().await?;
        Ok(())
    }

    /// Waits for the next message; the wait may be cancelled.
    pub async fn listen(&mut self) -> Result<Option<ReceivedMessage>, BrokerError> {
        let packet = self.receive().await?;
        Self::found(packet)
    }

    /// Waits for the answer to a packet; passes messages received meanwhile to `found`.
    async fn answer<T>(
        &mut self,
        wanted: impl Fn(&Packet) -> Option<T>,
        mut found: impl FnMut(ReceivedMessage),
    ) -> Result<T, BrokerError> {
        let until = Instant::now() + PATIENCE;
        loop {
            let packet = timeout_at(until, self.receive()).await.map_err(|_| BrokerError::Silent)??;
            if let Some(answer) = wanted(&packet) {
                return Ok(answer);
            }
            Self::found(packet)?.into_iter().for_each(&mut found);
        }
    }

    fn found(packet: Packet) -> Result<Option<ReceivedMessage>, BrokerError> {
        match packet {
            Packet::Disconnect(Disconnect { reason_code, .. }) => Err(BrokerError::Ended(reason_code)),
            Packet::Publish(Publish { topic, payload, retain, .. }) => {
                Ok(Some(ReceivedMessage { topic, payload, retain }))
            }
            _ => Ok(None),
        }
    }

    async fn receive(&mut self) -> Result<Packet, BrokerError> {
        loop {
            match Packet::read(&mut self.read, Some(LARGEST)) {
                Ok(packet) => return Ok(packet),
                Err(Error::InsufficientBytes(_)) => {}
                Err(error) => return Err(BrokerError::Garbled(error)),
            }
            if self.stream.read_buf(&mut self.read).await? == 0 {
                return Err(
                    io::Error::new(io::ErrorKind::UnexpectedEof, "the broker closed the connection").into()
                );
            }
        }
    }

    async fn write(&mut self, packet: &Packet) -> Result<(), BrokerError> {
        let mut octets = BytesMut::new();
        packet.write(&mut octets, None).map_err(BrokerError::Garbled)?;
        let written = async {
            self.stream.write_all(&octets).await?;
            self.stream.flush().await
        };
        timeout(PATIENCE, written).await.map_err(|_| BrokerError::Silent)??;
        self.ping_due = Instant::now() + self.pause;
        Ok(())
    }
}

/// Packet that publishes the message.
fn publication(message: OutgoingMessage, qos: QoS, pkid: u16) -> Packet {
    let OutgoingMessage { topic, payload, retain, is_json, expiry_s } = message;
    let properties = PublishProperties {
        payload_format_indicator: is_json.then_some(1),
        content_type: is_json.then(|| "application/json".to_owned()),
        message_expiry_interval: expiry_s,
        ..PublishProperties::default()
    };
    Packet::Publish(Publish { retain, pkid, ..Publish::new(topic, qos, payload, Some(properties)) })
}

#[cfg(test)]
pub(crate) mod scripted;
