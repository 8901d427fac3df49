//! One connection to a broker: packets over a stream, one of them unanswered at most.

use std::io;
use std::time::Duration;

use bytes::BytesMut;
use rumqttc::v5::mqttbytes::v5::{
    ConnAck, ConnAckProperties, Connect, ConnectProperties, ConnectReturnCode, Disconnect,
    DisconnectReasonCode, LastWill, Login, Packet, PingReq, PubAckReason, Publish, Subscribe,
    SubscribeReasonCode,
};
use rumqttc::v5::mqttbytes::{Error, QoS};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, timeout, timeout_at};

use super::dial::{Dial, Stream};

/// A broker that has not answered for this long is gone. By judgement.
const PATIENCE: Duration = Duration::from_secs(10);
/// Without a packet for this long each side takes the other for gone, seconds.
const KEEP_ALIVE_S: u16 = 30;
/// The largest packet that is read: more than an alert ever takes.
const LARGEST: u32 = 1 << 20;
/// The one publication on its way, and the one subscription.
const PUBLICATION: u16 = 1;
const SUBSCRIPTION: u16 = 2;

/// Why a connection is no more.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Broken {
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

/// What became of a publication.
pub(crate) enum Published {
    Taken,
    Refused(String),
}

/// A message that a subscription brings.
pub(crate) type Found = Publish;

/// Who connects.
pub(crate) struct Caller<'a> {
    pub(crate) client_id: &'a str,
    pub(crate) login: Option<Login>,
    pub(crate) will: Option<LastWill>,
}

pub(crate) struct Connection {
    stream: Box<dyn Stream>,
    /// What is read and not understood yet.
    read: BytesMut,
    /// The largest packet that the broker takes.
    largest: Option<u32>,
    /// Longest time between two packets that this side sends.
    pause: Duration,
    /// When the next ping is due, unless another packet is sent before.
    ping_due: Instant,
}

impl Connection {
    pub(crate) async fn open(dial: &Dial, caller: Caller<'_>) -> Result<Self, Broken> {
        let stream = timeout(PATIENCE, dial.dial()).await.map_err(|_| Broken::Silent)??;
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
        connection.write(&Packet::Connect(connect, caller.will, caller.login)).await?;
        let wanted = |packet: &Packet| match packet {
            Packet::ConnAck(answer) => Some(answer.clone()),
            _ => None,
        };
        let ConnAck { code, properties, .. } = connection.answer(wanted, |_| {}).await?;
        if code != ConnectReturnCode::Success {
            return Err(Broken::Refused(code));
        }
        let said = properties.as_ref();
        let of = |what: fn(&ConnAckProperties) -> Option<u8>| said.and_then(what);
        if of(|said| said.max_qos) == Some(0) {
            return Err(Broken::NoQos);
        }
        if of(|said| said.retain_available) == Some(0) {
            return Err(Broken::NoRetain);
        }
        connection.largest = said.and_then(|said| said.max_packet_size);
        let keep_alive_s = said.and_then(|said| said.server_keep_alive).filter(|&seconds| seconds > 0);
        connection.pause = Duration::from_secs(keep_alive_s.unwrap_or(KEEP_ALIVE_S).into()) / 2;
        connection.ping_due = Instant::now() + connection.pause;
        Ok(connection)
    }

    /// Publishes at QoS 1.
    pub(crate) async fn publish(
        &mut self,
        message: Publish,
        found: impl FnMut(Found),
    ) -> Result<Published, Broken> {
        let packet = Packet::Publish(Publish { qos: QoS::AtLeastOnce, pkid: PUBLICATION, ..message });
        if let Some(largest) = self.largest
            && packet.size() > largest as usize
        {
            return Ok(Published::Refused(format!("the broker takes no more than {largest} octets")));
        }
        self.write(&packet).await?;
        let wanted = |packet: &Packet| match packet {
            Packet::PubAck(answer) if answer.pkid == PUBLICATION => Some(answer.reason),
            _ => None,
        };
        Ok(match self.answer(wanted, found).await? {
            PubAckReason::Success | PubAckReason::NoMatchingSubscribers => Published::Taken,
            reason => Published::Refused(format!("the broker refuses a message: {reason:?}")),
        })
    }

