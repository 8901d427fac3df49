//! Values that callers exchange with the connection to a broker.

use bytes::Bytes;

/// User name and password of the client.
#[derive(Clone)]
pub(crate) struct Login {
    pub username: String,
    pub password: String,
}

/// Identity of the client.
pub(crate) struct ClientIdentity<'a> {
    pub client_id: &'a str,
    pub login: Option<Login>,
    /// Last will: the broker publishes it at QoS 1, without format and expiry, when the connection is lost.
    pub will: Option<OutgoingMessage>,
}

/// A message to be published.
#[derive(Default)]
pub(crate) struct OutgoingMessage {
    pub topic: String,
    pub payload: Vec<u8>,
    /// Whether the broker keeps the message for new subscribers.
    pub retain: bool,
    /// Whether the payload is declared as JSON.
    pub is_json: bool,
    /// Expiry at the broker, in seconds.
    pub expiry_s: Option<u32>,
}

/// Result of a publication.
pub(crate) enum PublishResult {
    Taken,
    Refused(String),
}

/// Subscription at QoS 0.
pub(crate) struct Subscription {
    /// Topic filter.
    pub filter: String,
    /// Whether the client's own messages are not sent back.
    pub nolocal: bool,
    /// Whether the broker sends the messages that it has retained.
    pub retained: bool,
}

/// A message received by subscription.
pub(crate) struct ReceivedMessage {
    pub topic: Bytes,
    pub payload: Bytes,
    /// Whether the broker had retained the message.
    pub retain: bool,
}
