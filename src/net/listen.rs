//! UDP lines: one socket a group (or address), port and interface. A connection to a receiver or gateway is a line, too.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use socket2::{Domain, Protocol, Socket, Type};

use crate::config::{Address, Config, Connection, ConnectionFormat};
use fusion::time::Time;

/// Receive buffer of a line in the kernel, octets: two seconds of the busiest sensors.
pub const RECEIVE_BUFFER: usize = 8 << 20;
/// Room for the largest datagram, octets.
const DATAGRAM_MAX: usize = 1 << 16;

/// Where gateways post lines of Remote ID to.
pub const POSTED_TO: &str = "/api/v1/remote-id";

/// A socket, and the sensors that are heard on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The group to join, or the local address to bind.
    pub address: Address,
    /// UDP port.
    pub port: u16,
    /// The only senders whose datagrams count; empty: all.
    pub sources: Vec<Ipv4Addr>,
    /// Indices of the configuration's sensors.
    pub sensors: Vec<usize>,
    /// What is behind it, where that is no datagrams as the service handles them.
    pub connection: Option<Connection>,
}

/// A datagram that came on a line.
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

/// The counters of a line; written by its task, read by anyone.
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
    /// The socket that is open, by its inode, and what the kernel has dropped on it so far; 0: not known.
    socket: AtomicU64,
    dropped_there: AtomicU64,
    /// Whether the socket is open and the group joined.
    pub joined: AtomicBool,
    /// The last datagram, nanoseconds since the epoch; 0: none yet.
    pub last_received: AtomicI64,
    /// Datagrams that the engine has taken; counted of a line that is posted to.
    pub handled: AtomicU64,
    /// What its translator has dropped, by reason.
    untranslated: Mutex<Vec<(&'static str, u64)>>,
}

