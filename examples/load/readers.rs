//! Who reads the API: streams that are read to their end, one that never is, and single answers.
//!
//! Requests are HTTP/1.0: the answer is then the plain octets up to the connection's end.

use std::io::{self, BufRead, BufReader, Read as _, Write};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use fusion::time::Time;
use socket2::{Domain, Socket, Type};
use utm_fusion::live::now;

/// An answer, or the next line of a stream, comes within this time.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a reader asks for.
pub struct Wish {
    /// The address that it asks from; an address may open only so many streams at once.
    pub from: Ipv4Addr,
    /// `?` and parameters, or nothing.
    pub query: String,
}

/// What a reader got.
#[derive(Debug, Default)]
pub struct Read {
    /// Octets in all.
    pub octets: u64,
    /// `tracks` events, after the first slot it saw.
    pub slots: u64,
    /// Slots between two events that neither came nor were announced as lost.
    pub missing: u64,
    /// `resync` events.
    pub resyncs: u64,
    /// From a slot's publication to here, seconds.
    pub delays_s: Vec<f32>,
    /// Why it ended before its time.
    pub failed: Option<String>,
}

/// Reads the stream until it is to stop.
pub fn read(address: SocketAddr, wish: &Wish, stop: &AtomicBool) -> Read {
    let mut read = Read::default();
    if let Err(error) = follow(address, wish, stop, &mut read)
        && !stop.load(Ordering::Relaxed)
    {
        read.failed = Some(format!("{error}, after {} slots", read.slots));
    }
    read
}

fn follow(address: SocketAddr, wish: &Wish, stop: &AtomicBool, read: &mut Read) -> io::Result<()> {
    let mut lines = BufReader::with_capacity(
        32 * 1024,
        ask(address, wish.from, &format!("/api/v1/stream{}", wish.query))?,
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
            let head = Head::of(&line).ok_or_else(|| io::Error::other("an event without seq"))?;
            if event == b"tracks" {
                read.slots += 1;
                read.delays_s.extend(head.published.map(|published| now().seconds_since(published) as f32));
                read.missing += last.map_or(0, |last| head.seq.saturating_sub(last + 1));
            }
            // A snapshot begins anew.
            last = Some(head.seq);
        }
    }
    Ok(())
}

/// What stands in front of the features.
struct Head {
    seq: u64,
    published: Option<Time>,
}

impl Head {
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

/// Opens a stream and leaves it at that.
pub fn open_and_never_read(address: SocketAddr, stop: &AtomicBool) {
    let stream = ask(address, Ipv4Addr::LOCALHOST, "/api/v1/stream");
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(Duration::from_millis(200));
    }
    drop(stream);
}

/// The body of an answer that is 200.
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

/// A connection from an address of this machine.
pub fn connect(address: SocketAddr, from: Ipv4Addr) -> io::Result<TcpStream> {
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None)?;
    socket.bind(&SocketAddrV4::new(from, 0).into())?;
    socket.connect(&address.into())?;
    let stream: TcpStream = socket.into();
    stream.set_read_timeout(Some(PATIENCE))?;
    Ok(stream)
}
