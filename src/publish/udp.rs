//! Datagrams out.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};

use socket2::{Domain, Protocol, Socket, Type};

use crate::config::{Address, Sink};
use crate::current::Current;

/// A socket for each destination; clones send to the same ones. Sending never waits: what cannot be sent at once is an
/// error.
#[derive(Clone, Debug)]
pub struct Sinks(Current<Vec<Destination>>);

type Destination = (UdpSocket, SocketAddrV4);

impl Sinks {
    /// Opens them.
    ///
    /// # Errors
    /// No socket, or the interface of a group is not there; the error names the destination.
    pub fn open(sinks: &[Sink]) -> io::Result<Self> {
        let opened: Vec<Destination> = sinks.iter().map(open).collect::<io::Result<_>>()?;
        Ok(Self(opened.into()))
    }

    /// Sends to these from now on, through new sockets.
    ///
    /// # Errors
    /// As [`Sinks::open`]; the old ones stay.
    pub fn reopen(&self, sinks: &[Sink]) -> io::Result<()> {
        self.0.replace(sinks.iter().map(open).collect::<io::Result<_>>()?);
        Ok(())
    }

    /// Sends a datagram to all; how many of them failed.
    pub fn send(&self, datagram: &[u8]) -> u64 {
        let failed = |(socket, to): &&Destination| socket.send_to(datagram, *to).is_err();
        self.0.get().iter().filter(failed).count() as u64
    }
}

fn open(sink: &Sink) -> io::Result<Destination> {
    let (interface, to) = match sink.address {
        Address::Multicast { group, interface } => (Some(interface), group),
        Address::Unicast(address) => (None, address),
    };
    let to = SocketAddrV4::new(to, sink.port);
    let socket = socket(interface, sink.ttl)
        .map_err(|error| io::Error::new(error.kind(), format!("output to {to}: {error}")))?;
    Ok((socket, to))
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
