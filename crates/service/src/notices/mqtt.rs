//! Broker of MQTT 5: each active alert is a retained message on its own topic, and each change is an event.
//!
//! One message at a time is unacknowledged, so it is known what the broker has missed. Each connection publishes all active
//! alerts, and clears the messages retained from an earlier run.

use std::fmt;
use std::sync::Arc;

use tokio::time::{sleep, sleep_until};

use super::batch::NoticeBatch;
use super::body;
use super::delivery::{NoticeQueue, PendingDelivery};
use super::mirror::Mirror;
use crate::live::now;
use crate::net::dial::Dialer;
use crate::net::health::DeliveryResult;
use crate::net::mqtt::{
    BrokerConnection, BrokerError, ClientIdentity, Login, OutgoingMessage, PublishResult, ReceivedMessage,
    Subscription,
};
use crate::net::peers::{Closing, closed};

const ONLINE: &str = "online";
const OFFLINE: &str = "offline";

/// A broker as receiver.
pub(super) struct Broker {
    pub(super) queue: Arc<NoticeQueue>,
    pub(super) dial: Dialer,
    pub(super) client_id: String,
    pub(super) login: Option<Login>,
    /// Prefix of all topics.
    pub(super) prefix: String,
    pub(super) site: String,
    /// Prefix of the ids of this run's notices.
    pub(super) run: String,
}

/// Leaves out the password.
impl fmt::Debug for Broker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Broker")
            .field("dial", &self.dial)
            .field("prefix", &self.prefix)
            .finish_non_exhaustive()
    }
}

