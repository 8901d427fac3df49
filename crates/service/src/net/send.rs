//! UDP output.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::sync::{Mutex, PoisonError};

use socket2::{Domain, Protocol, Socket, Type};

use crate::current::Current;
use site::config::{Address, Feed, Sink};

/// One socket per destination, shared by clones. Sending never waits: a datagram that cannot be sent at once is an error.
#[derive(Clone, Debug)]
pub struct UdpDestinations(Current<Vec<OpenDestination>>);

#[derive(Debug)]
struct OpenDestination {
    sink: Sink,
    /// Never contended: only the engine's thread sends.
    socket: Mutex<UdpSocket>,
}

impl UdpDestinations {
    /// Opens the destinations.
    ///
    /// # Errors
    /// No socket is available, or the interface of a group does not exist; the error names the destination.
    pub fn open(sinks: &[Sink]) -> io::Result<Self> {
        Ok(Self(open_all(sinks)?.into()))
    }

    /// Replaces the destinations, with new sockets.
    ///
    /// # Errors
    /// As for [`UdpDestinations::open`]; the old destinations then stay.
    pub fn reopen(&self, sinks: &[Sink]) -> io::Result<()> {
        self.0.replace(open_all(sinks)?);
        Ok(())
    }

    /// Sends a datagram to all destinations; returns the number of failures.
    pub fn send(&self, datagram: &[u8]) -> u64 {
        self.send_to(|_| true, datagram)
    }

    /// Sends a datagram to the destinations of this feed; returns the number of failures.
    pub fn send_of(&self, feed: Feed, datagram: &[u8]) -> u64 {
        self.send_to(|sink| sink.feed() == feed, datagram)
    }

    fn send_to(&self, is_wanted: impl Fn(&Sink) -> bool, datagram: &[u8]) -> u64 {
        let failed = |opened: &&OpenDestination| is_wanted(&opened.sink) && opened.send(datagram).is_err();
        self.0.get().iter().filter(failed).count() as u64
    }

    /// Whether any destination wants this feed.
    pub fn want(&self, feed: Feed) -> bool {
        self.0.get().iter().any(|opened| opened.sink.feed() == feed)
    }
}

impl OpenDestination {
    /// Sends a datagram. A socket identifies its interface by number: after the interface has gone and come back, a new
    /// socket is needed.
    fn send(&self, datagram: &[u8]) -> io::Result<usize> {
        let to = destination(&self.sink);
        let mut socket = self.socket.lock().unwrap_or_else(PoisonError::into_inner);
        match socket.send_to(datagram, to) {
            Err(error) if error.kind() != io::ErrorKind::WouldBlock => {
                *socket = open(&self.sink)?;
                socket.send_to(datagram, to)
            }
            sent => sent,
        }
    }
}

fn open_all(sinks: &[Sink]) -> io::Result<Vec<OpenDestination>> {
    let opened = |sink: &Sink| {
        let named = |error: io::Error| {
            io::Error::new(error.kind(), format!("output to {}: {error}", destination(sink)))
        };
        Ok(OpenDestination { socket: open(sink).map_err(named)?.into(), sink: *sink })
    };
    sinks.iter().map(opened).collect()
}

fn destination(sink: &Sink) -> SocketAddrV4 {
    let to = match sink.address {
        Address::Multicast { group, .. } => group,
        Address::Unicast(address) => address,
    };
    SocketAddrV4::new(to, sink.port)
}

fn open(sink: &Sink) -> io::Result<UdpSocket> {
    let interface = match sink.address {
        Address::Multicast { interface, .. } => Some(interface),
        Address::Unicast(_) => None,
    };
    socket(interface, sink.ttl)
}

/// A socket for sending; multicast is sent from `interface`.
///
/// # Errors
/// No socket is available, or the interface does not exist.
pub fn socket(interface: Option<Ipv4Addr>, ttl: u8) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_nonblocking(true)?;
    if let Some(interface) = interface {
        socket.set_multicast_if_v4(&interface)?;
        socket.set_multicast_ttl_v4(ttl.into())?;
        socket.set_multicast_loop_v4(true)?;
    } else {
        socket.set_ttl_v4(ttl.into())?;
    }
    // With the loopback interface, neither datagrams nor the sender's address leave this machine.
    let from = interface.filter(Ipv4Addr::is_loopback).unwrap_or(Ipv4Addr::UNSPECIFIED);
    socket.bind(&SocketAddrV4::new(from, 0).into())?;
    Ok(socket.into())
}

/// A socket whose datagrams stay on this machine: multicast from `interface`, or unicast without it. `from` is its own
/// address. Sending waits.
///
/// # Errors
/// No socket is available, the interface does not exist, or `from` is not an address of this machine.
pub fn local_socket(interface: Option<Ipv4Addr>, from: Ipv4Addr) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    if let Some(interface) = interface {
        socket.set_multicast_if_v4(&interface)?;
        // The system loops datagrams back, and sends them to no network.
        socket.set_multicast_ttl_v4(0)?;
        socket.set_multicast_loop_v4(true)?;
    }
    socket.bind(&SocketAddrV4::new(from, 0).into())?;
    Ok(socket.into())
}
