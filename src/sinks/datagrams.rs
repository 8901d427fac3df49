//! Sinks over UDP: each message a datagram, to a group or a host.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use tokio::net::UdpSocket;
use tokio::time::sleep;

use super::counts::Loss;
use super::desk::Desk;
use super::second::Second;
use crate::net::peers::{Closing, closed};
use crate::net::send::socket;

/// Datagrams that are sent at once, and the pause between two such lots: a receiver's buffer is not run over by a city's
/// traffic, and 10,000 messages are still sent in a second.
const LOT: usize = 32;
const PAUSE: Duration = Duration::from_millis(2);

/// What a format makes of a second: each message by itself.
pub(super) type Messages = Box<dyn FnMut(&Second) -> Vec<Vec<u8>> + Send>;

/// One sink.
pub(super) struct Datagrams {
    pub(super) desk: Arc<Desk>,
    pub(super) to: SocketAddrV4,
    /// Where a group is reached.
    pub(super) interface: Option<Ipv4Addr>,
    pub(super) ttl: u8,
    pub(super) messages: Messages,
}

impl std::fmt::Debug for Datagrams {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Datagrams").field("desk", &self.desk).field("to", &self.to).finish_non_exhaustive()
    }
}

impl Datagrams {
    /// Sends what comes until the service ends.
    pub(super) async fn deliver(mut self, mut closing: Closing) {
        let mut opened = None;
        loop {
            let second = tokio::select! {
                second = self.desk.next() => second,
                () = closed(&mut closing) => match self.desk.take() {
                    Some(second) => second,
                    None => return,
                },
            };
            if let Err(error) = self.send(&second, &mut opened).await {
                // A socket knows its interface by number: where that went and came back, only a new one reaches it.
                opened = None;
                let wait = self.desk.fails(error.to_string(), Some(Loss::Unreachable));
                tokio::select! {
                    () = sleep(wait) => {}
                    () = closed(&mut closing) => {}
                }
            }
        }
    }

    /// Whether it can be sent to.
    pub(super) async fn reach(&self) -> Result<(), String> {
        self.open().map(drop).map_err(|error| error.to_string())
    }

    fn open(&self) -> io::Result<UdpSocket> {
        UdpSocket::from_std(socket(self.interface, self.ttl)?)
    }

    async fn send(&mut self, second: &Second, opened: &mut Option<UdpSocket>) -> io::Result<()> {
        let socket = match opened {
            Some(socket) => socket,
            None => opened.insert(self.open()?),
        };
        for lot in (self.messages)(second).chunks(LOT) {
            for message in lot {
                socket.send_to(message, self.to).await?;
                self.desk.sent(1);
            }
            if lot.len() == LOT {
                sleep(PAUSE).await;
            }
        }
        self.desk.works();
        Ok(())
    }
}
