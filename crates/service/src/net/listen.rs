//! Input lines: one UDP socket for each group (or address), port and interface. A connection to a receiver or gateway is a
//! line, too.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use socket2::{Domain, Protocol, Socket, Type};

use fusion::time::Time;
use site::config::{Address, Config, Connection, ConnectionFormat};

/// Receive buffer of a line in the kernel, in octets: two seconds of the busiest sensors.
pub const RECEIVE_BUFFER: usize = 8 << 20;
/// Size of the largest datagram, in octets.
const DATAGRAM_MAX: usize = 1 << 16;

/// Path to which gateways post lines of Remote ID.
pub const POSTED_TO: &str = "/api/v1/remote-id";

/// An input line, and its sensors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfiguredLine {
    /// The group to join, or the local address to bind.
    pub address: Address,
    /// UDP port.
    pub port: u16,
    /// Accepted senders; empty: all.
    pub sources: Vec<Ipv4Addr>,
    /// Indices of the sensors in the configuration.
    pub sensors: Vec<usize>,
    /// Connection of the line, if it is not a plain UDP socket.
    pub connection: Option<Connection>,
}

/// A datagram received on a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Index of the line.
    pub line: usize,
    /// Time at which it was read from the socket.
    pub received: Time,
    /// Sender.
    pub from: SocketAddrV4,
    /// The datagram.
    pub payload: Vec<u8>,
}

