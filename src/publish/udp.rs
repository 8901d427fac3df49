//! Datagrams out.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};

use socket2::{Domain, Protocol, Socket, Type};

use crate::config::{Address, Sink};

/// A socket for each destination. Sending never waits: what cannot be sent at once is an error.
#[derive(Debug)]
pub struct Sinks(Vec<(UdpSocket, SocketAddrV4)>);

impl Sinks {
    /// Opens them.
    ///
    /// # Errors
    /// No socket, or the interface of a group is not there; the error names the destination.
    pub fn open(sinks: &[Sink]) -> io::Result<Self> {
        let open = |sink: &Sink| {
            let (interface, to) = match sink.address {
                Address::Multicast { group, interface } => (Some(interface), group),
                Address::Unicast(address) => (None, address),
            };
            let to = SocketAddrV4::new(to, sink.port);
            let socket = socket(interface, sink.ttl)
                .map_err(|error| io::Error::new(error.kind(), format!("output to {to}: {error}")))?;
            Ok((socket, to))
        };
        sinks.iter().map(open).collect::<io::Result<_>>().map(Self)
    }

    /// Sends a datagram to all; how many of them failed.
    pub fn send(&self, datagram: &[u8]) -> u64 {
        let failed = |(socket, to): &&(UdpSocket, SocketAddrV4)| socket.send_to(datagram, *to).is_err();
        self.0.iter().filter(failed).count() as u64
    }
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