impl Broker {
    /// Publishes until the service ends, and connects again when the connection breaks.
    pub(super) async fn deliver(self, mut closing: Closing) {
        loop {
            let mut unsent = None;
            let Err(broken) = self.session(&mut closing, &mut unsent).await else { return };
            let why = broken.to_string();
            let wait = match unsent {
                Some(batch) => self.queue.settle(batch, DeliveryResult::Later { why, after: None }),
                None => self.queue.fails(why),
            };
            tokio::select! {
                () = sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Publishes a test as an event, with another client id than the running service.
    pub(super) async fn test(&self) -> Result<String, String> {
        let client_id = format!("{}-check", self.client_id);
        let caller = ClientIdentity { client_id: &client_id, login: self.login.clone(), will: None };
        let mut connection =
            BrokerConnection::open(&self.dial, caller).await.map_err(|broken| broken.to_string())?;
        let body = body::of_test(&format!("{}-test", self.run), &self.site, now());
        let published =
            connection.publish(self.event(body), |_| {}).await.map_err(|broken| broken.to_string())?;
        // The test has been acknowledged already.
        let _ = connection.end().await;
        match published {
            PublishResult::Taken => Ok(format!("published on {}/alerts/events", self.prefix)),
            PublishResult::Refused(why) => Err(why),
        }
    }

    /// Runs a connection from its beginning. `unsent` is the delivery that was not acknowledged when it broke.
    async fn session(
        &self,
        closing: &mut Closing,
        unsent: &mut Option<NoticeBatch>,
    ) -> Result<(), BrokerError> {
        let will = Some(self.status(OFFLINE));
        let caller = ClientIdentity { client_id: &self.client_id, login: self.login.clone(), will };
        let mut connection = BrokerConnection::open(&self.dial, caller).await?;
        self.queue.mirrored(Mirror::begin);
        connection.publish(self.status(ONLINE), |_| {}).await?;
        let found = |message: ReceivedMessage| self.found(&message);
        connection.subscribe(self.retained()).await?;
        // A broker answers in order: its retained messages arrive before the answer.
        connection.ping(found).await?;
        self.queue.works();
        loop {
            let ping_due = connection.ping_due();
            let owed = tokio::select! {
                owed = self.queue.owed() => owed,
                heard = connection.listen() => {
                    heard?.into_iter().for_each(found);
                    continue;
                }
                () = sleep_until(ping_due) => {
                    connection.ping(found).await?;
                    continue;
                }
                () = closed(closing) => break,
            };
            self.pay(&mut connection, owed, unsent).await?;
        }
        while let Some(owed) = self.queue.take_owed() {
            self.pay(&mut connection, owed, unsent).await?;
        }
        self.queue.mirrored(Mirror::end);
        while let Some(owed) = self.queue.take_owed() {
            self.pay(&mut connection, owed, unsent).await?;
        }
        connection.publish(self.status(OFFLINE), found).await?;
        connection.end().await
    }

    async fn pay(
        &self,
        connection: &mut BrokerConnection,
        owed: PendingDelivery,
        unsent: &mut Option<NoticeBatch>,
    ) -> Result<(), BrokerError> {
        let found = |message: ReceivedMessage| self.found(&message);
        match owed {
            PendingDelivery::State(topic, alert) => {
                let message = alert.as_deref().map(body::of_alert).unwrap_or_default();
                let message = OutgoingMessage { retain: true, ..self.json(&topic, message) };
                match connection.publish(message, found).await? {
                    PublishResult::Taken if alert.is_none() => {
                        self.queue.mirrored(|mirror| mirror.cleared(&topic));
                    }
                    PublishResult::Taken => {}
                    PublishResult::Refused(why) => _ = self.queue.fails(why),
                }
            }
            PendingDelivery::Event(batch) => {
                let id = batch.id(&self.run);
                let message = self.event(body::of_batch(&batch, &id, &self.site));
                *unsent = Some(batch);
                let answer = match connection.publish(message, found).await? {
                    PublishResult::Taken => DeliveryResult::Taken,
                    PublishResult::Refused(why) => DeliveryResult::Refused { why },
                };
                unsent.take().map(|batch| self.queue.settle(batch, answer));
            }
        }
        Ok(())
    }

    /// Handles a retained message of the broker.
    fn found(&self, message: &ReceivedMessage) {
        if !message.retain || message.payload.is_empty() {
            return;
        }
        let Ok(topic) = str::from_utf8(&message.topic) else { return };
        let end = topic.strip_prefix(&*self.prefix).and_then(|topic| topic.strip_prefix('/'));
        self.queue.mirrored(|mirror| end.into_iter().for_each(|topic| mirror.found(topic)));
    }

    /// Subscription to all retained alerts.
    fn retained(&self) -> Subscription {
        Subscription { filter: self.topic("alerts/+/+"), nolocal: true, retained: true }
    }

    fn status(&self, status: &str) -> OutgoingMessage {
        let (topic, payload) = (self.topic("status"), status.into());
        OutgoingMessage { topic, payload, retain: true, ..OutgoingMessage::default() }
    }

    fn event(&self, body: Vec<u8>) -> OutgoingMessage {
        self.json("alerts/events", body)
    }

    fn json(&self, topic: &str, payload: Vec<u8>) -> OutgoingMessage {
        OutgoingMessage { topic: self.topic(topic), payload, is_json: true, ..OutgoingMessage::default() }
    }

    fn topic(&self, end: &str) -> String {
        format!("{}/{end}", self.prefix)
    }
}

#[cfg(test)]
#[cfg(feature = "mqtt")]
mod tests {
    use tokio::sync::watch;

    use super::super::outbox::NoticeOutbox;
    use super::super::selection::NoticeSelection;
    use super::*;
    use crate::live::Severity;
    use crate::net::mqtt::scripted::pings_while_flooded;

    #[tokio::test]
    async fn busy_broker_gets_pings_within_the_keep_alive() {
        let (closing, closed) = watch::channel(false);
        let pings = pings_while_flooded("north/alerts/area/area-1", |port| async move {
            let selection = NoticeSelection::new("mqtt".to_owned(), None, Severity::Warning);
            let broker = Broker {
                queue: Arc::new(NoticeQueue::new(
                    "mqtt".to_owned(),
                    NoticeOutbox::new(selection, Some(Mirror::default())),
                )),
                dial: Dialer::plain("127.0.0.1", port),
                client_id: "test".to_owned(),
                login: None,
                prefix: "north".to_owned(),
                site: "north".to_owned(),
                run: "run".to_owned(),
            };
            broker.deliver(closed).await;
        });
        let pings = pings.await;
        // The first ping is sent when the connection begins.
        assert!(pings >= 3, "{pings} pings");
        drop(closing);
    }
}
