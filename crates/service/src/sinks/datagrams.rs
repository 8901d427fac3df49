//! Sinks over UDP: each message is a datagram, to a group or a host.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use tokio::net::UdpSocket;
use tokio::time::sleep;

use super::counts::SinkLoss;
use super::delivery::SinkQueue;
use super::second::PictureSecond;
use crate::net::peers::{Closing, closed};
use crate::net::send::socket;

/// Number of datagrams sent at once, and the pause between two such lots. A city's traffic then does not overflow a
/// receiver's buffer, and 10,000 messages are still sent within a second.
const LOT: usize = 32;
const PAUSE: Duration = Duration::from_millis(2);

/// Converts a second's picture to messages.
pub(super) type MessageEncoder = Box<dyn FnMut(&PictureSecond) -> Vec<Vec<u8>> + Send>;

/// A sink over UDP.
pub(super) struct DatagramSink {
    pub(super) queue: Arc<SinkQueue>,
    pub(super) to: SocketAddrV4,
    /// Interface for multicast.
    pub(super) interface: Option<Ipv4Addr>,
    pub(super) ttl: u8,
    pub(super) messages: MessageEncoder,
}

impl std::fmt::Debug for DatagramSink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Datagrams").field("queue", &self.queue).field("to", &self.to).finish_non_exhaustive()
    }
}

impl DatagramSink {
    /// Sends until the service ends.
    pub(super) async fn deliver(mut self, mut closing: Closing) {
        let mut opened = None;
        loop {
            let second = tokio::select! {
                second = self.queue.next() => second,
                () = closed(&mut closing) => match self.queue.take() {
                    Some(second) => second,
                    None => return,
                },
            };
            if let Err(error) = self.send(&second, &mut opened).await {
                // A socket identifies its interface by number: after the interface has gone and come back, a new socket is
                // needed.
                opened = None;
                let wait = self.queue.fails(error.to_string(), Some(SinkLoss::Unreachable));
                tokio::select! {
                    () = sleep(wait) => {}
                    () = closed(&mut closing) => {}
                }
            }
        }
    }

    /// Whether a socket can be opened.
    pub(super) async fn reach(&self) -> Result<(), String> {
        self.open().map(drop).map_err(|error| error.to_string())
    }

    fn open(&self) -> io::Result<UdpSocket> {
        UdpSocket::from_std(socket(self.interface, self.ttl)?)
    }

    async fn send(&mut self, second: &PictureSecond, opened: &mut Option<UdpSocket>) -> io::Result<()> {
        let socket = match opened {
            Some(socket) => socket,
            None => opened.insert(self.open()?),
        };
        for lot in (self.messages)(second).chunks(LOT) {
            for message in lot {
                socket.send_to(message, self.to).await?;
                self.queue.sent(1);
            }
            if lot.len() == LOT {
                sleep(PAUSE).await;
            }
        }
        self.queue.works();
        Ok(())
    }
}
