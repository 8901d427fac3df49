//! The stream as WebSocket messages over sockets, with correct and incorrect clients.

use std::net::SocketAddr;
use std::time::Duration;

use flate2::read::DeflateDecoder;
use serde_json::Value;
use socket2::{Domain, Socket, Type};
use tokio::net::TcpStream;
use utm_fusion::api::Options;

use crate::common::{Reader, Site, flown, receive, send};
use crate::schema::check;

const WS: &str = "/api/v1/stream/ws";
const HANDSHAKE: &str = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
                         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
const PING: u8 = 0x89;
const CLOSE: u8 = 0x88;

/// A client that sends raw frames, and may violate every rule.
struct Client {
    socket: TcpStream,
    came: Vec<u8>,
    head: String,
}

impl Client {
    async fn open(address: SocketAddr, path: &str, headers: &str) -> Self {
        Self::over(TcpStream::connect(address).await.unwrap(), path, &format!("{HANDSHAKE}{headers}")).await
    }

    async fn over(socket: TcpStream, path: &str, headers: &str) -> Self {
        let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n");
        send(&socket, request.as_bytes()).await;
        let mut client = Self { socket, came: Vec::new(), head: String::new() };
        let end = loop {
            if let Some(at) = client.came.windows(4).position(|four| four == b"\r\n\r\n") {
                break at + 4;
            }
            assert!(client.more().await, "no answer");
        };
        client.head = String::from_utf8(client.came.drain(..end).collect()).unwrap();
        client
    }

    fn status(&self) -> &str {
        self.head.split(' ').nth(1).unwrap()
    }

    async fn more(&mut self) -> bool {
        let mut octets = [0; 1 << 16];
        let read = tokio::time::timeout(Duration::from_secs(60), receive(&self.socket, &mut octets));
        let count = read.await.expect("nothing comes for 20 s");
        self.came.extend_from_slice(&octets[..count]);
        count > 0
    }

    /// First octet and content of the next frame; `None` at the end.
    async fn frame(&mut self) -> Option<(u8, Vec<u8>)> {
        loop {
            let length = |octets: &[u8]| octets.iter().fold(0, |sum, octet| sum << 8 | usize::from(*octet));
            let (from, count) = match self.came.get(1) {
                Some(126) if self.came.len() >= 4 => (4, length(&self.came[2..4])),
                Some(127) if self.came.len() >= 10 => (10, length(&self.came[2..10])),
                Some(&short) if short < 126 => (2, usize::from(short)),
                _ => (0, usize::MAX / 2),
            };
            if self.came.len() >= from + count {
                let frame: Vec<u8> = self.came.drain(..from + count).collect();
                return Some((frame[0], frame[from..].to_vec()));
            }
            if !self.more().await {
                return None;
            }
        }
    }

    /// The next message except heartbeats, decompressed. Control frames are skipped.
    async fn message(&mut self) -> Option<Value> {
        loop {
            let text = match self.frame().await? {
                (0x81, text) => text,
                (0xc1, mut blocks) => {
                    blocks.extend([0, 0, 0xff, 0xff]);
                    let mut text = Vec::new();
                    // The deflate stream has no end, which the decoder reports.
                    let _ = std::io::Read::read_to_end(&mut DeflateDecoder::new(&blocks[..]), &mut text);
                    text
                }
                _ => continue,
            };
            let message: Value = serde_json::from_slice(&text).unwrap();
            if message["event"] != "heartbeat" {
                return Some(message);
            }
        }
    }

    /// Sends a masked frame.
    async fn send(&self, first: u8, octets: &[u8]) {
        let mut frame = vec![first, 0x80 | octets.len() as u8, 1, 2, 3, 4];
        frame.extend(octets.iter().zip([1, 2, 3, 4].iter().cycle()).map(|(octet, mask)| octet ^ mask));
        send(&self.socket, &frame).await;
    }

    /// Code of the close frame, which must be the last one.
    async fn closed(&mut self) -> u16 {
        loop {
            match self.frame().await.expect("a last frame") {
                (CLOSE, octets) => {
                    assert!(!self.more().await, "nothing comes behind the last frame");
                    return u16::from_be_bytes(octets[..2].try_into().unwrap());
                }
                _ => continue,
            }
        }
    }
}

async fn dropped(site: &Site, reason: &str) -> u64 {
    let text = site.get("/metrics").await.text;
    let line = format!("utm_fusion_streams_dropped_total{{reason=\"{reason}\"}} ");
    text.lines().find_map(|found| found.strip_prefix(&line)?.parse().ok()).unwrap()
}