/// Counters of a line; written by its task.
#[derive(Debug, Default)]
pub struct LineCounters {
    /// Datagrams passed on.
    pub received: AtomicU64,
    /// Datagrams from a source that is not configured.
    pub foreign: AtomicU64,
    /// Datagrams lost because the engine's queue was full.
    pub queue_full: AtomicU64,
    /// Datagrams that the kernel dropped because they were not read in time.
    pub kernel_dropped: AtomicU64,
    /// Inode of the open socket, and the kernel's drop count of this socket; 0 if unknown.
    socket: AtomicU64,
    dropped_there: AtomicU64,
    /// Whether the socket is open and the group joined.
    pub joined: AtomicBool,
    /// Time of the last datagram, in nanoseconds since the epoch; 0 before the first.
    pub last_received: AtomicI64,
    /// Datagrams that the engine has handled; counted only for the line that gateways post to.
    pub handled: AtomicU64,
    /// Number of items that the translator dropped, by reason.
    untranslated: Mutex<Vec<(&'static str, u64)>>,
}

impl LineCounters {
    fn count(&self, handed_on: bool) {
        let counter = if handed_on { &self.received } else { &self.queue_full };
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Sets the number of items that the translator dropped so far.
    pub fn note_untranslated(&self, reasons: impl Iterator<Item = (&'static str, u64)>) {
        let mut noted = self.untranslated.lock().unwrap_or_else(PoisonError::into_inner);
        noted.clear();
        noted.extend(reasons);
    }

    /// Number of items that the translator dropped, by reason; empty without a translator.
    pub fn untranslated(&self) -> Vec<(&'static str, u64)> {
        self.untranslated.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Counts a datagram, and whether it was passed on.
    pub fn note(&self, received: Time, handed_on: bool) {
        self.last_received.store(received.nanos(), Ordering::Relaxed);
        self.count(handed_on);
    }

    /// Records that this socket was just opened.
    pub fn opened(&self, socket: &UdpSocket) {
        self.socket.store(inode(socket).unwrap_or(0), Ordering::Relaxed);
        self.dropped_there.store(0, Ordering::Relaxed);
    }

    /// Updates the kernel's drop count from `table`, its table of UDP sockets.
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

/// Inode of a socket, its key in the kernel's table.
fn inode(socket: &UdpSocket) -> Option<u64> {
    let link = std::fs::read_link(format!("/proc/self/fd/{}", socket.as_raw_fd())).ok()?;
    link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.parse().ok()
}

/// Number of datagrams dropped on a socket: the last column of its line, in which the inode is the tenth.
fn kernel_drops(table: &str, inode: u64) -> Option<u64> {
    let is_it =
        |line: &&str| line.split_whitespace().nth(9).is_some_and(|column| column.parse() == Ok(inode));
    table.lines().skip(1).find(is_it)?.split_whitespace().next_back()?.parse().ok()
}

/// Lines of a configuration. Inputs with the same group, port and interface share a socket.
pub fn lines(config: &Config) -> Vec<ConfiguredLine> {
    let mut lines: Vec<ConfiguredLine> = Vec::new();
    for (sensor, of) in config.sensors.iter().enumerate() {
        for input in &of.inputs {
            let same = |line: &&mut ConfiguredLine| {
                line.connection.is_none() && line.address == input.address && line.port == input.port
            };
            match lines.iter_mut().find(same) {
                Some(line) => {
                    // An input without a source accepts all senders.
                    match input.source {
                        Some(source) if !line.sources.is_empty() => line.sources.push(source),
                        _ => line.sources.clear(),
                    }
                    line.sensors.push(sensor);
                }
                None => lines.push(ConfiguredLine {
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
            // All posted lines use the same route.
            if let Some(line) = lines.iter_mut().find(|line| posted && line.is_posted()) {
                if !line.sensors.contains(&sensor) {
                    line.sensors.push(sensor);
                }
                continue;
            }
            // Messages of one MAVLink port may belong to sensors of different kinds.
            let is_shared = |line: &&mut ConfiguredLine| {
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
            lines.push(ConfiguredLine {
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

impl ConfiguredLine {
    /// Opens the socket, non-blocking, and joins the group. Also returns the size of its receive buffer in octets, which
    /// the system may have reduced.
    ///
    /// # Errors
    /// The address does not belong to this machine, another user holds the port, or the interface does not exist.
    pub fn open(&self) -> io::Result<(UdpSocket, usize)> {
        let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
        socket.set_nonblocking(true)?;
        // Several processes may listen to one group.
        socket.set_reuse_address(true)?;
        socket.set_recv_buffer_size(RECEIVE_BUFFER)?;
        socket.bind(&self.destination().into())?;
        self.join(&socket)?;
        // Linux reports twice the requested size, including its own overhead.
        let buffer = socket.recv_buffer_size()? / if cfg!(target_os = "linux") { 2 } else { 1 };
        Ok((socket.into(), buffer))
    }

    /// Destination address of the line's datagrams.
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

    /// Whether datagrams from this sender are accepted.
    pub fn accepts(&self, from: Ipv4Addr) -> bool {
        self.sources.is_empty() || self.sources.contains(&from)
    }

    /// Whether the line is a UDP socket.
    pub fn is_udp(&self) -> bool {
        self.connection.as_ref().is_none_or(Connection::is_listener)
    }

    /// Whether gateways post to the line over HTTP.
    pub fn is_posted(&self) -> bool {
        self.connection.as_ref().is_some_and(|connection| connection.format == ConnectionFormat::Http)
    }

    /// Name for display: `239.192.48.1:8048 on 127.0.0.1`, or `beast 127.0.0.1:30005`.
    pub fn name(&self) -> String {
        if let Some(Connection { address, topic, .. }) =
            self.connection.as_ref().filter(|of| of.is_subscription())
        {
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

/// Reads a line until its socket fails. Passes each datagram to `hand_on`, which returns `false` if it was lost. Cancelling
/// loses no datagram.
///
/// # Errors
/// The socket failed; for example, the interface has gone.
pub async fn read(
    socket: &tokio::net::UdpSocket,
    index: usize,
    line: &ConfiguredLine,
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

/// Reads the datagrams waiting in the kernel for a line that is about to be closed, while `goes_on` returns `true`.
/// `hand_on` is as in [`read`]. Returns whether all were read.
///
/// # Errors
/// The socket failed.
pub fn drain(
    socket: &UdpSocket,
    index: usize,
    line: &ConfiguredLine,
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

/// An accepted datagram; `None` from another source, which is counted as foreign.
fn arrival(
    (index, line): (usize, &ConfiguredLine),
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
    fn kernel_drops_are_counted_per_socket() {
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
    fn unread_datagrams_are_dropped_and_counted() {
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
