//! `[[output.mqtt]]`: each track as a message to a broker of MQTT 5, once a second.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use tokio::time::{sleep, sleep_until};

use super::PictureSink;
use super::counts::SinkLoss;
use super::delivery::SinkQueue;
use super::second::PictureSecond;
use crate::net::dial::{Certificates, Dialer};
use crate::net::mqtt::{BrokerConnection, BrokerError, ClientIdentity, Login, OutgoingMessage};
use crate::net::peers::{Closing, closed, is_local};
use crate::net::secret::secret;
use picture::TrackJson;
use site::config::{self, Site};

const ONLINE: &str = "online";
const OFFLINE: &str = "offline";
/// Expiry of a track's message at the broker, in seconds. If the service dies, no track remains that looks current.
const EXPIRY_S: u32 = 10;

/// A broker as sink.
pub(super) struct TrackBroker {
    pub(super) queue: Arc<SinkQueue>,
    dial: Dialer,
    client_id: String,
    login: Option<Login>,
    /// The first levels of all topics.
    prefix: String,
    /// Whether the broker keeps the last message of each track for new subscribers.
    retain: bool,
}

/// Leaves out the password.
impl fmt::Debug for TrackBroker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TrackBroker")
            .field("queue", &self.queue)
            .field("dial", &self.dial)
            .field("prefix", &self.prefix)
            .finish_non_exhaustive()
    }
}

/// Opens a sink; no connection is made yet.
pub(super) fn open(mqtt: &config::MqttTracks, site: &Site) -> Result<PictureSink, String> {
    let config::MqttTracks { id, host, port, tls, ca, username, password_file, password_env, .. } = mqtt;
    let dial = if *tls {
        Dialer::tls(host, *port, &Certificates { ca: ca.as_deref(), ..Certificates::default() })?
    } else {
        Dialer::plain(host, *port)
    };
    let password = secret(password_file.as_deref(), password_env.as_deref())?.unwrap_or_default();
    let usual_id = || format!("utm-fusion-{}-{}-{id}", site.sac, site.sic);
    Ok(PictureSink::Broker(TrackBroker {
        queue: Arc::new(SinkQueue::new(format!("mqtt:{id}"), mqtt.picture)),
        dial,
        client_id: mqtt.client_id.clone().unwrap_or_else(usual_id),
        login: username.clone().map(|username| Login { username, password }),
        prefix: mqtt.prefix.clone(),
        retain: mqtt.retain,
    }))
}

/// A description of the sink, without secrets.
pub(super) fn line(mqtt: &config::MqttTracks) -> String {
    let config::MqttTracks { id, host, port, tls, prefix, picture, .. } = mqtt;
    let tls = if *tls { "TLS" } else { "without TLS" };
    format!("picture to mqtt:{id}: {host}:{port}, {tls}, topics {prefix}/tracks/…, {}", picture.name())
}

/// A weakness of the configuration that the operator should remove.
pub(super) fn warning(mqtt: &config::MqttTracks) -> Option<String> {
    (!mqtt.tls && !is_local(&mqtt.host))
        .then(|| format!("mqtt:{}: the picture travels beyond this machine without TLS", mqtt.id))
}

/// Reason for the end of a connection.
struct BrokerFailure {
    why: String,
    /// Reason for which a second was lost with it.
    loss: Option<SinkLoss>,
}

impl From<BrokerError> for BrokerFailure {
    fn from(broken: BrokerError) -> Self {
        Self { why: broken.to_string(), loss: None }
    }
}

impl TrackBroker {
    /// Publishes each second until the service ends, and connects again when a connection fails.
    pub(super) async fn deliver(self, mut closing: Closing) {
        loop {
            let Err(BrokerFailure { why, loss }) = self.session(&mut closing).await else { return };
            let wait = self.queue.fails(why, loss);
            tokio::select! {
                () = sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Whether the broker accepts a connection; nothing is published.
    pub(super) async fn reach(&self) -> Result<(), String> {
        let client_id = format!("{}-check", self.client_id);
        let caller = ClientIdentity { client_id: &client_id, login: self.login.clone(), will: None };
        let connection =
            BrokerConnection::open(&self.dial, caller).await.map_err(|broken| broken.to_string())?;
        connection.end().await.map_err(|broken| broken.to_string())
    }

    async fn session(&self, closing: &mut Closing) -> Result<(), BrokerFailure> {
        let will = Some(self.status(OFFLINE));
        let caller = ClientIdentity { client_id: &self.client_id, login: self.login.clone(), will };
        let mut connection = tokio::select! {
            connection = BrokerConnection::open(&self.dial, caller) => connection?,
            () = closed(closing) => return Ok(()),
        };
        self.queue.begin();
        connection.publish(self.status(ONLINE), |_| {}).await?;
        self.queue.works();
        let mut shown = BTreeSet::new();
        loop {
            let ping_due = connection.ping_due();
            let second = tokio::select! {
                second = self.queue.next() => second,
                heard = connection.listen() => {
                    heard?;
                    continue;
                }
                () = sleep_until(ping_due) => {
                    connection.ping(|_| {}).await?;
                    continue;
                }
                () = closed(closing) => break,
            };
            self.publish(&mut connection, &second, &mut shown).await?;
        }
        while let Some(second) = self.queue.take() {
            self.publish(&mut connection, &second, &mut shown).await?;
        }
        for id in &shown {
            self.clear(&mut connection, id).await?;
        }
        connection.publish(self.status(OFFLINE), |_| {}).await?;
        Ok(connection.end().await?)
    }

    /// Publishes the tracks of a second; those that have ended are cleared at the broker.
    async fn publish(
        &self,
        connection: &mut BrokerConnection,
        second: &PictureSecond,
        shown: &mut BTreeSet<String>,
    ) -> Result<(), BrokerFailure> {
        let lose = |why: String| BrokerFailure { why, loss: Some(SinkLoss::Unreachable) };
        let mut current = BTreeSet::new();
        for track in second.tracks() {
            let id = second.maker.track_id(track);
            let message = serde_json::to_vec(&TrackJson::new(track, &second.maker));
            let message = self.track(&id, message.map_err(|error| lose(error.to_string()))?);
            if connection.send(message).await.map_err(|broken| lose(broken.to_string()))? {
                self.queue.sent(1);
                current.insert(id);
            } else {
                self.queue.left_out(1);
            }
        }
        for id in shown.difference(&current) {
            self.clear(connection, id).await?;
        }
        *shown = current;
        Ok(())
    }

    /// Publishes an empty message: it informs subscribers that the track has ended, and clears the retained message.
    async fn clear(&self, connection: &mut BrokerConnection, id: &str) -> Result<(), BrokerError> {
        connection.send(self.track(id, Vec::new())).await.map(drop)
    }

    fn track(&self, id: &str, payload: Vec<u8>) -> OutgoingMessage {
        let topic = format!("{}/tracks/{id}", self.prefix);
        OutgoingMessage { topic, payload, retain: self.retain, is_json: true, expiry_s: Some(EXPIRY_S) }
    }

    fn status(&self, status: &str) -> OutgoingMessage {
        let (topic, payload) = (format!("{}/tracks-status", self.prefix), status.into());
        OutgoingMessage { topic, payload, retain: true, ..OutgoingMessage::default() }
    }
}