impl LineCounters {
    fn count(&self, handed_on: bool) {
        let counter = if handed_on { &self.received } else { &self.queue_full };
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Notes what its translator has dropped so far.
    pub fn note_untranslated(&self, reasons: impl Iterator<Item = (&'static str, u64)>) {
        let mut noted = self.untranslated.lock().unwrap_or_else(PoisonError::into_inner);
        noted.clear();
        noted.extend(reasons);
    }

    /// What its translator has dropped, by reason; empty where there is none.
    pub fn untranslated(&self) -> Vec<(&'static str, u64)> {
        self.untranslated.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Notes a datagram, and whether it was handed on.
    pub fn note(&self, received: Time, handed_on: bool) {
        self.last_received.store(received.nanos(), Ordering::Relaxed);
        self.count(handed_on);
    }

    /// Notes a socket that was just opened.
    pub fn opened(&self, socket: &UdpSocket) {
        self.socket.store(inode(socket).unwrap_or(0), Ordering::Relaxed);
        self.dropped_there.store(0, Ordering::Relaxed);
    }

    /// Notes what the kernel has dropped; `table` is its table of UDP sockets.
    pub fn note_kernel_drops(&self, table: &str) {
        let socket = self.socket.load(Ordering::Relaxed);
        if let Some(dropped) = kernel_drops(table, socket).filter(|_| socket != 0) {
            let before = self.dropped_there.swap(dropped, Ordering::Relaxed);
            self.kernel_dropped.fetch_add(dropped.saturating_sub(before), Ordering::Relaxed);
        }
    }
}

/// The kernel's table of UDP sockets; empty on systems without one.
pub fn kernel_table() -> String {
    String::from_utf8(std::fs::read("/proc/net/udp").unwrap_or_default()).unwrap_or_default()
}

/// The number by which the kernel's table knows a socket.
fn inode(socket: &UdpSocket) -> Option<u64> {
    let link = std::fs::read_link(format!("/proc/self/fd/{}", socket.as_raw_fd())).ok()?;
    link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.parse().ok()
}

/// The datagrams that were dropped on a socket: the last column of its line, in which the inode is the tenth.
fn kernel_drops(table: &str, inode: u64) -> Option<u64> {
    let is_it =
        |line: &&str| line.split_whitespace().nth(9).is_some_and(|column| column.parse() == Ok(inode));
    table.lines().skip(1).find(is_it)?.split_whitespace().next_back()?.parse().ok()
}

/// The lines of a configuration: inputs that share group, port and interface share a socket.
pub fn lines(config: &Config) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (sensor, of) in config.sensors.iter().enumerate() {
        for input in &of.inputs {
            let same = |line: &&mut Line| {
                line.connection.is_none() && line.address == input.address && line.port == input.port
            };
            match lines.iter_mut().find(same) {
                Some(line) => {
                    // An input without a source hears all.
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
                    connection: None,
                }),
            }
        }
        for connection in &of.connections {
            let posted = connection.format == ConnectionFormat::Http;
            // There is one route, whoever's lines are posted to it.
            if let Some(line) = lines.iter_mut().find(|line| posted && line.is_posted()) {
                if !line.sensors.contains(&sensor) {
                    line.sensors.push(sensor);
                }
                continue;
            }
            // Messages of one MAVLink port belong to sensors of different kinds.
            let is_shared = |line: &&mut Line| {
                let kinds = |&index: &usize| config.sensors[index].kind.name();
                let other_kinds = line.sensors.iter().map(kinds).all(|kind| kind != of.kind.name());
                let mavlink = line.connection.as_ref().filter(|of| of.format == ConnectionFormat::Mavlink);
                mavlink.is_some_and(|with| {
                    with.format == connection.format && with.socket() == connection.socket()
                }) && other_kinds
            };
            if let Some(line) = lines.iter_mut().find(is_shared) {
                line.sensors.push(sensor);
                continue;
            }
            let listen = match config.http.listen {
                SocketAddr::V4(listen) => Some(listen),
                SocketAddr::V6(_) => None,
            };
            let socket = if posted { listen } else { connection.socket() };
            lines.push(Line {
                address: Address::Unicast(socket.map_or(Ipv4Addr::UNSPECIFIED, |socket| *socket.ip())),
                port: match socket {
                    Some(socket) => socket.port(),
                    None if posted => config.http.listen.port(),
                    None => connection.broker().map_or(0, |broker| broker.port),
                },
                sources: Vec::new(),
                sensors: vec![sensor],
                connection: Some(connection.clone()),
            });
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
        socket.bind(&self.destination().into())?;
        self.join(&socket)?;
        // Linux tells twice what it was asked for, for its own book-keeping.
        let buffer = socket.recv_buffer_size()? / if cfg!(target_os = "linux") { 2 } else { 1 };
        Ok((socket.into(), buffer))
    }

    /// The destination of the line's datagrams.
    pub fn destination(&self) -> SocketAddrV4 {
        let address = match self.address {
            Address::Multicast { group, .. } => group,
            Address::Unicast(address) => address,
        };
        SocketAddrV4::new(address, self.port)
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

    /// Whether it is a socket for datagrams.
    pub fn is_udp(&self) -> bool {
        self.connection.as_ref().is_none_or(|connection| connection.format == ConnectionFormat::Mavlink)
    }

    /// Whether gateways post to it over HTTP.
    pub fn is_posted(&self) -> bool {
        self.connection.as_ref().is_some_and(|connection| connection.format == ConnectionFormat::Http)
    }

    /// `239.192.48.1:8048 on 127.0.0.1`, or `beast 127.0.0.1:30005`, for people.
    pub fn name(&self) -> String {
        if let Some(Connection { format: ConnectionFormat::Mqtt, address, topic, .. }) = &self.connection {
            return format!("{topic} at {address}");
        }
        if self.is_posted() {
            return format!("POST {POSTED_TO}");
        }
        if let Some(Connection { format, address, .. }) = &self.connection {
            return format!("{} {address}", format.name());
        }
        match self.address {
            Address::Multicast { group, interface } => format!("{group}:{} on {interface}", self.port),
            Address::Unicast(address) => format!("{address}:{}", self.port),
        }
    }
}

/// Reads a line until its socket fails, handing each datagram to `hand_on`, which is `false` where it was lost. Ended
/// between two datagrams it has lost none.
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
    let mut buffer = vec![0; DATAGRAM_MAX];
    loop {
        let (length, from) = socket.recv_from(&mut buffer).await?;
        if let Some(arrival) = arrival((index, line), counters, now(), from, &buffer[..length]) {
            counters.count(hand_on(arrival));
        }
    }
}

/// Reads what waits in the kernel for a line that is about to be closed, while `goes_on`; `hand_on` is as in [`read`].
/// Whether all of it was read.
///
/// # Errors
/// The socket failed.
pub fn drain(
    socket: &UdpSocket,
    index: usize,
    line: &Line,
    counters: &LineCounters,
    now: impl Fn() -> Time,
    mut hand_on: impl FnMut(Arrival) -> bool,
    mut goes_on: impl FnMut() -> bool,
) -> io::Result<bool> {
    let mut buffer = vec![0; DATAGRAM_MAX];
    while goes_on() {
        let (length, from) = match socket.recv_from(&mut buffer) {
            Ok(received) => received,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(true),
            Err(error) => return Err(error),
        };
        if let Some(arrival) = arrival((index, line), counters, now(), from, &buffer[..length]) {
            counters.count(hand_on(arrival));
        }
    }
    Ok(false)
}

/// A datagram that counts; one from another source is counted as foreign.
fn arrival(
    (index, line): (usize, &Line),
    counters: &LineCounters,
    received: Time,
    from: SocketAddr,
    payload: &[u8],
) -> Option<Arrival> {
    let SocketAddr::V4(from) = from else { return None };
    if !line.accepts(*from.ip()) {
        counters.foreign.fetch_add(1, Ordering::Relaxed);
        return None;
    }
    counters.last_received.store(received.nanos(), Ordering::Relaxed);
    Some(Arrival { line: index, received, from, payload: payload.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_are_those_of_the_socket() {
        let table = "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer drops\n\
                     \x20 101: 0130C0EF:1F70 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 71 2 00 12\n\
                     \x20 102: 0130C0EF:1F70 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 72 2 00 5\n";
        assert_eq!([71, 72, 73].map(|inode| kernel_drops(table, inode)), [Some(12), Some(5), None]);
        let counters = LineCounters::default();
        counters.socket.store(72, Ordering::Relaxed);
        counters.note_kernel_drops(table);
        counters.note_kernel_drops(table);
        assert_eq!(counters.kernel_dropped.load(Ordering::Relaxed), 5, "counted once");
    }

    #[test]
    #[expect(clippy::disallowed_methods, reason = "sockets belong here")]
    fn what_nobody_reads_is_dropped_and_counted() {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        if inode(&socket).is_none() {
            return println!("skipped: this system has no table of sockets");
        }
        let counters = LineCounters::default();
        counters.opened(&socket);
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        for _ in 0..2_000 {
            sender.send_to(&[0; 1400], socket.local_addr().unwrap()).unwrap();
        }
        counters.note_kernel_drops(&kernel_table());
        assert!(counters.kernel_dropped.load(Ordering::Relaxed) > 0);
    }
}