    /// Publishes at QoS 0, which the broker does not acknowledge; `false` where the message is larger than the broker takes.
    pub(crate) async fn send(&mut self, message: Publish) -> Result<bool, Broken> {
        let packet = Packet::Publish(Publish { qos: QoS::AtMostOnce, ..message });
        if self.largest.is_some_and(|largest| packet.size() > largest as usize) {
            return Ok(false);
        }
        self.write(&packet).await?;
        Ok(true)
    }

    /// Asks for messages; those that are retained come where others are waited for. A broker that shows them to nobody goes
    /// without saying.
    pub(crate) async fn subscribe(&mut self, subscribe: Subscribe) -> Result<(), Broken> {
        self.write(&Packet::Subscribe(Subscribe { pkid: SUBSCRIPTION, ..subscribe })).await
    }

    /// Asks for messages, and waits until the broker says that they will come.
    pub(crate) async fn subscribed(
        &mut self,
        subscribe: Subscribe,
        found: impl FnMut(Found),
    ) -> Result<(), Broken> {
        self.subscribe(subscribe).await?;
        let wanted = |packet: &Packet| match packet {
            Packet::SubAck(answer) if answer.pkid == SUBSCRIPTION => Some(answer.return_codes.clone()),
            _ => None,
        };
        let codes = self.answer(wanted, found).await?;
        match codes.into_iter().find(|code| !matches!(code, SubscribeReasonCode::Success(_))) {
            Some(code) => Err(Broken::NotSubscribed(code)),
            None => Ok(()),
        }
    }

    /// When the broker needs a ping to keep the connection. Messages that are received do not move it: only what this side
    /// sends counts as a sign of life (MQTT 5, 3.1.2.10).
    pub(crate) const fn ping_due(&self) -> Instant {
        self.ping_due
    }

    /// Sends a ping, and waits for the answer.
    pub(crate) async fn ping(&mut self, found: impl FnMut(Found)) -> Result<(), Broken> {
        self.write(&Packet::PingReq(PingReq)).await?;
        let wanted = |packet: &Packet| matches!(packet, Packet::PingResp(_)).then_some(());
        self.answer(wanted, found).await
    }

    /// Ends it, so that nobody hears the last will.
    pub(crate) async fn end(mut self) -> Result<(), Broken> {
        self.write(&Packet::Disconnect(Disconnect::new(DisconnectReasonCode::NormalDisconnection))).await?;
        self.stream.shutdown().await?;
        Ok(())
    }

    /// The next message that nobody asked for; it may be dropped while it waits.
    pub(crate) async fn listen(&mut self) -> Result<Option<Found>, Broken> {
        let packet = self.receive().await?;
        Self::found(packet)
    }

    /// Waits for the answer to what was sent; what else comes is seen to.
    async fn answer<T>(
        &mut self,
        wanted: impl Fn(&Packet) -> Option<T>,
        mut found: impl FnMut(Found),
    ) -> Result<T, Broken> {
        let until = Instant::now() + PATIENCE;
        loop {
            let packet = timeout_at(until, self.receive()).await.map_err(|_| Broken::Silent)??;
            if let Some(answer) = wanted(&packet) {
                return Ok(answer);
            }
            Self::found(packet)?.into_iter().for_each(&mut found);
        }
    }

    fn found(packet: Packet) -> Result<Option<Found>, Broken> {
        match packet {
            Packet::Disconnect(Disconnect { reason_code, .. }) => Err(Broken::Ended(reason_code)),
            Packet::Publish(message) => Ok(Some(message)),
            _ => Ok(None),
        }
    }

    async fn receive(&mut self) -> Result<Packet, Broken> {
        loop {
            match Packet::read(&mut self.read, Some(LARGEST)) {
                Ok(packet) => return Ok(packet),
                Err(Error::InsufficientBytes(_)) => {}
                Err(error) => return Err(Broken::Garbled(error)),
            }
            if self.stream.read_buf(&mut self.read).await? == 0 {
                return Err(
                    io::Error::new(io::ErrorKind::UnexpectedEof, "the broker closed the connection").into()
                );
            }
        }
    }

    async fn write(&mut self, packet: &Packet) -> Result<(), Broken> {
        let mut octets = BytesMut::new();
        packet.write(&mut octets, None).map_err(Broken::Garbled)?;
        let written = async {
            self.stream.write_all(&octets).await?;
            self.stream.flush().await
        };
        timeout(PATIENCE, written).await.map_err(|_| Broken::Silent)??;
        self.ping_due = Instant::now() + self.pause;
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod scripted;
