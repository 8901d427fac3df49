//! Test broker on this machine that floods a client with messages.

use std::net::Ipv4Addr;
use std::time::Duration;

use bytes::BytesMut;
use rumqttc::v5::mqttbytes::v5::{
    ConnAck, ConnAckProperties, ConnectReturnCode, Packet, PingResp, PubAck, Publish, SubAck,
    SubscribeReasonCode,
};
use rumqttc::v5::mqttbytes::{Error, QoS};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, interval, timeout_at};

use super::LARGEST;

/// Keep-alive that the broker requests, in seconds.
const KEEP_ALIVE_S: u16 = 1;
const PROPERTIES: ConnAckProperties = ConnAckProperties {
    session_expiry_interval: None,
    receive_max: None,
    max_qos: None,
    retain_available: None,
    max_packet_size: None,
    assigned_client_identifier: None,
    topic_alias_max: None,
    reason_string: None,
    user_properties: Vec::new(),
    wildcard_subscription_available: None,
    subscription_identifiers_available: None,
    shared_subscription_available: None,
    server_keep_alive: Some(KEEP_ALIVE_S),
    response_information: None,
    server_reference: None,
    authentication_method: None,
    authentication_data: None,
};
/// Time between two messages of the broker, a fraction of the keep-alive.
const EACH: Duration = Duration::from_millis(20);
/// Time for which messages are sent.
const LASTS: Duration = Duration::from_millis(2_500);

/// Number of pings from a client while messages on `topic` arrive much faster than the keep-alive. Like a real broker, this
/// one closes the connection when no packet has arrived for one and a half times the keep-alive.
pub(crate) async fn pings_while_flooded<F: Future<Output = ()> + Send + 'static>(
    topic: &str,
    client: impl FnOnce(u16) -> F,
) -> usize {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let client = tokio::spawn(client(port));
    let (stream, _) = listener.accept().await.unwrap();
    let pings = serve(stream, topic).await;
    client.abort();
    pings
}

async fn serve(mut stream: TcpStream, topic: &str) -> usize {
    let (mut read, mut pings) = (BytesMut::new(), 0);
    let (mut each, until) = (interval(EACH), Instant::now() + LASTS);
    let mut heard = Instant::now();
    let mut is_subscribed = false;
    while Instant::now() < until {
        let patience = heard + Duration::from_secs(KEEP_ALIVE_S.into()) * 3 / 2;
        tokio::select! {
            octets = timeout_at(patience, stream.read_buf(&mut read)) => match octets {
                Ok(Ok(octets)) if octets > 0 => heard = Instant::now(),
                _ => return pings,
            },
            _ = each.tick(), if is_subscribed => {
                let message = Publish::new(topic, QoS::AtMostOnce, "{}", None);
                send(&mut stream, &Packet::Publish(message)).await;
            }
        }
        loop {
            let answer = match Packet::read(&mut read, Some(LARGEST)) {
                Err(Error::InsufficientBytes(_)) => break,
                Ok(Packet::Connect(..)) => Packet::ConnAck(ConnAck {
                    session_present: false,
                    code: ConnectReturnCode::Success,
                    properties: Some(PROPERTIES),
                }),
                Ok(Packet::Subscribe(subscribe)) => {
                    is_subscribed = true;
                    Packet::SubAck(SubAck {
                        pkid: subscribe.pkid,
                        return_codes: vec![SubscribeReasonCode::Success(QoS::AtMostOnce)],
                        properties: None,
                    })
                }
                Ok(Packet::Publish(message)) => Packet::PubAck(PubAck::new(message.pkid, None)),
                Ok(Packet::PingReq(_)) => {
                    pings += 1;
                    Packet::PingResp(PingResp)
                }
                other => panic!("{other:?}"),
            };
            send(&mut stream, &answer).await;
        }
    }
    pings
}

async fn send(stream: &mut TcpStream, packet: &Packet) {
    let mut octets = BytesMut::new();
    packet.write(&mut octets, None).unwrap();
    stream.write_all(&octets).await.unwrap();
}
