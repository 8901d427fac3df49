//! UDP lines: one socket a group (or address), port and interface.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use socket2::{Domain, Protocol, Socket, Type};

use crate::config::{Address, Config};
use crate::time::Time;

/// What the kernel keeps for a line until it is read, octets: two seconds of the busiest sensors.
pub const RECEIVE_BUFFER: usize = 8 << 20;

/// A socket to be opened, and the sensors that are heard on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The group to join, or the local address to bind.
    pub address: Address,
    /// UDP port.
    pub port: u16,
    /// Only datagrams from here count; empty: from anywhere.
    pub sources: Vec<Ipv4Addr>,
    /// Indices of the configuration's sensors.
    pub sensors: Vec<usize>,
}

/// What came on a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Index of the line.
    pub line: usize,
    /// When it was read from the socket.
    pub received: Time,
    /// Who sent it.
    pub from: SocketAddrV4,
    /// The datagram.
    pub payload: Vec<u8>,
}

/// What a line has counted; written by the line's task, read by anyone.
#[derive(Debug, Default)]
pub struct LineCounters {
    /// Datagrams handed on.
    pub received: AtomicU64,
    /// Datagrams from a source that is not configured.
    pub foreign: AtomicU64,
    /// Datagrams lost because the engine's queue was full.
    pub queue_full: AtomicU64,
    /// Datagrams that the kernel dropped because nobody read them in time.
    pub kernel_dropped: AtomicU64,
    /// Whether the socket is open and the group joined.
    pub joined: AtomicBool,
    /// The last datagram, nanoseconds since the epoch; 0: none yet.
    pub last_received: AtomicI64,
}

/// The lines of a configuration: inputs that share group, port and interface share a socket.
pub fn lines(config: &Config) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (sensor, of) in config.sensors.iter().enumerate() {
        for input in &of.inputs {
            let same = |line: &&mut Line| line.address == input.address && line.port == input.port;
            match lines.iter_mut().find(same) {
                Some(line) => {
                    // Who does not name a source hears all.
                    match input.source {
                        Some(source) if !line.sources.is_empty() => line.sources.push(source),
                        _ => line.sources.clear(),
                    }
                    line.sensors.push(sensor);
                }
                None => lines.push(Line {
                    address: input.address,
                    port: input.port,
                    sources: input.source.into_iter().collect(),
                    sensors: vec![sensor],
                }),
            }
        }
    }
    lines
}

impl Line {
    /// Opens the socket and joins the group; non-blocking. Also the octets of its receive buffer, which the system may
    /// have made smaller than asked for.
    ///
    /// # Errors
    /// The address is not of this machine, the port is taken by another user, or the interface is not there.
    pub fn open(&self) -> io::Result<(UdpSocket, usize)> {
        let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
        socket.set_nonblocking(true)?;
        // Several processes may listen to one group.
        socket.set_reuse_address(true)?;
        socket.set_recv_buffer_size(RECEIVE_BUFFER)?;
        let bound = match self.address {
            Address::Multicast { group, .. } => group,
            Address::Unicast(address) => address,
        };
        socket.bind(&SocketAddrV4::new(bound, self.port).into())?;
        self.join(&socket)?;
        // Linux tells twice what it was asked for, for its own book-keeping.
        let buffer = socket.recv_buffer_size()? / if cfg!(target_os = "linux") { 2 } else { 1 };
        Ok((socket.into(), buffer))
    }

    fn join(&self, socket: &Socket) -> io::Result<()> {
        let Address::Multicast { group, interface } = self.address else { return Ok(()) };
        if self.sources.is_empty() {
            return socket.join_multicast_v4(&group, &interface);
        }
        self.sources.iter().try_for_each(|source| socket.join_ssm_v4(source, &group, &interface))
    }

    /// Whether a datagram from there counts.
    pub fn accepts(&self, from: Ipv4Addr) -> bool {
        self.sources.is_empty() || self.sources.contains(&from)
    }

    /// `239.192.48.1:8048 on 127.0.0.1`, for people.
    pub fn name(&self) -> String {
        match self.address {
            Address::Multicast { group, interface } => format!("{group}:{} on {interface}", self.port),
            Address::Unicast(address) => format!("{address}:{}", self.port),
        }
    }
}

/// Reads a line until its socket fails, handing each datagram to `hand_on`, which is `false` where it was lost.
///
/// # Errors
/// The socket failed: the interface is gone, for example.
pub async fn read(
    socket: &tokio::net::UdpSocket,
    index: usize,
    line: &Line,
    counters: &LineCounters,
    now: impl Fn() -> Time,
    mut hand_on: impl FnMut(Arrival) -> bool,
) -> io::Result<()> {
    let mut buffer = vec![0; 1 << 16];
    loop {
        let (length, from) = socket.recv_from(&mut buffer).await?;
        let received = now();
        let SocketAddr::V4(from) = from else { continue };
        if !line.accepts(*from.ip()) {
            counters.foreign.fetch_add(1, Ordering::Relaxed);
            continue;
        }
        counters.last_received.store(received.nanos(), Ordering::Relaxed);
        let arrival = Arrival { line: index, received, from, payload: buffer[..length].to_vec() };
        let counter = if hand_on(arrival) { &counters.received } else { &counters.queue_full };
        counter.fetch_add(1, Ordering::Relaxed);
    }
}
