//! Readers of the API: streams that are read to their end, one that is never read, and single requests.
//!
//! Requests are HTTP/1.0, so that the response is plain octets up to the end of the connection.

use std::io::{self, BufRead, BufReader, Read as _, Write};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use fusion::time::Time;
use socket2::{Domain, Socket, Type};
use utm_fusion::live::now;

/// Timeout for a response, or for the next line of a stream.
const PATIENCE: Duration = Duration::from_secs(10);

/// Request of a reader.
pub struct ReaderRequest {
    /// Source address; the number of concurrent streams per address is limited.
    pub from: Ipv4Addr,
    /// `?` and parameters, or empty.
    pub query: String,
}

/// Result of a reader.
#[derive(Debug, Default)]
pub struct ReaderResult {
    /// Total number of octets.
    pub octets: u64,
    /// Number of `tracks` events after the first slot.
    pub slots: u64,
    /// Number of slots between two events that were neither received nor announced as lost.
    pub missing: u64,
    /// Number of `resync` events.
    pub resyncs: u64,
    /// Delays from a slot's publication to its reception here, seconds.
    pub delays_s: Vec<f32>,
    /// Reason for an early end.
    pub failed: Option<String>,
}

/// Reads the stream until `stop`.
pub fn read(address: SocketAddr, request: &ReaderRequest, stop: &AtomicBool) -> ReaderResult {
    let mut read = ReaderResult::default();
    if let Err(error) = follow(address, request, stop, &mut read)
        && !stop.load(Ordering::Relaxed)
    {
        read.failed = Some(format!("{error}, after {} slots", read.slots));
    }
    read
}

fn follow(
    address: SocketAddr,
    request: &ReaderRequest,
    stop: &AtomicBool,
    read: &mut ReaderResult,
) -> io::Result<()> {
    let mut lines = BufReader::with_capacity(
        32 * 1024,
        ask(address, request.from, &format!("/api/v1/stream{}", request.query))?,
    );
    let (mut line, mut event, mut last) = (Vec::new(), Vec::new(), None);
    while !stop.load(Ordering::Relaxed) {
        line.clear();
        if lines.read_until(b'\n', &mut line)? == 0 {
            return Err(io::Error::other("the stream ended"));
        }
        read.octets += line.len() as u64;
        if let Some(name) = line.strip_prefix(b"event: ") {
            event = name.trim_ascii_end().to_vec();
            read.resyncs += u64::from(event == b"resync");
        } else if line.starts_with(b"data: ") && (event == b"tracks" || event == b"snapshot") {
            let head = EventHead::of(&line).ok_or_else(|| io::Error::other("an event without seq"))?;
            if event == b"tracks" {
                read.slots += 1;
                read.delays_s.extend(head.published.map(|published| now().seconds_since(published) as f32));
                read.missing += last.map_or(0, |last| head.seq.saturating_sub(last + 1));
            }
            // A snapshot starts a new sequence.
            last = Some(head.seq);
        }
    }
    Ok(())
}

/// Members before the features.
struct EventHead {
    seq: u64,
    published: Option<Time>,
}

impl EventHead {
    fn of(line: &[u8]) -> Option<Self> {
        let text = str::from_utf8(&line[..line.len().min(512)]).ok()?;
        let behind = |key: &str| text.split_once(key).map(|(_, behind)| behind);
        let seq = behind("\"seq\":")?.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()?;
        let published: Option<jiff::Timestamp> =
            behind("\"published_at\":\"").and_then(|behind| behind.split('"').next()?.parse().ok());
        let published =
            published.and_then(|time| Some(Time::from_nanos(time.as_nanosecond().try_into().ok()?)));
        Some(Self { seq, published })
    }
}

/// Opens a stream and never reads it.
pub fn open_and_never_read(address: SocketAddr, stop: &AtomicBool) {
    let stream = ask(address, Ipv4Addr::LOCALHOST, "/api/v1/stream");
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(Duration::from_millis(200));
    }
    drop(stream);
}

/// Body of a response with status 200.
pub fn get(address: SocketAddr, path: &str) -> io::Result<String> {
    let mut answer = String::new();
    ask(address, Ipv4Addr::LOCALHOST, path)?.read_to_string(&mut answer)?;
    let (head, body) = answer.split_once("\r\n\r\n").ok_or_else(|| io::Error::other("no answer"))?;
    let good = head.split(' ').nth(1) == Some("200");
    if good { Ok(body.to_owned()) } else { Err(io::Error::other(head.to_owned())) }
}

fn ask(address: SocketAddr, from: Ipv4Addr, path: &str) -> io::Result<TcpStream> {
    let mut stream = connect(address, from)?;
    write!(stream, "GET {path} HTTP/1.0\r\nhost: {address}\r\n\r\n")?;
    Ok(stream)
}

/// Connects from an address of this machine.
pub fn connect(address: SocketAddr, from: Ipv4Addr) -> io::Result<TcpStream> {
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None)?;
    socket.bind(&SocketAddrV4::new(from, 0).into())?;
    socket.connect(&address.into())?;
    let stream: TcpStream = socket.into();
    stream.set_read_timeout(Some(PATIENCE))?;
    Ok(stream)
}
