//! Stands in for the connection to a broker in a program that was built without MQTT.

use std::convert::Infallible;

use tokio::time::Instant;

use super::dial::Dialer;

#[expect(dead_code, reason = "no message is sent or received")]
mod message;

pub(crate) use message::{
    ClientIdentity, Login, OutgoingMessage, PublishResult, ReceivedMessage, Subscription,
};

/// Reason why no connection is opened.
#[derive(Debug, thiserror::Error)]
#[error("this program was built without MQTT")]
pub(crate) struct BrokerError;

/// A connection that cannot be opened.
pub(crate) struct BrokerConnection(Infallible);

/// Defines methods of a connection that does not exist.
macro_rules! absent {
    ($($name:ident($($argument:ty),*) -> $result:ty;)*) => {
        $(pub async fn $name(&mut self, $(_: $argument),*) -> Result<$result, BrokerError> {
            match self.0 {}
        })*
    };
}

impl BrokerConnection {
    pub async fn open(_: &Dialer, _: ClientIdentity<'_>) -> Result<Self, BrokerError> {
        Err(BrokerError)
    }

    absent! {
        publish(OutgoingMessage, impl FnMut(ReceivedMessage)) -> PublishResult;
        send(OutgoingMessage) -> bool;
        subscribe(Subscription) -> ();
        subscribed(Subscription, impl FnMut(ReceivedMessage)) -> ();
        ping(impl FnMut(ReceivedMessage)) -> ();
        listen() -> Option<ReceivedMessage>;
    }

    pub const fn ping_due(&self) -> Instant {
        match self.0 {}
    }

    pub async fn end(self) -> Result<(), BrokerError> {
        match self.0 {}
    }
}