/// Waits until a condition holds.
async fn until(what: &str, mut is_so: impl AsyncFnMut() -> bool) {
    for _ in 0..2_000 {
        if is_so().await {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("not within 10 s: {what}");
}

#[tokio::test]
async fn websocket_sends_the_same_events() {
    for (parameters, extension) in [
        ("", ""),
        (
            "?source=fused&trail_s=5",
            "Sec-WebSocket-Extensions: permessage-deflate; client_max_window_bits\r\n",
        ),
        ("?interval_ms=500", ""),
        ("?class=other", "Sec-WebSocket-Extensions: permessage-deflate\r\n"),
    ] {
        let mut site = Site::plain();
        site.publish(2).await;
        let address = site.listen().await;
        let mut events = Reader::open(address, &format!("/api/v1/stream{parameters}"), "").await;
        let mut client = Client::open(address, &format!("{WS}{parameters}"), extension).await;
        assert_eq!(client.status(), "101", "{}", client.head);
        let head = client.head.to_lowercase();
        assert!(client.head.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{head}");
        assert_eq!(head.contains("permessage-deflate; server_no_context_takeover"), !extension.is_empty());
        let described = site.get("/api/v1/asyncapi.json").await.json();
        site.publish(12).await;
        site.publish_status(site.status()).await;
        site.state.close();
        let mut count = 0;
        while let Some(event) = events.next().await {
            let message = client.message().await.unwrap();
            assert_eq!(message.as_object().unwrap().len(), 3);
            let schema = &described["components"]["messages"][format!("{}_message", event.name)]["payload"];
            check(&described, schema, &message, &event.name);
            let schema = &described["components"]["messages"][&event.name]["payload"];
            check(&described, schema, &event.data, &event.name);
            assert_eq!(message["event"], event.name.as_str());
            assert_eq!(message["id"], event.id.as_str());
            assert_eq!(message["data"], event.data);
            count += 1;
        }
        assert!(count > 3, "{count}");
        assert_eq!(client.closed().await, 1001, "the service stops");
    }
}

#[tokio::test]
async fn websocket_resumes() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    let mut first = Client::open(address, WS, "").await;
    let id = first.message().await.unwrap()["id"].as_str().unwrap().to_owned();
    drop(first);
    site.publish(3).await;
    let mut again = Client::open(address, &format!("{WS}?last_event_id={id}"), "").await;
    let seqs = [again.message().await, again.message().await, again.message().await].map(Option::unwrap);
    let now = site.get("/api/v1/tracks").await.json()["seq"].as_u64().unwrap();
    assert_eq!(seqs.each_ref().map(|event| event["event"].as_str().unwrap()), ["tracks"; 3]);
    assert_eq!(seqs.map(|event| event["data"]["seq"].as_u64().unwrap()), [now - 2, now - 1, now]);
    let mut unknown = Client::open(address, &format!("{WS}?last_event_id=1-1"), "").await;
    assert_eq!(unknown.message().await.unwrap()["event"], "snapshot");
}

#[tokio::test]
async fn a_ping_is_answered_and_a_close_too() {
    let mut site = Site::plain();
    site.publish(1).await;
    let mut client = Client::open(site.listen().await, WS, "").await;
    assert_eq!(client.message().await.unwrap()["event"], "snapshot");
    client.send(PING, b"are you there").await;
    loop {
        match client.frame().await.unwrap() {
            (0x8a, octets) => break assert_eq!(octets, b"are you there"),
            (first, _) => assert_eq!(first, 0x81),
        }
    }
    client.send(CLOSE, &1000_u16.to_be_bytes()).await;
    assert_eq!(client.closed().await, 1000);
    until("its seat is free", async || site.get("/metrics").await.text.contains("\nutm_fusion_streams 0\n"))
        .await;
    assert_eq!(dropped(&site, "protocol").await, 0);
}

#[tokio::test]
async fn protocol_violation_closes_and_is_counted() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    let far = [0x82, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff];
    let cases: [(&[u8], u16); 7] = [
        (b"\x89\x00", 1002),                      // not masked
        (b"\xc9\x80\x00\x00\x00\x00", 1002),      // compressed, a control frame
        (b"\x83\x80\x00\x00\x00\x00", 1002),      // unknown
        (b"\x89\xfe\x01\x00", 1002),              // a control frame of 256 octets
        (b"\x81\x85\x00\x00\x00\x00Hello", 1003), // a message
        (&far, 1003),                             // a message of 2^64 - 1 octets, announced
        (b"GET / HTTP/1.1\r\n\r\n", 1002),
    ];
    for (count, (octets, code)) in cases.into_iter().enumerate() {
        let mut client = Client::open(address, WS, "").await;
        send(&client.socket, octets).await;
        assert_eq!(client.closed().await, code, "{octets:?}");
        until("it is counted", async || dropped(&site, "protocol").await == count as u64 + 1).await;
    }
    // More frames than a client needs between two heartbeats.
    let mut client = Client::open(address, WS, "").await;
    let ping = [PING, 0x80, 0, 0, 0, 0];
    send(&client.socket, &ping.repeat(1_000)).await;
    assert_eq!(client.closed().await, 1008);
    // The service still works.
    let mut client = Client::open(address, WS, "").await;
    assert_eq!(client.message().await.unwrap()["event"], "snapshot");
}

#[tokio::test]
async fn slow_and_silent_clients_are_dropped() {
    let options = Options { patience: Duration::from_millis(300), ..Options::default() };
    let mut site = Site::with(options, |_| {});
    site.publish(1).await;
    let address = site.listen().await;
    // Reads, but sends nothing.
    let mut silent = Client::open(address, WS, "").await;
    while silent.frame().await.is_some() {}
    until("the silent one is counted", async || dropped(&site, "silent").await == 1).await;
    // A client that answers pings but reads nothing. Its window is small, so its messages pile up.
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    socket.set_recv_buffer_size(2_048).unwrap();
    socket.connect(&address.into()).unwrap();
    socket.set_nonblocking(true).unwrap();
    let slow = Client::over(TcpStream::from_std(socket.into()).unwrap(), WS, HANDSHAKE).await;
    assert_eq!(slow.status(), "101");
    // Slots of a city: two exceed the kernel's buffer.
    let mut slots = flown().frames.iter().skip(flown().frames.len() / 2 + 4);
    until("the slow one is counted", async || {
        if let Some(mut frame) = slots.next().cloned() {
            frame.picture.tracks = std::iter::repeat_n(frame.picture.tracks, 100).flatten().collect();
            site.writer.publish(frame);
        }
        // It still answers pings.
        let _ = slow.socket.try_write(&[0x8a, 0x80, 0, 0, 0, 0]);
        dropped(&site, "slow").await == 1
    })
    .await;
    assert!(site.get("/metrics").await.text.contains("\nutm_fusion_streams 0\n"));
}

#[tokio::test]
async fn limits_and_rights_are_those_of_streams() {
    let options = Options { streams: 2, ..Options::default() };
    let mut site = Site::with(options, |_| {});
    site.publish(1).await;
    let address = site.listen().await;
    let mut first = Client::open(address, WS, "").await;
    assert_eq!(first.message().await.unwrap()["event"], "snapshot");
    let _second = Reader::open(address, "/api/v1/stream", "").await;
    let third = Client::open(address, WS, "").await;
    assert_eq!(third.status(), "429", "{}", third.head);
    // An upgraded connection still counts.
    drop(third);
    until("its connection counts", async || {
        site.get("/metrics").await.text.contains("\nutm_fusion_http_connections 2\n")
    })
    .await;
    drop(first);
    until("no longer", async || {
        site.get("/metrics").await.text.contains("\nutm_fusion_http_connections 1\n")
    })
    .await;
}

#[tokio::test]
async fn page_of_another_origin_is_refused() {
    let mut site =
        Site::with(Options::default(), |config| config.http.cors = vec!["https://map.example".to_owned()]);
    site.publish(1).await;
    let address = site.listen().await;
    for (origin, status) in [
        ("http://localhost", "101"),
        ("https://map.example", "101"),
        ("https://strange.example", "403"),
        ("null", "403"),
    ] {
        let client = Client::open(address, WS, &format!("Origin: {origin}\r\n")).await;
        assert_eq!(client.status(), status, "{origin}: {}", client.head);
    }
    let cross = Client::open(address, WS, "Sec-Fetch-Site: cross-site\r\n").await;
    assert_eq!(cross.status(), "403");
}

#[tokio::test]
async fn invalid_handshake_is_refused() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    let without = |line: &str| {
        let lines = HANDSHAKE.split_inclusive("\r\n").filter(|kept| !kept.starts_with(line));
        lines.collect::<String>()
    };
    for headers in [
        without("Upgrade"),
        without("Connection"),
        without("Sec-WebSocket-Key"),
        without("Sec-WebSocket-Version"),
        HANDSHAKE.replace("13", "12"),
        HANDSHAKE.replace("dGhlIHNhbXBsZSBub25jZQ==", "dGhl"),
        String::new(),
    ] {
        let socket = TcpStream::connect(address).await.unwrap();
        let client = Client::over(socket, WS, &headers).await;
        assert_eq!(client.status(), "426", "{headers}");
        assert!(client.head.to_lowercase().contains("sec-websocket-version: 13"), "{}", client.head);
    }
    let socket = TcpStream::connect(address).await.unwrap();
    send(&socket, format!("HEAD {WS} HTTP/1.1\r\nHost: localhost\r\n{HANDSHAKE}\r\n").as_bytes()).await;
    let mut octets = [0; 12];
    assert_eq!(receive(&socket, &mut octets).await, octets.len());
    assert_eq!(&octets, b"HTTP/1.1 426");
    // Parameters are checked as on other routes.
    let wrong = Client::open(address, &format!("{WS}?bbox=1"), "").await;
    assert_eq!(wrong.status(), "400");
    let unknown = Client::open(address, &format!("{WS}?after=x"), "").await;
    assert_eq!(unknown.status(), "400");
}
