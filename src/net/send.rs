//! Datagrams out.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::sync::{Mutex, PoisonError};

use socket2::{Domain, Protocol, Socket, Type};

use crate::config::{Address, Feed, Sink};
use crate::current::Current;

/// A socket for each destination, shared by clones. Sending never waits: what cannot be sent at once is an error.
#[derive(Clone, Debug)]
pub struct Sinks(Current<Vec<Opened>>);

#[derive(Debug)]
struct Opened {
    sink: Sink,
    /// Only the engine's thread sends, so nobody waits for it.
    socket: Mutex<UdpSocket>,
}

impl Sinks {
    /// Opens them.
    ///
    /// # Errors
    /// No socket, or the interface of a group is not there; the error names the destination.
    pub fn open(sinks: &[Sink]) -> io::Result<Self> {
        Ok(Self(open_all(sinks)?.into()))
    }

    /// Sends to these from now on, through new sockets.
    ///
    /// # Errors
    /// As [`Sinks::open`]; the old ones stay.
    pub fn reopen(&self, sinks: &[Sink]) -> io::Result<()> {
        self.0.replace(open_all(sinks)?);
        Ok(())
    }

    /// Sends a datagram to all; returns how many of these failed.
    pub fn send(&self, datagram: &[u8]) -> u64 {
        self.send_to(|_| true, datagram)
    }

    /// Sends a datagram of this feed to those that want it; returns how many of these failed.
    pub fn send_of(&self, feed: Feed, datagram: &[u8]) -> u64 {
        self.send_to(|sink| sink.feed() == feed, datagram)
    }

    fn send_to(&self, is_wanted: impl Fn(&Sink) -> bool, datagram: &[u8]) -> u64 {
        let failed = |opened: &&Opened| is_wanted(&opened.sink) && opened.send(datagram).is_err();
        self.0.get().iter().filter(failed).count() as u64
    }

    /// Whether anybody wants this feed.
    pub fn want(&self, feed: Feed) -> bool {
        self.0.get().iter().any(|opened| opened.sink.feed() == feed)
    }
}

impl Opened {
    /// A socket knows its interface by number: where that went and came back, only a new one reaches it.
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

fn open_all(sinks: &[Sink]) -> io::Result<Vec<Opened>> {
    let opened = |sink: &Sink| {
        let named = |error: io::Error| {
            io::Error::new(error.kind(), format!("output to {}: {error}", destination(sink)))
        };
        Ok(Opened { socket: open(sink).map_err(named)?.into(), sink: *sink })
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

/// A socket that sends: multicast from `interface`.
///
/// # Errors
/// No socket, or no such interface.
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
    // From the loopback interface nothing leaves this machine, nor does its address.
    let from = interface.filter(Ipv4Addr::is_loopback).unwrap_or(Ipv4Addr::UNSPECIFIED);
    socket.bind(&SocketAddrV4::new(from, 0).into())?;
    Ok(socket.into())
}

/// A socket whose datagrams stay on this machine: multicast from `interface`, or unicast where that is `None`. `from` is its own
/// address. Sending waits.
///
/// # Errors
/// No socket, no such interface, or `from` is no address of this machine.
pub fn local_socket(interface: Option<Ipv4Addr>, from: Ipv4Addr) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    if let Some(interface) = interface {
        socket.set_multicast_if_v4(&interface)?;
        // The system loops it back, and sends it on no network.
        socket.set_multicast_ttl_v4(0)?;
        socket.set_multicast_loop_v4(true)?;
    }
    socket.bind(&SocketAddrV4::new(from, 0).into())?;
    Ok(socket.into())
}
